//! Definitive data of an observatory: variometers of different axes, the same field.

use common::Document;
use correct::{Frame, ibf, run};
use simulate::{BaselinePlan, ObservatoryPlan, TheodolitePlan, observatory};

/// Eight weeks without errors but the resolution of the circle, 1″, and a drift.
fn corrected(components: &str) -> Document {
    let theodolite = TheodolitePlan {
        circle_arcsec: 0.0,
        levelling_arcsec: 0.0,
        offset_changes_nt: 0.0,
        residual_nt: 0.0,
        time_s: 0.0,
        scalar_nt: 0.0,
        pillar_difference_nt: -3.2,
        ..TheodolitePlan::default()
    };
    let baseline = BaselinePlan { walk_nt: 0.0, annual_nt: 0.0, ..BaselinePlan::default() };
    let plan = ObservatoryPlan {
        weeks: 8,
        components: components.into(),
        theodolite,
        baseline,
        ..ObservatoryPlan::default()
    };
    let document = observatory(&plan).expect("a plan").document;
    let document = absolute::run(document).expect("baselines");
    run(document, Frame::Geo).expect("a field")
}

#[test]
fn axes_of_a_variometer_do_not_matter() {
    let [hez, xyz] = ["hez", "xyz"].map(corrected);
    let (first, second) = (&hez.recordings[0], &xyz.recordings[0]);
    for axis in ["x", "y", "z"] {
        let of =
            |one: &common::Recording| one.column(&format!("field_geo_{axis}_nt")).expect("a field").to_vec();
        assert!(of(first).iter().chain(&of(second)).all(|value| value.is_finite()));
        let worst = of(first).iter().zip(of(second)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // 1″ is 0.1 nT across the field and 0.24 nT along it, and less by eight readings of sixteen measurements.
        assert!(worst < 0.1, "{axis}: {worst} nT");
    }
    let delta = first.column("delta_f_nt").expect("a scalar magnetometer");
    let rms = (delta.iter().map(|value| value * value).sum::<f64>() / delta.len() as f64).sqrt();
    // The noise of the scalar magnetometer is 0.05 nT.
    assert!((rms - 0.05).abs() < 0.01, "{rms} nT");
}

#[test]
fn ingest_reads_the_yearly_baseline_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flx2025.blv");
    let document = corrected("hez");
    let first =
        &document.calibration.as_ref().expect("a calibration").absolute.as_ref().expect("sets").sets[0];
    std::fs::write(&path, ibf(document.clone(), "FLX").expect("a file")).expect("written");
    let read = ingest::run(Document::default(), &[path], &ingest::Options::default()).expect("read").document;
    // The first two measurements are on the eighth day; their mean is read.
    for (key, digit) in [("h_nt", 0.01), ("d_deg", 0.01 / 60.0), ("z_nt", 0.01)] {
        let found = read.recordings[0].column(&format!("observed_baseline_{key}")).expect(key)[7];
        let (value, std) = (first.baseline[key].value(), first.baseline[key].std().expect("a std"));
        assert!((found - value).abs() < digit + 3.0 * std, "{key}: {found} {value}");
    }
}

#[test]
fn a_yearly_baseline_file_has_every_day() {
    let text = ibf(corrected("xyz"), "FLX").expect("a file");
    let lines: Vec<&str> = text.split("\r\n").collect();
    assert!(lines[0].starts_with("XYZF") && lines[0].ends_with("FLX 2025"), "{}", lines[0]);
    let star = lines.iter().position(|line| *line == "*").expect("observed baselines");
    assert_eq!(star - 1, 16);
    assert!(lines[star + 1].starts_with("001") && lines[star + 365].starts_with("365"));
    assert!(lines[star + 10].contains(" -3.20"), "{}", lines[star + 10]);
    assert!(lines[star + 200].contains("99999.00"), "{}", lines[star + 200]);
}
