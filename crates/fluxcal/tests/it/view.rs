//! `fluxcal view`: files, folders and documents as a page; a browser is not needed.

use std::fs;
use std::path::Path;

use testkit::fixture;

use crate::FLUXCAL;

/// What it says, and the page where there is one.
fn view(folder: &Path, files: &[&Path]) -> (testkit::Run, String) {
    let page = folder.join("page.html");
    let mut arguments = vec!["view", "--no-browser", "-o", page.to_str().expect("a name")];
    arguments.extend(files.iter().map(|file| file.to_str().expect("a name")));
    let run = testkit::run(FLUXCAL, &arguments, "");
    (run, fs::read_to_string(&page).unwrap_or_default())
}

#[test]
fn files_of_one_series_are_one_recording() {
    let folder = tempfile::tempdir().expect("a folder");
    let [one, two] = ["a", "b"].map(|part| fixture(&format!("ingest/flx20240310{part}.min")));
    let other = fixture("ingest/imagcdf.cdf");
    let elsewhere = folder.path().join("flx20240310a.min");
    fs::copy(&one, &elsewhere).expect("copied");
    let (run, page) = view(folder.path(), &[&one, &two, &other, &elsewhere]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(run.stdout.trim(), folder.path().join("page.html").to_string_lossy());
    // The letters differ, and so two of them are series of their own.
    // The last is of the same name, in another folder.
    for id in ["flx20240310a", "flx20240310b", "imagcdf", "flx20240310a-4"] {
        assert!(page.contains(&format!("{id}: ")), "{id}");
    }
    assert!(run.stderr.contains("open in a browser:"), "{}", run.stderr);
}

#[test]
fn a_folder_of_days_with_notes_and_a_gap() {
    let folder = tempfile::tempdir().expect("a folder");
    let days = folder.path().join("days");
    fs::create_dir(&days).expect("a folder");
    let line = |second: u32| format!("{},{},2,3\n", 1_700_000_000 + second, second % 7);
    for (day, seconds) in [(1, 0..100), (2, 200..300)] {
        let rows: String = seconds.map(line).collect();
        fs::write(days.join(format!("day{day}.csv")), format!("unix_s,x_nT,y_nT,z_nT\n{rows}"))
            .expect("written");
    }
    fs::write(days.join("README.md"), "Days of a logger.\n").expect("written");
    let (run, page) = view(folder.path(), &[&days]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("left out") && run.stderr.contains("README.md"), "{}", run.stderr);
    assert!(page.contains("<h1>days</h1>"));
    let gap = "data-group=\"day1\" data-from=\"1700000099.0\" data-to=\"1700000200.0\">gap</a>";
    assert!(page.contains(gap), "{page}");
}

#[test]
fn a_document_and_what_cannot_be_viewed() {
    let folder = tempfile::tempdir().expect("a folder");
    let document = fixture("diagnose/warm/expected.json");
    let (run, page) = view(folder.path(), &[&document]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(page.contains("<section id=\"diagnosis\">"));
    let day = fixture("ingest/flx20240310a.min");
    let nonsense = folder.path().join("nonsense.bin");
    fs::write(&nonsense, [0, 159, 146, 150]).expect("written");
    let missing = folder.path().join("missing.csv");
    for (files, said) in [
        (vec![document.as_path(), day.as_path()], "view one document alone"),
        (vec![missing.as_path()], "missing.csv"),
        (vec![nonsense.as_path()], "nonsense.bin"),
    ] {
        let other = tempfile::tempdir().expect("a folder");
        let (run, page) = view(other.path(), &files);
        assert_eq!((run.code, run.stdout.as_str(), page.as_str()), (2, "", ""), "{}", run.stderr);
        assert!(run.stderr.contains(said), "{}", run.stderr);
    }
}
