//! The calibration, written to the document.

use common::covariance;
use common::uncertainty::{self, Block};
use common::{
    AdoptedEffect, AgainstKnown, Axis, Document, FieldDirections, Quantity, ScalarCalibration,
    ScalarParameter, Uncertainty,
};
use estimate::{Svd, stats};
use faer::{ColRef, Mat, RowRef, Scale};
use physics::Unit;
use physics::frames::ARCSEC;

use crate::design::Rows;
use crate::directions::directions_by;
use crate::given::Given;
use crate::linear::{Linear, RANK_TOLERANCE, deviations, stacked, unit};
use crate::model::{AXES, NINE, PAIRS, Parameter};
use crate::read::Series;
use crate::solved::Solved;
use crate::{Error, weakest, words};

/// What shows all twelve parameters.
const MORE_ATTITUDES: &str =
    "record further attitudes, so that the field lies along each sensor in both directions and between them";

pub fn adopt(document: &mut Document, mut solved: Solved, series: &[Series]) -> Result<(), Error> {
    solved.scalar = describe(document, &solved, series);
    let joint = joint(document, &solved)?;
    let (state, unit, scales) = (&solved.found.state, solved.given.unit, &solved.given.scales);
    let factor = stats::coverage_factor(0.95, solved.found.freedom);
    let suffix = unit.suffix();
    let calibration = document.calibration.get_or_insert_default();
    let sensors = calibration.sensors.get_or_insert_default();
    for axis in Axis::ALL {
        let k = axis.index();
        let paths = [uncertainty::sensitivity(axis, suffix), uncertainty::sensor_offset(axis)];
        let values = [state[k] * scales.sensitivity[k], state[3 + k] * scales.magnitude_nt];
        let quantity =
            |which: usize| Quantity::new(values[which], joint.std(&paths[which])).covered_by(factor);
        let sensor = sensors.entry(axis).get_or_insert_default();
        match unit {
            Unit::Volt => sensor.sensitivity_nt_per_v = Some(quantity(0)),
            Unit::Nanotesla => sensor.sensitivity_nt_per_nt = Some(quantity(0)),
        }
        sensor.offset_nt = Some(quantity(1));
        sensor.covariance = Some(covariance::rows(&joint.covariance(&paths)));
        sensor.covariance_order = Some(vec![format!("sensitivity_nt_per_{suffix}"), "offset_nt".into()]);
    }
    let axes = calibration.axes.get_or_insert_default();
    let extra = axes.sensors.take().map(|before| before.extra).unwrap_or_default();
    let mut directions =
        physics::directions(&Axis::ALL, &solved.mu, &joint.covariance(&uncertainty::directions("sensors")));
    directions.extra = extra;
    axes.sensors = Some(directions);
    // The offsets are whole now.
    axes.offsets_nt = None;
    axes.cross_covariance = None;
    calibration.uncertainty = Some(joint);
    model(document, &solved);
    document.calibration.get_or_insert_default().scalar = Some(Box::new(solved.scalar));
    Ok(())
}

fn model(document: &mut Document, solved: &Solved) {
    let found = instances(solved);
    if found.is_empty() && document.model.is_none() {
        return;
    }
    let all = &mut document.model.get_or_insert_default().effects;
    // As the fit took them off: those of other recordings and times stay.
    let is = |one: &AdoptedEffect, other| uncertainty::effect(one, "") == uncertainty::effect(other, "");
    all.retain(|one| !found.iter().any(|(other, _)| is(one, other)));
    all.extend(found.into_iter().map(|(effect, _)| effect));
}

/// The effects as documents have them, each with the places of its parameters in the state and their units.
fn instances(solved: &Solved) -> Vec<(AdoptedEffect, Vec<(usize, f64)>)> {
    let Solved { model, found, effects, .. } = solved;
    let of = |(number, effect): (usize, &physics::EffectInstance)| {
        let mine = |(place, one): (usize, &Parameter)| match one {
            Parameter::Effect { number: own, unit, .. } if own[0] == number => Some((place, *unit)),
            _ => None,
        };
        let places: Vec<(usize, f64)> = model.parameters.iter().enumerate().filter_map(mine).collect();
        let size = |(place, unit): &(usize, f64)| {
            let std = found.covariance[(*place, *place)].max(0.0).sqrt() * unit;
            Quantity::new(found.state[*place] * unit, std)
        };
        let names = effect.kind.parameters().iter().map(|info| info.name.to_string());
        let parameters = names.zip(places.iter().map(size)).collect();
        let effect = AdoptedEffect {
            effect: effect.kind.name().into(),
            sensor: effect.axis,
            column: effect.column.clone(),
            parameters,
            extra: [("found_by".to_string(), "scalarcal".into())].into_iter().collect(),
            ..AdoptedEffect::default()
        };
        (effect, places)
    };
    effects.iter().enumerate().map(of).collect()
}

