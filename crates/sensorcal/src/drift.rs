//! Offset drift: offsets from date to date ("Measurement of Sensor Noise in Low Field": what takes longer
//! than a day to a week is offset), their trend and yearly term.

use common::covariance::between;
use common::number::{counted, figures, p_value, plural, significant};
use common::{AnnualTerm, Code, DriftDates, OffsetDrift, Quantity, procedure};
use estimate::mixture::Mixture;
use estimate::{hac, linear, stats};
use faer::{ColRef, Mat};

use crate::conditions::Conditions;
use crate::readings::recordings;
use crate::reversal::{self, Outcome, Sensitivity};
use crate::shape::Subject;
use crate::wander::Wandering;
use crate::{Error, Result};

const DAY_S: f64 = 86_400.0;
const YEAR_D: f64 = 365.25;
/// A yearly term needs dates over so much of a year, and so many of them.
const ANNUAL_FROM: (f64, usize) = (0.9, 16);
/// A temperature that moves by less than this (rms, K) shows no coefficient.
const TEMPERATURE_FROM_K: f64 = 0.5;
/// Below this probability a trend, a yearly term or a coefficient is claimed.
const TOLD_BELOW: f64 = 0.01;
/// Above this probability that a random walk is less than the dates' own errors, it is not seen.
const UNSEEN_ABOVE: f64 = 0.05;

/// Mean, trend, yearly term and temperature's part of the offsets of all dates; None without a recording.
pub fn drift(
    of: Subject<'_>,
    sensitivity: Sensitivity<'_>,
    conditions: &Conditions,
) -> Result<Option<OffsetDrift>> {
    let Subject { document, sensor, .. } = of;
    let mut dates = Vec::new();
    for (path, recording) in recordings(document, procedure::OFFSET_DRIFT, sensor)? {
        let Some(start) = recording.start() else {
            let expected = "the date of the recording, as in 1977-05-26T14:44:35Z";
            return Err(Error::document(format!("{path}.start"), "no such key", expected));
        };
        let Outcome { reversal, scatter_nt2, by_temperature, .. } =
            reversal::one(of, recording, &path, sensitivity, conditions)?;
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
        return Err(Error::Unanswerable(format!(
            "sensor {sensor}: `offset_drift` was recorded on {}; a mean and its scatter need 3 dates, a trend 5, a yearly term {}",
            counted(dates.len(), "date"),
            ANNUAL_FROM.1
        )));
    }
    Ok(Some(result(&dates, conditions)?))
}

