//! Documents that anybody could have written, and that tell nothing.

use common::Document;
use concealed::sets::Set;

#[test]
fn every_set_writes_documents_of_the_public_format_that_tell_nothing() {
    let long = Set::LONG.map(|set| (set, 1));
    for (set, count) in Set::ALL.map(|set| (set, 3)).into_iter().chain(long) {
        for case in set.cases(7, count) {
            let text = case.document.to_string();
            let document = Document::parse(&text).unwrap_or_else(|error| panic!("{}: {error}", set.word()));
            assert!(document.model.is_none() && document.diagnosis.is_none());
            let told = case.truth.effects.iter().flat_map(|effect| &effect.accepted);
            for word in told.map(|name| name.split(' ').next().unwrap_or(name)).chain([set.word()]) {
                // As a name of its own: columns and the noise's keys have units behind them.
                let tells = [format!("\"{word}\""), format!("{word} "), format!("{word}-")];
                assert!(tells.iter().all(|told| !text.contains(told)), "{} tells {word}", case.truth.case);
            }
        }
    }
}

#[test]
fn the_same_seed_writes_the_same_bytes_and_another_does_not() {
    let text = |seed: u64, count: usize| {
        let case = Set::Single.cases(seed, count).swap_remove(1);
        (case.document.to_string(), serde_json::to_string(&case.truth).expect("JSON"))
    };
    assert_eq!(text(5, 2), text(5, 4));
    assert_ne!(text(5, 2), text(6, 2));
}

/// What is left of an effect beside a fresh calibration is what the case was to have.
#[test]
fn effects_have_the_stated_size() {
    for case in Set::Single.cases(3, 9) {
        let left = case.truth.effects[0].left_nt / case.truth.noise_nt;
        assert!((left / case.truth.strength - 1.0).abs() < 0.1, "{}: {left}", case.truth.effects[0].name);
    }
}

/// Of long recordings as well, whose effects are off their formulas by a share of themselves.
#[test]
fn long_recordings_are_long_and_their_effects_have_the_stated_size() {
    for case in Set::LongSingle.cases(3, 5) {
        let (truth, effect) = (&case.truth, &case.truth.effects[0]);
        assert!((9_000..30_000).contains(&truth.readings), "{}", truth.readings);
        assert!((0.0..=0.2).contains(&effect.form_error), "{}", effect.form_error);
        let left = effect.left_nt / truth.noise_nt;
        assert!((left / truth.strength - 1.0).abs() < 0.1, "{}: {left}", effect.name);
    }
}

/// Of recordings as instruments write them too: the public format, columns of one length, times that go
/// forward, and a truth that tells each way in which they were written.
#[test]
fn recordings_as_they_are_are_documents_as_well() {
    let sets =
        [(Set::Choose, 30), (Set::ChooseSeveral, 6), (Set::ChooseOutside, 8), (Set::RecordedClean, 14)];
    let mut said = String::new();
    for (set, count) in sets {
        for case in set.cases(2, count) {
            Document::parse(&case.document.to_string())
                .unwrap_or_else(|error| panic!("{}: {error}", set.word()));
            for recording in case.document["recordings"].as_array().expect("recordings") {
                let columns = recording["columns"].as_object().expect("columns");
                let time: Vec<f64> = serde_json::from_value(columns["time_s"].clone()).expect("times");
                assert!(time.windows(2).all(|pair| pair[1] > pair[0]), "{}", case.truth.case);
                let rows = |column: &serde_json::Value| column.as_array().map(Vec::len);
                assert!(
                    columns.values().all(|column| rows(column) == Some(time.len())),
                    "{}",
                    case.truth.case
                );
            }
            assert!((1_500..=90_000).contains(&case.truth.readings), "{}", case.truth.readings);
            said += &format!("{} {}, ", case.truth.length, case.truth.recorded.join(", "));
        }
    }
    let ways = [
        "Hz",
        "uneven times",
        "a storm",
        "codes of",
        "follows the truth",
        "correlates by chance",
        "gaps",
        "lost rows",
        "times to 1 ms",
        "times to 1 us",
        "decoys",
        "noise declared",
        "noise not declared",
        "medium",
        "longest",
    ];
    for way in ways {
        assert!(said.contains(way), "{way} never occurs");
    }
}
