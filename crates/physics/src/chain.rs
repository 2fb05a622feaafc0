//! The forward model of a whole recording, with every effect in its place.

use crate::lanes::{Dual, LANES, slope, unit};
use common::Axis;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use std::borrow::Cow;

use crate::effect::Surroundings;
use crate::effects::add_known_gradient;
use crate::model::column;
use crate::{
    Basic, Context, EffectInstance, Error, Kind, Parameter, Real, Stage, field_geo, frames, parallel,
};

/// What the chain predicts for a recording.
#[derive(Clone, Debug)]
pub struct Prediction<T: Real = f64> {
    /// The field in GEO, nT. Differential recordings: as `field_sen`.
    pub field_geo: Vec<Vector3<T>>,
    /// The field in SEN at the sensors, nT.
    pub field_sen: Vec<Vector3<T>>,
    /// The readings x, y, z in the recording's unit; differential: of the test instrument.
    pub readings: Vec<Vector3<T>>,
}

/// Predicts the readings of a recording.
pub fn predict(
    basic: &Basic,
    effects: &[EffectInstance],
    context: &Context<'_>,
) -> Result<Prediction, Error> {
    Ok(predict_with_jacobian(basic, effects, context, &[])?.0)
}

/// The parameters of effects in another number type, all derivatives zero.
pub(crate) fn values<T: Real>(effects: &[EffectInstance]) -> Vec<Vec<T>> {
    effects.iter().map(|effect| effect.parameters.iter().map(|value| T::from(*value)).collect()).collect()
}

/// An effect that cannot act in a recording, for want of something that was not recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// The recording.
    pub recording: String,
    /// Name of the effect.
    pub who: String,
    /// What it lacks.
    pub what: String,
}

/// As [`predict`], with every effect that the recording lets act, and the others by what they lack.
pub fn predict_acting(
    basic: &Basic,
    effects: &[EffectInstance],
    context: &Context<'_>,
) -> Result<(Prediction, Vec<LeftOut>), Error> {
    let mut acting = effects.to_vec();
    let mut left_out = Vec::new();
    loop {
        match predict(basic, &acting, context) {
            Err(Error::Missing { recording, who, what })
                if acting.iter().any(|effect| effect.kind.name() == who) =>
            {
                acting.retain(|effect| effect.kind.name() != who);
                left_out.push(LeftOut { recording, who, what });
            }
            other => return other.map(|prediction| (prediction, left_out)),
        }
    }
}

/// The prediction and its derivative by each of `parameters`.
pub fn predict_with_jacobian(
    basic: &Basic,
    effects: &[EffectInstance],
    context: &Context<'_>,
    parameters: &[Parameter],
) -> Result<(Prediction, Vec<Prediction>), Error> {
    let chain = Chain { basic, effects, values: &values(effects), context };
    let fields = chain.fields()?;
    let derivatives: Vec<Vec<Prediction>> = match parameters.len() {
        0 => Vec::new(),
        1 => vec![slopes::<1>(&chain, &fields, parameters)?],
        2..=3 => vec![slopes::<3>(&chain, &fields, parameters)?],
        _ => parameters
            .par_chunks(LANES)
            .map(|parameters| slopes::<LANES>(&chain, &fields, parameters))
            .collect::<Result<_, Error>>()?,
    };
    let readings = chain.read(&fields.sen, &fields.coil)?;
    let prediction = Prediction { field_geo: fields.geo, field_sen: fields.sen, readings };
    Ok((prediction, derivatives.into_iter().flatten().collect()))
}

