//! Offset drift: offsets from date to date ("Measurement of Sensor Noise in Low Field": what takes longer than a day to a week is
//! offset).

use common::number::{counted, figures, p_value, plural, significant};
use common::{
    AnnualTerm, Axis, Document, DriftDates, Error as Fault, Noise, OffsetDrift, Quantity, procedure,
};
use estimate::correlated::{self, CorrelatedFit, Scale, Whitening};
use estimate::{hac, linear, stats};
use faer::Mat;

use crate::Error;
use crate::conditions::Conditions;
use crate::readings::recordings;
use crate::reversal::{self, Outcome, Sensitivity};
use crate::shape::{Allowed, Block, Shape};

const DAY_S: f64 = 86_400.0;
const YEAR_D: f64 = 365.25;
/// A yearly term needs dates over so much of a year, and so many of them.
const ANNUAL_FROM: (f64, usize) = (0.9, 16);
/// A temperature that moves by less than this (rms, K) shows no coefficient.
const TEMPERATURE_FROM_K: f64 = 0.5;
/// Below this probability a trend, a yearly term or a coefficient is told.
const TOLD_BELOW: f64 = 0.01;
/// Variance of noise with memory over that of a date's own uncertainty: octaves from an eighth to 512.
const OCTAVES: std::ops::RangeInclusive<i32> = -3..=9;

/// One date.
struct Date {
    recording: String,
    time_s: f64,
    offset: Quantity,
    temperature_c: Option<f64>,
    /// Variance from scatter, nT².
    scatter_nt2: f64,
    /// Derivative by each parameter of the known effects of temperature, which were taken off; None where none were.
    by_temperature: Option<Vec<f64>>,
}

/// Mean, trend, yearly term and temperature's part of the offsets of all dates; None without a recording.
pub fn drift(
    document: &Document,
    sensor: Axis,
    sensitivity: Sensitivity<'_>,
    noise: &dyn Fn(f64) -> Shape,
    conditions: &Conditions,
) -> Result<Option<OffsetDrift>, Error> {
    let mut dates = Vec::new();
    for (path, recording) in recordings(document, procedure::OFFSET_DRIFT, sensor)? {
        let Some(start) = recording.start() else {
            let expected = "the date of the recording, as in 1977-05-26T14:44:35Z";
            return Err(Fault::document(format!("{path}.start"), "no such key", expected).into());
        };
        let Outcome { reversal, scatter_nt2, by_temperature, .. } =
            reversal::one(document, recording, &path, sensor, sensitivity, noise, conditions)?;
        let column = recording.column("sensor_temperature_c").unwrap_or_default();
        let known: Vec<f64> = column.iter().copied().filter(|t| t.is_finite()).collect();
        dates.push(Date {
            recording: recording.id.clone(),
            time_s: start.unix_s,
            offset: reversal.offset_nt,
            temperature_c: (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64),
            scatter_nt2,
            by_temperature,
        });
    }
    if dates.is_empty() {
        return Ok(None);
    }
    dates.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    if dates.len() < 3 {
        return Err(Error::Undetermined(format!(
            "sensor {sensor}: `offset_drift` was recorded on {} of the 3 dates that a mean and its scatter need (a trend needs 5, a yearly term {})",
            dates.len(),
            ANNUAL_FROM.1
        )));
    }
    Ok(Some(result(&dates, conditions)?))
}

