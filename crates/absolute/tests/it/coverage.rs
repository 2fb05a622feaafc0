//! Coverage of the 95 % intervals over simulated years. FLUXCAL_CAMPAIGNS sets how many years.

use absolute::{Options, run};
use common::{AbsoluteCalibration, Quantity};
use simulate::{BaselinePlan, ObservatoryPlan, TheodolitePlan, observatory};

/// The share of intervals that hold, and what is allowed.
const BAND: [f64; 2] = [0.93, 0.97];
/// Of adopted baselines, which average over sizes that few measurements tell: they may hold more often.
const WIDE: [f64; 2] = [0.93, 0.99];

struct Year {
    found: AbsoluteCalibration,
    /// Unix time, s, and baseline values in the units of the document.
    truth: Vec<(f64, [f64; 3])>,
}

fn year(plan: &ObservatoryPlan) -> Year {
    let made = observatory(plan).expect("a plan");
    let document =
        run(made.document, &Options::default()).unwrap_or_else(|error| panic!("{}: {error}", plan.seed));
    let found = *document.calibration.expect("a calibration").absolute.expect("measurements");
    let degrees = found.components.as_deref() == Some("hez");
    let unit = |[x, y, z]: [f64; 3]| [x, if degrees { y.to_degrees() } else { y }, z];
    Year { found, truth: made.truth.into_iter().map(|(time, values)| (time, unit(values))).collect() }
}

fn inside(quantity: &Quantity, truth: f64) -> bool {
    let std = quantity.std().expect("a standard uncertainty");
    (quantity.value() - truth).abs() <= quantity.coverage_factor_95().unwrap_or(1.96) * std
}

/// Observed baseline values, and the adopted ones on the days between the first and the last measurement.
fn shares(plans: impl Iterator<Item = ObservatoryPlan>) -> ([f64; 3], [f64; 3], [usize; 2]) {
    let (mut observed, mut adopted, mut counts) = ([0.0; 3], [0.0; 3], [0; 2]);
    for plan in plans {
        let Year { found, truth } = year(&plan);
        let sets = found.sets.len();
        for (set, (_, values)) in found.sets.iter().zip(&truth) {
            counts[0] += 1;
            for (k, quantity) in set.baseline.values().enumerate() {
                observed[k] += f64::from(u8::from(inside(quantity, values[k])));
            }
        }
        let nodes = found.adopted.as_ref().expect("baselines");
        let start = common::time::Start::parse(&nodes.start).expect("a start").unix_s;
        let (first, last) = (truth[0].0, truth[sets - 1].0);
        for (time, values) in truth[sets..].iter().filter(|(time, _)| (first..=last).contains(time)) {
            counts[1] += 1;
            for (k, baseline) in nodes.components.values().enumerate() {
                let next = nodes.time_s.partition_point(|node| start + node < *time);
                let share =
                    (time - start - nodes.time_s[next - 1]) / (nodes.time_s[next] - nodes.time_s[next - 1]);
                let at = |all: &[f64]| all[next - 1] + share * (all[next] - all[next - 1]);
                adopted[k] +=
                    f64::from(u8::from((at(&baseline.value) - values[k]).abs() <= 1.96 * at(&baseline.std)));
            }
        }
    }
    (observed.map(|one| one / counts[0] as f64), adopted.map(|one| one / counts[1] as f64), counts)
}

fn covered(name: &str, usual: u64, plan: &ObservatoryPlan) {
    let years = testkit::campaigns(usual);
    let plans = (1..=years).map(|seed| ObservatoryPlan { seed, ..plan.clone() });
    let (observed, adopted, [sets, days]) = shares(plans);
    println!(
        "{name}, {years} years: observed {observed:.3?} of {sets}, adopted {adopted:.3?} of {days} days"
    );
    for share in observed {
        assert!(
            testkit::agrees((share * sets as f64).round() as usize, sets, BAND, 3),
            "{name}: observed {share}"
        );
    }
    for share in adopted {
        // Days of one year are correlated: a year counts as some ten of them.
        let judged = 10 * years as usize;
        assert!(
            testkit::agrees((share * judged as f64).round() as usize, judged, WIDE, 3),
            "{name}: adopted {share}"
        );
    }
}

/// Circles and magnetometer alone: what the readings themselves tell.
fn plain() -> TheodolitePlan {
    TheodolitePlan {
        levelling_arcsec: 0.0,
        residual_nt: 0.05,
        time_s: 0.5,
        scalar_nt: 0.0,
        ..TheodolitePlan::default()
    }
}

#[test]
fn years_of_a_quiet_pillar() {
    let plan = ObservatoryPlan { theodolite: plain(), ..ObservatoryPlan::default() };
    covered("hez", 6, &plan);
    covered(
        "xyz, null method",
        6,
        &ObservatoryPlan { components: "xyz".into(), method: "null".into(), ..plan },
    );
}

#[test]
fn years_with_steps() {
    let baseline = BaselinePlan { step_days: vec![120.0], step_nt: 8.0, ..BaselinePlan::default() };
    covered("a step", 6, &ObservatoryPlan { theodolite: plain(), baseline, ..ObservatoryPlan::default() });
}
