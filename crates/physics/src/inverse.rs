//! The chain run backwards: from readings to the field that made them.

use nalgebra::Vector3;

use crate::chain::Chain;
use crate::{Basic, Context, EffectInstance, Error};

/// Passes before the chain counts as not invertible.
const PASSES: usize = 200;
/// The reading must be met to within this, nT.
const TOLERANCE_NT: f64 = 1e-9;

/// The field in SEN (nT) whose prediction is the readings (in the unit of the recording), for every row.
///
/// Solves F(B) = y for the second half F of the forward chain by B ← B + (μᵀ)⁻¹ (y − F(B)): one pass for
/// effects that do not depend on the field, a few for those that do (NASA's two-pass correction is
/// its beginning). Where the passes do not settle, the chain is not invertible, and that is said; an effect that
/// hides the field (codes, cut-off, frozen readings) is refused. A row with a missing reading gives a missing field.
pub fn field_in_sen(
    basic: &Basic,
    effects: &[EffectInstance],
    context: &Context<'_>,
    readings: &[Vector3<f64>],
) -> Result<Vec<Vector3<f64>>, Error> {
    let refuse = |passes: usize, missed_nt: f64| Error::NotInvertible {
        recording: context.recording.id.clone(),
        passes,
        missed_nt,
        effects: if effects.is_empty() {
            "Sensor axes that lie in one plane".into()
        } else {
            effects.iter().map(|effect| effect.kind.about().title).collect::<Vec<_>>().join(", ")
        },
    };
    if let Some(effect) = effects.iter().find(|effect| !effect.kind.about().invertible) {
        return Err(Error::Hidden {
            recording: context.recording.id.clone(),
            effect: effect.kind.name().into(),
            title: effect.kind.about().title.into(),
        });
    }
    let coil_nt = coil_field(basic, context);
    let unmix = basic.mu.transpose().try_inverse().ok_or_else(|| refuse(0, f64::INFINITY))?;
    let values: Vec<&[f64]> = effects.iter().map(|effect| effect.parameters.as_slice()).collect();
    let chain = Chain { basic, effects, values: &values, context };
    let mut field = vec![Vector3::zeros(); readings.len()];
    // A row without a reading, or without a prediction, has no field; memory bridges it like any missing sample.
    let missing = Vector3::repeat(f64::NAN);
    let lost = |row: &Vector3<f64>| row.iter().any(|value| !value.is_finite());
    field
        .iter_mut()
        .zip(readings)
        .filter(|(_, reading)| lost(reading))
        .for_each(|(field, _)| *field = missing);
    let mut missed_nt = f64::INFINITY;
    for _ in 0..PASSES {
        let predicted = chain.read(&field, &coil_nt)?;
        missed_nt = 0.0;
        for ((field, predicted), reading) in field.iter_mut().zip(&predicted).zip(readings) {
            if lost(field) {
                continue;
            }
            if lost(predicted) {
                *field = missing;
                continue;
            }
            let difference =
                Vector3::from_fn(|i, _| (reading[i] - predicted[i]) * basic.sensors[i].sensitivity);
            missed_nt = f64::max(missed_nt, difference.amax());
            *field += unmix * difference;
        }
        if missed_nt <= TOLERANCE_NT || !missed_nt.is_finite() {
            break;
        }
    }
    // Rounding in fields of 64 000 nT leaves some 1e-11 nT.
    if missed_nt > TOLERANCE_NT {
        return Err(refuse(PASSES, missed_nt));
    }
    Ok(field)
}

/// The field along each coil without effects, nT: what the effects of the second half may refer to.
fn coil_field(basic: &Basic, context: &Context<'_>) -> Vec<Vector3<f64>> {
    let constants = Vector3::from_fn(|c, _| basic.coils[c].constant_nt_per_a);
    context.current_a.iter().map(|current| current.component_mul(&constants)).collect()
}
