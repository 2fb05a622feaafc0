//! What the sources say, beside the values.

use common::covariance::rows;
use common::uncertainty;
use common::{AxesDirections, Axis, Document, OneOrEach, Uncertainty};
use faer::Mat;
use nalgebra::Matrix3;
use physics::{Kind, ParameterInfo, Unit, frames};

use crate::model::{self, Unknown, chain, moving_place};
use crate::sized;

/// States the uncertainty of each fitted value, and the covariances of those that are told together.
pub fn state(document: &mut Document, joint: &Uncertainty, paths: &[String]) {
    let fitted = |path: &String| paths.contains(path);
    let known = |path: &String, value: f64, info: Option<&ParameterInfo>| {
        sized::quantity(value, joint.std(path), joint.degrees_of_freedom(path), info)
    };
    for effect in document.model.iter_mut().flat_map(|model| &mut model.effects) {
        let infos = Kind::named(&effect.effect).map_or(&[][..], Kind::parameters);
        for info in infos {
            let path = uncertainty::effect(effect, info.name);
            if let Some(quantity) = effect.parameters.get_mut(info.name).filter(|_| fitted(&path)) {
                let found = known(&path, quantity.value(), Some(info));
                *quantity = if quantity.is_at_least() { found.at_least() } else { found };
            }
        }
    }
    let Some(calibration) = document.calibration.as_mut() else { return };
    let chains = [Unit::Volt, Unit::Nanotesla]
        .into_iter()
        .flat_map(|unit| chain().map(move |parameter| Unknown::Chain(parameter, unit)));
    for unknown in chains.chain(Axis::ALL.map(Unknown::Field)) {
        let path = model::path(Some(calibration), &unknown);
        let Some(path) = path.filter(|path| fitted(path) && joint.std(path) > 0.0) else { continue };
        if let Some(Some(quantity)) = moving_place(calibration, &unknown) {
            *quantity = known(&path, quantity.value(), None);
        }
    }
    // The covariance of two constants of a sensor or a coil, where the fit moved one of them.
    let both = |keys: Option<[(String, &str); 2]>| {
        let (paths, names): (Vec<String>, Vec<&str>) = keys?.into_iter().unzip();
        let known = paths.iter().any(fitted) && paths.iter().all(|path| joint.std(path) > 0.0);
        let order = names.into_iter().map(str::to_string).collect();
        known.then(|| (rows(&joint.covariance(&paths)), order))
    };
    for axis in Axis::ALL {
        if let Some(coil) = calibration.coils.as_mut().and_then(|coils| coils.entry(axis).as_mut()) {
            let keys = [
                (uncertainty::coil_constant(axis), "constant_nt_per_a"),
                (uncertainty::coil_offset(axis), "offset_nt"),
            ];
            if keys.iter().any(|(path, _)| fitted(path)) {
                (coil.covariance, coil.covariance_order) = both(Some(keys)).unzip();
            }
        }
        if let Some(sensor) = calibration.sensors.as_mut().and_then(|sensors| sensors.entry(axis).as_mut()) {
            let offset = uncertainty::sensor_offset(axis);
            let [volt, nanotesla] = ["v", "nt"].map(|unit| uncertainty::sensitivity(axis, unit));
            let of = |path: &str, key: &'static str| {
                Some([(path.to_string(), key), (offset.clone(), "offset_nt")])
            };
            let keys = match (&sensor.sensitivity_nt_per_v, &sensor.sensitivity_nt_per_nt) {
                (Some(_), None) => of(&volt, "sensitivity_nt_per_v"),
                (None, Some(_)) => of(&nanotesla, "sensitivity_nt_per_nt"),
                _ => None,
            };
            if [&offset, &volt, &nanotesla].into_iter().any(fitted) {
                (sensor.covariance, sensor.covariance_order) = both(keys).unzip();
            }
        }
    }
    let Some(axes) = calibration.axes.as_mut() else { return };
    let [sensors, coils] = ["sensors", "coils"].map(uncertainty::directions);
    for (place, paths) in [(&mut axes.sensors, &sensors), (&mut axes.coils, &coils)] {
        if let Some(place) = place.as_mut().filter(|_| paths.iter().any(fitted)) {
            directions(place, &joint.covariance(paths));
        }
    }
    let all = [sensors, coils].concat();
    if all.iter().any(fitted) {
        let stated = [&axes.sensors, &axes.coils]
            .iter()
            .all(|of| of.as_ref().is_some_and(|of| of.covariance.is_some()));
        axes.cross_covariance =
            stated.then(|| rows(&joint.covariance(&all).submatrix(0, 9, 9, 9).to_owned()));
    }
}

/// States the covariance of nine cosines.
fn directions(of: &mut AxesDirections, covariance: &Mat<f64>) {
    let widest = |axis: Axis| {
        let own = Matrix3::from_fn(|r, s| covariance[(3 * axis.index() + r, 3 * axis.index() + s)]);
        own.symmetric_eigenvalues().max().max(0.0).sqrt() / frames::ARCSEC
    };
    of.std_arcsec = Some(OneOrEach::Each(Axis::ALL.map(|axis| (axis, widest(axis))).into_iter().collect()));
    of.covariance_order = Some((0..9).map(|k| format!("matrix[{}][{}]", k % 3, k / 3)).collect());
    of.covariance = Some(rows(covariance));
}
