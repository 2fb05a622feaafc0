//! Two magnetometers in recordings of their own.

use common::{Column, Document};
use diagnose::Options;

use crate::pair::pair;

#[test]
fn a_pair_in_two_recordings_is_the_pair() {
    let (together, _) = pair();
    let mut apart: Document = together.clone();
    let mut reference = apart.recordings[0].clone();
    let mut test = apart.recordings.remove(0);
    reference.id = "reference".into();
    test.id = "test".into();
    reference.columns.retain(|name, _| !name.starts_with("test_"));
    test.columns.retain(|name, _| !name.starts_with("reference_"));
    apart.recordings = vec![reference, test];
    let rms = |document: &Document| {
        let found = diagnose::run(document.clone(), &Options::default()).expect("diagnosed");
        let recordings = found.recordings.len();
        let entry = found.diagnosis.expect("a diagnosis").remove(0);
        (entry.fit.expect("a fit").rms_refitted_nt, recordings)
    };
    let (known, found) = (rms(&together), rms(&apart));
    assert!((found.0 / known.0 - 1.0).abs() < 1e-9, "{found:?} {known:?}");
    assert_eq!(found.1, 2, "the document keeps its recordings");
    let mut never = apart;
    if let Some(Column(time)) = never.recordings[1].columns.get_mut("time_s") {
        time.iter_mut().for_each(|t| *t += 1e6);
    }
    let error = diagnose::run(never, &Options::default()).expect_err("never together").to_string();
    assert!(error.contains("recordings that overlap in time"), "{error}");
}