fn result(dates: &[Date], conditions: &Conditions) -> Result<OffsetDrift, Error> {
    let first = dates[0].time_s;
    let day = |date: &Date| (date.time_s - first) / DAY_S;
    let count = dates.len() as f64;
    let own = |date: &Date| date.scatter_nt2;
    let corrected = dates.iter().all(|date| date.by_temperature.is_some());
    let own_mean = dates.iter().map(own).sum::<f64>() / count;
    let mean = dates.iter().map(|date| date.offset.value()).sum::<f64>() / count;
    let square = dates.iter().map(|date| (date.offset.value() - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // Errors of the coefficients of temperature are common to all dates.
    let common = common(dates, conditions);
    let average = |column: &Vec<f64>| column.iter().sum::<f64>() / count;
    let common_mean = conditions.variance(&common.iter().map(average).collect::<Vec<_>>());
    let columns = Columns::of(dates, &day);
    let mut found = OffsetDrift {
        mean_nt: Quantity::new(mean, (own_mean / count + common_mean).sqrt()),
        rms_nt: square.sqrt(),
        own_rms_nt: (square - own_mean).max(0.0).sqrt(),
        dates: DriftDates {
            recording: dates.iter().map(|date| date.recording.clone()).collect(),
            time_d: dates.iter().map(day).collect(),
            offset_nt: dates.iter().map(|date| date.offset.value()).collect(),
            std_nt: dates.iter().map(|date| own(date).sqrt()).collect(),
            residual_nt: dates.iter().map(|date| date.offset.value() - mean).collect(),
            sensor_temperature_c: dates.iter().filter_map(|date| date.temperature_c).collect(),
        },
        ..OffsetDrift::default()
    };
    if dates.len() >= 5 {
        trend(dates, &columns, (conditions, &common), &mut found)?;
    } else {
        found.findings.push(format!(
            "{} {} no trend: at least five are needed",
            counted(dates.len(), "date"),
            plural(dates.len(), "shows", "show")
        ));
    }
    if corrected {
        found.findings.push(
            "offsets are at the reference temperatures: what is known of temperature is taken off".into(),
        );
    }
    Ok(found)
}

/// For each parameter of the temperatures, how it moves the offset of each date; empty where they were not taken off.
fn common(dates: &[Date], conditions: &Conditions) -> Vec<Vec<f64>> {
    let of = |parameter: usize| {
        dates.iter().map(move |date| date.by_temperature.as_ref().map_or(0.0, |by| by[parameter]))
    };
    (0..conditions.covariance.len()).map(|parameter| of(parameter).collect()).collect()
}

/// What the offsets may follow.
struct Columns {
    design: Mat<f64>,
    annual: Option<usize>,
    temperature: Option<usize>,
}

impl Columns {
    /// 1 and the time in years from its middle; a yearly term where the dates span one; the temperature where it moved and is
    /// not known already.
    fn of(dates: &[Date], day: &dyn Fn(&Date) -> f64) -> Self {
        let times: Vec<f64> = dates.iter().map(day).collect();
        let middle = times.iter().sum::<f64>() / times.len() as f64;
        let span = times[times.len() - 1] / YEAR_D;
        let mut columns: Vec<Vec<f64>> =
            vec![vec![1.0; times.len()], times.iter().map(|t| (t - middle) / YEAR_D).collect()];
        let annual = (span >= ANNUAL_FROM.0 && dates.len() >= ANNUAL_FROM.1).then(|| {
            let angle = |t: &f64| std::f64::consts::TAU * t / YEAR_D;
            columns.push(times.iter().map(|t| angle(t).cos()).collect());
            columns.push(times.iter().map(|t| angle(t).sin()).collect());
            columns.len() - 2
        });
        let temperatures: Vec<f64> = dates
            .iter()
            .filter(|date| date.by_temperature.is_none())
            .filter_map(|date| date.temperature_c)
            .collect();
        let temperature = (temperatures.len() == dates.len() && dates.len() >= 8).then(|| {
            let mean = temperatures.iter().sum::<f64>() / temperatures.len() as f64;
            temperatures.iter().map(|t| t - mean).collect::<Vec<f64>>()
        });
        let temperature = temperature
            .filter(|t| t.iter().map(|t| t * t).sum::<f64>() / t.len() as f64 > TEMPERATURE_FROM_K.powi(2))
            .map(|t| {
                columns.push(t);
                columns.len() - 1
            });
        let design = Mat::from_fn(times.len(), columns.len(), |i, j| columns[j][i]);
        Self { design, annual, temperature }
    }
}

/// Trend and yearly term under white noise, flicker noise and a random walk of any size, averaged by likelihood; and under
/// each of them alone.
fn trend(
    dates: &[Date],
    columns: &Columns,
    (conditions, common): (&Conditions, &[Vec<f64>]),
    found: &mut OffsetDrift,
) -> Result<(), Error> {
    let y: Vec<f64> = dates.iter().map(|date| date.offset.value()).collect();
    let noises = noises(dates)?;
    let design = columns.design.as_ref();
    let all: Vec<Whitening> = noises.iter().flat_map(|(_, allowed)| allowed.whitenings.clone()).collect();
    let mut fit = correlated::fit(design, &y, &all, Scale::Known)?;
    let shifts: Vec<Vec<f64>> = common
        .iter()
        .map(|column| Ok(linear::fit(design, column, None)?.coefficients))
        .collect::<Result<_, Error>>()?;
    for i in 0..design.ncols() {
        let by: Vec<f64> = shifts.iter().map(|shift| shift[i]).collect();
        fit.covariance[(i, i)] += conditions.variance(&by);
    }
    let p = |i: usize| stats::two_sided_p(fit.coefficients[i] / fit.covariance[(i, i)].sqrt(), fit.freedom);
    let of =
        |fit: &CorrelatedFit, i: usize| Quantity::new(fit.coefficients[i], fit.covariance[(i, i)].sqrt());
    let mut weights = fit.weights.iter();
    for (name, allowed) in &noises {
        let alone = correlated::fit(design, &y, &allowed.whitenings, Scale::Known)?;
        found.trend_by_noise_nt_per_year.insert((*name).to_string(), of(&alone, 1));
        let weight = weights.by_ref().take(allowed.whitenings.len()).sum();
        found.noise.insert((*name).to_string(), weight);
    }
    found.trend_by_noise_nt_per_year.insert("newey_west".into(), newey_west(columns, &y)?);
    found.coverage_factor_95 = stats::coverage_factor(0.95, fit.freedom);
    found.trend_nt_per_year = Some(of(&fit, 1));
    found.trend_p = Some(p(1));
    found.dates.residual_nt = fit.residuals.clone();
    let verdict = if p(1) < TOLD_BELOW { "is real" } else { "is not significant" };
    let std = |name: &str| figures(found.trend_by_noise_nt_per_year[name].std().unwrap_or(0.0), 2);
    found.findings.push(format!(
        "the trend {verdict} under noise with memory ({}); it would be ± {} nT a year under white noise, {} under flicker noise, {} under a random walk",
        p_value(p(1)),
        std("white"),
        std("flicker"),
        std("random_walk")
    ));
    if let Some(at) = columns.annual {
        let annual = annual(&fit, at);
        if annual.p_value < TOLD_BELOW {
            found.findings.push(format!(
                "a yearly term of {} nT is significant ({})",
                significant(annual.amplitude_nt, 2),
                p_value(annual.p_value)
            ));
        }
        found.annual = Some(annual);
    }
    if let Some(at) = columns.temperature {
        found.temperature_nt_per_k = Some(of(&fit, at));
        if p(at) < TOLD_BELOW {
            found.findings.push(format!("the offset follows the sensor's temperature ({})", p_value(p(at))));
        }
    }
    Ok(())
}

fn annual(fit: &CorrelatedFit, at: usize) -> AnnualTerm {
    let (a, b) = (fit.coefficients[at], fit.coefficients[at + 1]);
    let c = |i: usize, j: usize| fit.covariance[(at + i, at + j)];
    let determinant = c(0, 0) * c(1, 1) - c(0, 1) * c(1, 0);
    let form = (a * a * c(1, 1) - 2.0 * a * b * c(0, 1) + b * b * c(0, 0)) / determinant;
    AnnualTerm {
        cosine_nt: Quantity::new(a, c(0, 0).sqrt()),
        sine_nt: Quantity::new(b, c(1, 1).sqrt()),
        amplitude_nt: a.hypot(b),
        p_value: stats::f_p(form / 2.0, 2.0, fit.freedom),
    }
}

/// The dates' own uncertainties, alone, and with white noise, flicker noise or a random walk of any size beside them.
fn noises(dates: &[Date]) -> Result<[(&'static str, Allowed); 3], Error> {
    let variance: Vec<f64> = dates.iter().map(|date| date.scatter_nt2).collect();
    let mean = variance.iter().sum::<f64>() / variance.len() as f64;
    let largest = dates.iter().map(|date| date.offset.value().abs()).fold(0.0, f64::max);
    if mean <= 1e-24 * largest * largest {
        return Err(Error::Undetermined(
            "the offsets of the dates have no scatter; are they copies of one?".into(),
        ));
    }
    let time: Vec<f64> = dates.iter().map(|date| date.time_s - dates[0].time_s).collect();
    let count = dates.len();
    let rows = [(count, Some(time))];
    let white = Noise { white_rms_nt: Some(1.0), ..Noise::default() };
    let flicker = Noise { flicker_nt2_per_hz_at_1hz: Some(1.0), ..Noise::default() };
    let walk = Noise { random_walk_nt_per_sqrt_s: Some(1.0), ..Noise::default() };
    let octaves: Vec<f64> = std::iter::once(0.0).chain(OCTAVES.map(|octave| 2f64.powi(octave))).collect();
    // White noise in every second octave: noise with memory, which makes wider intervals, weighs twice as much beforehand.
    let seconds: Vec<f64> = octaves.iter().copied().step_by(2).collect();
    let allowed = |noise: &Noise, ratios: &[f64]| -> Result<Allowed, Error> {
        let mut allowed = Allowed::default();
        let shape = noise::covariance(noise, count, rows[0].1.as_deref())
            .map_err(|error| Error::Undetermined(error.to_string()))?;
        let size = (0..count).map(|row| shape[row * count + row]).sum::<f64>() / count as f64;
        for ratio in ratios {
            allowed.add(&rows, |_, count| {
                let mut all: Vec<f64> = shape.iter().map(|value| value * ratio * mean / size).collect();
                (0..count).for_each(|row| all[row * count + row] += variance[row].max(1e-6 * mean));
                Ok(Block { covariance: all, flicker_share: ratio / (1.0 + ratio) })
            })?;
        }
        Ok(allowed)
    };
    Ok([
        ("white", allowed(&white, &seconds)?),
        ("flicker", allowed(&flicker, &octaves)?),
        ("random_walk", allowed(&walk, &octaves)?),
    ])
}

/// The least-squares trend with the standard uncertainty of Newey and West, which allows for short memory only.
fn newey_west(columns: &Columns, y: &[f64]) -> Result<Quantity, Error> {
    let design = columns.design.as_ref();
    let fit = linear::fit(design, y, None)?;
    let columns: Vec<&[f64]> = (0..design.ncols()).map(|j| columns.design.col_as_slice(j)).collect();
    let robust = hac::newey_west(&columns, &fit.residuals, fit.covariance.as_ref(), hac::lags(y.len()));
    Ok(Quantity::new(fit.coefficients[1], robust[(1, 1)].sqrt()))
}
