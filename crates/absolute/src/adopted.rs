//! The baseline between the measurements.

use common::number::significant;
use common::time::Start;
use common::{
    AbsoluteSet, AdoptedBaseline, AdoptedBaselines, BaselineFollows, BaselineStep, Code, Document, Findings,
    Quantity, Recording, procedure,
};
use indexmap::IndexMap;
use physics::Components;

use crate::Error;
use crate::evidence::{At, Course, Data, Mixture, Regressor};
use crate::sets::{Measured, moment};
use crate::words::named;

/// ln of the posterior odds from which a step, a column or a measurement that is off is taken.
const TAKEN: f64 = 3.0;
/// Standard deviation of a step or of a measurement that is off, nT.
const STEP_NT: f64 = 10.0;
/// The same of what a column makes, in its rms.
const FOLLOWS_NT: f64 = 5.0;
/// Most of them.
const MOST: usize = 12;
/// More measurements than this are averaged in groups.
const MOST_MEASUREMENTS: usize = 300;
/// A baseline is adopted for so long before the first measurement and after the last, s.
const FURTHEST_S: f64 = 30.0 * 86_400.0;
/// Days with a node of their own; of a longer series every second one has one, or fewer.
const MOST_DAYS: usize = 4000;
const YEAR_S: f64 = 365.25 * 86_400.0;
const DAY_S: f64 = 86_400.0;

/// What explains measurements beside the time.
#[derive(Clone, Debug, PartialEq)]
enum Cause {
    /// Before this measurement.
    Step(usize),
    /// This measurement alone.
    Off(usize),
    /// This column.
    Column(usize),
}

/// A column of the variometer at the measurements, over its rms.
struct Follows {
    name: String,
    mean: f64,
    rms: f64,
    at: Vec<f64>,
}

/// Measurements that are used: several of them, averaged, where there are very many.
struct Used {
    time_s: f64,
    recording: String,
    /// Places in the document's list.
    sets: Vec<usize>,
}

