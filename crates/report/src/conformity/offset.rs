use common::number::{signed, significant, uncertain};
use common::{Axis, Document, OffsetDrift, Quantity};

use crate::conformity::joint::{Joint, sensor};
use crate::conformity::spec::Requirement;
use crate::conformity::temperature::{Coefficients, Part, Range, asked};
use crate::conformity::verdict::{ShownValue, normal_std};

/// Below this probability a yearly term is more than chance.
const YEARLY_BELOW: f64 = 0.01;
/// Dates must span so much of the time that is asked for.
const SPAN: f64 = 0.9;
const YEAR_D: f64 = 365.25;

/// Largest change of an offset, nT: over the temperatures |Σ_parts c ΔT + q ΔT²| at the worst of their ends
/// and turning points; over the years what [`drift`] gives; both added, with u² the sum of both squares (JCGM
/// 100).
pub fn stability(
    document: &Document,
    joint: &Joint,
    requirement: &Requirement,
    axis: Axis,
) -> Result<ShownValue, String> {
    let mut found = ShownValue::default();
    let mut how = Vec::new();
    let asks = |part: &Part| part.required(requirement).is_some();
    let ranges = Part::BOTH.into_iter().filter(asks);
    let parts = ranges.map(|part| Ok((part, asked(document, axis, part, requirement)?)));
    let parts: Vec<(Part, Range)> = parts.collect::<Result<_, String>>()?;
    if !parts.is_empty() {
        let known = Coefficients::of(document, joint, axis);
        let coefficients = known.filter(|known| parts.iter().all(|(part, _)| known.has(*part))).ok_or(
            "there are no coefficients of temperature; sensorcal finds them from a `temperature_run`",
        )?;
        let candidates = |number: usize| -> Vec<Option<(Part, f64)>> {
            let Some((part, range)) = parts.get(number) else { return vec![None] };
            let [low, high] = range.warmer;
            let turning = coefficients.turning(*part).filter(|at| (low..=high).contains(at));
            let ends = [Some(low), Some(high), turning].into_iter().flatten();
            ends.map(|warmer| Some((*part, warmer))).collect()
        };
        let mut worst = (0.0, 0.0, Vec::new());
        for first in candidates(0) {
            for second in candidates(1) {
                let warmer: Vec<(Part, f64)> = first.into_iter().chain(second).collect();
                let (value, std) = coefficients.change(0.0, &warmer);
                if value.abs() > f64::abs(worst.0) || worst.2.is_empty() {
                    worst = (value, std, warmer);
                }
            }
        }
        let (value, std, warmer) = worst;
        let at = |(part, kelvin): &(Part, f64)| {
            format!("the {} {} K", part.word(), signed(&significant(*kelvin, 3)))
        };
        let at: Vec<String> = warmer.iter().map(at).collect();
        let change = signed(&uncertain(value, std));
        how.push(format!("{change} nT with {} from the reference", at.join(" and ")));
        (found.value, found.std) = (value.abs(), std);
        found.gaps.extend(parts.iter().filter_map(|(_, range)| range.gap.clone()));
    }
    if let Some(years) = requirement.years {
        let drift = sensor(document, axis).and_then(|sensor| sensor.drift.as_ref());
        let drift = drift
            .ok_or("offsets were not followed over time; sensorcal finds their drift from `offset_drift`")?;
        let drift = self::drift(drift, years)?;
        found.value += drift.value.abs();
        found.std = found.std.hypot(drift.std);
        found.gaps.extend(drift.gap);
        how.push(drift.how);
    }
    found.how = how.join("; ");
    Ok(found)
}

pub struct Drift {
    /// The change, nT, with the sign of the trend.
    pub value: f64,
    /// Its standard uncertainty, nT.
    pub std: f64,
    /// Where the dates do not span the years.
    pub gap: Option<String>,
    pub how: String,
}

/// The change of an offset in some years, nT: |trend| · years, and where a yearly term is more than chance
/// twice its amplitude, which it may add at most. u² = u²(trend) years² + 4 u²(amplitude), the latter the
/// larger of its two components'.
pub fn drift(drift: &OffsetDrift, years: f64) -> Result<Drift, String> {
    let trend = drift.trend_nt_per_year.as_ref();
    let trend = trend.ok_or("the offsets show no trend: at least five dates of `offset_drift` are needed")?;
    // Each of the quantities that sensorcal finds has its own factor.
    let widened = |quantity: &Quantity| {
        let factor = quantity.coverage_factor_95().unwrap_or(drift.coverage_factor_95);
        quantity.std().map(|std| normal_std(std, factor))
    };
    let own = widened(trend).ok_or("the trend of the offsets has no uncertainty; sensorcal gives one")?;
    let mut std = own * years;
    let mut size = trend.value().abs() * years;
    let mut how = format!("{} nT a year", signed(&uncertain(trend.value(), own)));
    if let Some(annual) = drift.annual.as_ref().filter(|annual| annual.p_value < YEARLY_BELOW) {
        let of = |quantity: &Quantity| widened(quantity).unwrap_or(0.0);
        let own = of(&annual.cosine_nt).max(of(&annual.sine_nt));
        size += 2.0 * annual.amplitude_nt;
        std = std.hypot(2.0 * own);
        how += &format!(", and {} nT to either side within the year", significant(annual.amplitude_nt, 3));
    }
    let days = drift.dates.time_d.last().copied().unwrap_or(0.0);
    let gap = (days < SPAN * years * YEAR_D).then(|| {
        let [days, asked] = [days, years * YEAR_D].map(|days| significant(days, 4));
        format!("offsets were followed over {days} days of {asked} (go on with `offset_drift`)")
    });
    Ok(Drift { value: size.copysign(trend.value()), std, gap, how })
}
