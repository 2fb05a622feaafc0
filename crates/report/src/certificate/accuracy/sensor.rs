use common::{Axis, CrossFieldFit, Document, Quantity, SensorCalibration};
use nalgebra::Vector3;
use physics::Kind;
use physics::frames::ARCSEC;

use super::super::Requirement;
use super::super::axes::turn_per_k;
use super::super::offset::{Drift, drift};
use super::super::range::{calibrated_nt, codes_nt};
use super::super::temperature::{Coefficients, Part};
use super::super::verdict::normal_std;
use super::Gaps;

/// The field at which the catalogue gives nonlinearity and fields across, nT.
const FULL_NT: f64 = 50_000.0;

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

/// A field and temperatures.
pub struct Place {
    /// The field in SEN, nT.
    pub field: Vector3<f64>,
    /// Sensor and electronics less their reference, K.
    pub warmer: [f64; 2],
}

/// What a sensor's corrected reading errs by, nT.
pub struct SensorError {
    /// What is known and not corrected.
    pub bias: f64,
    /// Standard uncertainty from the coil's constant, which other sensors may share.
    pub common: f64,
    /// Standard uncertainty of each other term.
    pub terms: Vec<(&'static str, f64)>,
}

/// The terms of one sensor's error δb:
/// - V δk + δO with their covariance, V = (b − O)/k; the part of u(k) that comes from the coil stands apart;
/// - nonlinearity: with the model's coefficients a (b/50 000 nT)^p and u(a); where none was found, the size and u of what was looked for, a
///   cubic one less the line that fits it best over the field of the calibration;
/// - temperatures: gᵀ C g of the coefficients;
/// - turn of the axis with temperature: u(a) and u(b) times the fields across;
/// - fields across: gᵀ C g of the coefficients, and their size where the model does not correct them; one that could not be seen is
///   zero, give or take the largest that was;
/// - noise of a reading: flicker noise in the band of the recordings, and white noise; rounding δ/√12;
/// - drift of the offset, turn of the reversals (a bound, rectangular).
pub struct Sensor {
    sensitivity: f64,
    offset: f64,
    covariance: [[f64; 2]; 2],
    common_k: f64,
    nonlinearity: [f64; 2],
    nonlinearity_over_nt: Option<f64>,
    temperature: Option<Coefficients>,
    turn: Option<[f64; 2]>,
    across: Option<Across>,
    noise: f64,
    rounding: f64,
    drift: Option<Drift>,
    reversal: f64,
}

impl Sensor {
    /// From a document, for what the requirement asks; what has no term is named. None where k or O has no uncertainty.
    pub fn of(
        document: &Document,
        requirement: &Requirement,
        axis: Axis,
        found: &SensorCalibration,
        gaps: &mut Gaps,
    ) -> Option<Self> {
        let k = found.sensitivity_nt_per_v.as_ref().or(found.sensitivity_nt_per_nt.as_ref())?;
        let offset = found.offset_nt.as_ref()?;
        let (covariance, common_k) = constants(document, axis, found, k, offset)?;
        let effects: Vec<_> = document
            .model
            .iter()
            .flat_map(|model| &model.effects)
            .filter(|effect| effect.recording.is_none() && effect.sensor.is_none_or(|sensor| sensor == axis))
            .collect();
        for effect in &effects {
            let local = Kind::named(&effect.effect).is_some_and(|kind| {
                use physics::Place::{Electronics, Logger, Sensor};
                [Sensor, Electronics, Logger].contains(&kind.place()) && !KNOWN.contains(&kind)
            });
            if local {
                gaps.add(axis, &format!("the budget has no term for `{}` of the model", effect.effect));
            }
        }
        let of_model = |kind: Kind| effects.iter().find(|effect| effect.effect == kind.name());
        let bent = [Kind::QuadraticNonlinearity, Kind::CubicNonlinearity].map(|kind| {
            of_model(kind).and_then(|effect| effect.parameters.get("departure_nt")).and_then(Quantity::std)
        });
        let looked_for = |kind: Kind| {
            let departures = &found.sensitivity.as_ref()?.departures;
            let departure = departures.iter().find(|departure| departure.departure == kind.name())?;
            let size = departure.parameter.get("departure_nt")?;
            Some(size.value().hypot(size.std().unwrap_or(0.0)))
        };
        let corrected = bent.iter().any(Option::is_some);
        let nonlinearity = if corrected {
            bent.map(|std| std.unwrap_or(0.0))
        } else {
            [Kind::QuadraticNonlinearity, Kind::CubicNonlinearity].map(|kind| looked_for(kind).unwrap_or(0.0))
        };
        let temperature = Coefficients::of(document, axis);
        let warm = [
            (Part::Sensor, requirement.sensor_temperature_c.is_some()),
            (Part::Electronics, requirement.electronics_temperature_c.is_some()),
        ];
        for (part, _) in warm.into_iter().filter(|(_, asked)| *asked) {
            if !temperature.as_ref().is_some_and(|known| known.has(part)) {
                let word = part.word();
                gaps.add(
                    axis,
                    &format!(
                        "what the {word}'s temperature does is not known (`temperature_run` would show it)"
                    ),
                );
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
        let turn = turn_per_k(document, axis).map(|pair| pair.map(|angle| angle.std().unwrap_or(0.0)));
        if warm[0].1 && turn.is_none() {
            gaps.add(
                axis,
                "whether the axis turns with temperature is not known (`axes_orientation` at several temperatures would show it)",
            );
        }
        let across =
            found.cross_field.as_ref().map(|fit| Across::of(fit, of_model(Kind::CrossField).is_some()));
        if across.is_none() {
            gaps.add(axis, "what fields across do is not known (`cross_field` would show it)");
        }
        let noise = found.noise.as_ref();
        if noise.is_none() {
            gaps.add(axis, "the noise is not known (`sensor_noise` would show it)");
        }
        let noise = noise.map_or(0.0, |noise| {
            let flicker = noise.bands.first().map_or(0.0, |band| band.flicker_rms_nt.value());
            flicker.hypot(noise.white_rms_nt.value())
        });
        let code = codes_nt(document, axis).into_iter().flatten().reduce(f64::max);
        let moved = requirement.years.map(|years| match &found.drift {
            Some(found) => drift(found, years),
            None => Err("how the offset drifts is not known (`offset_drift` would show it)".into()),
        });
        let moved = match moved {
            Some(Ok(mut moved)) => {
                moved.gap.take().into_iter().for_each(|gap| gaps.add(axis, &gap));
                Some(moved)
            }
            Some(Err(why)) => {
                gaps.add(axis, &why);
                None
            }
            None => None,
        };
        let reversal = found.reversal.as_ref();
        Some(Self {
            sensitivity: k.value(),
            offset: offset.value(),
            covariance,
            common_k,
            nonlinearity,
            nonlinearity_over_nt: if corrected { None } else { calibrated_nt(found) },
            temperature,
            turn,
            across,
            noise,
            rounding: code.map_or(0.0, |code| code / 12f64.sqrt()),
            drift: moved,
            reversal: reversal.map_or(0.0, |reversal| reversal.imperfect_turn.bound_nt / 3f64.sqrt()),
        })
    }

    /// The error with a field along the sensor of `along` nT.
    pub fn error(&self, along: f64, axis: Axis, place: &Place) -> SensorError {
        let reading = (along - self.offset) / self.sensitivity;
        let [[kk, ko], [_, oo]] = self.covariance;
        let [u, v] = [1, 2].map(|on| place.field[(axis.index() + on) % 3]);
        let share = along / FULL_NT;
        let line = self.nonlinearity_over_nt.map_or(0.0, |over| 0.6 * (over / FULL_NT).powi(2) * share);
        let [of_sensor, of_electronics] = place.warmer;
        let warmer = [(Part::Sensor, of_sensor), (Part::Electronics, of_electronics)];
        let turned = self.turn.map_or(0.0, |[a, b]| (a * u).hypot(b * v) * of_sensor.abs() * ARCSEC);
        let terms = vec![
            ("sensitivity and offset", (reading * reading * kk + 2.0 * reading * ko + oo).max(0.0).sqrt()),
            (
                "nonlinearity",
                (self.nonlinearity[0] * share * share).hypot(self.nonlinearity[1] * (share.powi(3) - line)),
            ),
            ("temperatures", self.temperature.as_ref().map_or(0.0, |known| known.change(along, &warmer).1)),
            ("turn with temperature", turned),
            (
                "fields across",
                self.across.as_ref().map_or(0.0, |across| across.std(share, u / FULL_NT, v / FULL_NT)),
            ),
            ("noise of a reading", self.noise),
            ("rounding", self.rounding),
            ("drift of the offset", self.drift.as_ref().map_or(0.0, |drift| drift.std)),
            ("turn of the reversals", self.reversal),
        ];
        let bias = self.drift.as_ref().map_or(0.0, |drift| drift.value);
        SensorError { bias, common: reading.abs() * self.common_k, terms }
    }
}

/// Covariance of k and O without the part of u(k) that comes from the coil, and that part. What axescal adds to an offset has
/// the uncertainty of the sum.
fn constants(
    document: &Document,
    axis: Axis,
    found: &SensorCalibration,
    k: &Quantity,
    offset: &Quantity,
) -> Option<([[f64; 2]; 2], f64)> {
    let key =
        if found.sensitivity_nt_per_v.is_some() { "sensitivity_nt_per_v" } else { "sensitivity_nt_per_nt" };
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let added = axes.and_then(|axes| axes.offsets_nt.as_ref()?.get(axis)?.std());
    let joint = || {
        let order = found.covariance_order.as_ref()?;
        let place = |name: &str| order.iter().position(|key| key == name);
        found.covariance.as_ref()?.get(place(key)?)?.get(place("offset_nt")?).copied()
    };
    let joint = if added.is_some() { 0.0 } else { joint().unwrap_or(0.0) };
    let (std_k, std_o) = (k.std()?, added.or(offset.std())?);
    let fit = found.sensitivity.as_ref();
    let common = fit.and_then(|fit| fit.uncertainty.get(key)).map_or(0.0, |budget| budget.type_b.min(std_k));
    let factors =
        [fit.map(|fit| fit.noise.coverage_factor_95), found.reversal.as_ref().map(|r| r.coverage_factor_95)];
    let widened = normal_std(1.0, factors.into_iter().flatten().fold(0.0, f64::max));
    let square = widened * widened;
    let own = (std_k * std_k - common * common).max(0.0);
    Some(([[own * square, joint * square], [joint * square, std_o * std_o * square]], common * widened))
}

/// Parameters of the fields across, in the order of [`shapes`].
const PARAMETERS: [&str; 5] = [
    "offset.first_nt",
    "offset.second_nt",
    "offset.mixed_nt",
    "sensitivity.first_nt",
    "sensitivity.second_nt",
];

/// Change of the reading for each nT of the parameters; b along and u, v across in units of 50 000 nT.
fn shapes(b: f64, u: f64, v: f64) -> [f64; 5] {
    [u * u, v * v, u * v, b * u, b * v]
}

/// What fields across do.
struct Across {
    /// Covariance of the parameters, nT².
    covariance: [[f64; 5]; 5],
    /// Their values where they are not corrected, nT.
    left: [f64; 5],
}

impl Across {
    fn of(fit: &CrossFieldFit, corrected: bool) -> Self {
        let widened = normal_std(1.0, fit.noise.coverage_factor_95).powi(2);
        let value = |name: &str| {
            let (group, key) = name.split_once('.').unwrap_or((name, ""));
            let of = if group == "offset" { &fit.offset } else { &fit.sensitivity };
            (of.get(key).map(Quantity::value), of.values().map(|size| size.value().abs()).fold(0.0, f64::max))
        };
        let places = PARAMETERS.map(|name| fit.covariance_order.iter().position(|key| key == name));
        let mut covariance = [[0.0; 5]; 5];
        for (a, row) in covariance.iter_mut().enumerate() {
            for (b, entry) in row.iter_mut().enumerate() {
                let found = places[a].zip(places[b]).and_then(|(a, b)| fit.covariance.get(a)?.get(b));
                *entry = found.map_or(0.0, |found| found * widened);
            }
            if places[a].is_none() {
                row[a] = value(PARAMETERS[a]).1.powi(2);
            }
        }
        let left = PARAMETERS.map(|name| if corrected { 0.0 } else { value(name).0.unwrap_or(0.0) });
        Self { covariance, left }
    }

    fn std(&self, b: f64, u: f64, v: f64) -> f64 {
        let by = shapes(b, u, v);
        let entries = (0..25).map(|k| by[k / 5] * self.covariance[k / 5][k % 5] * by[k % 5]);
        let left: f64 = by.iter().zip(&self.left).map(|(by, left)| by * left).sum();
        (entries.sum::<f64>().max(0.0) + left * left).sqrt()
    }
}
