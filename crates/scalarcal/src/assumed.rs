//! What is assumed of the sensors where rotations do not determine it: limits, or values taken as they are.

use clap::Args;
use common::{Axis, Calibration, Code, Document, Error, Finding, OneOrEach, Quantity};
use physics::Unit;
use program::number;

use crate::read;

/// What is assumed.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct Assumed {
    /// Scale factors are within this many percent of what is stated, or of nominal
    #[arg(long, value_name = "PERCENT", value_parser = within::<50>)]
    pub scales_within: Option<f64>,
    /// Angles between the sensors are within this many degrees of what is stated, or of 90°
    #[arg(long, value_name = "DEGREES", value_parser = within::<30>)]
    pub angles_within: Option<f64>,
    /// Determine offsets alone; scale factors and angles are taken as they are stated, or as nominal
    #[arg(long, value_parser = ["offsets"], conflicts_with_all = ["scales_within", "angles_within"])]
    pub only: Option<String>,
}

/// Standard uncertainty of a scale factor that is taken as it is, relative, small beside any that is measured.
const TAKEN_SCALE_STD: f64 = 1e-7;
/// That of an angle, arcsec.
const TAKEN_ANGLE_STD_ARCSEC: f64 = 1e-2;
const ARCSEC_PER_DEG: f64 = 3600.0;

impl Assumed {
    pub(crate) fn is_any(&self) -> bool {
        self.only.is_some() || self.scales_within.is_some() || self.angles_within.is_some()
    }

    /// States it as a calibration with its uncertainty, of which the fit makes a prior: limits are those of a
    /// uniform distribution, with a standard uncertainty of the limit over √3. Stated uncertainties stay.
    ///
    /// Errors: readings in volts without a nominal sensitivity.
    pub(crate) fn state(&self, document: &mut Document) -> Result<Finding, Error> {
        let uniform = |limit: f64| limit / 3.0_f64.sqrt();
        let taken = self.only.is_some();
        let scale =
            if taken { Some(TAKEN_SCALE_STD) } else { self.scales_within.map(|limit| uniform(0.01 * limit)) };
        let limit = self.angles_within.map(|limit| uniform(limit * ARCSEC_PER_DEG));
        let angle = if taken { Some(TAKEN_ANGLE_STD_ARCSEC) } else { limit };
        if let Some(relative) = scale {
            scales(document, relative, taken)?;
        }
        let axes = document.calibration.get_or_insert_default().axes.get_or_insert_default();
        let sensors = axes.sensors.get_or_insert_default();
        let known = sensors.std_arcsec.is_some() || sensors.covariance.is_some();
        if let Some(std_arcsec) = angle.filter(|_| taken || !known) {
            sensors.matrix.get_or_insert([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
            (sensors.covariance, sensors.covariance_order) = (None, None);
            // The angle between two directions has the variance of both.
            sensors.std_arcsec = Some(OneOrEach::One(std_arcsec / 2.0_f64.sqrt()));
        }
        let limits = [
            self.scales_within.map(|limit| format!("scale factors within {limit} %")),
            self.angles_within.map(|limit| format!("angles between the sensors within {limit}°")),
            taken.then(|| "scale factors and angles between the sensors are as stated, or nominal, without uncertainty".into()),
        ];
        let limits: Vec<String> = limits.into_iter().flatten().collect();
        Ok(Code::CalibrationAssumed.said(format!(
            "assumed: {}; where that is wrong, so are the offsets, by more than their uncertainty",
            limits.join(", ")
        )))
    }

    /// Scale factors and angles that were taken as they are come back as they were, without uncertainty.
    ///
    /// Errors: readings that contradict them.
    pub(crate) fn restored(
        &self,
        mut found: Document,
        before: Option<Calibration>,
    ) -> Result<Document, Error> {
        let taken = self.only.is_some();
        let Some(calibration) = found.calibration.as_mut().filter(|_| taken) else { return Ok(found) };
        let is_contradicted =
            |(_, code, _): (&str, Option<Code>, &str)| code == Some(Code::PriorContradicted);
        if calibration.scalar.iter().any(|scalar| scalar.findings.coded().any(is_contradicted)) {
            let words = "the readings contradict the scale factors and angles that --only offsets takes as they are: the offsets would be wrong by more than their uncertainty. Give what is known of the sensors in their place, as in --scales-within 2 --angles-within 1";
            return Err(Error::Unanswerable(words.into()));
        }
        for axis in Axis::ALL {
            let earlier = before.as_ref().and_then(|before| before.sensor(axis));
            let Some(sensor) = calibration.sensors.get_or_insert_default().entry(axis) else { continue };
            sensor.sensitivity_nt_per_v = earlier.and_then(|earlier| earlier.sensitivity_nt_per_v.clone());
            sensor.sensitivity_nt_per_nt = earlier.and_then(|earlier| earlier.sensitivity_nt_per_nt.clone());
            (sensor.covariance, sensor.covariance_order) = (None, None);
        }
        let earlier = before.and_then(|before| before.axes).and_then(|axes| axes.sensors);
        calibration.axes.get_or_insert_default().sensors = earlier;
        Ok(found)
    }
}

/// A number above zero, up to one beyond which the fit is not linear over it.
fn within<const MOST: u8>(text: &str) -> Result<f64, String> {
    let number = number::positive(text)?;
    let fits = number <= f64::from(MOST);
    if fits { Ok(number) } else { Err(format!("found {text}; expected a number up to {MOST}")) }
}

/// Gives the sensitivities this relative standard uncertainty.
fn scales(document: &mut Document, relative: f64, taken: bool) -> Result<(), Error> {
    let mut free = document.recordings.iter().filter(|recording| read::is_free(recording));
    let unit = free.find_map(|recording| read::unit_of(|name| recording.columns.contains_key(name)));
    let unit = unit.unwrap_or(Unit::Volt);
    for axis in Axis::ALL {
        let Some(value) = read::sensitivity(document, unit, axis) else {
            let expected = "the nT of a volt, from which scale factors are taken";
            return Err(Error::document("instrument.nominal_sensitivity_nt_per_v", "none", expected));
        };
        let sensors = document.calibration.get_or_insert_default().sensors.get_or_insert_default();
        let sensor = sensors.entry(axis).get_or_insert_default();
        let stated = match unit {
            Unit::Volt => &mut sensor.sensitivity_nt_per_v,
            _ => &mut sensor.sensitivity_nt_per_nt,
        };
        if taken || stated.as_ref().is_none_or(|stated| stated.std().is_none()) {
            *stated = Some(Quantity::new(value, relative * value.abs()));
            (sensor.covariance, sensor.covariance_order) = (None, None);
        }
    }
    Ok(())
}
