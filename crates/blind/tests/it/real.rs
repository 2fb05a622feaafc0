//! Real recordings, which are not in the repository: what needs them is run by `just recordings`, with the
//! folder in `FLUXCAL_DATA` (else `../shared/data` beside the repository), the programs built.

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

const BLIND: &str = env!("CARGO_BIN_EXE_blind");

fn made(place: &Path, more: &[&str]) -> testkit::Run {
    let always = ["make", "--set", "clean", "--seed", "1", "-o", "cases", "--truths", "t.json"];
    testkit::run_in(BLIND, place, &[&always, more].concat())
}

#[test]
fn a_folder_that_is_missing_is_said_and_left_out() {
    let place = tempfile::tempdir().expect("a folder");
    let made = made(place.path(), &["--cases", "1", "--recordings", "nowhere"]);
    assert_eq!((made.code, made.stdout.trim().len()), (0, 64), "{}", made.stderr);
    assert_eq!(made.stderr, "blind: nowhere: no folder of recordings; nothing is concealed in real ones\n");
    let seals = std::fs::read_to_string(place.path().join("cases/seals.txt")).expect("seals");
    assert_eq!(seals.lines().count(), 1);
}

/// At least five recordings of three folders show nothing; each is a case itself, and has effects at four
/// strengths beside it.
#[test]
#[ignore = "needs the recordings: just recordings"]
fn quiet_recordings_become_hosts() {
    let place = tempfile::tempdir().expect("a folder");
    let recordings = testkit::recordings("").display().to_string();
    let made = made(place.path(), &["--cases", "0", "--each", "4", "--recordings", &recordings]);
    assert_eq!(made.code, 0, "{}", made.stderr);
    let json = |name: &str| -> Value {
        let text = std::fs::read_to_string(place.path().join(name)).expect(name);
        serde_json::from_str(&text).expect("JSON")
    };
    let tried = json("cases/hosts.json");
    let hosts: BTreeSet<&str> = tried
        .as_array()
        .expect("a list")
        .iter()
        .filter(|one| one["host"] == true)
        .filter_map(|one| one["name"].as_str())
        .collect();
    let folders = injected::CANDIDATES.iter().filter(|one| hosts.contains(one.name)).map(|one| one.folder);
    assert!(hosts.len() >= 5 && folders.collect::<BTreeSet<_>>().len() >= 3, "{hosts:?}");
    let truths: Vec<Value> = json("t.json")
        .as_object()
        .expect("truths")
        .values()
        .map(|text| serde_json::from_str(text.as_str().expect("text")).expect("a truth"))
        .collect();
    for host in hosts {
        let own = truths.iter().filter(|truth| truth["scene"] == host);
        let strengths: Vec<f64> = own.filter_map(|truth| truth["strength"].as_f64()).collect();
        assert_eq!(strengths.iter().sum::<f64>(), 14.3, "{host}: {strengths:?}");
    }
}
