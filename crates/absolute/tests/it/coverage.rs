//! Coverage of the 95 % intervals over simulated years. FLUXCAL_CAMPAIGNS sets how many years.

use absolute::{Options, run};
use common::{AbsoluteCalibration, BaselineFollows, Quantity};
use simulate::{BaselinePlan, ObservatoryPlan, TheodolitePlan, observatory};

/// The share of intervals that hold, and what is allowed.
const BAND: [f64; 2] = [0.93, 0.97];

struct Year {
    found: AbsoluteCalibration,
    /// Unix time, s, and baseline values in the units of the document.
    truth: Vec<(f64, [f64; 3])>,
    /// Unix time, s, and temperature of the variometer.
    room: Vec<(f64, f64)>,
}

fn year(plan: &ObservatoryPlan) -> Year {
    let made = observatory(plan).expect("a plan");
    let document =
        run(made.document, &Options::default()).unwrap_or_else(|error| panic!("{}: {error}", plan.seed));
    let variometer = &document.recordings[0];
    let start = variometer.start().expect("a start").unix_s;
    let [times, room] =
        ["time_s", "sensor_temperature_c"].map(|name| variometer.column(name).expect("a column"));
    let room = times.iter().zip(room).map(|(time, room)| (start + time, *room)).collect();
    let found = *document.calibration.expect("a calibration").absolute.expect("measurements");
    let degrees = found.components.as_deref() == Some("hez");
    let unit = |[x, y, z]: [f64; 3]| [x, if degrees { y.to_degrees() } else { y }, z];
    Year { found, truth: made.truth.into_iter().map(|(time, values)| (time, unit(values))).collect(), room }
}

fn inside(quantity: &Quantity, truth: f64) -> bool {
    let std = quantity.std().expect("a standard uncertainty");
    (quantity.value() - truth).abs() <= quantity.coverage_factor_95().unwrap_or(1.96) * std
}

/// Observed baseline values, and the adopted ones on the days between the first and the last measurement.
fn shares(plans: impl Iterator<Item = ObservatoryPlan>) -> ([f64; 3], [f64; 3], [usize; 2]) {
    let (mut observed, mut adopted, mut counts) = ([0.0; 3], [0.0; 3], [0; 2]);
    for plan in plans {
        let Year { found, truth, room } = year(&plan);
        let temperature = |time: f64| {
            let next = room.partition_point(|(other, _)| *other < time).clamp(1, room.len() - 1);
            let ((a, from), (b, to)) = (room[next - 1], room[next]);
            from + (to - from) * (time - a) / (b - a)
        };
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
            for (k, [value, std]) in
                nodes.at(time - start).expect("a day of the year").into_iter().enumerate()
            {
                let follows = nodes.components[k].follows.iter();
                let warm =
                    |one: &BaselineFollows| one.coefficient.value() * (temperature(*time) - one.reference);
                let value = value + follows.map(warm).sum::<f64>();
                adopted[k] += f64::from(u8::from((value - values[k]).abs() <= 1.96 * std));
            }
        }
    }
    (observed.map(|one| one / counts[0] as f64), adopted.map(|one| one / counts[1] as f64), counts)
}

/// Of one case: observed intervals hold; gives the share of adopted ones that do, for each component.
fn covered(name: &str, usual: u64, plan: &ObservatoryPlan) -> [f64; 3] {
    let years = testkit::campaigns(usual);
    let plans = (1..=years).map(|seed| ObservatoryPlan { seed, ..plan.clone() });
    let (observed, adopted, [sets, days]) = shares(plans);
    println!(
        "{name}, {years} years: observed {observed:.3?} of {sets}, adopted {adopted:.3?} of {days} days"
    );
    for share in observed {
        let inside = (share * sets as f64).round() as usize;
        assert!(testkit::agrees(inside, sets, BAND, 18), "{name}: observed {share}");
    }
    adopted
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

fn of(baseline: BaselinePlan) -> ObservatoryPlan {
    ObservatoryPlan { theodolite: plain(), baseline, ..ObservatoryPlan::default() }
}

/// The courses are averaged by their probability, so the intervals of adopted baselines hold in 95 % of cases over
/// kinds of baselines that go straight, wander and step: more often where one goes straight, less where it wanders a
/// little.
#[test]
fn intervals_hold() {
    const USUAL: u64 = 2;
    let plan = of(BaselinePlan::default());
    let xyz = ObservatoryPlan { components: "xyz".into(), method: "null".into(), ..plan.clone() };
    let step = BaselinePlan { step_days: vec![120.0], step_nt: 8.0, ..BaselinePlan::default() };
    let straight = BaselinePlan { walk_nt: 0.0, annual_nt: 0.0, ..BaselinePlan::default() };
    let walk = BaselinePlan { walk_nt: 3.0, ..BaselinePlan::default() };
    let cases = [
        ("wandering a little", plan),
        ("xyz, null method", xyz),
        ("a step", of(step)),
        ("a straight drift", of(straight)),
        ("a random walk", of(walk)),
        ("levelling, time and the scalar as well", ObservatoryPlan::default()),
    ];
    let adopted: Vec<f64> = cases.iter().flat_map(|(name, plan)| covered(name, USUAL, plan)).collect();
    let share = adopted.iter().sum::<f64>() / adopted.len() as f64;
    println!("adopted, all cases: {share:.3}");
    // Days of one year are correlated: a year of one component counts as some ten of them.
    let judged = 10 * adopted.len() * testkit::campaigns(USUAL) as usize;
    assert!(testkit::agrees((share * judged as f64).round() as usize, judged, BAND, 1), "adopted {share}");
}
