//! How the results are traceable: each standard that the calibration rests on, with its own certificate.

use common::{Axis, Certificate, Document, Recording, Reference, ReferenceKind, procedure};
use page::number::{bare, figures};
use page::{Cell, Table};

use crate::expanded::Expanded;
use crate::sheet::{Sheet, blank_cell};

const CLAUSE: &str = "7.8.4.1 c";

/// Statement and standards.
pub fn part(sheet: &mut Sheet, document: &Document, data: &Certificate) {
    sheet.begin("Metrological traceability", CLAUSE);
    sheet.required("Statement", CLAUSE, data.traceability.as_deref());
    let mut table = Table::new(
        "Standards and instruments",
        "standard | identity | certificate | issued by | on | standard uncertainty used",
    );
    let given = data.references.as_deref().unwrap_or_default();
    let needed = needed(document);
    let named = |kind: ReferenceKind| given.iter().any(|one| one.kind == kind);
    let unnamed = needed.iter().filter(|kind| !named(**kind));
    let missing = unnamed.map(|kind| Reference { kind: *kind, ..Reference::default() });
    for one in given.iter().cloned().chain(missing) {
        let text = |text: &Option<String>| text.clone().map_or_else(|| blank_cell(CLAUSE), Cell::Text);
        let [identity, certificate, by, on] =
            [&one.identity, &one.certificate, &one.issued_by, &one.date].map(text);
        table.row((name(one.kind), identity, certificate, by, on, used(document, one.kind)));
    }
    if table.rows.is_empty() {
        let blank = || blank_cell(CLAUSE);
        table.row(("standard", blank(), blank(), blank(), blank(), Cell::Empty));
    }
    sheet.table(table);
    if !crate::results::coils_alone(document) {
        let mut table = Expanded::table("Coil constants used for the results");
        let coils = document.calibration.as_ref().and_then(|calibration| calibration.coils.as_ref());
        for (axis, coil) in coils.into_iter().flat_map(|coils| coils.iter()) {
            let factor = coil.constant.as_ref().map(|fit| fit.coverage_factor_95);
            if let Some(constant) = &coil.constant_nt_per_a {
                Expanded::of(constant, factor).row(&mut table, &format!("coil {axis}, constant"), "nT/A");
            }
        }
        sheet.table(table);
    }
}

fn name(kind: ReferenceKind) -> &'static str {
    match kind {
        ReferenceKind::Coils => "coil system",
        ReferenceKind::Voltmeter => "voltmeter",
        ReferenceKind::Resistor => "precision resistor",
        ReferenceKind::ScalarMagnetometer => "scalar magnetometer",
        ReferenceKind::Theodolite => "theodolites",
        ReferenceKind::Thermometer => "thermometer",
        ReferenceKind::Magnetometer => "reference magnetometer",
        ReferenceKind::Other => "other",
    }
}

/// What a document with such contents must rest on.
fn needed(document: &Document) -> Vec<ReferenceKind> {
    let facility = document.facility.as_ref();
    let calibration = document.calibration.as_ref();
    let column = |starts: &str| {
        let mut names = document.recordings.iter().flat_map(|recording| recording.columns.keys());
        names.any(|name| name.starts_with(starts))
    };
    let beside = |recording: &Recording| recording.procedure == procedure::DIFFERENTIAL;
    let compared = calibration.is_some_and(|calibration| calibration.differential.is_some())
        || document.recordings.iter().any(beside);
    let resistors = facility.and_then(|facility| facility.coils.as_ref());
    let resistors = resistors.is_some_and(|coils| coils.iter().any(|(_, coil)| coil.resistor_ohm.is_some()));
    let magnitude = calibration.and_then(|calibration| calibration.scalar.as_ref());
    let scalar = facility.is_some_and(|facility| facility.reference_std_nt.is_some())
        || magnitude.is_some_and(|scalar| scalar.reference.contains("scalar magnetometer"));
    let warmed = calibration.and_then(|calibration| calibration.sensors.as_ref());
    let warmed = warmed.is_some_and(|sensors| sensors.iter().any(|(_, sensor)| sensor.temperature.is_some()));
    let all = [
        (ReferenceKind::Coils, facility.is_some_and(|facility| facility.coils.is_some()) || column("coil_")),
        (ReferenceKind::Voltmeter, facility.is_some_and(|facility| facility.voltmeter.is_some())),
        (ReferenceKind::Resistor, resistors),
        (ReferenceKind::ScalarMagnetometer, scalar),
        (ReferenceKind::Theodolite, facility.is_some_and(|facility| facility.theodolite_arcsec.is_some())),
        (ReferenceKind::Thermometer, warmed),
        (ReferenceKind::Magnetometer, compared),
    ];
    // The coil system is the item where nothing else was calibrated.
    let item = crate::results::coils_alone(document);
    let needed = all.into_iter().filter(|(kind, there)| *there && !(item && *kind == ReferenceKind::Coils));
    needed.map(|(kind, _)| kind).collect()
}

/// The standard uncertainty that the evaluation allowed for.
fn used(document: &Document, kind: ReferenceKind) -> Option<String> {
    let facility = document.facility.as_ref()?;
    match kind {
        ReferenceKind::Voltmeter => {
            let voltmeter = facility.voltmeter.as_ref()?;
            let absolute = voltmeter.absolute_v.map(|v| format!("{} V", bare(v)));
            let relative = voltmeter.relative.filter(|part| *part > 0.0);
            let relative = relative.map(|part| format!("{} of the reading", bare(part)));
            let parts: Vec<String> = absolute.into_iter().chain(relative).collect();
            (!parts.is_empty()).then(|| parts.join(" and "))
        }
        ReferenceKind::Resistor => {
            let coils = facility.coils.as_ref()?;
            let of = |axis: Axis| Some((axis, coils.get(axis)?.resistor_relative_uncertainty?));
            let all: Vec<(Axis, f64)> = Axis::ALL.into_iter().filter_map(of).collect();
            let (_, first) = *all.first()?;
            Some(if all.iter().all(|(_, one)| *one == first) {
                format!("{}, relative", figures(first, 2))
            } else {
                let each: Vec<String> =
                    all.iter().map(|(axis, one)| format!("{axis} {}", figures(*one, 2))).collect();
                format!("{}, relative", each.join(", "))
            })
        }
        ReferenceKind::ScalarMagnetometer => facility.reference_std_nt.map(|std| format!("{} nT", bare(std))),
        ReferenceKind::Theodolite => {
            facility.theodolite_arcsec.map(|std| format!("{} arcsec a reading", bare(std)))
        }
        _ => None,
    }
}
