//! The results with their expanded uncertainties.

mod coils;
mod differential;
mod directions;
mod residuals;
mod sensors;

use common::{Certificate, Document, Error};
use conformity::Joint;

use crate::expanded::Expanded;
use crate::sheet::Sheet;

/// Results, those from before an adjustment, and whose they are.
pub fn part(
    sheet: &mut Sheet,
    document: &Document,
    data: &Certificate,
    findings: &[String],
) -> Result<(), Error> {
    sheet.begin("Results", "7.8.2.1 m, p, 7.8.2.2, 7.8.4.1 a, d");
    sheet.say(
        "Each value is given with its expanded uncertainty U = k u for a coverage probability of 95 %; k is the coverage factor. k follows from the \
         effective degrees of freedom; it is 1.96, that of a normal distribution, where the document states none. U has two digits, and the \
         value ends at the same decimal. U is valid at the time of the calibration and does not allow for changes afterwards.",
    );
    let joint = Joint::of(document)?;
    let before = sheet.parts.last().map_or(0, |part| part.items.len());
    if coils_alone(document) {
        coils::tables(sheet, document);
        directions::tables(sheet, document, &joint, "coils", "GEO");
    } else {
        sensors::tables(sheet, document, &joint);
        directions::tables(sheet, document, &joint, "sensors", "SEN");
        differential::tables(sheet, document);
    }
    residuals::table(sheet, document);
    if sheet.parts.last().is_some_and(|part| part.items.len() == before) {
        sheet.required("Results", "7.8.2.1 m", None);
    }
    let remarks: Vec<String> = findings.iter().map(|words| words.replace('`', "")).collect();
    if !remarks.is_empty() {
        sheet.listed("Remarks of the evaluation", "7.8.2.1 m", Some(&remarks));
    }
    adjustment(sheet, data);
    sheet.listed("Results from external providers", "7.8.2.1 p", data.external_results.as_deref());
    sheet.listed("Data supplied by the customer", "7.8.2.2", data.customer_data.as_deref());
    Ok(())
}

fn adjustment(sheet: &mut Sheet, data: &Certificate) {
    let adjustment = data.adjustment.as_ref();
    sheet.stated("Adjustment or repair", "7.8.4.1 d", adjustment.and_then(|one| one.done.as_deref()));
    let before = adjustment.map(|one| one.before.as_slice()).unwrap_or_default();
    let mut table = Expanded::table("Results before adjustment or repair; those above are from after it");
    for one in before {
        Expanded::of(&one.result, None).row(&mut table, &one.of, &one.unit);
    }
    sheet.table(table);
}

/// Whether the coil system is the item: no sensor and no direction of one was calibrated.
pub fn coils_alone(document: &Document) -> bool {
    document.calibration.as_ref().is_some_and(|calibration| {
        let sensors = calibration.axes.as_ref().is_some_and(|axes| axes.sensors.is_some());
        calibration.coils.is_some()
            && calibration.sensors.is_none()
            && !sensors
            && calibration.differential.is_none()
    })
}
