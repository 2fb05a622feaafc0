//! The chain run backwards: from readings to the field that made them, with its derivatives.

mod band;
mod derivative;
mod slope;

use nalgebra::{Matrix3, Vector3};

use crate::chain::{Chain, values};
use crate::{Basic, Context, EffectInstance, Error, Real, Stage};
use band::Band;

/// Passes before the chain counts as not invertible.
const PASSES: usize = 60;
/// A field has settled when a pass changes it, or its prediction misses, by no more than this, nT.
const TOLERANCE_NT: f64 = 1e-9;
/// Slopes are taken anew at most so often.
const SLOPES: usize = 8;
/// Rows over which memory is followed, tried one after the other.
const REACHES: [usize; 3] = [4, 16, 64];
/// Largest work, rows × reach², for which a reach is tried.
const MOST_WORK: usize = 50_000_000;

/// What became of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// Its field is found.
    Found,
    /// A reading is missing, or what its prediction needs.
    Missing,
    /// The readings do not determine it: the passes did not settle, or it was read too late.
    NotInvertible,
}

/// Runs the second half F of the forward chain, from the field in SEN to the readings, backwards.
///
/// Solves F(B) = y by B ← B + S (y − F(B)), for all rows at once. S is (μᵀ)⁻¹, so that one pass is exact for
/// effects that do not depend on the field and a few for those that do (NASA's two-pass correction is its
/// beginning). Where F remembers, or that does not settle, S is the inverse of ∂F/∂B, which dual numbers give
/// for rows near each other: lags and delays longer than a step are taken out that way. What comes of it
/// holds to [`TOLERANCE_NT`] whatever S, or is said not to.
#[derive(Clone, Copy, Debug)]
pub struct Inverter<'a> {
    basic: &'a Basic,
    effects: &'a [EffectInstance],
    context: &'a Context<'a>,
    unmix: Matrix3<f64>,
}

/// Fields that were found.
pub struct Solved<'a> {
    /// The field in SEN for each row, nT; NaN where there is none.
    pub field_sen: Vec<Vector3<f64>>,
    /// What became of each row.
    pub rows: Vec<Row>,
    /// Largest distance between a reading and the prediction of its field over the rows that are found, nT.
    pub missed_nt: f64,
    inverter: Inverter<'a>,
    /// Where the slopes are taken: the field, with the best guess where it is not determined.
    at: Vec<Vector3<f64>>,
    step: Step,
}

/// S: what a pass makes of the difference between readings and predictions.
enum Step {
    /// (μᵀ)⁻¹ in each row.
    Unmix(Matrix3<f64>),
    /// The inverse of the slope over neighbouring rows.
    Band(Band),
    /// The inverse of the slope in each row, where rows are independent of each other.
    Rows(Vec<Matrix3<f64>>),
}

impl Step {
    fn of(&self, difference: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        match self {
            Step::Unmix(unmix) => difference.iter().map(|difference| unmix * difference).collect(),
            Step::Band(band) => band.solve(difference),
            Step::Rows(inverses) => {
                inverses.iter().zip(difference).map(|(inverse, by)| inverse * by).collect()
            }
        }
    }
}

impl<'a> Inverter<'a> {
    /// Refuses axes in one plane, and effects that hide the field (codes, cut-off, frozen readings).
    pub fn new(
        basic: &'a Basic,
        effects: &'a [EffectInstance],
        context: &'a Context<'a>,
    ) -> Result<Self, Error> {
        let hides = |effect: &&EffectInstance| effect.acts(context.recording) && !effect.kind.invertible();
        if let Some(effect) = effects.iter().find(hides) {
            return Err(Error::Hidden {
                recording: context.recording.id.clone(),
                effect: effect.kind.name().into(),
                title: effect.kind.about().title.into(),
            });
        }
        let unmix = basic
            .mu
            .transpose()
            .try_inverse()
            .ok_or_else(|| Error::InOnePlane { recording: context.recording.id.clone() })?;
        Ok(Self { basic, effects, context, unmix })
    }

    /// Whether the readings are one matrix times the field and offsets: nothing acts behind the field, and no
    /// coil's gradient is known.
    pub fn is_affine(&self) -> bool {
        let behind = |effect: &EffectInstance| effect.kind.about().stage >= Stage::Block;
        let gradient = self.context.positions_m.is_some() && self.context.gradient_nt_per_m_a.amax() > 0.0;
        !gradient && !self.effects.iter().any(|effect| behind(effect) && effect.acts(self.context.recording))
    }

