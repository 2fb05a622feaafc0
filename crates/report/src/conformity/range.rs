use common::number::{significant, uncertain};
use common::{Axis, Document, SensitivityFit, SensorCalibration};

use crate::conformity::each_sensor;
use crate::conformity::joint::{adopted, axes, sensitivity, sensor};
use crate::conformity::verdict::{Shown, ShownValue, normal_std};

/// Declared and found widths of a code that differ by more than this share are told.
const UNLIKE: f64 = 0.05;

/// The largest field that a sensor was seen to follow in either direction, nT; where its output stands, the
/// field at which that begins. u = B u(k)/k, the coil's constant included.
pub fn range(document: &Document) -> Vec<Shown> {
    let one_side = |(end, side)| {
        let mut all = each_sensor(document, |axis| one_range(document, axis, end));
        for shown in &mut all {
            *shown.as_mut().map_or_else(|missing| &mut missing.of, |found| &mut found.of) += side;
        }
        all
    };
    [(0, " below zero"), (1, " above zero")].into_iter().flat_map(one_side).collect()
}

fn one_range(document: &Document, axis: Axis, end: usize) -> Result<ShownValue, String> {
    let fit = sensor(document, axis).and_then(|sensor| sensor.sensitivity.as_ref());
    let followed = fit.and_then(|fit| Some((fit, followed(fit)?)));
    let (fit, followed) = followed
        .ok_or("it was not calibrated in a coil; `sensor_sensitivity` up to the limit would show it")?;
    let relative = sensor(document, axis).and_then(relative_std);
    let relative = relative.ok_or("its sensitivity has no uncertainty; sensorcal gives one")?;
    let stands = fit.saturation.as_ref().and_then(|saturation| saturation.fields_nt[end]);
    let (value, gaps, how) = match stands {
        Some(field) => (field.abs(), Vec::new(), "the output is saturated from there on"),
        None => {
            let gap = "no larger field was applied, in which the output might saturate (`sensor_sensitivity` up to the \
                       limit would show it)";
            (followed[end], vec![gap.to_string()], "the largest field that was applied")
        }
    };
    let std = value * relative * normal_std(1.0, fit.noise.coverage_factor_95);
    Ok(ShownValue { value, std, gaps, how: how.into(), ..ShownValue::default() })
}

/// The largest fields of either sign that a sensor followed in its calibration, as magnitudes, nT.
fn followed(fit: &SensitivityFit) -> Option<[f64; 2]> {
    let fields = &fit.residuals.field_nt;
    let largest = |sign: f64| fields.iter().fold(0.0, |most: f64, field| most.max(sign * field));
    (!fields.is_empty()).then(|| [largest(-1.0), largest(1.0)])
}

/// The field along a sensor, of either sign, up to which it was calibrated, nT.
pub fn calibrated_nt(sensor: &SensorCalibration) -> Option<f64> {
    followed(sensor.sensitivity.as_ref()?).map(|[below, above]| below.min(above))
}

/// Width of a code, nT: the larger of the declared one (times k) and of those that the noise recordings show.
/// u = width u(k)/k; the number of volts of a code is taken as it is.
pub fn resolution(document: &Document, axis: Axis) -> Result<ShownValue, String> {
    let [declared, seen] = codes_nt(document, axis);
    let (value, how) = match (declared, seen) {
        (Some(declared), Some(seen)) if (seen / declared - 1.0).abs() > UNLIKE => {
            let [said, shown] = [declared, seen].map(|nt| significant(nt, 3));
            let how = format!("declared {said} nT, the noise recordings show {shown} nT; the larger counts");
            (declared.max(seen), how)
        }
        (Some(declared), Some(seen)) => {
            (declared.max(seen), "as declared and as the noise recordings show".into())
        }
        (Some(declared), None) => (declared, "as declared; no recording shows quantisation".into()),
        (None, Some(seen)) => (seen, "as the noise recordings show".into()),
        (None, None) => {
            let why = "no quantisation step is declared (`instrument.quantisation_v`), and no `sensor_noise` shows one";
            return Err(why.into());
        }
    };
    let std = value * sensor(document, axis).and_then(relative_std).unwrap_or(0.0);
    Ok(ShownValue { value, std, how, ..ShownValue::default() })
}

/// Width of a code, nT: as declared (times k), and the largest that the noise recordings show.
pub fn codes_nt(document: &Document, axis: Axis) -> [Option<f64>; 2] {
    let sensor = sensor(document, axis);
    let instrument = document.instrument.as_ref();
    let per_volt = sensor.and_then(|sensor| sensor.sensitivity_nt_per_v.as_ref()).map(|k| k.value().abs());
    let per_volt = per_volt.or(instrument.and_then(|instrument| instrument.nominal_sensitivity_nt_per_v));
    let in_volts =
        instrument.and_then(|instrument| instrument.quantisation_v).zip(per_volt).map(|(v, k)| v * k);
    let declared = instrument.and_then(|instrument| instrument.quantisation_nt).or(in_volts);
    let series = sensor.and_then(|sensor| sensor.noise.as_ref()).map(|noise| noise.series.iter());
    let seen = series.and_then(|series| series.filter_map(|series| series.code_nt).reduce(f64::max));
    [declared, seen]
}

/// The frequency up to which a sensor follows the field, Hz: 1/(2π τ) with τ of `loop_bandwidth` in the
/// model, u = f u(τ)/τ; else the highest drive of an AC run that it was seen to follow.
pub fn bandwidth(document: &Document, axis: Axis) -> Result<ShownValue, String> {
    let lag = adopted(document, "loop_bandwidth", axis).and_then(|effect| effect.parameters.get("lag_s"));
    if let Some(lag) = lag.filter(|lag| lag.value() > 0.0) {
        let value = 1.0 / (std::f64::consts::TAU * lag.value());
        let lag_std = lag.std().ok_or("`loop_bandwidth` of the model has no uncertainty; state one")?;
        let std = value * lag_std / lag.value();
        let how =
            format!("the loop follows with a lag of {} ms", uncertain(lag.value() * 1e3, lag_std * 1e3));
        return Ok(ShownValue { value, std, how, ..ShownValue::default() });
    }
    let phases =
        axes(document).into_iter().flat_map(|axes| &axes.phases).filter(|phase| phase.sensor == axis);
    let fastest = phases.max_by(|a, b| a.drive_hz.total_cmp(&b.drive_hz)).ok_or(
        "no coil was driven with AC; `axes_orientation` with `conditions.drive_hz` up to the limit would show it",
    )?;
    Ok(ShownValue {
        value: fastest.drive_hz,
        gaps: vec!["no faster drive was recorded (`axes_orientation` with a `conditions.drive_hz` up to the limit would show it)".into()],
        how: format!("follows a drive of {} Hz", fastest.drive_hz),
        ..ShownValue::default()
    })
}

/// u(k)/k, where it is stated.
fn relative_std(sensor: &SensorCalibration) -> Option<f64> {
    let (k, _) = sensitivity(sensor)?;
    k.std().map(|std| std / k.value().abs())
}
