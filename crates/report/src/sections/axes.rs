//! Directions of sensors and coils.

use common::{AxesCalibration, AxesDirections, Axis, Document, OneOrEach, PairComparison, ScaleResult};
use page::words::{cells, counted, sentence};

use super::axes_map;
use super::effects::{self, findings};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Finding, Item, Section, Table, number};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let axes = document.calibration.as_ref()?.axes.as_ref()?;
    let mut section = Section::new("axes", "Directions");
    all(&mut section, "axes", axes);
    if let Some(subset) = &axes.subset {
        section.items.push(Item::Heading("From one sensor or one coil alone".into()));
        all(&mut section, "axes-alone", subset);
    }
    (!section.is_empty()).then_some(section)
}

/// Everything that was found; ids of plots begin with `id`.
fn all(section: &mut Section, id: &str, axes: &AxesCalibration) {
    section.warnings.extend(findings("", &axes.findings, &effects::axes::RULES, axes));
    section.warnings.extend(axes.doubtful.iter().map(|one| {
        let words = format!(
            "orientation {} (\"{}\", row {}), coil {}, sensor {}: {} nT from the prediction of the others (p = {})",
            one.orientation,
            one.recording,
            one.row,
            one.coil,
            one.sensor,
            number::figures(one.leave_one_out_nt, 4),
            number::probability(one.p_adjusted)
        );
        Finding::of(words, effects::axes::doubtful(axes, one))
    }));
    if let Some(fit) = &axes.fit {
        let chi = fit.chi_squared_p.map(|p| format!("; χ² of the residuals: {}", number::p_value(p)));
        section.say(format!(
            "{} in {}, {}: rank {} of {}. Residuals {} nT rms, noise of a reading {} nT ({}){}. A 95 % interval is ± {} standard \
             uncertainties.",
            counted(fit.readings, "reading"),
            counted(axes.orientations.len(), "orientation"),
            fit.method,
            fit.rank,
            fit.unknowns,
            number::significant(fit.rms_nt, 4),
            number::significant(fit.noise_nt, 4),
            fit.noise_source,
            chi.unwrap_or_default(),
            number::significant(fit.coverage_factor_95, 3)
        ));
    }
    for (of, frame, directions) in [("sensors", "SEN", &axes.sensors), ("coils", "GEO", &axes.coils)] {
        let Some(directions) = directions else { continue };
        section.table(cosines(of, frame, directions));
        section.table(angles(of, directions));
        axes_map::maps(&format!("{id}-{of}"), of, directions).into_iter().for_each(|plot| section.plot(plot));
    }
    if let Some(pair) = &axes.pair {
        section.table(unconstrained(pair));
    }
    residuals(section, id, axes);
    fields(section, axes);
    orientations(section, axes);
}

/// The report's unconstrained solution of one sensor and one coil.
fn unconstrained(pair: &PairComparison) -> Table {
    let mut table = Table::new(
        "Without the unit-length constraint (minimum norm), and how far the directions are from those above",
        [("vector", ""), ("x", ""), ("y", ""), ("z", ""), ("difference", "arcsec")],
    );
    for (name, vector, difference) in [
        (format!("sensor {}", pair.sensor), pair.unconstrained_sensor, pair.sensor_difference_arcsec),
        (format!("coil {}", pair.coil), pair.unconstrained_coil, pair.coil_difference_arcsec),
    ] {
        let [x, y, z] = vector.map(|component| Cell::Text(number::fixed(component, 8)));
        table.row([name.into(), x, y, z, Cell::Figures(difference, 3)]);
    }
    table
}

fn cosines(of: &str, frame: &str, directions: &AxesDirections) -> Table {
    let mut table = Table::new(
        format!("Directions of the {of} in {frame}"),
        [
            ("axis", ""),
            ("x", ""),
            ("y", ""),
            ("z", ""),
            ("largest standard uncertainty", "arcsec"),
            ("off nominal", "arcsec"),
        ],
    );
    for axis in Axis::ALL {
        let Some(vector) = directions.direction(axis) else { continue };
        let [x, y, z] = vector.map(|cosine| Cell::Text(number::fixed(cosine, 8)));
        let std = directions.std_arcsec.as_ref().and_then(|std: &OneOrEach| std.get(axis));
        let off = directions.off_nominal_arcsec.as_ref().and_then(|off| off.get(axis));
        table.row([axis.letter().into(), x, y, z, std.map(|std| Cell::Figures(std, 2)).into(), off.into()]);
    }
    table
}

fn angles(of: &str, directions: &AxesDirections) -> Table {
    let mut table = Table::new(
        format!("Non-orthogonality of the {of}: 90° less the angle between two axes"),
        [("axes", ""), ("angle", "arcsec")],
    );
    for (pair, angle) in directions.non_orthogonality_arcsec.iter().flatten() {
        table.row([pair.as_str().into(), angle.into()]);
    }
    table
}