/// The derivatives by at most `N` parameters.
fn slopes<const N: usize>(
    chain: &Chain<'_, f64>,
    fields: &Fields<f64>,
    parameters: &[Parameter],
) -> Result<Vec<Prediction>, Error> {
    let Chain { basic, effects, context, .. } = *chain;
    let mut lifted: Basic<Dual<N>> = basic.lift();
    let mut values: Vec<Vec<Dual<N>>> = values(effects);
    let directions: Vec<Direction> = parameters.iter().map(|one| vec![(*one, 1.0)]).collect();
    seed(basic, &mut lifted, &mut values, &directions);
    let chain = Chain { basic: &lifted, effects, values: &values, context };
    // What acts behind the field leaves it as it is.
    let behind = parameters.iter().all(|parameter| match parameter {
        Parameter::Effect(effect, _) => effects[*effect].kind.about().stage >= Stage::Block,
        Parameter::SensorTurn(..) | Parameter::Sensitivity(_) | Parameter::SensorOffset(_) => true,
        Parameter::CoilConstant(_) | Parameter::CoilOffset(_) | Parameter::CoilTurn(..) => false,
    });
    let fields = if behind { fields.lift() } else { chain.fields()? };
    let readings = chain.read(&fields.sen, &fields.coil)?;
    let zero = |series: &[Vector3<Dual<N>>]| vec![vec![Vector3::zeros(); series.len()]; parameters.len()];
    // All in one pass: a row of numbers with derivatives is long.
    let of = |series: &[Vector3<Dual<N>>]| {
        let mut all = vec![Vec::with_capacity(series.len()); parameters.len()];
        for v in series {
            all.iter_mut().enumerate().for_each(|(lane, own)| own.push(v.map(|value| slope(&value, lane))));
        }
        all
    };
    let [geo, sen] = [&fields.geo, &fields.sen].map(|series| if behind { zero(series) } else { of(series) });
    let series = geo.into_iter().zip(sen).zip(of(&readings));
    Ok(series
        .map(|((field_geo, field_sen), readings)| Prediction { field_geo, field_sen, readings })
        .collect())
}

/// Parameters that move together, each by how much.
pub type Direction = Vec<(Parameter, f64)>;

/// Carries the derivatives along at most `N` directions, each in a lane of its own.
pub(crate) fn seed<const N: usize>(
    basic: &Basic,
    lifted: &mut Basic<Dual<N>>,
    values: &mut [Vec<Dual<N>>],
    directions: &[Direction],
) {
    let each = directions.iter().enumerate().flat_map(|(lane, direction)| {
        direction.iter().map(move |(parameter, moved)| (*parameter, unit(lane) * *moved))
    });
    for (parameter, moved) in each {
        // What a small turn adds to a direction.
        let added = |column: Vector3<f64>, which: usize| {
            let turn = std::array::from_fn(|k| if k == which { moved } else { Dual::from(0.0) });
            frames::turned_at_length(&column, turn) - column.map(Dual::from)
        };
        match parameter {
            Parameter::CoilTurn(axis, which) => {
                let mut to = lifted.eta.column_mut(axis.index());
                to += added(column(&basic.eta, axis), which);
            }
            Parameter::SensorTurn(axis, which) => {
                let mut to = lifted.mu.column_mut(axis.index());
                to += added(column(&basic.mu, axis), which);
            }
            Parameter::Effect(effect, number) => values[effect][number] += moved,
            constant => lifted.constant_mut(constant).into_iter().for_each(|value| *value += moved),
        }
    }
}

/// The field of a recording: of each coil along its axis, in GEO and in SEN.
struct Fields<T: Real> {
    coil: Vec<Vector3<T>>,
    geo: Vec<Vector3<T>>,
    sen: Vec<Vector3<T>>,
}

impl Fields<f64> {
    /// As numbers that carry no derivative.
    fn lift<T: Real>(&self) -> Fields<T> {
        let [coil, geo, sen] = [&self.coil, &self.geo, &self.sen]
            .map(|series| series.iter().map(|field| field.map(T::from)).collect());
        Fields { coil, geo, sen }
    }
}

/// A known matrix times a vector, written out: quicker for numbers with derivatives than the general product.
fn product<T: Real>(matrix: &Matrix3<f64>, v: &Vector3<T>) -> Vector3<T> {
    Vector3::from_fn(|i, _| v[0] * matrix[(i, 0)] + v[1] * matrix[(i, 1)] + v[2] * matrix[(i, 2)])
}

/// The chain of one recording with the values of its parameters.
pub(crate) struct Chain<'a, T: Real> {
    pub basic: &'a Basic<T>,
    pub effects: &'a [EffectInstance],
    pub values: &'a [Vec<T>],
    pub context: &'a Context<'a>,
}

