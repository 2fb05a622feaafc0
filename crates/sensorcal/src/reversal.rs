//! Offset by turning the sensor through 180° ("Measurement of Sensor Offset in Low Field").
//!
//! V₁ = (B − O)/k and V₂ = (−B − O)/k, so O = −k (V₁ + V₂)/2 (the report's eq. 26 has sign and k wrong).

use common::number::{counted, plural};
use common::{
    Code, Document, Findings, ImperfectTurn, Quantity, Recording, Reversal, ReversalOffset, ReversalPairs,
    procedure,
};
use estimate::correlated::{self, Scale};
use estimate::stats;
use faer::Mat;
use physics::{Context, Unit};

use crate::conditions::Conditions;
use crate::readings::{code, output, recordings, times};
use crate::shape::{Place, Shape, Subject};
use crate::{Error, Result};

/// A pair that is so far from the rest is left out (Grubbs).
const OUTLIER_BELOW: f64 = 1e-3;
/// Readings from which a drift of the shield's field is fitted.
const DRIFT_FROM: usize = 8;

/// Sensitivity by which readings become field: k and its standard uncertainty, in the unit of the readings.
pub type Sensitivity<'a> = &'a dyn Fn(Unit) -> Option<(f64, f64)>;

/// The offset over all recordings, by what its uncertainty comes from.
#[derive(Clone, Debug)]
pub struct Turned {
    pub offset_nt: f64,
    /// Variance from scatter and from the sensitivity, nT².
    pub own_nt2: f64,
    /// From standard uncertainty to 95 % interval.
    pub coverage_factor_95: f64,
    /// Derivatives by the parameters of the temperatures, common to all recordings and a coil's; or empty.
    pub by_temperature: Vec<f64>,
}

impl Turned {
    /// The variance from scatter and sensitivity of a normal distribution with the same 95 % interval.
    pub fn covered_nt2(&self) -> f64 {
        self.own_nt2 * (self.coverage_factor_95 / stats::coverage_factor(0.95, f64::INFINITY)).powi(2)
    }
}

/// O from all recordings of reversals; None without one.
pub fn offset(
    of: Subject<'_>,
    sensitivity: Sensitivity<'_>,
    conditions: &Conditions,
) -> Result<Option<(ReversalOffset, Turned)>> {
    let mut found = ReversalOffset::default();
    let mut outcomes = Vec::new();
    for (path, recording) in recordings(of.document, procedure::SENSOR_OFFSET_REVERSAL, of.sensor)? {
        let outcome = one(of, recording, &path, sensitivity, conditions)?;
        let pairs = &outcome.reversal.pairs;
        let out = pairs.row.iter().zip(&pairs.used).filter(|(_, used)| !**used);
        let rows: Vec<String> = out.map(|(row, _)| row.to_string()).collect();
        if !rows.is_empty() {
            let pairs = plural(rows.len(), "pair from row", "pairs from rows");
            let are = plural(rows.len(), "is an outlier", "are outliers");
            let (id, rows) = (&recording.id, rows.join(", "));
            let words = format!("recording \"{id}\": the {pairs} {rows} {are} and left out");
            found.findings.push(Code::Outliers.about(id).said(words));
        }
        found.recordings.push(outcome.reversal.clone());
        outcomes.push(outcome);
    }
    if outcomes.is_empty() {
        return Ok(None);
    }
    let turned = mean_of(&outcomes, conditions, &mut found.findings);
    let variance = turned.own_nt2 + conditions.variance(&turned.by_temperature);
    found.offset_nt = Quantity::new(turned.offset_nt, variance.sqrt());
    found.coverage_factor_95 = turned.coverage_factor_95;
    Ok(Some((found, turned)))
}

