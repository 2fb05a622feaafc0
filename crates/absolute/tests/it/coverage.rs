//! Coverage of the 95 % intervals over simulated years. FLUXCAL_CAMPAIGNS sets how many years.

use absolute::run;
use common::{AbsoluteCalibration, BaselineFollows, Quantity};
use simulate::{BaselinePlan, ObservatoryPlan, TheodolitePlan, observatory};

/// The share of intervals of observed baseline values that hold, and what is allowed.
const BAND: [f64; 2] = [0.93, 0.98];
/// Of adopted baselines, each beside a random walk: where nothing wanders they hold more often.
const WIDE: [f64; 2] = [0.93, 1.0];
/// Days of a year on which adopted baselines are judged, far enough apart to be independent.
const APART: usize = 90;
/// What is judged together: cases, each of three components.
const JUDGED: usize = 21;

struct Year {
    found: AbsoluteCalibration,
    /// Unix time, s, and baseline values in the units of the document.
    truth: Vec<(f64, [f64; 3])>,
    /// Unix time, s, and temperature of the variometer.
    room: Vec<(f64, f64)>,
}

fn year(plan: &ObservatoryPlan) -> Year {
    let made = observatory(plan).expect("a plan");
    let document = run(made.document).unwrap_or_else(|error| panic!("{}: {error}", plan.seed));
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

/// Observed baseline values, and the adopted ones on a few days between the first and the last measurement.
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
        let days = truth[sets..].iter().filter(|(time, _)| (first..=last).contains(time));
        for (time, values) in days.skip(APART / 3).step_by(APART) {
            counts[1] += 1;
            for (k, key) in nodes.components.keys().enumerate() {
                let [value, std] = nodes.at(key, time - start).expect("a day of the year");
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

/// The intervals of one case hold.
fn covered(name: &str, usual: u64, plan: &ObservatoryPlan) {
    let years = testkit::campaigns(usual);
    let plans = (1..=years).map(|seed| ObservatoryPlan { seed, ..plan.clone() });
    let (observed, adopted, [sets, days]) = shares(plans);
    println!(
        "{name}, {years} years: observed {observed:.3?} of {sets}, adopted {adopted:.3?} of {days} days"
    );
    for (what, shares, count, band) in [("observed", observed, sets, BAND), ("adopted", adopted, days, WIDE)]
    {
        for share in shares {
            let inside = (share * count as f64).round() as usize;
            assert!(testkit::agrees(inside, count, band, JUDGED), "{name}: {what} {share}");
        }
    }
}

/// Circles and magnetometer alone: what the readings themselves tell.
fn plain() -> TheodolitePlan {
    let (levelling_arcsec, residual_nt, time_s, scalar_nt) = (0.0, 0.05, 0.5, 0.0);
    TheodolitePlan { levelling_arcsec, residual_nt, time_s, scalar_nt, ..TheodolitePlan::default() }
}

fn of(baseline: BaselinePlan) -> ObservatoryPlan {
    ObservatoryPlan { theodolite: plain(), baseline, ..ObservatoryPlan::default() }
}

#[test]
fn intervals_hold() {
    let plan = of(BaselinePlan::default());
    let xyz = ObservatoryPlan { components: "xyz".into(), method: "null".into(), ..plan.clone() };
    let south = ObservatoryPlan { main_field_nt: [20_900.0, -4_000.0, -43_840.0], ..plan.clone() };
    let step = BaselinePlan { step_days: vec![120.0], step_nt: 8.0, ..BaselinePlan::default() };
    let straight = BaselinePlan { walk_nt: 0.0, annual_nt: 0.0, ..BaselinePlan::default() };
    let walk = BaselinePlan { walk_nt: 3.0, ..BaselinePlan::default() };
    // The error of the scalar magnetometer is the same in all measurements of a year: its interval is not judged here.
    let observer = TheodolitePlan { scalar_nt: 0.0, ..TheodolitePlan::default() };
    let levelled = ObservatoryPlan { theodolite: observer, ..ObservatoryPlan::default() };
    let cases = [
        ("wandering a little", plan),
        ("xyz, null method", xyz),
        ("southern field", south),
        ("a step", of(step)),
        ("a straight drift", of(straight)),
        ("a random walk", of(walk)),
        ("levelling and times as well", levelled),
    ];
    cases.iter().for_each(|(name, plan)| covered(name, 2, plan));
}
