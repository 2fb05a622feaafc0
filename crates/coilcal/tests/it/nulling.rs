//! Spectra of the nulled field against the site noise that was simulated.

use common::{Axis, Document, NullingCalibration};
use serde_json::{Value, json};

use crate::build::{calibrated, simulated};

/// The noise of each site: A/f + white, and mains.
fn plan(seed: u64, mains: f64) -> Value {
    let site = |flicker: f64| json!({"noise": {"white_rms_nt": 0.02, "flicker_nt2_per_hz_at_1hz": flicker}, "mains_nt": [mains, 0, 0]});
    json!({
        "fluxcal": 1,
        "seed": seed,
        "start": "1977-05-23T08:00:00-05:00",
        "instrument": {"sensors": ["x", "y"]},
        "truth": {"site": {"weekday-day": site(0.002), "weekday-night": site(0.0004), "weekend-day": site(0.0006), "weekend-night": site(0.0002)}},
        "procedures": [{"procedure": "nulling_residual", "id": "null"}]
    })
}

fn found(plan: &Value) -> NullingCalibration {
    *calibrated(simulated(plan)).nulling.expect("spectra")
}

#[test]
fn the_merged_spectrum_is_that_of_the_site() {
    let (mut inside, mut all) = (0, 0);
    for seed in 0..5 {
        let nulling = found(&plan(seed, 0.0));
        assert_eq!(nulling.sites.len(), 4);
        assert_eq!(nulling.quietest.as_deref(), Some("weekend-night"));
        for (name, flicker) in [("weekday-day", 0.002), ("weekend-night", 0.0002)] {
            let site = &nulling.sites[name];
            let bands: Vec<[f64; 2]> = site.series.iter().map(|series| series.band_hz).collect();
            let end = bands[0][1];
            assert!((end - 0.08).abs() < 1e-9 && bands[1][0] == end && bands[2][1] == 64.0, "{bands:?}");
            for axis in [Axis::X, Axis::Y] {
                let spectrum = site.spectra.get(axis).expect("a spectrum");
                for (k, f) in spectrum.frequency_hz.iter().enumerate() {
                    // White noise of 0.02 nT at the rate of the series in whose band f lies; away from the
                    // lowest frequencies, where the window smears the slope.
                    let series = site.series.iter().find(|series| *f <= series.band_hz[1]).expect("a series");
                    let defined = flicker / f + 2.0 * 0.02 * 0.02 / series.rate_hz;
                    if *f > 4.0 * series.band_hz[0] || series.rate_hz > 1.0 {
                        inside += u32::from(
                            (spectrum.low_nt2_per_hz[k]..=spectrum.high_nt2_per_hz[k]).contains(&defined),
                        );
                        all += 1;
                    }
                }
            }
        }
    }
    let share = f64::from(inside) / f64::from(all);
    println!("{inside} of {all} bins hold the truth: {:.1} %", 100.0 * share);
    assert!((0.92..0.98).contains(&share), "{share}");
}

#[test]
fn expected_rms_is_the_root_of_the_area() {
    let nulling = found(&plan(3, 0.0));
    for expected in &nulling.sites["weekday-day"].expected {
        let [low, high] = expected.band_hz;
        assert!((low - 1.0 / expected.length_s).abs() < 1e-12 && high == 50.0);
        // A ln(f₂/f₁), and white noise in the bands: to 0.08 Hz at 0.2 Hz, 0.8 Hz at 2 Hz, 50 Hz at 128 Hz.
        let white: f64 = [(0.0, 0.08, 0.2), (0.08, 0.8, 2.0), (0.8, 50.0, 128.0)]
            .iter()
            .map(|(from, to, rate)| {
                (f64::min(*to, high) - f64::max(*from, low)).max(0.0) * 2.0 * 0.02 * 0.02 / rate
            })
            .sum();
        let truth = (0.002 * (high / low).ln() + white).sqrt();
        let rms = expected.rms_nt.get(Axis::X).expect("an rms");
        let sigmas = (rms.value() - truth) / rms.std().expect("a std");
        println!(
            "{} s: {:.4} ± {:.4} nT for {truth:.4}",
            expected.length_s,
            rms.value(),
            rms.std().expect("a std")
        );
        assert!(sigmas.abs() < 4.0, "{} s: {sigmas} sigma", expected.length_s);
    }
}

#[test]
fn mains_is_found_at_its_frequency_and_at_its_alias_and_nowhere_else() {
    let nulling = found(&plan(1, 0.3));
    for (name, site) in &nulling.sites {
        let mains: Vec<_> = site.lines.iter().filter(|line| line.sensor == "x").collect();
        let fast = mains.iter().find(|line| line.recording.ends_with("-3")).expect("a line");
        assert_eq!(fast.name.as_deref(), Some("mains 60 Hz"), "{name}");
        assert!((fast.amplitude_nt / 0.3 - 1.0).abs() < 0.2, "{name}: {}", fast.amplitude_nt);
    }
    // At 100 Hz the mains of 60 Hz stands at 40 Hz.
    let mut slow = plan(2, 0.3);
    slow["procedures"][0]["sites"] = json!(["weekday-day"]);
    slow["procedures"][0]["series"] = json!([{"length_s": 60, "rate_hz": 100}]);
    let lines = &found(&slow).sites["weekday-day"].lines;
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert_eq!(lines[0].name.as_deref(), Some("alias of mains 60 Hz"));
    // Without mains nothing is claimed: 60 series of two sensors at a level of 1e-3 each.
    let claimed: usize = (10..15)
        .map(|seed| found(&plan(seed, 0.0)).sites.values().map(|site| site.lines.len()).sum::<usize>())
        .sum();
    println!("lines claimed in 120 clean spectra: {claimed}");
    assert!(claimed <= 2, "{claimed}");
}

#[test]
fn a_series_at_uneven_times_is_read_and_that_is_said() {
    let mut plan = plan(3, 0.0);
    plan["procedures"][0]["sites"] = json!(["weekday-day"]);
    plan["procedures"][0]["series"] = json!([{"length_s": 60, "rate_hz": 100}]);
    let mut document = simulated(&plan);
    let uneven_s = |document: &Document| {
        let nulling = calibrated(document.clone()).nulling.expect("spectra");
        nulling.sites["weekday-day"].series[0].uneven_s
    };
    assert_eq!(uneven_s(&document), None);
    let time = document.recordings[0].columns.get_mut("time_s").expect("times");
    time.iter_mut().enumerate().for_each(|(row, t)| *t += 0.009 * f64::from((row as u32 * 7) % 5) / 4.0);
    let told = uneven_s(&document).expect("uneven");
    assert!((0.0025..0.009).contains(&told), "{told}");
}