    /// The field in SEN (nT) whose prediction is the readings (in the unit of the recording), for every row.
    pub fn field(self, readings: &[Vector3<f64>]) -> Result<Solved<'a>, Error> {
        let nominal: Vec<Vector3<f64>> = readings
            .iter()
            .map(|reading| {
                let of = |i: usize| {
                    let sensor = self.basic.sensors[i];
                    sensor.sensitivity * reading[i] + sensor.offset_nt
                };
                let field = self.unmix * Vector3::from_fn(|i, _| of(i));
                if field.iter().all(|value| value.is_finite()) { field } else { Vector3::repeat(f64::NAN) }
            })
            .collect();
        let reaches: Vec<Option<usize>> = if self.remembers(&nominal)? {
            let tried = REACHES.into_iter().filter(|reach| {
                *reach == REACHES[0] || readings.len().saturating_mul(reach * reach) <= MOST_WORK
            });
            tried.map(Some).collect()
        } else {
            vec![None, Some(0)]
        };
        let remembers = reaches[0].is_some();
        let mut best: Option<Solved<'a>> = None;
        for reach in reaches {
            let solved = self.attempt(readings, nominal.clone(), reach)?;
            let unsettled =
                |solved: &Solved<'_>| solved.rows.iter().filter(|row| **row == Row::NotInvertible).count();
            let better = best.as_ref().is_none_or(|best| unsettled(&solved) < unsettled(best));
            let done = unsettled(&solved) == 0;
            if better {
                best = Some(solved);
            }
            if done {
                break;
            }
        }
        let mut best = best.expect("at least one reach is tried");
        if !remembers && !self.is_affine() {
            // Row by row the slope at the field is all of ∂F/∂B: each derivative then takes one pass.
            best.step = Step::Rows(self.inverses(&best.at)?);
        }
        Ok(best)
    }

    /// Passes with slopes over one reach; without, with (μᵀ)⁻¹.
    fn attempt(
        self,
        readings: &[Vector3<f64>],
        mut field: Vec<Vector3<f64>>,
        reach: Option<usize>,
    ) -> Result<Solved<'a>, Error> {
        let slope = |field: &[Vector3<f64>]| -> Result<Step, Error> {
            Ok(match reach {
                None => Step::Unmix(self.unmix),
                Some(reach) => Step::Band(self.slope(field, reach)?),
            })
        };
        let missing = Vector3::repeat(f64::NAN);
        let lost = |row: &Vector3<f64>| !row.iter().all(|value| value.is_finite());
        let mut step = slope(&field)?;
        let mut taken = 1;
        let mut rows: Vec<Row> =
            field.iter().map(|field| if lost(field) { Row::Missing } else { Row::Found }).collect();
        let mut settled = vec![false; rows.len()];
        let mut missed = vec![0.0; rows.len()];
        let mut worst_before = f64::INFINITY;
        for pass in 0..PASSES {
            let predicted = self.read(&self.basic.lift(), &values(self.effects), &field)?;
            let difference: Vec<Vector3<f64>> = predicted
                .iter()
                .zip(readings)
                .zip(&mut rows)
                .map(|((predicted, reading), row)| {
                    if *row == Row::Found && lost(predicted) {
                        // What never had a prediction lacks a column; what lost it on the way ran away.
                        *row = if pass == 0 { Row::Missing } else { Row::NotInvertible };
                    }
                    if *row != Row::Found {
                        return Vector3::zeros();
                    }
                    Vector3::from_fn(|i, _| (reading[i] - predicted[i]) * self.basic.sensors[i].sensitivity)
                })
                .collect();
            let change = step.of(&difference);
            let mut worst: f64 = 0.0;
            for (at, field) in field.iter_mut().enumerate() {
                if rows[at] != Row::Found {
                    *field = missing;
                    continue;
                }
                *field += change[at];
                missed[at] = difference[at].amax();
                let left = missed[at].min(change[at].amax());
                settled[at] = left <= TOLERANCE_NT;
                worst = worst.max(left);
            }
            if worst <= TOLERANCE_NT {
                break;
            }
            if worst > 0.1 * worst_before && reach.is_some() && taken < SLOPES {
                step = slope(&field)?;
                taken += 1;
            }
            worst_before = worst;
        }
        if let Step::Band(band) = &step {
            settled.iter_mut().zip(band.unseen()).for_each(|(settled, unseen)| *settled &= !unseen);
        }
        for (row, settled) in rows.iter_mut().zip(settled) {
            if *row == Row::Found && !settled {
                *row = Row::NotInvertible;
            }
        }
        let found = |at: &usize| rows[*at] == Row::Found;
        let missed_nt = (0..rows.len()).filter(found).map(|at| missed[at]).fold(0.0, f64::max);
        let field_sen = (0..rows.len()).map(|at| if found(&at) { field[at] } else { missing }).collect();
        Ok(Solved { field_sen, rows, missed_nt, inverter: self, at: field, step })
    }

    fn read<T: Real>(
        &self,
        basic: &Basic<T>,
        values: &[Vec<T>],
        field: &[Vector3<T>],
    ) -> Result<Vec<Vector3<T>>, Error> {
        // The field along each coil without effects: what the effects of the second half may refer to.
        let constants = Vector3::from_fn(|c, _| basic.coils[c].constant_nt_per_a);
        let along = |current: &Vector3<f64>| Vector3::from_fn(|c, _| constants[c] * current[c]);
        let coil_nt: Vec<Vector3<T>> = self.context.current_a.iter().map(along).collect();
        Chain { basic, effects: self.effects, values, context: self.context }.read(field, &coil_nt)
    }
}

/// The field in SEN of every row, if all have one; see [`Inverter`]. NaN where a reading is missing.
pub fn field_in_sen(
    basic: &Basic,
    effects: &[EffectInstance],
    context: &Context<'_>,
    readings: &[Vector3<f64>],
) -> Result<Vec<Vector3<f64>>, Error> {
    let solved = Inverter::new(basic, effects, context)?.field(readings)?;
    let not: Vec<usize> =
        (0..solved.rows.len()).filter(|row| solved.rows[*row] == Row::NotInvertible).collect();
    match not.first() {
        None => Ok(solved.field_sen),
        Some(first) => Err(Error::NotInvertible {
            recording: context.recording.id.clone(),
            rows: not.len(),
            first: *first,
            effects: effects.iter().map(|effect| effect.kind.about().title).collect::<Vec<_>>().join(", "),
        }),
    }
}