fn residuals(section: &mut Section, id: &str, axes: &AxesCalibration) {
    let Some(readings) = &axes.readings else { return };
    let doubtful = |row: usize| {
        axes.doubtful.iter().any(|one| {
            readings.sensor.get(row) == Some(&one.sensor)
                && readings.row.get(row) == Some(&one.row)
                && readings.recording.get(row) == Some(&one.recording)
        })
    };
    let draw = |end: &str, title: &str, shown: &dyn Fn(usize) -> bool| {
        let mut plot = Plot::new(
            format!("{id}-residuals{end}"),
            title,
            Dimension::linear("reading", ""),
            Dimension::linear("reading less prediction", "nT"),
        );
        for axis in Axis::ALL {
            let of = |row: &usize| readings.sensor.get(*row) == Some(&axis) && shown(*row);
            let rows = || (0..readings.residual_nt.len()).filter(of);
            let x: Vec<f64> = rows().map(|row| (row + 1) as f64).collect();
            let y: Vec<f64> = rows().map(|row| readings.residual_nt[row]).collect();
            plot.push(Series::new(format!("sensor {axis}"), Mark::Points, axis.index(), &x, &y));
        }
        plot
    };
    section.plot(draw("", "Residuals of the readings, orientation by orientation", &|_| true));
    if !axes.doubtful.is_empty() {
        let title = "The same without the outliers";
        section.plot(draw("-left", title, &|row| !doubtful(row)));
    }
    let mut doubtful = Table::new(
        "Outliers",
        [
            ("recording", ""),
            ("orientation", ""),
            ("row", ""),
            ("coil", ""),
            ("sensor", ""),
            ("from the prediction of the others", "nT"),
            ("t", ""),
            ("p", ""),
        ],
    );
    for one in &axes.doubtful {
        doubtful.row([
            one.recording.as_str().into(),
            one.orientation.into(),
            one.row.into(),
            one.coil.letter().into(),
            one.sensor.letter().into(),
            Cell::Figures(one.leave_one_out_nt, 4),
            Cell::Figures(one.t, 3),
            Cell::Probability(one.p_adjusted),
        ]);
    }
    section.table(doubtful);
}

fn fields(section: &mut Section, axes: &AxesCalibration) {
    let mut table = Table::new(
        "Fields fitted together with the directions",
        [("what", ""), ("x", "nT"), ("y", "nT"), ("z", "nT")],
    );
    for (what, each) in [
        ("residual field, GEO", &axes.residual_field_nt),
        ("correction to each sensor's offset", &axes.offsets_nt),
    ] {
        if each.is_some() {
            let [x, y, z] = cells(each.as_ref());
            table.row([what.into(), x, y, z]);
        }
    }
    section.table(table);
    if let Some(scales) = &axes.scales {
        section.say(sentence(&scales.verdict));
        let mut table = Table::new(
            "Scale factors, fitted and compared with the calibration",
            [
                ("scale", ""),
                ("fitted", ""),
                ("calibration's own standard uncertainty", ""),
                ("distance from 1", "std"),
                ("p", ""),
            ],
        );
        let mut row = |name: String, scale: &ScaleResult| {
            table.row([
                name.into(),
                Cell::Uncertain { value: scale.value, std: scale.std },
                Cell::Figures(scale.calibration_std, 2),
                scale.sigmas.map(|sigmas| Cell::Figures(sigmas, 2)).into(),
                scale.p_value.map_or(Cell::Empty, Cell::Probability),
            ]);
        };
        scales.sensors.iter().for_each(|(axis, scale)| row(format!("sensor {axis}"), scale));
        scales.coils.iter().for_each(|(axis, scale)| row(format!("coil {axis}"), scale));
        row("common".into(), &scales.common);
        section.table(table);
    }
}

fn orientations(section: &mut Section, axes: &AxesCalibration) {
    let mut table = Table::new(
        "Orientations: the small rotation about the SEN axes that corrects each",
        [
            ("recordings", ""),
            ("readings", ""),
            ("rms", "nT"),
            ("about x", "arcsec"),
            ("about y", "arcsec"),
            ("about z", "arcsec"),
            ("moved to the nearest rotation by", "arcsec"),
        ],
    );
    for one in &axes.orientations {
        let [x, y, z] = cells(one.correction_arcsec.as_ref());
        table.row([
            one.recordings.join(", ").into(),
            one.readings.into(),
            Cell::Figures(one.rms_nt, 3),
            x,
            y,
            z,
            Cell::Figures(one.orthogonalised_by_arcsec, 2),
        ]);
    }
    section.table(table);
    let mut phases = Table::new(
        "Phases against an AC drive (negative: the reading lags)",
        [("sensor", ""), ("drive", "Hz"), ("phase", "rad"), ("p", ""), ("as a delay", "s")],
    );
    for one in &axes.phases {
        phases.row([
            one.sensor.letter().into(),
            one.drive_hz.into(),
            (&one.phase_rad).into(),
            Cell::Probability(one.p_value),
            Cell::Figures(one.delay_s, 3),
        ]);
    }
    section.table(phases);
    let mut assumptions = Table::new(
        "Assumptions that the recordings do not test, and their effect on a direction",
        [("assumed", ""), ("for each nT", "arcsec"), ("for each arcsec", "arcsec")],
    );
    let figures = |number: Option<f64>| number.map_or(Cell::Empty, |number| Cell::Figures(number, 2));
    for one in &axes.assumptions {
        assumptions.row([
            one.assumed.as_str().into(),
            figures(one.arcsec_per_nt),
            figures(one.arcsec_per_arcsec),
        ]);
    }
    section.table(assumptions);
}
