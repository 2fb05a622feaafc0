//! What the correction rests on: every parameter of the chain behind the field that is known with an uncertainty, and the
//! covariance of all of them.

use common::{AxesDirections, Axis, Document, Quantity, SensorCalibration};
use nalgebra::{DMatrix, Vector3};
use physics::frames::{ARCSEC, matrix, tangents};
use physics::{EffectInstance, Kind, Parameter, Role, Unit};
use std::ops::{AddAssign, Mul};

/// A correlation below this is rounding.
const ROUNDING: f64 = 1e-12;

/// Parameters with their covariance.
#[derive(Clone, Debug)]
pub struct Known {
    /// The parameters that have an uncertainty.
    pub parameters: Vec<Parameter>,
    /// Their covariance: the elements that are not zero, on the diagonal and above, by row and column.
    pub covariance: Vec<(usize, usize, f64)>,
}

impl Known {
    /// The covariance of what has these derivatives by the parameters, `element(a, b)` being an element of J_a J_bᵀ + J_b J_aᵀ.
    pub fn sum<T: AddAssign + Mul<f64, Output = T>>(
        &self,
        total: &mut T,
        element: impl Fn(usize, usize) -> T,
    ) {
        for &(a, b, value) in &self.covariance {
            // On the diagonal the element counts J_a J_aᵀ twice.
            *total += element(a, b) * if a == b { 0.5 * value } else { value };
        }
    }
}

impl Known {
    /// As a document states them, for readings in `unit`: k and O of each sensor, the directions of the sensors, and the
    /// parameters of `effects`, which stand at these `places` of `model.effects`.
    pub fn of(
        document: &Document,
        effects: &[EffectInstance],
        places: &[usize],
        unit: Unit,
    ) -> Result<Self, common::Error> {
        let mut terms = Terms::default();
        for axis in Axis::ALL {
            sensor(&mut terms, document, axis, unit);
        }
        let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
        if let Some(sensors) = axes.and_then(|axes| axes.sensors.as_ref()) {
            directions(&mut terms, sensors)?;
        }
        model(&mut terms, document, effects, places);
        terms.known()
    }
}

/// Parameters and the entries of their covariance.
#[derive(Default)]
struct Terms {
    parameters: Vec<Parameter>,
    entries: Vec<(Parameter, Parameter, f64)>,
}

impl Terms {
    fn variance(&mut self, parameter: Parameter, std: f64) {
        if std > 0.0 && std.is_finite() {
            self.parameters.push(parameter);
            self.entries.push((parameter, parameter, std * std));
        }
    }

    fn covariance(&mut self, a: Parameter, b: Parameter, value: f64) {
        self.entries.push((a, b, value));
    }

    /// What is not positive in the covariance by rounding is taken as zero.
    fn known(self) -> Result<Known, common::Error> {
        let count = self.parameters.len();
        if count == 0 {
            return Ok(Known { parameters: Vec::new(), covariance: Vec::new() });
        }
        let place = |parameter| self.parameters.iter().position(|other| *other == parameter);
        let mut covariance = DMatrix::zeros(count, count);
        for (a, b, value) in &self.entries {
            if let (Some(a), Some(b)) = (place(*a), place(*b)) {
                (covariance[(a, b)], covariance[(b, a)]) = (*value, *value);
            }
        }
        // In units of each standard uncertainty, so that what is rounding does not depend on units.
        let std: Vec<f64> = (0..count).map(|k| covariance[(k, k)].sqrt()).collect();
        let scaled = DMatrix::from_fn(count, count, |a, b| covariance[(a, b)] / (std[a] * std[b]));
        if scaled.iter().any(|value| !value.is_finite() || value.abs() > 1.0 + 1e-6) {
            let expected = "covariances no larger than the product of the two standard uncertainties";
            return Err(common::Error::document("calibration", "a covariance that cannot be", expected));
        }
        let mut decomposed = scaled.symmetric_eigen();
        decomposed.eigenvalues.iter_mut().for_each(|value| *value = value.max(0.0));
        let scaled = decomposed.recompose();
        let covariance = (0..count)
            .flat_map(|a| (a..count).map(move |b| (a, b)))
            .filter(|(a, b)| scaled[(*a, *b)].abs() > ROUNDING)
            .map(|(a, b)| (a, b, std[a] * std[b] * scaled[(a, b)]))
            .collect();
        Ok(Known { parameters: self.parameters, covariance })
    }
}

/// k and O of one sensor. What axescal found to be added to O has O's own uncertainty in it as what was known before, so that its
/// uncertainty is that of their sum.
fn sensor(terms: &mut Terms, document: &Document, axis: Axis, unit: Unit) {
    let Some(calibration) = document.calibration.as_ref() else { return };
    let found = calibration.sensor(axis);
    let (scale, offset) = (Parameter::Sensitivity(axis), Parameter::SensorOffset(axis));
    let std = |quantity: Option<&Quantity>| quantity.and_then(Quantity::std).unwrap_or(0.0);
    terms.variance(scale, std(found.and_then(|found| physics::sensitivity(found, unit))));
    let added = calibration.axes.as_ref().and_then(|axes| axes.offsets_nt.as_ref()?.get(axis));
    if let Some(std) = added.and_then(Quantity::std) {
        terms.variance(offset, std);
        return;
    }
    terms.variance(offset, std(found.and_then(|found| found.offset_nt.as_ref())));
    if let Some(value) = found.and_then(|found| joint(found, unit)) {
        terms.covariance(scale, offset, value);
    }
}