/// The baselines of each component, with what looks wrong.
///
/// Errors: a fit that fails.
pub fn adopted(
    document: &Document,
    measured: &Measured,
    written: &[AbsoluteSet],
    components: Components,
) -> Result<(AdoptedBaselines, Findings), Error> {
    let mut findings = Findings::default();
    let outliers: Vec<bool> = (0..written.len()).map(|at| measured.outlier(at).is_some()).collect();
    let good: Vec<usize> = (0..written.len()).filter(|at| !outliers[*at]).collect();
    let good = if good.is_empty() { (0..written.len()).collect() } else { good };
    let used: Vec<Used> = (good.chunks(good.len().div_ceil(MOST_MEASUREMENTS)))
        .map(|sets| Used {
            time_s: sets.iter().map(|at| measured.time_s(*at)).sum::<f64>() / sets.len() as f64,
            recording: written[sets[0]].recording.clone(),
            sets: sets.to_vec(),
        })
        .collect();
    let [start_s, end_s] = span(document, [used[0].time_s, used[used.len() - 1].time_s]);
    let follows = follows(document, &used);
    let days = ((end_s - start_s) / DAY_S).ceil().max(1.0) as usize;
    let every = days.div_ceil(MOST_DAYS);
    let mut times: Vec<f64> = (0..=days.div_ceil(every)).map(|node| (node * every) as f64 * DAY_S).collect();
    let mut found = Vec::new();
    for k in 0..3 {
        let component = Component::of(measured, &used, k, components)?;
        let (causes, mixture) = component.causes(&follows)?;
        for cause in &causes {
            if let (Cause::Step(before), _) = cause {
                times.extend([0.5 * (used[before - 1].time_s + used[*before].time_s) - start_s; 2]);
            }
        }
        found.push((component, causes, mixture));
    }
    times.sort_by(f64::total_cmp);
    times.dedup_by(|a, b| *a == *b && (*a / DAY_S).fract() == 0.0);
    let pillars = measured.sets.iter().map(|(set, _)| set.pillar[0]);
    let mut result = AdoptedBaselines {
        start: moment(start_s),
        pillar_difference_nt: pillars.sum::<f64>() / measured.sets.len() as f64,
        ..AdoptedBaselines::default()
    };
    for (k, (component, causes, mixture)) in found.into_iter().enumerate() {
        let key = components.keys()[k];
        let common = common_std(measured, &used, k) / components.units()[k];
        let baseline = component.written(&used, &follows, &causes, &mixture, &times, start_s, common)?;
        let (name, unit) = named(key);
        for (cause, factor) in &causes {
            if let Cause::Off(at) = cause {
                let words = format!(
                    "{name} of \"{}\" is off the baseline by more than the other measurements scatter (ln of the Bayes factor {}); it is not used, measure it again",
                    used[*at].recording,
                    significant(*factor, 2)
                );
                findings.push(Code::Outliers.about(&used[*at].recording).said(words));
            }
        }
        for step in &baseline.steps {
            let words =
                format!("{name} steps by {}{unit} between {} and {}", step.size, step.after, step.before);
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

/// Temperatures and tilts beside the variometer, where they change.
fn follows(document: &Document, used: &[Used]) -> Vec<Follows> {
    let mut points: IndexMap<&str, Vec<(f64, f64)>> = IndexMap::new();
    for recording in document.recordings.iter().filter(|one| one.procedure == procedure::VARIOMETER) {
        let Some((start, times)) = recording.start().zip(recording.column("time_s")) else { continue };
        for (name, column) in &recording.columns {
            if name.ends_with("_c") || name.ends_with("_rad") {
                let all = times.iter().zip(column.iter()).filter(|(_, value)| value.is_finite());
                points
                    .entry(name)
                    .or_default()
                    .extend(all.map(|(time, value)| (start.unix_s + time, *value)));
            }
        }
    }
    let of = |(name, mut all): (&str, Vec<(f64, f64)>)| {
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let near = |one: &Used| {
            let next = all.partition_point(|(time, _)| *time < one.time_s).min(all.len() - 1);
            all[next].1
        };
        let at: Vec<f64> = used.iter().map(near).collect();
        let mean = at.iter().sum::<f64>() / at.len() as f64;
        let rms = (at.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / at.len() as f64).sqrt();
        (rms > 0.0 && used.len() > 3).then(|| Follows {
            name: name.to_string(),
            mean,
            rms,
            at: at.iter().map(|value| (value - mean) / rms).collect(),
        })
    };
    points.into_iter().filter(|(_, all)| !all.is_empty()).filter_map(of).collect()
}

/// The measurements of one component.
struct Component {
    data: Data,
    mean_nt: f64,
    /// nT in its unit.
    unit_nt: f64,
}

impl Component {
    fn of(measured: &Measured, used: &[Used], k: usize, components: Components) -> Result<Self, Error> {
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
        let values: Vec<(f64, f64)> = used.iter().map(one).collect();
        let mean_nt = values.iter().map(|(value, _)| value).sum::<f64>() / values.len() as f64;
        Ok(Self {
            data: Data {
                years: used.iter().map(|one| (one.time_s - used[0].time_s) / YEAR_S).collect(),
                value_nt: values.iter().map(|(value, _)| value - mean_nt).collect(),
                variance: values.iter().map(|(_, variance)| *variance).collect(),
            },
            mean_nt,
            unit_nt: rad_nt * components.units()[k],
        })
    }

    fn regressor(&self, cause: &Cause, follows: &[Follows]) -> Regressor {
        let count = self.data.years.len();
        let from = |is: &dyn Fn(usize) -> bool| (0..count).map(|i| f64::from(u8::from(is(i)))).collect();
        match cause {
            Cause::Step(before) => Regressor { at: from(&|i| i >= *before), prior_nt: STEP_NT },
            Cause::Off(at) => Regressor { at: from(&|i| i == *at), prior_nt: STEP_NT },
            Cause::Column(column) => Regressor { at: follows[*column].at.clone(), prior_nt: FOLLOWS_NT },
        }
    }

    fn regressors(&self, causes: &[(Cause, f64)], follows: &[Follows]) -> Vec<Regressor> {
        causes.iter().map(|(cause, _)| self.regressor(cause, follows)).collect()
    }

    /// Takes causes one by one, each time that of most evidence, while the readings are for it. Steps, single
    /// measurements and columns have the same prior odds as kinds, shared out among their members.
    fn causes(&self, follows: &[Follows]) -> Result<(Vec<(Cause, f64)>, Mixture), Error> {
        let count = self.data.years.len();
        // On either side of a step are two measurements.
        let steps = (2..count.saturating_sub(1)).map(Cause::Step);
        let all: Vec<Cause> = steps
            .chain((0..if count > 3 { count } else { 0 }).map(Cause::Off))
            .chain((0..follows.len()).map(Cause::Column))
            .collect();
        let mut taken: Vec<(Cause, f64)> = Vec::new();
        loop {
            let mixture = Mixture::of(&self.data, &self.regressors(&taken, follows))?;
            let others = all.iter().filter(|cause| !taken.iter().any(|(other, _)| other == *cause));
            let others: Vec<Cause> = others.cloned().collect();
            let more: Vec<Regressor> = others.iter().map(|cause| self.regressor(cause, follows)).collect();
            let factors = mixture.log_bayes_factors(&more);
            let best = (others.into_iter().zip(factors))
                .map(|(cause, factor)| {
                    let members = if matches!(cause, Cause::Column(_)) { follows.len() } else { count };
                    (cause, factor, factor - (members as f64).ln())
                })
                .max_by(|a, b| a.2.total_cmp(&b.2));
            match best {
                Some((cause, factor, odds)) if odds > TAKEN && taken.len() < MOST => {
                    taken.push((cause, factor))
                }
                _ => return Ok((taken, mixture)),
            }
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn written(
        &self,
        used: &[Used],
        follows: &[Follows],
        causes: &[(Cause, f64)],
        mixture: &Mixture,
        times: &[f64],
        start_s: f64,
        common: f64,
    ) -> Result<AdoptedBaseline, Error> {
        let regressors = self.regressors(causes, follows);
        let step_s = |before: usize| 0.5 * (used[before - 1].time_s + used[before].time_s);
        let mut result = AdoptedBaseline::default();
        let at = |(node, time): (usize, &f64)| {
            let time_s = start_s + time;
            // Of two nodes at a step the second is behind it.
            let second = node > 0 && times[node - 1] == *time;
            let behind = |step_s: f64| time_s > step_s || (second && time_s == step_s);
            let regressors = causes.iter().map(|(cause, _)| match cause {
                Cause::Step(before) if behind(step_s(*before)) => 1.0,
                _ => 0.0,
            });
            At { years: (time_s - used[0].time_s) / YEAR_S, regressors: regressors.collect() }
        };
        let nodes: Vec<At> = times.iter().enumerate().map(at).collect();
        for [value, std] in mixture.at(&self.data, &regressors, &nodes) {
            result.value.push((value + self.mean_nt) / self.unit_nt);
            result.std.push((std / self.unit_nt).hypot(common));
        }
        for ((cause, factor), regressor) in causes.iter().zip(&regressors) {
            let [value, std] = mixture.coefficient(regressor).map(|nt| nt / self.unit_nt);
            match cause {
                Cause::Step(before) => result.steps.push(BaselineStep {
                    after: used[before - 1].recording.clone(),
                    before: used[*before].recording.clone(),
                    time: Start { unix_s: step_s(*before), offset_s: 0.0 }.text().unwrap_or_default(),
                    size: Quantity::new(value, std),
                    log_bayes_factor: *factor,
                }),
                Cause::Column(column) => {
                    let Follows { name, mean, rms, .. } = &follows[*column];
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
        let probabilities: Vec<(Course, f64)> = mixture.probabilities().collect();
        let best = probabilities.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(course, _)| *course);
        result.course = best.map(Course::name).unwrap_or_default();
        result.probabilities = probabilities.iter().map(|(course, share)| (course.name(), *share)).collect();
        result.scatter_std = mixture.scatter_nt() / self.unit_nt;
        result.left_out_rms = best.and_then(|best| mixture.left_out_rms(best)).unwrap_or(0.0) / self.unit_nt;
        Ok(result)
    }
}