/// The mean over recordings, weighted by their own scatter: errors of the sensitivity and of the coefficients
/// of temperature are common to all, weigh for none of them and do not average down.
fn mean_of(outcomes: &[Outcome], conditions: &Conditions, findings: &mut Findings) -> Turned {
    let sum: f64 = outcomes.iter().map(|outcome| outcome.scatter_nt2.recip()).sum();
    let weight = |outcome: &Outcome| outcome.scatter_nt2.recip() / sum;
    let offset = |outcome: &Outcome| outcome.reversal.offset_nt.value();
    let offset_nt = outcomes.iter().map(|outcome| weight(outcome) * offset(outcome)).sum::<f64>();
    let by = |parameter: usize| -> f64 {
        let of = |outcome: &Outcome| outcome.by_temperature.as_ref().map_or(0.0, |by| by[parameter]);
        outcomes.iter().map(|outcome| weight(outcome) * of(outcome)).sum()
    };
    let by_temperature: Vec<f64> = (0..conditions.covariance.nrows()).map(by).collect();
    let freedom = outcomes.iter().map(|outcome| outcome.reversal.noise.degrees_of_freedom).sum();
    let mut scatter_nt2 = sum.recip();
    if outcomes.len() > 1 {
        // At other temperatures than the mean's, errors of the coefficients are part of a difference.
        let apart = |one: &Outcome| -> f64 {
            let Some(by) = &one.by_temperature else { return 0.0 };
            let by: Vec<f64> = by.iter().zip(&by_temperature).map(|(by, mean)| by - mean).collect();
            conditions.variance(&by)
        };
        let chi_of = |one: &Outcome| (offset(one) - offset_nt).powi(2) / (one.scatter_nt2 + apart(one));
        let chi: f64 = outcomes.iter().map(chi_of).sum();
        let above = outcomes.len() as f64 - 1.0;
        if stats::chi_squared_p(chi, above) < 0.01 {
            scatter_nt2 *= chi / above;
            findings.push(
                Code::ReversalsDiffer.said("the recordings differ by more than their scatter; the uncertainty of the offset is based on the differences"),
            );
        }
    }
    let by_sensitivity: f64 =
        outcomes.iter().map(|outcome| weight(outcome) * outcome.by_sensitivity_nt).sum();
    Turned {
        offset_nt,
        own_nt2: scatter_nt2 + by_sensitivity.powi(2),
        coverage_factor_95: stats::coverage_factor(0.95, freedom),
        by_temperature,
    }
}

/// The bound of a turn that misses 180° by ε: for V₂ the sensor sees −B∥ cos ε + B⊥ sin ε in place of −B∥.
pub fn imperfect(reversals: &[Reversal], angle_deg: f64, across_nt: Option<f64>) -> ImperfectTurn {
    let angle = angle_deg.to_radians();
    let along = reversals.iter().map(|r| r.shield_field_nt.value().abs()).fold(0.0, f64::max);
    let across = across_nt.unwrap_or(0.0);
    ImperfectTurn {
        angle_deg,
        field_across_nt: across_nt,
        bound_nt: 0.5 * (along * (1.0 - angle.cos()) + across * angle.sin()),
        bound_per_nt_across: 0.5 * angle.sin(),
    }
}

pub struct Outcome {
    pub reversal: Reversal,
    /// Variance of the offset from scatter, nT²; the rest is common to recordings.
    pub scatter_nt2: f64,
    /// What one standard uncertainty of the sensitivity moves it by, nT.
    pub by_sensitivity_nt: f64,
    /// Derivative of the offset by each parameter of the temperatures; None where they were not taken off.
    pub by_temperature: Option<Vec<f64>>,
}

