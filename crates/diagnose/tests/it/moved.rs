//! A calibration that no longer holds.

use common::{Axis, Document, Quantity, Verdict};
use serde_json::json;
use testkit::laws;

use crate::bench::{NOISE_NT, Scene, diagnosed, parsed, simulated};

const OFFSET_NT: f64 = 0.4;

/// A recording with a drawn calibration, and the offset of a coil off by so many of its uncertainties.
fn off_by(multiple: f64) -> Document {
    let mut document = laws::json(&simulated(Scene::Runs, &[], &json!({"white_rms_nt": NOISE_NT}), 5));
    let mut stream = noise::Stream::new(7, "calibration");
    let calibration = &mut document["calibration"];
    for axis in ["x", "y", "z"] {
        for (instrument, key, std) in [
            ("sensors", "sensitivity_nt_per_nt", 2e-5),
            ("sensors", "offset_nt", OFFSET_NT),
            ("coils", "constant_nt_per_a", 0.6),
            ("coils", "offset_nt", OFFSET_NT),
        ] {
            let place = &mut calibration[instrument][axis][key];
            let value = place.as_f64().expect("a number");
            *place = json!({"value": value + std * stream.normal(), "std": std});
        }
    }
    let moved = &mut calibration["coils"]["y"]["offset_nt"]["value"];
    *moved = json!(moved.as_f64().expect("a number") + multiple * OFFSET_NT);
    parsed(&document)
}

#[test]
fn an_offset_that_moved_is_told_and_written_anew() {
    let offset = |document: &Document| {
        let calibration = document.calibration.as_ref().expect("a calibration");
        calibration.coil(Axis::Y).and_then(|coil| coil.offset_nt.as_ref()).map_or(0.0, Quantity::value)
    };
    for (multiple, moved) in [(0.0, false), (20.0, true)] {
        let document = off_by(multiple);
        let before = offset(&document);
        let (entry, found) = diagnosed(document);
        let after = offset(&found);
        if !moved {
            assert_eq!((entry.verdict, entry.calibration_moved.len()), (Verdict::Agrees, 0));
            continue;
        }
        assert_eq!(entry.verdict, Verdict::Explained, "{:?}", entry.reasons);
        let [found] = &entry.calibration_moved[..] else { panic!("{:?}", entry.calibration_moved) };
        let names: Vec<&String> = std::iter::once(&found.parameter).chain(&found.alternatives).collect();
        assert!(names.iter().any(|name| *name == "coils.y.offset_nt"), "{names:?}");
        let expected = -multiple * OFFSET_NT;
        // From where it was stated, which was off by its uncertainty.
        let std = found.shift.std().expect("an uncertainty").hypot(OFFSET_NT);
        assert!((found.shift.value() - expected).abs() < 3.0 * std, "{:?}", found.shift);
        assert!(found.p_adjusted < 1e-6 && found.stated_std == OFFSET_NT);
        assert!((after - before - expected).abs() < 2.0, "{before} {after}");
    }
}
