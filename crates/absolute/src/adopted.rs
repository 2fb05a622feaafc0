//! The baseline between the measurements.

use common::number::significant;
use common::time::Start;
use common::{
    AdoptedBaseline, AdoptedBaselines, BaselineFollows, BaselineStep, Code, Document, Findings, Quantity,
    Recording, procedure,
};
use physics::Components;

use crate::Error;
use crate::causes::{Cause, Follows, explained, follows, regressor};
use crate::evidence::{At, BEFORE_YEARS, Data, Mixture, Regressor, Trend};
use crate::read::moment;
use crate::sets::Measured;
use crate::words::named;

/// More measurements than this are averaged in groups.
const MOST_MEASUREMENTS: usize = 300;
/// A baseline is adopted for so long before the first measurement and after the last, s.
const FURTHEST_S: f64 = 30.0 * 86_400.0;
/// Days with a node of their own; of a longer series every second one has one, or fewer.
const MOST_DAYS: usize = 4000;
const YEAR_S: f64 = 365.25 * 86_400.0;
const DAY_S: f64 = 86_400.0;
const _: () = assert!(FURTHEST_S + DAY_S < BEFORE_YEARS * YEAR_S);

/// Measurements that are used: several of them, averaged, where there are very many.
struct Used {
    time_s: f64,
    /// Places in the document's list.
    sets: Vec<usize>,
    names: Vec<String>,
}

struct Common {
    used: Vec<Used>,
    follows: Vec<Follows>,
    start_s: f64,
}

/// The measurements of one component, and what explains them.
struct Fitted {
    data: Data,
    mean_nt: f64,
    /// nT in its unit.
    unit_nt: f64,
    /// Each with ln of its Bayes factor.
    causes: Vec<(Cause, f64)>,
    mixture: Mixture,
}

/// The baselines of each component, with what looks wrong. Errors: a fit that fails.
pub fn adopted(
    document: &Document,
    measured: &Measured,
    components: Components,
) -> Result<(AdoptedBaselines, Findings), Error> {
    let name = |at: &usize| measured.sets[*at].0.id.clone();
    let (outliers, good): (Vec<usize>, Vec<usize>) =
        (0..measured.sets.len()).partition(|at| measured.outlier(*at).is_some());
    let (outliers, good) = if good.is_empty() { (good, outliers) } else { (outliers, good) };
    let used: Vec<Used> = (good.chunks(good.len().div_ceil(MOST_MEASUREMENTS)))
        .map(|sets| Used {
            time_s: sets.iter().map(|at| measured.time_s(*at)).sum::<f64>() / sets.len() as f64,
            sets: sets.to_vec(),
            names: sets.iter().map(name).collect(),
        })
        .collect();
    let [start_s, end_s] = span(document, [used[0].time_s, used[used.len() - 1].time_s]);
    let times: Vec<f64> = used.iter().map(|one| one.time_s).collect();
    let all = Common { follows: follows(document, &times), used, start_s };
    let fit = |stepped: &[usize]| {
        (0..3).map(|k| Fitted::of(measured, &all, k, components, stepped)).collect::<Result<Vec<_>, _>>()
    };
    let mut fitted = fit(&[])?;
    // What moves one component moves the others as a rule: where one steps, the place is known for the others.
    let stepped: Vec<usize> = fitted.iter().flat_map(Fitted::stepped).collect();
    if !stepped.is_empty() {
        fitted = fit(&stepped)?;
    }
    let steps = fitted.iter().flat_map(Fitted::stepped).map(|before| step_s(&all.used, before) - all.start_s);
    let mut steps: Vec<f64> = steps.collect();
    steps.sort_by(f64::total_cmp);
    steps.dedup();
    let days = ((end_s - start_s) / DAY_S).ceil().max(1.0) as usize;
    let every = days.div_ceil(MOST_DAYS);
    let days = (0..=days.div_ceil(every)).map(|node| (node * every) as f64 * DAY_S);
    let mut times: Vec<f64> = days.filter(|day| !steps.contains(day)).collect();
    steps.iter().for_each(|step| times.extend([*step; 2]));
    times.sort_by(f64::total_cmp);
    let pillars = measured.sets.iter().map(|(set, _)| set.pillar[0]);
    let mut result = AdoptedBaselines {
        start: moment(start_s),
        pillar_difference_nt: pillars.sum::<f64>() / measured.sets.len() as f64,
        ..AdoptedBaselines::default()
    };
    let mut findings = Findings::default();
    for (k, (key, fitted)) in components.keys().into_iter().zip(fitted).enumerate() {
        let common = common_std(measured, &all.used, k) / components.units()[k];
        let mut baseline = fitted.written(&all, &times, common);
        let (letter, unit) = named(key);
        for (cause, factor) in &fitted.causes {
            let Cause::Off(at) = cause else { continue };
            let names = &all.used[*at].names;
            let words = format!(
                "{letter} of \"{}\" deviates from the baseline by more than the scatter of the other measurements (ln of the Bayes factor {}); it is not used, measure it again",
                names.join("\", \""),
                significant(*factor, 2)
            );
            findings.push(Code::Outliers.about(&names[0]).said(words));
            baseline.not_used.extend(names.clone());
        }
        baseline.not_used.extend(outliers.iter().map(name));
        for BaselineStep { size, after, before, .. } in &baseline.steps {
            let words = format!("{letter} steps by {size}{unit} between {after} and {before}");
            findings.push(Code::BaselineSteps.about(key).said(words));
        }
        result.common_std.insert(key.to_string(), common);
        result.components.insert(key.to_string(), baseline);
    }
    result.time_s = times;
    Ok((result, findings))
}

