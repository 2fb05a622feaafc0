//! The results with their expanded uncertainties.

mod directions;
mod sensors;

use common::{Axis, Certificate, Document, Error, Quantity};
use conformity::Joint;
use estimate::stats;
use page::{Cell, Table, number};

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
        coils(sheet, document);
        directions::tables(sheet, document, &joint, "coils", "GEO");
    } else {
        sensors::tables(sheet, document, &joint);
        directions::tables(sheet, document, &joint, "sensors", "SEN");
        differential(sheet, document);
    }
    residuals(sheet, document);
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

/// A coil system: constants, offsets, and its field along the axes.
fn coils(sheet: &mut Sheet, document: &Document) {
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
                off.map(|off| format!("largest departure within {} m", number::bare(off.distance_m)));
            add(within.as_deref().unwrap_or_default(), off.map(|off| &off.error_nt), "nT");
        }
    }
    sheet.table(constants);
    sheet.table(fields);
}

/// A magnetometer against a reference magnetometer: η and d of T = R η + d.
fn differential(sheet: &mut Sheet, document: &Document) {
    let found = document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
    let Some(found) = found else { return };
    let variance = |name: &str| {
        let place = found.covariance_order.as_ref()?.iter().position(|key| key == name)?;
        found.covariance.as_ref()?.get(place)?.get(place).copied()
    };
    let mut table = Expanded::table(
        "Matrix η and offset d of T = R η + d: test readings T by reference readings R, rows are samples",
    );
    for test in Axis::ALL {
        for reference in Axis::ALL {
            let (row, column) = (reference.index(), test.index());
            let Some(matrix) = &found.matrix else { continue };
            let std = variance(&format!("matrix[{row}][{column}]")).map(f64::sqrt);
            let what = format!("test axis {test} from reference axis {reference}");
            let element = found.fit.as_ref().and_then(|fit| fit.elements.get(&format!("{reference}{test}")));
            let freedom = element.and_then(|element| element.degrees_of_freedom);
            let factor = freedom.map(|freedom| stats::coverage_factor(0.95, freedom));
            Expanded::new(matrix[row][column], std, factor).row(&mut table, &what, "nT/nT");
        }
        if let Some(offset) = found.offset_nt.as_ref().and_then(|all| all.get(test)) {
            Expanded::of(offset, None).row(&mut table, &format!("test axis {test}, offset"), "nT");
        }
    }
    sheet.table(table);
}

/// What the calibration leaves of its own readings: the rms and the largest residual of each fit.
fn residuals(sheet: &mut Sheet, document: &Document) {
    let Some(calibration) = &document.calibration else { return };
    let mut table = Table::new("Residuals after calibration", "fit | readings | rms [nT] | largest [nT]");
    let mut add = |of: String, readings: Option<usize>, rms: f64, all: &[f64]| {
        let largest = all.iter().map(|one| one.abs()).fold(0.0, f64::max);
        let largest = if all.is_empty() { Cell::Empty } else { Cell::Figures(largest, 3) };
        table.row((of, readings, Cell::Figures(rms, 3), largest));
    };
    for (axis, coil) in calibration.coils.iter().flat_map(|coils| coils.iter()) {
        let Some(fit) = &coil.constant else { continue };
        // Its residuals are means of levels, the rms is that of single readings.
        add(format!("coil {axis}, constant"), Some(fit.readings), fit.rms_nt, &[]);
    }
    for (axis, sensor) in calibration.sensors.iter().flat_map(|sensors| sensors.iter()) {
        if let Some(fit) = &sensor.sensitivity {
            let all = &fit.residuals.residual_nt;
            add(format!("sensor {axis}, sensitivity"), Some(fit.readings), fit.noise.rms_nt, all);
        }
        if let Some(fit) = &sensor.temperature {
            add(format!("sensor {axis}, temperature"), None, fit.noise.rms_nt, &[]);
        }
        if let Some(fit) = &sensor.cross_field {
            add(format!("sensor {axis}, transverse fields"), None, fit.noise.rms_nt, &[]);
        }
        if let Some(drift) = &sensor.drift {
            let all = &drift.dates.residual_nt;
            let rms = (all.iter().map(|one| one * one).sum::<f64>() / all.len().max(1) as f64).sqrt();
            add(format!("sensor {axis}, offset from date to date"), Some(all.len()), rms, all);
        }
    }
    if let Some(axes) = &calibration.axes
        && let Some(fit) = &axes.fit
    {
        let all = axes.readings.as_ref().map(|readings| readings.residual_nt.as_slice()).unwrap_or_default();
        add("directions".into(), Some(fit.readings), fit.rms_nt, all);
    }
    if let Some(scalar) = &calibration.scalar {
        add("magnitude of the field, |B| − F".into(), Some(scalar.rows as usize), scalar.rms_nt, &[]);
    }
    if let Some(fit) = calibration.differential.as_ref().and_then(|found| found.fit.as_ref()) {
        for (axis, one) in fit.axes.iter() {
            add(format!("test axis {axis} against the reference"), Some(fit.samples), one.left_nt(), &[]);
        }
    }
    sheet.table(table);
}
