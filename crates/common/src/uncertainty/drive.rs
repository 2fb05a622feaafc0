//! What the calculated field of a coil rests on.

use super::joint::By;
use super::paths::{VOLTMETER_ABSOLUTE, VOLTMETER_RELATIVE, coil_constant, coil_offset, resistor};
use crate::{Axis, Document, Recording};

/// What the calculated field k I + B0 of a coil rests on in these recordings, by the changes of k and of B0
/// that one unit of each parameter acts like: constant and offset, and where currents were read as voltages,
/// resistor and voltmeter. Where one recording has currents, all count as known apart from the constant.
pub fn drive<'r>(
    document: &Document,
    coil: Axis,
    k: f64,
    mut recordings: impl Iterator<Item = &'r Recording>,
) -> By {
    let mut by = vec![(coil_constant(coil), vec![1.0, 0.0]), (coil_offset(coil), vec![0.0, 1.0])];
    if !recordings.any(|recording| recording.axis_column("coil", coil, "a").is_some()) {
        by.extend(of_current(document, coil, k));
    }
    by
}

/// What a current that was read as a voltage rests on, I = V/R, and how it changes the calculated field k I +
/// B0 of a coil: each parameter, with the changes of k and of B0 that one unit of it acts like. A voltmeter
/// that reads high by the share ε acts like k ε, a resistance stated high by ρ like −k ρ/R, a voltmeter that
/// adds v like k v/R on B0. Where the constant was measured with the same two, they moved it the other way.
pub fn of_current(document: &Document, coil: Axis, k: f64) -> By {
    let coils = document.facility.as_ref().and_then(|facility| facility.coils.as_ref());
    let ohm = coils.and_then(|coils| coils.get(coil)).and_then(|of| of.resistor_ohm);
    let of = |ohm: f64| {
        [
            (VOLTMETER_RELATIVE.to_string(), vec![k, 0.0]),
            (resistor(coil), vec![-k / ohm, 0.0]),
            (VOLTMETER_ABSOLUTE.to_string(), vec![0.0, k / ohm]),
        ]
    };
    ohm.filter(|ohm| *ohm > 0.0).map(of).into_iter().flatten().collect()
}