pub fn one(
    of: Subject<'_>,
    recording: &Recording,
    path: &str,
    sensitivity: Sensitivity<'_>,
    conditions: &Conditions,
) -> Result<Outcome> {
    let Subject { document, references, sensor, .. } = of;
    let (reading, unit) = output(recording, path, sensor)?;
    let Some(position) = recording.column("position") else {
        let expected = "`position`, +1 or −1 in the order taken";
        return Err(Error::document(format!("{path}.columns"), "no such column", expected));
    };
    let key = format!("{path}.columns.position");
    if let Some(row) = position.iter().position(|p| p.is_finite() && p.abs() != 1.0) {
        let found = format!("{} in row {row}", position[row]);
        return Err(Error::document(key, found, "+1 or −1, the two positions of the sensor"));
    }
    let rows: Vec<usize> =
        (0..recording.rows()).filter(|row| reading[*row].is_finite() && position[*row].is_finite()).collect();
    let (ups, downs) = [1.0, -1.0].map(|p| rows.iter().filter(|row| position[**row] == p).count()).into();
    if ups < 2 || downs < 2 {
        let found = format!("{} in position +1 and {downs} in −1", counted(ups, "reading"));
        let expected = "at least two in each; one position alone does not determine an offset";
        return Err(Error::document(key, found, expected));
    }
    let Some((k, k_std)) = sensitivity(unit) else {
        let key = format!("calibration.sensors.{sensor}.sensitivity_nt_per_v");
        let expected = "the sensitivity, from a `sensor_sensitivity` recording or stated there, or `instrument.nominal_sensitivity_nt_per_v`";
        return Err(Error::document(key, "no such key", expected));
    };
    let context = Context::new(document, recording, references).map_err(|error| error.at(path))?;
    let contribution = conditions.contribution(&context, sensor, path)?;
    let field: Vec<f64> = (0..recording.rows())
        .map(|row| k * reading[row] - contribution.as_ref().map_or(0.0, |c| c.field_nt[row]))
        .collect();
    let code_nt = code_width(document, reading, unit) * k;
    let shape = of.shape(code_nt);
    let series = Series { recording, field: &field, position, shape: &shape };
    let mut pairs = series.pairs(&rows, 0.0);
    let mut kept = rows.clone();
    if let Some(worst) = outlier(&pairs.offset_nt, code_nt) {
        pairs.used[worst] = false;
        let first = rows.iter().position(|row| *row == pairs.row[worst]).unwrap_or(0);
        let bad: Vec<usize> = rows[first..(first + 2).min(rows.len())].to_vec();
        kept.retain(|row| !bad.contains(row));
    }
    let (fit, noise) = series.fit(&kept)?;
    let drift = fit.coefficients.get(2).copied().unwrap_or(0.0);
    let used = pairs.used;
    pairs = series.pairs(&rows, drift);
    pairs.used = used;
    let offset = fit.coefficients[0];
    // The parameters of temperature move the offset by their mean derivative.
    let mean = |column: &Vec<f64>| kept.iter().map(|row| column[*row]).sum::<f64>() / kept.len() as f64;
    let by_temperature: Option<Vec<f64>> =
        contribution.as_ref().map(|contribution| contribution.derivatives.iter().map(mean).collect());
    let scatter_nt2 = scatter(&series, &kept, &fit, code_nt)?;
    let common = by_temperature.as_ref().map_or(0.0, |by| conditions.variance(by));
    let by_sensitivity_nt = offset * k_std / k;
    let variance = scatter_nt2 + by_sensitivity_nt.powi(2) + common;
    let quantity = |i: usize| Quantity::new(fit.coefficients[i], fit.covariance(i, i).sqrt());
    let reversal = Reversal {
        recording: recording.id.clone(),
        offset_nt: Quantity::new(offset, variance.sqrt()),
        shield_field_nt: quantity(1),
        shield_drift_nt_per_s: (fit.coefficients.len() > 2).then(|| quantity(2)),
        pairs,
        noise,
    };
    Ok(Outcome { reversal, scatter_nt2, by_sensitivity_nt, by_temperature })
}

/// Width of a code in a shield, in the unit of the readings: the smaller of what the instrument states and
/// what the readings show, for they may have been amplified; two readings may be those of the positions.
fn code_width(document: &Document, reading: &[f64], unit: Unit) -> f64 {
    let stated = unit.code_width(document.instrument.as_ref());
    match (stated, code(reading)) {
        (Some(stated), Some(seen)) => stated.min(seen),
        (one, other) => one.or(other).unwrap_or(0.0),
    }
}

/// Variance of the offset from scatter, nT². Where the noise is not known, no memory that is allowed for
/// makes it smaller than independent readings would; and where the readings scatter by less than a code,
/// rounding of either position does not average down: δ²/12 each, halved in their sum.
fn scatter(
    series: &Series<'_>,
    rows: &[usize],
    fit: &correlated::CorrelatedFit,
    code_nt: f64,
) -> Result<f64> {
    let (design, y) = series.problem(rows);
    let plain = estimate::linear::fit(design.as_ref(), &y, None)?;
    let variance = plain.sum_of_squares / plain.freedom;
    let independent = plain.covariance[(0, 0)] * variance;
    let floor = if variance.sqrt() < 0.5 * code_nt { code_nt * code_nt / 24.0 } else { 0.0 };
    let own = fit.covariance(0, 0);
    Ok(if series.shape.is_known() { own } else { own.max(independent) } + floor)
}

