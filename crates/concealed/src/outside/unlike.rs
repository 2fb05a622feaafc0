//! No effect of the catalogue comes near to what is outside it: its formulas, written out here, are fitted by
//! least squares.

use nalgebra::{DVector, Vector3};

use super::FURTHER;
use super::means::rate;
use super::tests::campaign;
use crate::base;
use crate::draw::Draw;
use crate::effect::{Effect, in_block, in_geo};
use crate::finer::ode;
use crate::kinds;
use crate::scene::{Campaign, Readings, Run};

/// Largest share of the squares of a contribution that one effect may take, on the average over campaigns.
const MOST: f64 = 0.3;
/// Lags, in readings.
const LAGS: [f64; 4] = [3.0, 10.0, 30.0, 100.0];

/// An effect of the catalogue with the contributions that it is made of.
type Formula = (String, Vec<Readings>);

/// A signal behind a lag, at each row.
fn lagged(run: &Run, rows: f64, signal: impl Fn(f64) -> f64) -> Vec<f64> {
    let (from, tau) = (run.times[0], rows * run.step_s());
    let slope = |t: f64, y: &[f64; 1]| [(signal(t) - y[0]) / tau];
    ode::march(from, [signal(from)], &run.times, 0.5 * run.step_s(), slope).iter().map(|y| y[0]).collect()
}

/// One sensor of a campaign.
struct Sensor<'a> {
    campaign: &'a Campaign,
    sensor: usize,
}

impl Sensor<'_> {
    /// The field along the sensor (0) or across it (1, 2), over 50 000 nT.
    fn field(&self, run: &Run, k: usize, t: f64) -> f64 {
        run.field_sen(&self.campaign.bench, t)[(self.sensor + k) % 3] / 5e4
    }

    fn warm(&self, run: &Run, k: usize, t: f64) -> f64 {
        run.temperatures[k](t) - self.campaign.reference_c[k]
    }

    fn rows(&self, of: impl Fn(&Run) -> Vec<f64>) -> Readings {
        let one = |run: &Run| {
            let mut all = [0; 3].map(|_| vec![0.0; run.times.len()]);
            all[self.sensor] = of(run);
            all
        };
        self.campaign.runs.iter().map(one).collect()
    }

    fn at(&self, of: impl Fn(&Run, f64) -> f64) -> Readings {
        self.rows(|run| run.times.iter().map(|t| of(run, *t)).collect())
    }

    /// A lagged temperature times a field; without a field the temperature alone.
    fn late(&self, rows: f64, thermometer: usize, field: Option<usize>) -> Readings {
        self.rows(|run| {
            let late = lagged(run, rows, |t| self.warm(run, thermometer, t));
            let times = |t: f64| field.map_or(1.0, |k| self.field(run, k, t));
            late.iter().zip(&run.times).map(|(warm, t)| warm * times(*t)).collect()
        })
    }

    fn of_fields(&self) -> Vec<Formula> {
        let power = |n: i32| vec![self.at(|run, t| self.field(run, 0, t).powi(n))];
        let product = |j: usize, k: usize| self.at(|run, t| self.field(run, j, t) * self.field(run, k, t));
        vec![
            ("quadratic_nonlinearity".into(), power(2)),
            ("cubic_nonlinearity".into(), power(3)),
            ("saturation".into(), power(9)),
            ("cross_field".into(), vec![product(1, 1), product(2, 2), product(1, 2)]),
            ("cross_field_sensitivity".into(), vec![product(0, 1), product(0, 2)]),
            ("delay".into(), vec![self.at(|run, t| rate(|t| self.field(run, 0, t), t))]),
            ("ageing".into(), vec![self.at(|_, t| t)]),
            ("sensitivity_ageing".into(), vec![self.at(|run, t| t * self.field(run, 0, t))]),
        ]
    }

    fn of_temperatures(&self) -> Vec<Formula> {
        let of = |k: usize, n: i32| self.at(|run, t| self.warm(run, k, t).powi(n));
        let times = |k: usize, n: i32, j: usize| {
            self.at(|run, t| self.warm(run, k, t).powi(n) * self.field(run, j, t))
        };
        let mut all = vec![("axis_temperature".into(), vec![times(0, 1, 1), times(0, 1, 2)])];
        for k in [0, 1] {
            all.push((format!("offset_temperature {k}"), vec![of(k, 1), of(k, 2)]));
            all.push((format!("sensitivity_temperature {k}"), vec![times(k, 1, 0), times(k, 2, 0)]));
        }
        all
    }

    fn of_lags(&self, rows: f64) -> Vec<Formula> {
        let loop_lag = |run: &Run| lagged(run, rows, |t| self.field(run, 0, t));
        let warm_up = |run: &Run, t: f64| (-t / (rows * run.step_s())).exp();
        vec![
            ("loop_bandwidth".into(), vec![self.rows(loop_lag)]),
            ("warm_up".into(), vec![self.at(warm_up)]),
            ("offset_temperature_lag".into(), vec![self.late(rows, 0, None)]),
            ("offset_electronics_temperature_lag".into(), vec![self.late(rows, 1, None)]),
            ("sensitivity_temperature_lag".into(), vec![self.late(rows, 0, Some(0))]),
            ("sensitivity_electronics_temperature_lag".into(), vec![self.late(rows, 1, Some(0))]),
            ("axis_creep".into(), vec![self.late(rows, 0, Some(1)), self.late(rows, 0, Some(2))]),
        ]
    }
}