impl<T: Real> Chain<'_, T> {
    /// The first half of the chain: from the currents to the field in SEN.
    fn fields(&self) -> Result<Fields<T>, Error> {
        let Self { basic, context, .. } = *self;
        if let Some(reference) = &context.reference_nt {
            // What comes from the surroundings comes to the test instrument; the reference is as it was read.
            let mut field: Vec<Vector3<T>> = reference.iter().map(|field| field.map(T::from)).collect();
            self.apply(Stage::Geo, &mut field, &[], &[])?;
            return Ok(Fields { coil: Vec::new(), geo: field.clone(), sen: field });
        }
        let mut coil: Vec<Vector3<T>> = context
            .current_a
            .iter()
            .map(|current| Vector3::from_fn(|c, _| basic.coils[c].constant_nt_per_a * current[c]))
            .collect();
        self.apply(Stage::Coil, &mut coil, &[], &[])?;
        let offsets =
            Vector3::from_fn(|c, _| if context.in_coils { basic.coils[c].offset_nt } else { T::from(0.0) });
        let mut geo: Vec<Vector3<T>> = coil
            .iter()
            .enumerate()
            .map(|(row, coil)| field_geo(&basic.eta, &(coil + offsets), &context.ambient(row).map(T::from)))
            .collect();
        self.apply(Stage::Geo, &mut geo, &coil, &[])?;
        let fixed = context.attitude.is_empty().then_some(context.orientation.rotation);
        let to_sen = |(row, field)| product(&fixed.unwrap_or_else(|| context.rotation(row)), field);
        let sen = geo.iter().enumerate().map(to_sen).collect();
        Ok(Fields { coil, geo, sen })
    }

    /// The second half of the chain: from the field in SEN to the readings.
    pub fn read(&self, field_sen: &[Vector3<T>], coil_nt: &[Vector3<T>]) -> Result<Vec<Vector3<T>>, Error> {
        let mut field = Cow::Borrowed(field_sen);
        if self.effects.iter().any(|effect| effect.kind.about().stage == Stage::Block) {
            self.apply(Stage::Block, field.to_mut(), coil_nt, field_sen)?;
        }
        let axes = Axis::ALL.map(|axis| column(&self.basic.mu, axis));
        let mut signal: Vec<Vector3<T>> =
            field.iter().map(|field| Vector3::from_fn(|i, _| parallel(&axes[i], field))).collect();
        add_known_gradient(self.basic, self.context, &mut signal);
        for stage in [Stage::Sensor, Stage::Electronics, Stage::Sampling] {
            self.apply(stage, &mut signal, coil_nt, &field)?;
        }
        for (signal, noise) in signal.iter_mut().zip(&self.context.noise_nt) {
            *signal += noise.map(T::from);
        }
        for stage in [Stage::Converter, Stage::Logger] {
            self.apply(stage, &mut signal, coil_nt, &field)?;
        }
        for value in &mut signal {
            for (component, sensor) in value.iter_mut().zip(&self.basic.sensors) {
                *component = (*component - sensor.offset_nt) / sensor.sensitivity;
            }
        }
        Ok(signal)
    }

    /// The effects of one stage, in the order in which the model lists them.
    fn apply(
        &self,
        stage: Stage,
        signal: &mut [Vector3<T>],
        coil_nt: &[Vector3<T>],
        field_sen: &[Vector3<T>],
    ) -> Result<(), Error> {
        // What effects of one kind with times of their own begin with: none reads what another made.
        let mut limited: Option<(Kind, Vec<Vector3<T>>)> = None;
        for (effect, values) in self.effects.iter().zip(self.values) {
            if effect.kind.about().stage != stage || !effect.acts(self.context.recording) {
                continue;
            }
            let around = Surroundings {
                who: effect.kind.name(),
                context: self.context,
                axis: effect.axis.unwrap_or(Axis::X),
                column: effect.column.as_deref().unwrap_or_default(),
                basic: self.basic,
                coil_nt,
                field_sen,
            };
            if effect.within.is_always() {
                effect.kind.apply(values, signal, &around)?;
                continue;
            }
            let clock = self.context.clock(effect.kind.name())?;
            let before = match limited.take() {
                Some((kind, before)) if kind == effect.kind => before,
                _ => signal.to_vec(),
            };
            let mut made = before.clone();
            effect.kind.apply(values, &mut made, &around)?;
            for (row, value) in
                made.into_iter().enumerate().filter(|(row, _)| effect.within.holds(clock[*row]))
            {
                signal[row] = value;
            }
            limited = Some((effect.kind, before));
        }
        Ok(())
    }
}