/// The joint uncertainty with the parameters that were found.
fn joint(document: &Document, solved: &Solved) -> Result<Uncertainty, Error> {
    let Solved { given, model, found, .. } = solved;
    let count = model.parameters.len();
    let (suffix, scales) = (given.unit.suffix(), &given.scales);
    let single = |place: usize, factor: f64| unit(place, count).iter().map(|one| one * factor).collect();
    let mut all: Vec<(String, Vec<f64>)> = Vec::new();
    for axis in Axis::ALL {
        let k = axis.index();
        all.push((uncertainty::sensitivity(axis, suffix), single(k, scales.sensitivity[k])));
        all.push((uncertainty::sensor_offset(axis), single(3 + k, scales.magnitude_nt)));
    }
    // Of the nine elements of μ, column by column.
    let by = directions_by(model, &found.state, &solved.mu);
    let cosine = |k: usize| by.iter().map(move |by| by.map_or(0.0, |by| by[(k % 3, k / 3)])).collect();
    all.extend(uncertainty::directions("sensors").into_iter().zip((0..9).map(cosine)));
    for (effect, places) in instances(solved) {
        for (name, (place, unit)) in effect.parameters.keys().zip(places) {
            all.push((uncertainty::effect(&effect, name), single(place, unit)));
        }
    }
    let (parameters, rows): (Vec<String>, Vec<Vec<f64>>) = all.into_iter().unzip();
    let map = covariance::matrix(&rows);
    // What is known beforehand moves the parameters by C Wᵀ W.
    let known = if given.known { given.prior.padded(count) } else { Linear::none(count) };
    let gain = &found.covariance * known.jacobian.transpose() * &known.jacobian;
    let own = positive(&(&found.covariance - &gain * &found.covariance), &found.covariance)?;
    let covariance = &map * own * map.transpose();
    let by_nine = &map * gain.subcols(0, NINE);
    let moved = |nine: &[f64]| (&by_nine * ColRef::from_slice(nine)).iter().copied().collect();
    let known = given.by.iter().filter(|_| given.known);
    let by = known.map(|(path, nine)| (path.clone(), moved(nine))).collect();
    let mut joint = Uncertainty::of(document)?;
    let added: Vec<String> = Axis::ALL.into_iter().map(uncertainty::added_offset).collect();
    joint
        .put(Block {
            name: "scalar: readings and reference".into(),
            degrees_of_freedom: found.freedom,
            parameters,
            covariance: (&covariance + covariance.transpose()) * Scale(0.5),
            by,
        })
        .map_err(|wrong| Error::Unanswerable(format!("the covariance of the calibration is {wrong}")))?;
    joint.forget(&added);
    Ok(joint)
}

/// The positive part of a share of a covariance. An average over forms of noise is wider than each of them,
/// and what is left of it without what was known may then be less than nothing in some direction.
///
/// Errors: [`Error::Unanswerable`] where the decomposition fails.
fn positive(share: &Mat<f64>, whole: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let count = whole.nrows();
    let scale = deviations(whole);
    let scaled =
        Mat::from_fn(count, count, |i, j| 0.5 * (share[(i, j)] + share[(j, i)]) / (scale[i] * scale[j]));
    let own = scaled.self_adjoint_eigen(faer::Side::Lower).map_err(|_| {
        Error::Unanswerable("the covariance of the calibration has no eigenvalues that can be found".into())
    })?;
    let (values, vectors) = (own.S().column_vector(), own.U());
    let root = Mat::from_fn(count, count, |i, k| scale[i] * vectors[(i, k)] * values[k].max(0.0).sqrt());
    Ok(&root * root.transpose())
}

fn describe(document: &Document, solved: &Solved, series: &[Series]) -> ScalarCalibration {
    let Solved { given, model, found, .. } = solved;
    let earlier = earlier(document, solved);
    // Known beforehand and by the magnitude together is not the readings alone.
    let mixed = given.known && solved.scalar.vector.is_some();
    let mut scalar = ScalarCalibration {
        reference: solved.sources.iter().map(|source| source.words()).collect::<Vec<_>>().join("; "),
        memory_of: (solved.form.ratio > 0.0).then(|| solved.form.of.name().into()),
        sensor_noise_nt: found.sensor.sqrt() * solved.unit_nt(),
        reference_noise_nt: found.reference.sqrt() * solved.unit_nt(),
        parameters: parameters(solved, earlier, mixed),
        rank: found.seen.rank(),
        beforehand: if earlier || mixed { None } else { against_known(solved) },
        ..solved.scalar.clone()
    };
    let rows = Rows::new(series, given.scales);
    let directions = weakest::directions(&rows, model, &found.state, &solved.mu);
    let fields: Vec<_> = directions.iter().map(|(_, _, field)| *field).collect();
    let of = (fields.as_slice(), given.scales.magnitude_nt);
    scalar.weakest = weakest::weakest(model, &found.state, &found.jacobian, of, &solved.mu);
    if let Some(weakest) = scalar.weakest.as_mut().filter(|_| solved.scalar.vector.is_some()) {
        // What further rotations show by the magnitude is not what they show by the direction.
        weakest.remedy = MORE_ATTITUDES.into();
        weakest.std_after_nt = None;
    }
    scalar.directions = Some(FieldDirections {
        unit: fields.iter().map(|field| field.normalize().into()).collect(),
        residual_nt: directions.iter().map(|(number, row, _)| solved.residuals[*number][*row]).collect(),
    });
    let findings = words::findings(solved, &scalar);
    scalar.findings.extend(findings);
    scalar
}

