//! A coil system: constants, offsets, and its field along the axes.

use common::{Document, Quantity};

use crate::expanded::Expanded;
use crate::sheet::Sheet;

/// The tables of the coils.
pub fn tables(sheet: &mut Sheet, document: &Document) {
    let coils = document.calibration.as_ref().and_then(|calibration| calibration.coils.as_ref());
    let mut constants = Expanded::table("Constant k and offset B₀ of B = k I + B₀, along each coil's axis");
    let mut fields = Expanded::table("Field along the axis, B(x) = B₀ + a x + b x² + c x⁴");
    for (axis, coil) in coils.into_iter().flat_map(|coils| coils.iter()) {
        let factor = coil.constant.as_ref().map(|fit| fit.coverage_factor_95);
        for (what, quantity, unit) in
            [("constant", &coil.constant_nt_per_a, "nT/A"), ("offset", &coil.offset_nt, "nT")]
        {
            if let Some(quantity) = quantity {
                Expanded::of(quantity, factor).row(&mut constants, &format!("coil {axis}, {what}"), unit);
            }
        }
        for survey in &coil.surveys {
            let of = format!("coil {axis}, \"{}\"", survey.recording);
            let mut add = |what: &str, quantity: Option<&Quantity>, unit: &str| {
                if let Some(quantity) = quantity {
                    Expanded::of(quantity, None).row(&mut fields, &format!("{of}, {what}"), unit);
                }
            };
            add("a", survey.first_nt_per_m.as_ref(), "nT/m");
            add("b", survey.second_nt_per_m2.as_ref(), "nT/m²");
            add("c", survey.fourth_nt_per_m4.as_ref(), "nT/m⁴");
            let off = survey.off_centre.as_ref();
            let within =
                off.map(|off| format!("largest departure within {} m", page::number::bare(off.distance_m)));
            add(within.as_deref().unwrap_or_default(), off.map(|off| &off.error_nt), "nT");
        }
    }
    sheet.table(constants);
    sheet.table(fields);
}
