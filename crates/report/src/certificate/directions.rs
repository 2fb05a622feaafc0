//! Directions of sensors or coils in their frame, and the angles between them.

use common::covariance::between;
use common::{Axis, Document, Quantity, uncertainty};
use minijinja::{Value, context};
use nalgebra::Vector3;

use crate::conformity::{Joint, NORMAL, axes};

/// The tables of one set of directions, `sensors` or `coils`: each row with its name, result, unit and factor.
pub fn tables(document: &Document, joint: &Joint, of: &str, frame: &str) -> Vec<Value> {
    let axes = axes(document);
    let found =
        axes.and_then(|axes| if of == "sensors" { axes.sensors.as_ref() } else { axes.coils.as_ref() });
    let Some(found) = found else { return Vec::new() };
    let one = of.trim_end_matches('s');
    let direction = |axis: Axis| Some((axis, Vector3::from(found.direction(axis)?)));
    let known: Vec<(Axis, Vector3<f64>)> = Axis::ALL.into_iter().filter_map(direction).collect();
    let paths = uncertainty::directions(of);
    // Each standard uncertainty is here that of the normal distribution with the same 95 % interval.
    let covariance = joint.covariance(&paths);
    let factor = joint.factor(&paths[0]).max(NORMAL);
    let expanded = |value: f64, variance: f64| match variance > 0.0 {
        true => Quantity::new(value, variance.sqrt() * NORMAL / factor),
        false => Quantity::Bare(value),
    };
    let (mut cosines, mut angles): (Vec<(String, Quantity, &str, f64)>, Vec<_>) = Default::default();
    for (i, (a, first)) in known.iter().enumerate() {
        for (row, name) in ["x", "y", "z"].iter().enumerate() {
            let place = 3 * a.index() + row;
            let result = expanded(first[row], covariance[(place, place)]);
            cosines.push((format!("{one} {a}, cosine with {name} of {frame}"), result, "1", factor));
        }
        for (b, second) in &known[i + 1..] {
            let cosine = first.dot(second).clamp(-1.0, 1.0);
            let across = (1.0 - cosine * cosine).sqrt();
            // dθ = −(m_b · dm_a + m_a · dm_b)/sin θ.
            let weight = |place: usize| match place / 3 {
                of if of == a.index() => -second[place % 3] / across,
                of if of == b.index() => -first[place % 3] / across,
                _ => 0.0,
            };
            let weights: Vec<f64> = (0..9).map(weight).collect();
            let variance = between(&covariance, &weights, &weights);
            let degrees = 1f64.to_degrees();
            let result = expanded(cosine.acos() * degrees, variance * degrees * degrees);
            angles.push((format!("between {one}s {a} and {b}"), result, "deg", factor));
        }
    }
    let own = axes.and_then(|axes| axes.fit.as_ref()).map_or(factor, |fit| fit.coverage_factor_95);
    for (axis, angle) in found.off_nominal_arcsec.iter().flat_map(|all| all.iter()) {
        angles.push((format!("{one} {axis}, off its nominal axis"), angle.clone(), "arcsec", own));
    }
    vec![
        context! { caption => format!("Directions of the {of} in {frame}, as cosines"), rows => cosines },
        context! { caption => format!("Angles of the {of}"), rows => angles },
    ]
}
