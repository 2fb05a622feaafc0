//! Many campaigns, one document a line; the same bytes on any number of threads.

use serde_json::Value;
use std::process::Command;

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

fn plan(name: &str) -> String {
    testkit::fixture(&format!("plans/{name}.json")).to_str().expect("UTF-8").to_string()
}

fn run(threads: &str, arguments: &[&str]) -> Vec<u8> {
    let output =
        Command::new(SIMULATE).args(arguments).env("RAYON_NUM_THREADS", threads).output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// What a sweep of the axes' plan writes with these options.
fn swept(threads: &str, options: &str) -> Vec<u8> {
    let plan = plan("magsat-axes");
    let fixed = ["sweep", "-q", plan.as_str()];
    run(threads, &fixed.into_iter().chain(options.split(' ')).collect::<Vec<_>>())
}

#[test]
fn one_thread_and_two_give_the_same_bytes() {
    for name in ["cubesat", "magsat"] {
        let campaign = ["campaign", "-q", &plan(name)];
        assert!(run("1", &campaign) == run("2", &campaign), "{name}");
    }
    assert!(swept("1", "--seeds 1..5") == swept("2", "--seeds 1..5"));
}

#[test]
fn parts_of_the_seeds_are_the_whole() {
    let part = |seeds: &str| swept("2", &format!("--seeds {seeds} --set truth.residual_field_nt.z=5"));
    assert!([part("1..2"), part("3..5")].concat() == part("1..5"));
}

#[test]
fn seeds_and_values_in_every_combination() {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = folder.path().join("truth.ndjson");
    let set = "--set instrument.noise.white_rms_nt=0.5,2 --set truth.residual_field_nt.z=5";
    let text = swept("2", &format!("--seeds 3,8 {set} --truth {}", truth.display()));
    let lines = |text: &str| -> Vec<Value> {
        text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
    };
    let documents = lines(std::str::from_utf8(&text).expect("UTF-8"));
    let truths = lines(&std::fs::read_to_string(&truth).expect("there"));
    assert_eq!((documents.len(), truths.len()), (4, 4));
    for (number, (seed, noise)) in [(3, 0.5), (8, 0.5), (3, 2.0), (8, 2.0)].into_iter().enumerate() {
        assert_eq!(truths[number]["seed"], seed);
        assert_eq!(truths[number]["residual_field_nt"][2], 5.0);
        assert_eq!(documents[number]["instrument"]["noise"]["white_rms_nt"], noise);
        assert_eq!(documents[number]["history"][0]["arguments"][1], format!("--seed={seed}"));
    }
    assert!(!String::from_utf8_lossy(&text).contains("residual_field_nt\""));
    // A line is the campaign of its seed.
    let campaign = run("1", &["campaign", "-q", "--seed", "8", &plan("magsat-axes")]);
    let [campaign, swept] = [campaign, swept("2", "--seeds 8")].map(|text| {
        let mut document: Value = serde_json::from_slice(&text).expect("JSON");
        document.as_object_mut().expect("an object").remove("history");
        document
    });
    assert_eq!(campaign, swept);
}

#[test]
fn a_fault_is_told_before_the_first_line() {
    let faults = r#"
sweep magsat-axes.json --seeds 1..3 --set procedures[0].drive_nt=70000
    procedures[0].drive_nt: found 70000 nT on coil x
sweep magsat-axes.json --seeds 1..3 --set procedures[3].drive_nt=1
    the plan has no "[3]" there
sweep magsat-axes.json --seeds 1..3 --set title.text=1
    the plan has no "text" there
sweep magsat-axes.json --seeds 1..3 --set seed=x
    are no JSON values
"#;
    assert_eq!(testkit::refusals(SIMULATE, &testkit::fixture("plans"), faults), 4);
}

/// A program that is ended while it writes leaves nothing behind, and what was there before as it was.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_leaves_nothing_behind() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("sweep.ndjson");
    std::fs::write(&out, "before\n").expect("written");
    let mut sweep = std::process::Command::new(SIMULATE)
        .args(["sweep", "-q", &plan("magsat-axes"), "--seeds", "1..1000000", "-o"])
        .arg(&out)
        .spawn()
        .expect("simulate");
    // Its file is open as soon as the kernel lists a descriptor that leads into the folder.
    let open = || {
        let listed = std::fs::read_dir(format!("/proc/{}/fd", sweep.id())).into_iter().flatten().flatten();
        let links = listed.filter_map(|entry| std::fs::read_link(entry.path()).ok());
        links.into_iter().any(|link| link.starts_with(folder.path().canonicalize().expect("a folder")))
    };
    while !open() {
        std::thread::yield_now();
    }
    let kill = std::process::Command::new("kill").args(["-TERM", &sweep.id().to_string()]).status();
    assert!(kill.expect("kill").success());
    assert!(!sweep.wait().expect("ended").success());
    assert_eq!(std::fs::read_to_string(&out).expect("there"), "before\n");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
}
