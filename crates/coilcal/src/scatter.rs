//! Repeats: readings with the same drive, and visits, those of them that were taken one after the other; and
//! the scatter of all about a model, on which type A uncertainties rest.

use common::FTest;
use estimate::linear::LinearFit;
use estimate::stats;

use crate::readings::Reading;

/// Levels are weighted below this probability that they scatter alike.
const UNEQUAL_BELOW: f64 = 1e-3;
/// Degrees of freedom with which the common scatter counts beside a level's own.
const PRIOR_FREEDOM: f64 = 4.0;
/// Currents within this share of the largest are one level.
const SAME: f64 = 1e-4;

/// Numbers of the readings at one drive.
pub type Level = Vec<usize>;

/// Groups the readings into levels, by rising current.
pub fn levels(readings: &[Reading]) -> Vec<Level> {
    let largest = readings.iter().map(|reading| reading.current_a.abs()).fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..readings.len()).collect();
    order.sort_by(|a, b| readings[*a].current_a.total_cmp(&readings[*b].current_a));
    let mut levels: Vec<Level> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for index in order {
        let current = readings[index].current_a;
        match levels.last_mut() {
            Some(level) if current - last <= SAME * largest => level.push(index),
            _ => levels.push(vec![index]),
        }
        last = current;
    }
    levels
}

/// Splits levels into visits, readings of one drive that follow each other: what wanders slowly is common.
fn visits(levels: &[Level]) -> Vec<Level> {
    let of = |level: &Level| {
        let mut members = level.clone();
        members.sort_unstable();
        members.chunk_by(|before, after| before + 1 == *after).map(<[usize]>::to_vec).collect::<Vec<_>>()
    };
    levels.iter().flat_map(of).collect()
}

/// Sum of squares of values about the means of their levels, and its degrees of freedom.
pub fn within(levels: &[Level], value: impl Fn(usize) -> f64) -> (f64, f64) {
    let (mut sum, mut freedom) = (0.0, 0.0);
    for level in levels {
        let mean = mean(level, &value);
        sum += level.iter().map(|member| (value(*member) - mean).powi(2)).sum::<f64>();
        freedom += level.len() as f64 - 1.0;
    }
    (sum, freedom)
}

pub fn mean(level: &[usize], value: impl Fn(usize) -> f64) -> f64 {
    level.iter().map(|member| value(*member)).sum::<f64>() / level.len() as f64
}

/// The standard deviation on which type A uncertainties rest.
pub struct Scatter {
    pub std_nt: f64,
    pub freedom: f64,
    pub source: &'static str,
}

/// Standard deviation of each reading over the common one: 1, or, where the scatter differs between levels
/// more than chance allows (Bartlett), that of its level, drawn towards the common one.
pub fn relative_std(readings: &[Reading], levels: &[Level]) -> Vec<f64> {
    let mut relative = vec![1.0; readings.len()];
    // What the currents differ by within a level is not scatter: the line between the levels takes it off.
    let (first, last) = (&levels[0], &levels[levels.len() - 1]);
    let (current, field) = (|m: usize| readings[m].current_a, |m: usize| readings[m].field_nt);
    let slope = (mean(last, field) - mean(first, field)) / (mean(last, current) - mean(first, current));
    let value = |member: usize| field(member) - slope * current(member);
    let (sum, freedom) = within(levels, value);
    let of = |level: &Level| within(std::slice::from_ref(level), value);
    let repeated: Vec<(f64, f64)> = levels.iter().map(of).filter(|(_, freedom)| *freedom > 0.0).collect();
    if repeated.len() < 2 || sum == 0.0 || repeated.iter().any(|(sum, _)| *sum == 0.0) {
        return relative;
    }
    let common = sum / freedom;
    let statistic = freedom * common.ln() - repeated.iter().map(|(sum, f)| f * (sum / f).ln()).sum::<f64>();
    let inverse: f64 = repeated.iter().map(|(_, f)| 1.0 / f).sum();
    let groups = repeated.len() as f64 - 1.0;
    let corrected = statistic / (1.0 + (inverse - 1.0 / freedom) / (3.0 * groups));
    if stats::chi_squared_p(corrected, groups) < UNEQUAL_BELOW {
        for level in levels {
            let (sum, freedom) = of(level);
            let variance = (sum + PRIOR_FREEDOM * common) / (freedom + PRIOR_FREEDOM);
            level.iter().for_each(|member| relative[*member] = (variance / common).sqrt());
        }
    }
    relative
}

/// The largest scatter about the model: of readings, of visits, which share what wanders slowly, or of
/// levels, whose visits may err together. As declared without degrees of freedom.
pub fn scatter(levels: &[Level], fit: &LinearFit, declared: Option<f64>) -> Scatter {
    let of = |sum_of_squares: f64, count: usize, source: &'static str| {
        let freedom = count as f64 - fit.rank as f64;
        Scatter { std_nt: (sum_of_squares / freedom.max(1.0)).sqrt(), freedom, source }
    };
    let visits = visits(levels);
    let largest = [
        of(fit.sum_of_squares, fit.residuals.len(), "residuals"),
        of(between(&visits, fit), visits.len(), "visits"),
        of(between(levels, fit), levels.len(), "levels"),
    ]
    .into_iter()
    .filter(|scatter| scatter.freedom >= 1.0)
    .max_by(|a, b| a.std_nt.total_cmp(&b.std_nt));
    let declared = declared.map(|std_nt| Scatter { std_nt, freedom: f64::INFINITY, source: "declared" });
    largest.or(declared).unwrap_or(Scatter { std_nt: 0.0, freedom: 0.0, source: "residuals" })
}

/// Scatter of the levels' means about the model against that of the visits about their level's mean; against
/// that of the repeats where no level was set twice.
pub fn lack_of_fit(levels: &[Level], fit: &LinearFit) -> Option<FTest> {
    let visits = visits(levels);
    let (all, below) = within(levels, |member| fit.standardised[member]);
    let (repeats, of_repeats) = within(&visits, |member| fit.standardised[member]);
    let (pure, below) =
        if visits.len() > levels.len() { (all - repeats, below - of_repeats) } else { (all, below) };
    let above = levels.len() as f64 - fit.rank as f64;
    if below < 1.0 || above < 1.0 || pure <= 0.0 {
        return None;
    }
    let f = between(levels, fit) / above / (pure / below);
    Some(FTest { f, above, below, p_value: stats::f_p(f, above, below) })
}

/// Sum of squares of the means of groups of readings about the model.
fn between(groups: &[Level], fit: &LinearFit) -> f64 {
    let residual = |member: usize| fit.standardised[member];
    groups.iter().map(|group| group.len() as f64 * mean(group, residual).powi(2)).sum()
}
