//! The error of a corrected field, as a budget over a whole sphere of fields.

mod sensor;

use common::number::{bare, fixed, signed, significant};
use common::{Axis, Document, uncertainty};
use faer::{Mat, RowRef};
use nalgebra::{Matrix3, Vector3};

use crate::conformity::directions::Directions;
use crate::conformity::joint::{self, Joint};
use crate::conformity::range::calibrated_nt;
use crate::conformity::spec::Requirement;
use crate::conformity::temperature::{Part, asked};
use crate::conformity::verdict::{Rule, Shown, ShownValue, shown};
use sensor::{Case, Gaps, Sensor};

/// Directions of the field, evenly over the sphere: none is farther than 2.5° from one of them.
const DIRECTIONS: usize = 2000;

/// Error of a component of the corrected field in SEN, nT, at the field, the temperatures and the time where
/// |e| + k u is largest.
///
/// With W = (μᵀ)⁻¹ and b_i = m_i · B, the field is W b, and what it errs by is Σ_i W_ji δb_i − Σ_i W_ji (δm_i
/// · B). e is what is known and not corrected (the drift of the offsets since the calibration); u² = gᵀ C g +
/// Σ_i W_ji² t_i², with g the derivatives by all parameters of the three sensors and their directions, C
/// their joint covariance (`calibration.uncertainty`), and t_i the terms of [`sensor::Sensor`] that rest on
/// no parameter; JCGM 100.
///
/// Along each diameter of the sphere every term is largest at one of its ends (a cubic bend less its line:
/// over the whole sphere), so that the surface is enough. Fields beyond those that the sensors were
/// calibrated in are left out, and named.
pub fn accuracy(of: (&Document, &Joint), requirement: &Requirement, rule: Rule) -> Vec<Shown> {
    let factor = rule.factor(requirement.kind.side());
    match Budget::of(of, requirement) {
        Ok(budget) => Axis::ALL.map(|axis| Ok(budget.worst(axis, factor))).into(),
        Err(why) => vec![shown("field", Err(why))],
    }
}

struct Budget {
    directions: Directions,
    inverse: Matrix3<f64>,
    sensors: [Sensor; 3],
    /// The parameters of the sensors, one sensor after the other, then the nine cosines: the term of each.
    names: Vec<&'static str>,
    /// Columns whose outer products are their covariance.
    root: Mat<f64>,
    /// Largest field, and the largest along each sensor, nT.
    range_nt: f64,
    along_nt: [f64; 3],
    /// Temperatures less the reference, K, for sensor and electronics: the ends of the ranges, half the way
    /// to them, and none.
    warmer: Vec<[f64; 2]>,
    gaps: Vec<String>,
}

struct ComponentError {
    bias: f64,
    std: f64,
    weights: Vec<f64>,
    /// Standard uncertainty of each term that rests on no parameter.
    terms: Vec<(&'static str, f64)>,
}

impl Budget {
    fn of((document, joint): (&Document, &Joint), requirement: &Requirement) -> Result<Self, String> {
        let directions = Directions::of(document, joint)?;
        let inverse = directions.mu.transpose().try_inverse();
        let inverse = inverse.ok_or("the sensor axes are coplanar and do not determine the field")?;
        let mut gaps = Gaps::default();
        let mut sensors = Vec::new();
        let asked_nt = requirement.range_nt.unwrap_or(0.0);
        let mut range_nt = asked_nt;
        let mut along_nt = [asked_nt; 3];
        for axis in Axis::ALL {
            let found =
                joint::sensor(document, axis).ok_or("the sensors were not calibrated; sensorcal does it")?;
            let sensor = Sensor::of((document, joint), requirement, axis, found, &mut gaps);
            sensors.push(sensor.ok_or(
                "a sensor's sensitivity or offset has no uncertainty; sensorcal finds both from `sensor_sensitivity` and \
                 `sensor_offset_reversal`",
            )?);
            match calibrated_nt(found) {
                Some(reached) if reached < asked_nt => {
                    along_nt[axis.index()] = reached;
                    let [reached, asked] = [reached, asked_nt].map(bare);
                    let rest = format!("(`sensor_sensitivity` up to {asked} nT would show the rest)");
                    gaps.add(axis, &format!("calibrated up to {reached} nT {rest}"));
                }
                Some(_) => {}
                None => {
                    let gap =
                        "its calibrated range of fields is unknown (`sensor_sensitivity` would show it)";
                    gaps.add(axis, gap);
                }
            }
            let across = found.cross_field.as_ref().map(|fit| fit.levels.across_nt.iter());
            let across = across.map(|fields| fields.fold(0.0, |most: f64, field| most.max(field.abs())));
            if let Some(across) = across.filter(|across| *across < asked_nt) {
                range_nt = range_nt.min(across);
                let [across, asked] = [across, asked_nt].map(bare);
                let rest = format!("(`cross_field` up to {asked} nT would show the rest)");
                gaps.add(axis, &format!("transverse fields were applied up to {across} nT {rest}"));
            }
        }
        let ends = |part: Part| {
            let is_asked = part.required(requirement).is_some();
            let mut warmer = vec![0.0];
            for axis in Axis::ALL.into_iter().filter(|_| is_asked) {
                match asked(document, axis, part, requirement) {
                    Ok(covered) => {
                        warmer.extend(covered.warmer.into_iter().flat_map(|end| [0.5 * end, end]));
                        covered.gap.into_iter().for_each(|gap| gaps.add(axis, &gap));
                    }
                    Err(why) => gaps.add(axis, &why),
                }
            }
            warmer.sort_by(f64::total_cmp);
            warmer.dedup();
            warmer
        };
        let [of_sensor, of_electronics] = Part::BOTH.map(ends);
        let warmer = of_sensor.iter().flat_map(|s| of_electronics.iter().map(|e| [*s, *e])).collect();
        let of_sensors = sensors.iter().flat_map(|sensor| sensor.parameters.iter().cloned());
        let of_directions = uncertainty::directions("sensors").into_iter().map(|path| ("directions", path));
        let (names, paths): (Vec<_>, Vec<_>) = of_sensors.chain(of_directions).unzip();
        let root = uncertainty::root(&joint.covariance(&paths))?;
        let sensors = sensors.try_into().map_err(|_| "three sensors are needed")?;
        let gaps = gaps.sentences();
        Ok(Self { directions, inverse, sensors, names, root, range_nt, along_nt, warmer, gaps })
    }

