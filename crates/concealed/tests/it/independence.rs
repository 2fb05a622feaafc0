//! The crate shares no line with what it proves.

use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

#[test]
fn neither_physics_nor_noise_nor_estimation_nor_a_stage_is_below_it() {
    let run = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let metadata: Value = serde_json::from_slice(&run.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let mut found = BTreeSet::new();
    let mut next = vec!["concealed".to_string()];
    while let Some(name) = next.pop() {
        let package = packages.iter().find(|package| package["name"] == *name).expect("of the workspace");
        for dependency in package["dependencies"].as_array().expect("dependencies") {
            let own = dependency["kind"].is_null() && dependency["path"].is_string();
            let name = dependency["name"].as_str().expect("a name").to_string();
            if own && found.insert(name.clone()) {
                next.push(name);
            }
        }
    }
    let allowed: BTreeSet<String> =
        ["common", "errors", "files", "partial", "program", "tables", "testkit"].map(String::from).into();
    assert!(found.is_subset(&allowed), "{found:?}");
}
