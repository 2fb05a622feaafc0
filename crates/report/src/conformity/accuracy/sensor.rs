use common::uncertainty;
use common::{AdoptedEffect, Axis, CrossFieldFit, Document, Quantity, SensorCalibration};
use nalgebra::Vector3;
use physics::frames::ARCSEC;
use physics::{FULL_NT, Kind};

use crate::conformity::directions::turn_per_k;
use crate::conformity::joint::{self, ACROSS, Joint};
use crate::conformity::offset::{Drift, drift};
use crate::conformity::range::{calibrated_nt, codes_nt};
use crate::conformity::spec::Requirement;
use crate::conformity::temperature::{Coefficients, Part};

/// What is not in the budget, with the sensors of which that holds.
#[derive(Default)]
pub struct Gaps(Vec<(String, Vec<Axis>)>);

impl Gaps {
    pub fn add(&mut self, axis: Axis, why: &str) {
        match self.0.iter_mut().find(|(known, _)| known == why) {
            Some((_, axes)) if axes.contains(&axis) => {}
            Some((_, axes)) => axes.push(axis),
            None => self.0.push((why.into(), vec![axis])),
        }
    }

    pub fn sentences(self) -> Vec<String> {
        let sentence = |(why, axes): (String, Vec<Axis>)| match axes.as_slice() {
            [axis] => format!("sensor {axis}: {why}"),
            axes => {
                let names: Vec<&str> = axes.iter().map(|axis| axis.letter()).collect();
                format!("sensors {}: {why}", names.join(", "))
            }
        };
        self.0.into_iter().map(sentence).collect()
    }
}

/// Effects that the budget has a term for.
const KNOWN: [Kind; 9] = [
    Kind::QuadraticNonlinearity,
    Kind::CubicNonlinearity,
    Kind::CrossField,
    Kind::CrossFieldSensitivity,
    Kind::OffsetTemperature,
    Kind::SensitivityTemperature,
    Kind::OffsetElectronicsTemperature,
    Kind::SensitivityElectronicsTemperature,
    Kind::AxisTemperature,
];

pub struct Case {
    /// The field in SEN, nT.
    pub field: Vector3<f64>,
    /// Sensor and electronics less their reference, K.
    pub warmer: [f64; 2],
}

