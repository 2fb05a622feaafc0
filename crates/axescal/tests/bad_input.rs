//! Every document of `fixtures/bad` brings its message, its exit code, and nothing on standard output.

use std::fs;

#[test]
fn each_fault_has_its_message() {
    let folder = testkit::fixture("bad");
    let mut names: Vec<String> = fs::read_dir(&folder)
        .expect("fixtures/bad")
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8"))
        .filter_map(|name| name.strip_suffix(".json").map(str::to_string))
        .collect();
    names.sort();
    assert!(names.len() >= 20);
    let mut wrong = Vec::new();
    for name in names {
        let document = fs::read_to_string(folder.join(format!("{name}.json"))).expect("readable");
        let run = testkit::run(env!("CARGO_BIN_EXE_axescal"), &[], &document);
        let said = format!("exit code {}\n{}", run.code, run.stderr);
        let expected = folder.join(format!("{name}.txt"));
        if testkit::bless() {
            fs::write(&expected, &said).expect("written");
        }
        let expected = fs::read_to_string(&expected).unwrap_or_default();
        if said != expected || !run.stdout.is_empty() || run.code == 0 {
            wrong.push(format!("{name}:\n{said}where this is expected:\n{expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