/// The days that baselines are for: those of the measurements and of the variometer, not too far from them.
fn span(document: &Document, [first, last]: [f64; 2]) -> [f64; 2] {
    let of = |one: &Recording| {
        let (start, times) = one.start().zip(one.column("time_s"))?;
        Some([start.unix_s + times.first()?, start.unix_s + times.last()?])
    };
    let series =
        document.recordings.iter().filter(|one| one.procedure == procedure::VARIOMETER).filter_map(of);
    let [from, to] = series.fold([first, last], |[from, to], one| [from.min(one[0]), to.max(one[1])]);
    [(from.max(first - FURTHEST_S) / DAY_S).floor() * DAY_S, to.min(last + FURTHEST_S)]
}

/// What the azimuth of the mark and the difference of the pillars leave uncertain in all values, the largest.
fn common_std(measured: &Measured, used: &[Used], k: usize) -> f64 {
    let of = |at: usize| measured.common(at).iter().map(|moved| moved[k] * moved[k]).sum::<f64>().sqrt();
    used.iter().flat_map(|one| &one.sets).map(|at| of(*at)).fold(0.0, f64::max)
}

/// When a step before a measurement is taken to be, Unix, s.
fn step_s(used: &[Used], before: usize) -> f64 {
    0.5 * (used[before - 1].time_s + used[before].time_s)
}

impl Fitted {
    fn of(
        measured: &Measured,
        all: &Common,
        k: usize,
        components: Components,
        stepped: &[usize],
    ) -> Result<Self, Error> {
        // A declination is weighed as the field across it.
        let horizontal = measured.horizontal_nt();
        let rad_nt = if components.units()[k] == 1.0 { 1.0 } else { horizontal };
        let one = |used: &Used| {
            let each = used.sets.iter().map(|at| {
                (measured.baseline(*at)[k] * rad_nt, measured.covariance(*at)[(k, k)] * rad_nt * rad_nt)
            });
            let weights: f64 = each.clone().map(|(_, variance)| 1.0 / variance).sum();
            (each.map(|(value, variance)| value / variance).sum::<f64>() / weights, 1.0 / weights)
        };
        let values: Vec<(f64, f64)> = all.used.iter().map(one).collect();
        let mean_nt = values.iter().map(|(value, _)| value).sum::<f64>() / values.len() as f64;
        let first_s = all.used[0].time_s;
        let data = Data {
            years: all.used.iter().map(|one| (one.time_s - first_s) / YEAR_S).collect(),
            value_nt: values.iter().map(|(value, _)| value - mean_nt).collect(),
            variance: values.iter().map(|(_, variance)| *variance).collect(),
        };
        let (causes, mixture) = explained(&data, &all.follows, stepped)?;
        Ok(Self { data, mean_nt, unit_nt: rad_nt * components.units()[k], causes, mixture })
    }

    /// The measurements before which it steps.
    fn stepped(&self) -> impl Iterator<Item = usize> {
        self.causes.iter().filter_map(|(cause, _)| match cause {
            Cause::Step(before) => Some(*before),
            _ => None,
        })
    }

    fn written(&self, all: &Common, times: &[f64], common: f64) -> AdoptedBaseline {
        let Self { causes, mixture, .. } = self;
        let regressors: Vec<Regressor> =
            causes.iter().map(|(cause, _)| regressor(cause, all.used.len(), &all.follows)).collect();
        let mut result = AdoptedBaseline::default();
        let at = |(node, time): (usize, &f64)| {
            // Of two nodes at a step the second is behind it.
            let second = node > 0 && times[node - 1] == *time;
            let behind = |step: f64| *time > step || (second && *time == step);
            let regressors = causes.iter().map(|(cause, _)| match cause {
                Cause::Step(before) if behind(step_s(&all.used, *before) - all.start_s) => 1.0,
                _ => 0.0,
            });
            let years = (all.start_s + time - all.used[0].time_s) / YEAR_S;
            At { years, regressors: regressors.collect() }
        };
        let nodes: Vec<At> = times.iter().enumerate().map(at).collect();
        for [value, std] in mixture.at(&self.data, &regressors, &nodes) {
            result.value.push((value + self.mean_nt) / self.unit_nt);
            result.std.push((std / self.unit_nt).hypot(common));
        }
        for ((cause, factor), regressor) in causes.iter().zip(&regressors) {
            let [value, std] = mixture.coefficient(regressor).map(|nt| nt / self.unit_nt);
            match cause {
                Cause::Step(before) => {
                    let time = Start { unix_s: step_s(&all.used, *before), offset_s: 0.0 };
                    result.steps.push(BaselineStep {
                        after: all.used[before - 1].names.last().cloned().unwrap_or_default(),
                        before: all.used[*before].names[0].clone(),
                        time: time.text().unwrap_or_default(),
                        size: Quantity::new(value, std),
                        log_bayes_factor: *factor,
                    });
                }
                Cause::Column(column) => {
                    let Follows { name, mean, rms, .. } = &all.follows[*column];
                    result.follows.push(BaselineFollows {
                        column: name.clone(),
                        coefficient: Quantity::new(value / rms, std / rms),
                        reference: *mean,
                        log_bayes_factor: *factor,
                    });
                }
                Cause::Off(_) => {}
            }
        }
        let probabilities = mixture.probabilities();
        let likeliest = probabilities.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let best = likeliest.map_or(Trend::Spline, |(trend, _)| *trend);
        result.trend = best.name().to_string();
        let shares = probabilities.iter().map(|(trend, share)| (trend.name().into(), *share));
        result.probabilities = shares.collect();
        result.scatter_std = mixture.scatter_nt() / self.unit_nt;
        result.left_out_rms = mixture.left_out_rms(best).unwrap_or(0.0) / self.unit_nt;
        result
    }
}
