//! Real recordings, which are not in the repository: tests that need them are run by `just recordings`, with
//! the folder in `FLUXCAL_DATA` (else `../shared/data` beside the repository), the programs built.

use std::path::{Path, PathBuf};
use testkit::programs::Programs;

fn programs() -> Programs {
    let beside = Path::new(env!("CARGO_BIN_EXE_recorded")).parent().expect("a folder");
    Programs::find(Some(beside)).expect("a folder")
}

#[test]
fn a_missing_folder_is_said_for_every_set() {
    let nowhere = tempfile::tempdir().expect("a folder");
    let programs = Programs::find(Some(nowhere.path())).expect("a folder");
    let text = recorded::recorded(nowhere.path(), programs, None).expect("a page").text;
    assert_eq!(text.matches("\nNot run: no folder `").count(), recorded::SETS.len());
    assert!(!text.contains(&nowhere.path().display().to_string()), "{text}");
}

#[test]
fn a_name_that_no_set_has_is_refused_with_those_that_there_are() {
    let nowhere = tempfile::tempdir().expect("a folder");
    let programs = Programs::find(Some(nowhere.path())).expect("a folder");
    let refused = recorded::recorded(nowhere.path(), programs, Some("nowhere"));
    let words = refused.expect_err("a refusal").to_string();
    assert!(words.starts_with("no set of that name; expected one of conrad-pair, "), "{words}");
}

#[test]
#[ignore = "needs the recordings: just recordings"]
fn a_misprint_in_a_certificate_is_found() {
    let text =
        recorded::recorded(&testkit::recordings(""), programs(), Some("certificates")).expect("a page").text;
    // 36911 nT/mA over 38.3 kohm is 963.7 nT/V.
    assert!(text.contains("| FGE_S0437-E0564 Z | 963.7 | 973.7 | +10.0 |"), "{text}");
}

#[test]
#[ignore = "needs the recordings: just recordings"]
fn instruments_that_share_no_field_are_not_made_to_look_good() {
    let text =
        recorded::recorded(&testkit::recordings(""), programs(), Some("meson-hall")).expect("a page").text;
    println!("{text}");
    let row = text.lines().find(|line| line.starts_with("| test x |")).expect("a matrix");
    let cell = row.split('|').nth(2).and_then(|cell| cell.split('±').next()).expect("an element");
    let own: f64 = cell.trim().parse().expect("a number");
    assert!(own < 0.8, "two fluxgates that felt one field would have 1: {row}");
    assert!(text.contains("the errors are correlated in time"), "{text}");
}

#[test]
fn the_page_in_docs_is_of_these_sets_and_its_plots_are_small() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/proof");
    let page = std::fs::read_to_string(folder.join("real.md")).expect("the page");
    for set in recorded::SETS {
        assert!(page.contains(&format!("\n## {}\n", set.title)), "{}: make the page again", set.title);
    }
    assert!(!page.contains("\nNot run: "), "the page was made without some of the recordings");
    let plots: Vec<&str> =
        page.lines().filter_map(|line| line.strip_prefix("![")?.split(['(', ')']).nth(1)).collect();
    assert!(plots.len() >= 5, "{plots:?}");
    for plot in plots {
        let bytes = std::fs::metadata(folder.join(plot)).expect(plot).len();
        assert!((1..60_000).contains(&bytes), "{plot}: {bytes} bytes");
    }
}