/// A field along a coil's axis, of the coil's current.
fn in_coil(
    campaign: &Campaign,
    coil: usize,
    of: impl Fn(&Run, &dyn Fn(f64) -> f64) -> Vec<f64> + Send + Sync + 'static,
) -> Vec<Readings> {
    let act = in_geo(move |campaign, run, _| {
        let axis: Vector3<f64> = campaign.bench.eta.column(coil).into();
        let current = |t: f64| run.current(coil).map_or(0.0, |current| current(t));
        of(run, &current).into_iter().map(|share| axis * share).collect()
    });
    vec![act(campaign, &campaign.plain(), 1.0)]
}

fn of_coils(campaign: &Campaign) -> Vec<Formula> {
    let warm = |run: &Run, current: &dyn Fn(f64) -> f64| {
        run.times.iter().map(|t| (run.temperatures[2](*t) - 21.0) * current(*t)).collect()
    };
    let mut all = Vec::new();
    for coil in 0..3 {
        all.push(("coil_temperature".into(), in_coil(campaign, coil, warm)));
        for rows in LAGS {
            let heated = move |run: &Run, current: &dyn Fn(f64) -> f64| {
                let power = lagged(run, rows, |t| current(t).powi(2));
                power.iter().zip(&run.times).map(|(power, t)| power * current(*t)).collect()
            };
            all.push(("coil_heating".into(), in_coil(campaign, coil, heated)));
            let within = move |run: &Run, current: &dyn Fn(f64) -> f64| lagged(run, rows, current);
            all.push(("eddy_currents".into(), in_coil(campaign, coil, within)));
        }
    }
    all
}

fn of_stray_current(campaign: &Campaign) -> Formula {
    let along = |axis: usize| {
        let act = in_block(move |_, run, _| {
            let current = |t: f64| run.column("panel_current_a").map_or(0.0, |current| current(t));
            run.times.iter().map(|t| Vector3::ith(axis, current(*t))).collect()
        });
        act(campaign, &campaign.plain(), 1.0)
    };
    ("stray_current".into(), [0, 1, 2].map(along).to_vec())
}

fn catalogue(campaign: &Campaign) -> Vec<Formula> {
    let mut all = of_coils(campaign);
    all.push(of_stray_current(campaign));
    for sensor in 0..3 {
        let sensor = Sensor { campaign, sensor };
        all.extend(sensor.of_fields());
        all.extend(sensor.of_temperatures());
        all.extend(LAGS.iter().flat_map(|rows| sensor.of_lags(*rows)));
    }
    all
}

/// What a fresh calibration leaves, as one column.
fn left(campaign: &Campaign, added: &Readings) -> DVector<f64> {
    let rest = base::left(campaign, added);
    DVector::from_iterator(rest.iter().flatten().map(Vec::len).sum(), rest.into_iter().flatten().flatten())
}

/// Columns at right angles to each other, of length one.
fn orthogonal(columns: Vec<DVector<f64>>) -> Vec<DVector<f64>> {
    let mut all: Vec<DVector<f64>> = Vec::new();
    for mut column in columns {
        let before = column.norm();
        all.iter().for_each(|other| column -= other * other.dot(&column));
        if column.norm() > 1e-6 * before {
            all.push(column.normalize());
        }
    }
    all
}

/// The formulas with their contributions as columns, beside a fresh calibration.
fn columns(campaign: &Campaign) -> Vec<(String, Vec<DVector<f64>>)> {
    let of = |parts: Vec<Readings>| orthogonal(parts.iter().map(|part| left(campaign, part)).collect());
    catalogue(campaign).into_iter().map(|(name, parts)| (name, of(parts))).collect()
}

/// The formula that takes most of an effect, with its share of the squares.
fn nearest<'a>(
    campaign: &Campaign,
    effect: &Effect,
    formulas: &'a [(String, Vec<DVector<f64>>)],
) -> (f64, &'a str) {
    let target = left(campaign, &(effect.act)(campaign, &campaign.plain(), 1.0)).normalize();
    let share = |parts: &[DVector<f64>]| parts.iter().map(|part| part.dot(&target).powi(2)).sum::<f64>();
    let all = formulas.iter().map(|(name, parts)| (share(parts), name.as_str()));
    all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, ""))
}

#[test]
fn no_formula_of_the_catalogue_comes_near() {
    const SEEDS: u64 = 4;
    let mut taken = vec![(0.0, String::new()); FURTHER.len()];
    for seed in 0..SEEDS {
        let campaign = campaign(100 + seed);
        let formulas = columns(&campaign);
        for ((name, make), (sum, words)) in FURTHER.into_iter().zip(&mut taken) {
            let effect = make(&campaign, &mut Draw::new(name, seed));
            let (share, formula) = nearest(&campaign, &effect, &formulas);
            *sum += share / SEEDS as f64;
            *words += &format!(" {formula} {share:.2}");
        }
    }
    for ((name, _), (share, words)) in FURTHER.iter().zip(taken) {
        assert!(share < MOST, "{name}: {share} by{words}");
    }
}

/// What is in the catalogue is taken by its own formula: the fit above can find what there is.
#[test]
fn formulas_take_what_the_catalogue_has() {
    let campaign = campaign(200);
    let formulas = columns(&campaign);
    for name in ["offset_temperature", "sensitivity_temperature", "cubic_nonlinearity", "cross_field"] {
        let kind = kinds::ALL.into_iter().find(|kind| kind.name == name).expect("a kind");
        let effect = (kind.make)(&campaign, &mut Draw::new(name, 1));
        let (share, formula) = nearest(&campaign, &effect, &formulas);
        assert!(share > 0.9 && formula.starts_with(name), "{name}: {share} by {formula}");
    }
}
