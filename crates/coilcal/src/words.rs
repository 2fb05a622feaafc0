//! The result in a few lines for people.

use common::{Document, PerAxis, Quantity};
use std::fmt::Write;

/// What was found of each coil, with ± and units, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let mut text = String::new();
    let coils = document.calibration.as_ref().and_then(|calibration| calibration.coils.as_ref());
    for (axis, coil) in coils.into_iter().flat_map(PerAxis::iter) {
        let (Some(constant), Some(offset), Some(fit)) =
            (&coil.constant_nt_per_a, &coil.offset_nt, &coil.constant)
        else {
            continue;
        };
        let std = |quantity: &Quantity| quantity.std().unwrap_or(0.0);
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "coilcal: coil {axis}: {:.4} ± {:.4} nT/A, offset {:+.3} ± {:.3} nT; {}, {} readings at {} levels, rms {:.3} nT",
            constant.value(),
            std(constant),
            offset.value(),
            std(offset),
            fit.model,
            fit.readings,
            fit.levels,
            fit.rms_nt
        );
        for finding in &fit.findings {
            let _ = writeln!(text, "  {finding}");
        }
    }
    text
}