/// The covariance of k and O where the document has it.
fn joint(found: &SensorCalibration, unit: Unit) -> Option<f64> {
    let order = found.covariance_order.as_ref()?;
    let scale = format!("sensitivity_nt_per_{}", unit.suffix());
    entry(found.covariance.as_ref()?, order, &scale, "offset_nt")
}

/// An entry of a covariance, by the names of its row and column.
fn entry(covariance: &[Vec<f64>], order: &[String], row: &str, column: &str) -> Option<f64> {
    let place = |name: &str| order.iter().position(|key| key == name);
    covariance.get(place(row)?)?.get(place(column)?).copied()
}

/// The turns of the sensors along their tangents, from the covariance of the direction cosines or from `std_arcsec`.
fn directions(terms: &mut Terms, sensors: &AxesDirections) -> Result<(), common::Error> {
    let Some(rows) = &sensors.matrix else { return Ok(()) };
    let mu = matrix(rows);
    let turns: Vec<(Axis, usize, Vector3<f64>)> = Axis::ALL
        .into_iter()
        .flat_map(|axis| {
            let [first, second] = tangents(&mu.column(axis.index()).into_owned());
            [(axis, 0, first), (axis, 1, second)]
        })
        .collect();
    let (Some(covariance), Some(order)) = (&sensors.covariance, &sensors.covariance_order) else {
        for (axis, which, _) in turns {
            let arcsec = sensors.std_arcsec.as_ref().and_then(|std| std.get(axis)).unwrap_or(0.0);
            terms.variance(Parameter::SensorTurn(axis, which), arcsec * ARCSEC);
        }
        return Ok(());
    };
    // Cov(turn a, turn b) = Σ e_a,r C(matrix[r][a], matrix[s][b]) e_b,s.
    for (a, first, along_a) in &turns {
        for (b, second, along_b) in &turns {
            let mut value = 0.0;
            for (r, s) in (0..9).map(|k| (k / 3, k % 3)) {
                let [row, column] =
                    [(r, a), (s, b)].map(|(row, axis)| format!("matrix[{row}][{}]", axis.index()));
                let element = entry(covariance, order, &row, &column).ok_or_else(|| {
                    common::Error::document(
                        "calibration.axes.sensors.covariance",
                        format!("no entry for {row} with {column}"),
                        "9x9, over the elements of `matrix` as covariance_order names them",
                    )
                })?;
                value += along_a[r] * element * along_b[s];
            }
            let [one, other] = [(a, first), (b, second)].map(|(axis, k)| Parameter::SensorTurn(*axis, *k));
            if one == other {
                terms.variance(one, value.max(0.0).sqrt());
            } else {
                terms.covariance(one, other, value);
            }
        }
    }
    Ok(())
}

/// The parameters of the effects, with what sensorcal says of them together.
fn model(terms: &mut Terms, document: &Document, effects: &[EffectInstance], places: &[usize]) {
    let Some(adopted) = document.model.as_ref().map(|model| &model.effects) else { return };
    let mut named: Vec<(Parameter, Axis, String, f64)> = Vec::new();
    for (number, (effect, at)) in effects.iter().zip(places).enumerate() {
        let adopted = &adopted[*at];
        for (place, info) in effect.kind.parameters().iter().enumerate() {
            let std = adopted.parameters.get(info.name).and_then(Quantity::std).unwrap_or(0.0);
            // The moment of a step or a spike has no derivative.
            if info.role == Role::Epoch || std <= 0.0 {
                continue;
            }
            let parameter = Parameter::Effect(number, place);
            terms.variance(parameter, std);
            if let Some(axis) = effect.axis {
                named.push((parameter, axis, name_of(effect.kind, info.name), std));
            }
        }
    }
    for (at, (a, axis, name, std)) in named.iter().enumerate() {
        for (b, of, other, other_std) in &named[..at] {
            let together = (axis == of).then(|| together(document, *axis, name, other)).flatten();
            // What was found in another form, or changed since, has the uncertainty that stands beside it, and no more.
            let same = |found: f64, std: f64| (found.sqrt() / std - 1.0).abs() < 1e-6;
            if let Some([own, cross, of_other]) = together
                && same(own, *std)
                && same(of_other, *other_std)
            {
                terms.covariance(*a, *b, cross);
            }
        }
    }
}

/// The name of a parameter in sensorcal's lists: `offset_temperature.coefficient_nt_per_k`, `offset.first_nt` for fields across.
fn name_of(kind: Kind, parameter: &str) -> String {
    let group = match kind {
        Kind::CrossField => "offset",
        Kind::CrossFieldSensitivity => "sensitivity",
        other => other.name(),
    };
    format!("{group}.{parameter}")
}

/// Variance of one parameter, covariance, variance of the other, where sensorcal has found both together.
fn together(document: &Document, axis: Axis, one: &str, other: &str) -> Option<[f64; 3]> {
    let sensor = document.calibration.as_ref()?.sensor(axis)?;
    let temperature = sensor.temperature.as_ref().map(|fit| (&fit.covariance, &fit.covariance_order));
    let across = sensor.cross_field.as_ref().map(|fit| (&fit.covariance, &fit.covariance_order));
    [temperature, across].into_iter().flatten().find_map(|(covariance, order)| {
        let of = |a: &str, b: &str| entry(covariance, order, a, b);
        Some([of(one, one)?, of(one, other)?, of(other, other)?])
    })
}