/// What a sensor's corrected reading errs by, nT.
pub struct SensorError {
    /// What is known and not corrected.
    pub bias: f64,
    /// The derivative by each of [`Sensor::parameters`].
    pub weights: Vec<f64>,
    /// Standard uncertainty of each term that rests on no parameter.
    pub terms: [(&'static str, f64); 6],
}

/// The terms of one sensor's error δb. Of parameters, with their joint covariance:
/// - V δk + δO, V = (b − O)/k;
/// - nonlinearity: the model's coefficients a (b/50 000 nT)^p;
/// - temperatures: the coefficients;
/// - turn of the axis with temperature: times the fields across;
/// - fields across: the coefficients.
///
/// By themselves:
/// - nonlinearity where none was found: the size and u of what was looked for, a cubic one less the line that
///   fits it best over the field of the calibration;
/// - fields across that the model does not correct: their size;
/// - noise of a reading: flicker noise in the band of the recordings, and white noise; rounding δ/√12;
/// - drift of the offset, turn of the reversals (a bound, rectangular).
pub struct Sensor {
    /// The parameters, each with the name of its term.
    pub parameters: Vec<(&'static str, String)>,
    sensitivity: f64,
    offset: f64,
    /// Powers of the field along the sensor for which the model has a coefficient.
    powers: Vec<i32>,
    nonlinearity: [f64; 2],
    nonlinearity_over_nt: Option<f64>,
    temperature: Option<Coefficients>,
    turns: bool,
    across: Option<Across>,
    noise: f64,
    rounding: f64,
    drift: Option<Drift>,
    reversal: f64,
}

impl Sensor {
    /// From a document, for what the requirement asks; what has no term is named. None where k or O has no
    /// uncertainty.
    pub fn of(
        (document, joint): (&Document, &Joint),
        requirement: &Requirement,
        axis: Axis,
        found: &SensorCalibration,
        gaps: &mut Gaps,
    ) -> Option<Self> {
        let (k, unit) = joint::sensitivity(found)?;
        let offset = found.offset_nt.as_ref()?;
        let constants = [uncertainty::sensitivity(axis, unit), joint::offset(document, axis)];
        let known = joint.covariance(&constants);
        if known[(0, 0)] == 0.0 || known[(1, 1)] == 0.0 {
            return None;
        }
        let mut parameters: Vec<(&'static str, String)> =
            constants.map(|path| ("sensitivity and offset", path)).into();
        let effects = effects(document, axis, gaps);
        let modelled = |kind: Kind| effects.iter().any(|effect| effect.effect == kind.name());
        let bends = [(Kind::QuadraticNonlinearity, 2), (Kind::CubicNonlinearity, 3)];
        let bends = bends.into_iter().filter(|(kind, _)| modelled(*kind));
        let powers = bends
            .map(|(kind, power)| {
                parameters.push(("nonlinearity", joint::effect(kind.name(), axis, "departure_nt")));
                power
            })
            .collect::<Vec<i32>>();
        let nonlinearity = if powers.is_empty() { looked_for(found) } else { [0.0; 2] };
        let temperature = Coefficients::of(document, joint, axis);
        for part in Part::BOTH.into_iter().filter(|part| part.required(requirement).is_some()) {
            if !temperature.as_ref().is_some_and(|known| known.has(part)) {
                let what = format!("what the {}'s temperature does is not known", part.word());
                gaps.add(axis, &format!("{what} (`temperature_run` would show it)"));
            }
        }
        for effect in temperature.iter().flat_map(Coefficients::effects) {
            if !effects.iter().any(|adopted| adopted.effect == effect) {
                gaps.add(
                    axis,
                    &format!("the model lacks `{effect}`, so that the field is not corrected for it"),
                );
            }
        }
        let paths = temperature.iter().flat_map(|known| known.paths.iter().cloned());
        parameters.extend(paths.map(|path| ("temperatures", path)));
        let turns = turn_per_k(document, axis).is_some();
        if turns {
            let names = ["first_arcsec_per_k", "second_arcsec_per_k"];
            let of = |name: &str| ("turn with temperature", joint::effect("axis_temperature", axis, name));
            parameters.extend(names.map(of));
        }
        let cross = found.cross_field.as_ref();
        let across = cross.map(|fit| Across::of(fit, axis, modelled(Kind::CrossField)));
        let paths = across.iter().flat_map(|across| across.paths.iter().cloned());
        parameters.extend(paths.map(|path| ("transverse fields", path)));
        let noise = found.noise.as_ref();
        let drift = requirement.years.zip(found.drift.as_ref()).map(|(years, found)| drift(found, years));
        let (drift, undetermined) = match drift.transpose() {
            Ok(drift) => (drift, None),
            Err(why) => (None, Some(why)),
        };
        for (lacks, what) in [
            (
                requirement.sensor_temperature_c.is_some() && !turns,
                "whether the axis turns with temperature is not known (`axes_orientation` at several temperatures would show it)",
            ),
            (across.is_none(), "the effect of transverse fields is unknown (`cross_field` would show it)"),
            (noise.is_none(), "the noise is not known (`sensor_noise` would show it)"),
            (
                requirement.years.is_some() && found.drift.is_none(),
                "how the offset drifts is not known (`offset_drift` would show it)",
            ),
        ] {
            if lacks {
                gaps.add(axis, what);
            }
        }
        let unsure = drift.as_ref().and_then(|drift| drift.gap.as_ref()).or(undetermined.as_ref());
        unsure.into_iter().for_each(|gap| gaps.add(axis, gap));
        let code = codes_nt(document, axis).into_iter().flatten().reduce(f64::max);
        let reversal = found.reversal.as_ref();
        Some(Self {
            parameters,
            sensitivity: k.value(),
            offset: offset.value(),
            powers,
            nonlinearity,
            nonlinearity_over_nt: calibrated_nt(found),
            temperature,
            turns,
            across,
            noise: noise.map_or(0.0, |noise| {
                let flicker = noise.bands.first().map_or(0.0, |band| band.flicker_rms_nt.value());
                flicker.hypot(noise.white_rms_nt.value())
            }),
            rounding: code.map_or(0.0, |code| code / 12f64.sqrt()),
            drift,
            reversal: reversal.map_or(0.0, |reversal| reversal.imperfect_turn.bound_nt / 3f64.sqrt()),
        })
    }

    /// The error with a field along the sensor of `along` nT.
    pub fn error(&self, along: f64, axis: Axis, case: &Case) -> SensorError {
        let reading = (along - self.offset) / self.sensitivity;
        let [u, v] = [1, 2].map(|on| case.field[(axis.index() + on) % 3]);
        let share = along / FULL_NT;
        let line = self.nonlinearity_over_nt.map_or(0.0, |over| 0.6 * (over / FULL_NT).powi(2) * share);
        let [of_sensor, of_electronics] = case.warmer;
        let warmer = [(Part::Sensor, of_sensor), (Part::Electronics, of_electronics)];
        let across = Across::weights(share, u / FULL_NT, v / FULL_NT);
        // What is corrected for a parameter errs the other way.
        let mut weights = vec![reading, 1.0];
        weights.extend(self.powers.iter().map(|power| -share.powi(*power)));
        let temperatures = self.temperature.iter().flat_map(|known| known.weights(along, &warmer));
        weights.extend(temperatures.map(|weight| -weight));
        if self.turns {
            weights.extend([u, v].map(|field| -field * of_sensor * ARCSEC));
        }
        weights.extend(self.across.iter().flat_map(|_| across.map(|weight| -weight)));
        let bent = [self.nonlinearity[0] * share * share, self.nonlinearity[1] * (share.powi(3) - line)];
        let terms = [
            ("nonlinearity", bent[0].hypot(bent[1])),
            ("transverse fields", self.across.as_ref().map_or(0.0, |known| known.left(&across).abs())),
            ("noise of a reading", self.noise),
            ("rounding", self.rounding),
            ("drift of the offset", self.drift.as_ref().map_or(0.0, |drift| drift.std)),
            ("turn of the reversals", self.reversal),
        ];
        SensorError { bias: self.drift.as_ref().map_or(0.0, |drift| drift.value), weights, terms }
    }
}

/// The effects of the model that act on a sensor. Those without a term, or without an uncertainty, are named.
fn effects<'a>(document: &'a Document, axis: Axis, gaps: &mut Gaps) -> Vec<&'a AdoptedEffect> {
    use physics::Place::{Electronics, Logger, Sensor};
    let all = document.model.iter().flat_map(|model| &model.effects);
    let own = all.filter(|effect| {
        let local = Kind::named(&effect.effect)
            .is_some_and(|kind| [Sensor, Electronics, Logger].contains(&kind.place()));
        local && effect.recording.is_none() && effect.sensor.is_none_or(|sensor| sensor == axis)
    });
    let own: Vec<&AdoptedEffect> = own.collect();
    for effect in &own {
        let name = &effect.effect;
        if !KNOWN.iter().any(|kind| kind.name() == name) {
            gaps.add(axis, &format!("the budget has no term for `{name}` of the model"));
        } else if effect.parameters.values().any(|parameter| parameter.std().is_none()) {
            gaps.add(axis, &format!("`{name}` of the model has no uncertainty"));
        }
    }
    own
}

/// Size of a quadratic and a cubic nonlinearity at 50 000 nT that were looked for and not found, nT.
fn looked_for(found: &SensorCalibration) -> [f64; 2] {
    [Kind::QuadraticNonlinearity, Kind::CubicNonlinearity].map(|kind| {
        let departures = found.sensitivity.iter().flat_map(|fit| &fit.departures);
        let mut of = departures.filter(|departure| departure.departure == kind.name());
        let size = of.next().and_then(|departure| departure.parameter.get("departure_nt"));
        size.map_or(0.0, |size| size.value().hypot(size.std().unwrap_or(0.0)))
    })
}

struct Across {
    paths: Vec<String>,
    /// Their values where they are not corrected, nT.
    left: [f64; 5],
}

impl Across {
    /// As sensorcal found it; `corrected` where the model has it.
    fn of(fit: &CrossFieldFit, axis: Axis, corrected: bool) -> Self {
        let left = ACROSS.map(|(group, _, parameter)| {
            let of = if group == "offset" { &fit.offset } else { &fit.sensitivity };
            of.get(parameter).filter(|_| !corrected).map_or(0.0, Quantity::value)
        });
        Self { paths: ACROSS.map(|(_, name, parameter)| joint::effect(name, axis, parameter)).into(), left }
    }

    /// Change of the reading for each nT of the parameters; b along and u, v across in units of 50 000 nT.
    fn weights(b: f64, u: f64, v: f64) -> [f64; 5] {
        [u * u, v * v, u * v, b * u, b * v]
    }

    /// What is not corrected changes a reading by, nT.
    fn left(&self, weights: &[f64; 5]) -> f64 {
        weights.iter().zip(&self.left).map(|(by, left)| by * left).sum()
    }
}