fn result(dates: &[Date], conditions: &Conditions) -> Result<OffsetDrift> {
    let day = |date: &Date| date.days_from(&dates[0]);
    let count = dates.len() as f64;
    let own = |date: &Date| date.scatter_nt2;
    let corrected = dates.iter().all(|date| date.by_temperature.is_some());
    let own_mean = dates.iter().map(own).sum::<f64>() / count;
    let mean = dates.iter().map(|date| date.offset.value()).sum::<f64>() / count;
    let square = dates.iter().map(|date| (date.offset.value() - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // How the coefficients of temperature, common to all dates, move the offset of each date.
    let of = |date: &Date, parameter: usize| date.by_temperature.as_ref().map_or(0.0, |by| by[parameter]);
    let each = |parameter: usize| dates.iter().map(|date| of(date, parameter)).collect();
    let common: Vec<Vec<f64>> = (0..conditions.covariance.nrows()).map(each).collect();
    let average = |column: &Vec<f64>| column.iter().sum::<f64>() / count;
    let common_mean = conditions.variance(&common.iter().map(average).collect::<Vec<_>>());
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
        trend(dates, (conditions, &common), &mut found)?;
    } else {
        let (dates, determine) =
            (counted(dates.len(), "date"), plural(dates.len(), "determines", "determine"));
        let words = format!("{dates} {determine} no trend: at least five are needed");
        found.findings.push(Code::TooFewDates.said(words));
    }
    if corrected {
        let words = "offsets are corrected to the reference temperatures";
        found.findings.push(Code::AtReferenceTemperatures.said(words));
    }
    Ok(found)
}

struct Date {
    recording: String,
    time_s: f64,
    offset: Quantity,
    /// Mean temperature of the sensor, where it was recorded.
    temperature_c: Option<f64>,
    /// Variance from scatter, nT².
    scatter_nt2: f64,
    /// Derivatives by the parameters of the effects of temperature that were taken off; None without.
    by_temperature: Option<Vec<f64>>,
}

impl Date {
    fn days_from(&self, first: &Date) -> f64 {
        (self.time_s - first.time_s) / DAY_S
    }
}

struct Columns {
    design: Mat<f64>,
    annual: Option<usize>,
    temperature: Option<usize>,
}

impl Columns {
    /// 1 and years from the middle; a yearly term where the dates span one; the temperature where it moved and
    /// its effect is not known.
    fn of(dates: &[Date]) -> Self {
        let times: Vec<f64> = dates.iter().map(|date| date.days_from(&dates[0])).collect();
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
        let open = dates.iter().filter(|date| date.by_temperature.is_none());
        let temperatures: Vec<f64> = open.filter_map(|date| date.temperature_c).collect();
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

/// Trend, yearly term and temperature's part, under any noise with memory; the trend under each.
fn trend(
    dates: &[Date],
    (conditions, common): (&Conditions, &[Vec<f64>]),
    found: &mut OffsetDrift,
) -> Result<()> {
    let columns = Columns::of(dates);
    let design = columns.design.as_ref();
    let y: Vec<f64> = dates.iter().map(|date| date.offset.value()).collect();
    let own: Vec<f64> = dates.iter().map(|date| date.scatter_nt2).collect();
    let time: Vec<f64> = dates.iter().map(|date| date.time_s - dates[0].time_s).collect();
    // Errors of the coefficients of temperature move all dates together, and the coefficients here with them.
    let moved: Vec<Vec<f64>> = common
        .iter()
        .map(|column| Ok(linear::fit(design, column, None)?.coefficients))
        .collect::<Result<_>>()?;
    let by = |i: usize| -> Vec<f64> { moved.iter().map(|moved| moved[i]).collect() };
    let unknowns = design.ncols();
    let shared = Mat::from_fn(unknowns, unknowns, |i, j| between(&conditions.covariance, &by(i), &by(j)));
    let wandering = Wandering::of(design, &y, &own, &time, &shared)?;
    let fit = &wandering.all;
    let of = |fit: &Mixture, i: usize| {
        Quantity::new(fit.coefficients()[i], fit.covariance(i, i).sqrt())
            .covered_by(fit.coverage_factor(i, 0.95))
    };
    for (name, alone) in &wandering.alone {
        found.trend_by_noise_nt_per_year.insert((*name).to_string(), of(alone, 1));
    }
    found.trend_by_noise_nt_per_year.insert("newey_west".into(), newey_west(&columns, &y)?);
    found.noise = wandering.weights.iter().map(|(name, weight)| ((*name).to_string(), *weight)).collect();
    let p = fit.p_value(&[1])?;
    found.coverage_factor_95 = fit.coverage_factor(1, 0.95);
    found.trend_nt_per_year = Some(of(fit, 1));
    found.trend_p = Some(p);
    let values = fit.coefficients();
    let left = ColRef::from_slice(&y) - design * ColRef::from_slice(values);
    found.dates.residual_nt = left.iter().copied().collect();
    let code = if p < TOLD_BELOW { Code::Trend } else { Code::TrendNotSignificant };
    let verdict = if p < TOLD_BELOW { "is significant" } else { "is not significant" };
    let std = |name: &str| figures(found.trend_by_noise_nt_per_year[name].std().unwrap_or(0.0), 2);
    found.findings.push(code.said(format!(
        "the trend {verdict} under correlated noise ({}); its standard uncertainty would be {} nT a year under white noise, {} under flicker noise, {} under a random walk",
        p_value(p),
        std("white"),
        std("flicker"),
        std("random_walk")
    )));
    if wandering.unseen > UNSEEN_ABOVE {
        found.findings.push(Code::RandomWalkPossible.said(format!(
            "the dates neither establish nor exclude a random walk of the offset (below {} nT in a year at 95 %): the intervals allow for it, and their coverage is at least 95 %",
            significant(wandering.walk_below_nt_per_sqrt_s * (DAY_S * YEAR_D).sqrt(), 2)
        )));
    }
    if let Some(at) = columns.annual {
        let annual = AnnualTerm {
            cosine_nt: of(fit, at),
            sine_nt: of(fit, at + 1),
            amplitude_nt: values[at].hypot(values[at + 1]),
            p_value: fit.p_value(&[at, at + 1])?,
        };
        if annual.p_value < TOLD_BELOW {
            let (nt, p) = (significant(annual.amplitude_nt, 2), p_value(annual.p_value));
            let words = format!("a yearly term of {nt} nT is significant ({p})");
            found.findings.push(Code::AnnualTerm.said(words));
        }
        found.annual = Some(annual);
    }
    if let Some(at) = columns.temperature {
        found.temperature_nt_per_k = Some(of(fit, at));
        let p = fit.p_value(&[at])?;
        if p < TOLD_BELOW {
            let words = format!("the offset follows the sensor's temperature ({})", p_value(p));
            found.findings.push(Code::FollowsTemperature.said(words));
        }
    }
    Ok(())
}

/// The least-squares trend with the uncertainty of Newey and West, which allows for short memory only.
fn newey_west(columns: &Columns, y: &[f64]) -> Result<Quantity> {
    let design = columns.design.as_ref();
    let fit = linear::fit(design, y, None)?;
    let columns: Vec<&[f64]> = (0..design.ncols()).map(|j| columns.design.col_as_slice(j)).collect();
    let robust = hac::newey_west(&columns, &fit.residuals, fit.covariance.as_ref(), hac::lags(y.len()));
    let factor = stats::coverage_factor(0.95, fit.freedom);
    Ok(Quantity::new(fit.coefficients[1], robust[(1, 1)].sqrt()).covered_by(factor))
}