    /// Where |e| + k u of a component is largest.
    fn worst(&self, axis: Axis, factor: f64) -> ShownValue {
        let mut worst: Option<(f64, ComponentError, Case)> = None;
        for field in directions().map(|direction| self.within(direction)) {
            for warmer in &self.warmer {
                let case = Case { field, warmer: *warmer };
                let error = self.error(axis, &case);
                let size = error.bias.abs() + factor * error.std;
                if worst.as_ref().is_none_or(|(most, ..)| size > *most) {
                    worst = Some((size, error, case));
                }
            }
        }
        let (value, std, how) = worst.map_or((0.0, 0.0, String::new()), |(size, error, case)| {
            (error.bias, error.std, words(size, &self.terms(&error), &case))
        });
        ShownValue { of: format!("component {axis}"), value, std, gaps: self.gaps.clone(), how }
    }

    /// The field in a direction: as large as asked, or as the sensors were calibrated in.
    fn within(&self, direction: Vector3<f64>) -> Vector3<f64> {
        let along = self.directions.mu.transpose() * direction;
        let limits = (0..3).map(|i| self.along_nt[i] / along[i].abs().max(f64::MIN_POSITIVE));
        direction * limits.fold(self.range_nt, f64::min)
    }

    fn error(&self, axis: Axis, case: &Case) -> ComponentError {
        let mut bias = 0.0;
        let mut terms: Vec<(&'static str, f64)> = Vec::new();
        let (mut weights, mut of_directions) = (Vec::with_capacity(self.names.len()), Vec::new());
        for sensor in Axis::ALL {
            let weight = self.inverse[(axis.index(), sensor.index())];
            let along = self.directions.column(sensor).dot(&case.field);
            let own = self.sensors[sensor.index()].error(along, sensor, case);
            bias += weight * own.bias;
            weights.extend(own.weights.iter().map(|by| weight * by));
            of_directions.extend(case.field.iter().map(|field| -weight * field));
            terms.extend(own.terms.map(|(name, std)| (name, weight * std)));
        }
        weights.extend(of_directions);
        let variance = self.variance(&weights) + terms.iter().map(|(_, std)| std * std).sum::<f64>();
        ComponentError { bias, std: variance.sqrt(), weights, terms }
    }

    /// gᵀ C g.
    fn variance(&self, weights: &[f64]) -> f64 {
        (RowRef::from_slice(weights) * &self.root).squared_norm_l2()
    }

    /// Standard uncertainty of each term alone, the largest first.
    fn terms(&self, error: &ComponentError) -> Vec<(&'static str, f64)> {
        let mut names: Vec<&'static str> = self.names.clone();
        names.extend(error.terms.iter().map(|(name, _)| *name));
        names.sort_unstable();
        names.dedup();
        let of = |name: &'static str| {
            let own = |(by, of): (&f64, &&'static str)| if *of == name { *by } else { 0.0 };
            let weights: Vec<f64> = error.weights.iter().zip(&self.names).map(own).collect();
            let alone =
                error.terms.iter().filter(|(of, _)| *of == name).map(|(_, std)| std * std).sum::<f64>();
            (name, (self.variance(&weights) + alone).sqrt())
        };
        let mut terms: Vec<(&'static str, f64)> = names.into_iter().map(of).collect();
        terms.sort_by(|a, b| b.1.total_cmp(&a.1));
        terms
    }
}

fn words(size: f64, terms: &[(&'static str, f64)], case: &Case) -> String {
    let field = [0, 1, 2].map(|row| fixed(case.field[row], 0)).join(", ");
    let [sensor, electronics] = case.warmer.map(|kelvin| signed(&significant(kelvin, 3)));
    let largest = terms.iter().take(4).filter(|(_, std)| *std > 0.0);
    let largest: Vec<String> =
        largest.map(|(name, std)| format!("{name} {}", significant(*std, 2))).collect();
    let (size, largest) = (significant(size, 3), largest.join(", "));
    format!(
        "|e| + k u = {size} nT, with a field of ({field}) nT, the sensors {sensor} K and the electronics {electronics} K from the reference; mainly from {largest}"
    )
}

/// Directions evenly over the sphere (a Fibonacci lattice), and both senses of each axis of SEN.
fn directions() -> impl Iterator<Item = Vector3<f64>> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let lattice = (0..DIRECTIONS).map(move |number| {
        let z = 1.0 - (2.0 * number as f64 + 1.0) / DIRECTIONS as f64;
        let (sine, cosine) = (golden * number as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        Vector3::new(across * cosine, across * sine, z)
    });
    let axes = (0..3).flat_map(|axis| [Vector3::ith(axis, 1.0), Vector3::ith(axis, -1.0)]);
    axes.chain(lattice)
}
