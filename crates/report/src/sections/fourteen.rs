//! The fourteen parameters of two magnetometers side by side.

use common::{FourteenParameters, Magnetometer};

use crate::{Cell, Section, Table, number};

/// Adds angles, ratios and angles between axes.
pub fn tables(section: &mut Section, fourteen: &FourteenParameters) {
    let assumed =
        if fourteen.assumed { "; not stated: assumed orthogonal, with equal scale factors" } else { "" };
    let known = match fourteen.known {
        Magnetometer::Reference => "reference",
        Magnetometer::Test => "test instrument",
    };
    section.say(format!("The fourteen parameters, five of the {known} known{assumed}."));
    let mut angles = Table::new(
        "Angles of the axes",
        [("angle", ""), ("value", "deg"), ("standard uncertainty", "arcsec"), ("from nominal", "arcsec")],
    );
    for (name, angle) in &fourteen.angles {
        angles.row([
            name.replace('_', " ").into(),
            Cell::Text(number::fixed(angle.value_deg, 6)),
            Cell::Figures(angle.std_arcsec, 2),
            angle.off_nominal_arcsec.into(),
        ]);
    }
    section.table(angles);
    let mut ratios = Table::new("Ratios of scale factors, reading per nT", [("ratio", ""), ("value", "")]);
    for (name, ratio) in &fourteen.ratios {
        ratios.row([name.replace('_', " over ").into(), ratio.into()]);
    }
    section.table(ratios);
    let mut orthogonality = Table::new(
        "90° less the angle between two axes",
        [("axes", ""), ("reference", "arcsec"), ("test", "arcsec")],
    );
    for (pair, angle) in &fourteen.reference_non_orthogonality_arcsec {
        orthogonality.row([
            pair.as_str().into(),
            angle.into(),
            fourteen.test_non_orthogonality_arcsec.get(pair).into(),
        ]);
    }
    section.table(orthogonality);
}