struct Series<'a> {
    recording: &'a Recording,
    field: &'a [f64],
    position: &'a [f64],
    shape: &'a Shape,
}

impl Series<'_> {
    /// Times from their middle, where they are known.
    fn centred(&self, rows: &[usize]) -> Option<Vec<f64>> {
        let times = times(self.recording, rows)?;
        let middle = times.iter().sum::<f64>() / times.len() as f64;
        Some(times.iter().map(|t| t - middle).collect())
    }

    /// k V = −O + p B + p (t − t̄) Ḃ: offset, the shield's field and its drift.
    fn problem(&self, rows: &[usize]) -> (Mat<f64>, Vec<f64>) {
        let time = self.centred(rows).filter(|_| rows.len() >= DRIFT_FROM);
        let design = Mat::from_fn(rows.len(), 2 + usize::from(time.is_some()), |i, column| {
            let position = self.position[rows[i]];
            match (column, &time) {
                (0, _) => -1.0,
                (1, _) => position,
                (_, Some(time)) => position * time[i],
                (_, None) => 0.0,
            }
        });
        (design, rows.iter().map(|row| self.field[*row]).collect())
    }

    fn fit(&self, rows: &[usize]) -> Result<(correlated::CorrelatedFit, common::FitNoise)> {
        let (design, y) = self.problem(rows);
        let recordings = [(rows.len(), times(self.recording, rows))];
        let allowed = self.shape.allowed(&recordings, Place::Shield, None)?;
        let fit = correlated::fit(design.as_ref(), &y, &allowed.whitenings, Scale::Fitted)?;
        if fit.freedom < 1.0 {
            let (id, readings) = (&self.recording.id, counted(rows.len(), "reading"));
            let determine = plural(rows.len(), "determines", "determine");
            return Err(Error::Unanswerable(format!(
                "recording \"{id}\": {readings} {determine} an offset but not its scatter; record more pairs"
            )));
        }
        let noise = allowed.describe(&fit);
        Ok((fit, noise))
    }

    /// Readings that follow each other in opposite positions, each used once, less the shield's drift.
    fn pairs(&self, rows: &[usize], drift: f64) -> ReversalPairs {
        let time = self.centred(rows).unwrap_or_else(|| vec![0.0; rows.len()]);
        let mut pairs = ReversalPairs::default();
        let mut at = 0;
        while at + 1 < rows.len() {
            let (first, second) = (rows[at], rows[at + 1]);
            if self.position[first] == self.position[second] {
                at += 1;
                continue;
            }
            let still = |at: usize| self.field[rows[at]] - self.position[rows[at]] * drift * time[at];
            pairs.row.push(first);
            pairs.offset_nt.push(-0.5 * (still(at) + still(at + 1)));
            pairs.used.push(true);
            at += 2;
        }
        pairs
    }
}

/// The outlier by Grubbs' test, more than a code away: t² = n (n − 2) g²/((n − 1)² − n g²).
fn outlier(values: &[f64], code_nt: f64) -> Option<usize> {
    let n = values.len() as f64;
    if n < 4.0 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n;
    let std = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    let worst =
        (0..values.len()).max_by(|a, b| (values[*a] - mean).abs().total_cmp(&(values[*b] - mean).abs()))?;
    let g = (values[worst] - mean).abs() / std;
    let left = (n - 1.0).powi(2) - n * g * g;
    let t = if left > 0.0 { (n * (n - 2.0) * g * g / left).sqrt() } else { f64::INFINITY };
    let far = (values[worst] - mean).abs() > code_nt;
    (far && std > 0.0 && n * stats::two_sided_p(t, n - 2.0) < OUTLIER_BELOW).then_some(worst)
}