/// Whether the document's calibration was found from some of the same recordings, by their ids.
pub fn earlier(document: &Document, solved: &Solved) -> bool {
    let before = document.calibration.as_ref().and_then(|calibration| calibration.scalar.as_ref());
    let single =
        |ids: &[String]| ids.iter().flat_map(|id| id.split(" + ")).map(str::to_string).collect::<Vec<_>>();
    before.is_some_and(|before| {
        let earlier = single(&before.recordings);
        single(&solved.scalar.recordings).iter().any(|id| earlier.contains(id))
    })
}

fn parameters(solved: &Solved, earlier: bool, mixed: bool) -> Vec<ScalarParameter> {
    let Solved { model, found, .. } = solved;
    let count = model.parameters.len();
    let alone = (found.seen.rank() == count && !mixed).then(|| found.seen.covariance());
    let known = solved.given.prior.padded(count).jacobian;
    let with = (!earlier && known.nrows() > 0)
        .then(|| Svd::of(stacked(&found.jacobian, &known).as_ref(), RANK_TOLERANCE).ok())
        .flatten()
        .filter(|svd| svd.rank() == count)
        .map(|svd| svd.covariance());
    let of = |place: usize| {
        let (name, unit, value, scale) = described(solved, place);
        let std = |variance: f64| variance.max(0.0).sqrt() * scale;
        let std_alone = alone.as_ref().map(|alone| std(alone[(place, place)]));
        ScalarParameter {
            name,
            unit: unit.into(),
            value,
            std: std(found.covariance[(place, place)]),
            std_alone: std_alone.filter(|std| std.is_finite()),
            std_with_known: with.as_ref().map(|with| std(with[(place, place)])),
        }
    };
    (0..count).map(of).collect()
}

/// Name, unit, value and what a unit of the state is in that unit.
pub fn described(solved: &Solved, place: usize) -> (String, &'static str, f64, f64) {
    let Solved { given: Given { unit, scales, .. }, model, found, .. } = solved;
    let value = found.state[place];
    let mut name = model.parameters[place].name();
    let (unit, scale) = match &model.parameters[place] {
        Parameter::Sensitivity(axis) => {
            let unit = if *unit == Unit::Volt { "nT/V" } else { "nT/nT" };
            (unit, scales.sensitivity[*axis])
        }
        Parameter::Offset(_) | Parameter::ReferenceOffset | Parameter::Magnitude => {
            ("nT", scales.magnitude_nt)
        }
        Parameter::Cosine(pair) => {
            let [a, b] = PAIRS[*pair];
            name = format!("{}{} off a right angle", AXES[a], AXES[b]);
            let angle = value.clamp(-1.0, 1.0).asin() / ARCSEC;
            return (name, "arcsec", angle, 1.0 / (1.0 - value * value).max(1e-12).sqrt() / ARCSEC);
        }
        Parameter::Effect { unit, .. } => ("", *unit),
        Parameter::Turn(_) => ("arcsec", 1.0 / ARCSEC),
    };
    (name, unit, value * scale, scale)
}

/// The readings alone against what was known beforehand.
fn against_known(solved: &Solved) -> Option<AgainstKnown> {
    let Solved { given, model, found, .. } = solved;
    let count = model.parameters.len();
    let known = given.prior.padded(count);
    if known.is_empty() || found.seen.rank() < count {
        return None;
    }
    let weights = &known.jacobian;
    let mut covariance = weights * found.seen.covariance() * weights.transpose();
    let mut residual = ColRef::from_slice(&known.about(&found.state).right).to_owned();
    if given.known {
        // At the joint minimum Jᵀr = −Wᵀρ: without what is known the state is C Wᵀρ away.
        residual = &residual + &covariance * &residual;
    }
    covariance += Mat::<f64>::identity(weights.nrows(), weights.nrows());
    let svd = Svd::of(covariance.as_ref(), 1e-14).ok()?;
    let solved = svd.solve(residual.try_as_col_major()?.as_slice());
    let chi_squared = RowRef::from_slice(&solved) * &residual;
    let degrees_of_freedom = weights.nrows() as f64;
    let p_value = stats::chi_squared_p(chi_squared, degrees_of_freedom);
    let against = AgainstKnown { chi_squared, degrees_of_freedom, p_value, used: given.known };
    (chi_squared >= 0.0).then_some(against)
}
