use common::{AdoptedEffect, Axis, Document, Quantity, SensorCalibration};
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
use super::across::Across;

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
        let effects = effects(document, axis, gaps);
        let modelled = |kind: Kind| effects.iter().find(|effect| effect.effect == kind.name()).copied();
        let (nonlinearity, nonlinearity_over_nt) = nonlinearity(found, modelled);
        let temperature = Coefficients::of(document, axis);
        let warm = [
            (Part::Sensor, requirement.sensor_temperature_c.is_some()),
            (Part::Electronics, requirement.electronics_temperature_c.is_some()),
        ];
        for (part, _) in warm.into_iter().filter(|(_, asked)| *asked) {
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
        let turn = turn_per_k(document, axis).map(|pair| pair.map(|angle| angle.std().unwrap_or(0.0)));
        let cross = found.cross_field.as_ref();
        let across = cross.map(|fit| Across::of(fit, modelled(Kind::CrossField).is_some()));
        let noise = found.noise.as_ref();
        let drift = requirement.years.zip(found.drift.as_ref()).map(|(years, found)| drift(found, years));
        let (drift, undetermined) = match drift.transpose() {
            Ok(drift) => (drift, None),
            Err(why) => (None, Some(why)),
        };
        for (lacks, what) in [
            (
                warm[0].1 && turn.is_none(),
                "whether the axis turns with temperature is not known (`axes_orientation` at several temperatures would show it)",
            ),
            (across.is_none(), "what fields across do is not known (`cross_field` would show it)"),
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
            sensitivity: k.value(),
            offset: offset.value(),
            covariance,
            common_k,
            nonlinearity,
            nonlinearity_over_nt,
            temperature,
            turn,
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
        let [[kk, ko], [_, oo]] = self.covariance;
        let [u, v] = [1, 2].map(|on| case.field[(axis.index() + on) % 3]);
        let share = along / FULL_NT;
        let line = self.nonlinearity_over_nt.map_or(0.0, |over| 0.6 * (over / FULL_NT).powi(2) * share);
        let [of_sensor, of_electronics] = case.warmer;
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

/// Size of what is left of a quadratic and a cubic nonlinearity at 50 000 nT, nT; and the field over which the line was fitted that has taken
/// a cubic's share, where none was found.
fn nonlinearity<'a>(
    found: &SensorCalibration,
    modelled: impl Fn(Kind) -> Option<&'a AdoptedEffect>,
) -> ([f64; 2], Option<f64>) {
    let kinds = [Kind::QuadraticNonlinearity, Kind::CubicNonlinearity];
    if kinds.iter().any(|kind| modelled(*kind).is_some()) {
        let std = |kind: Kind| modelled(kind).and_then(|effect| effect.parameters.get("departure_nt")?.std());
        return (kinds.map(|kind| std(kind).unwrap_or(0.0)), None);
    }
    let looked_for = |kind: Kind| {
        let departures = &found.sensitivity.as_ref()?.departures;
        let departure = departures.iter().find(|departure| departure.departure == kind.name())?;
        let size = departure.parameter.get("departure_nt")?;
        Some(size.value().hypot(size.std().unwrap_or(0.0)))
    };
    (kinds.map(|kind| looked_for(kind).unwrap_or(0.0)), calibrated_nt(found))
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
