//! Directions of sensors and coils.

use common::{AxesCalibration, AxesDirections, Axis, Document, PairComparison, ScaleResult};
use page::words::{cells, counted, sentence};

use super::axes_map;
use super::effects::{self, findings};
use crate::plot::{Plot, Series};
use crate::{Cell, Finding, Item, Section, Table, number};

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
        cosines(section, of, frame, directions);
        let caption = format!("Non-orthogonality of the {of}: 90° less the angle between two axes");
        let angles = directions.non_orthogonality_arcsec.iter().flatten();
        section.rows(caption, "axes | angle [arcsec]", angles);
        axes_map::maps(&format!("{id}-{of}"), of, directions).into_iter().for_each(|plot| section.plot(plot));
    }
    if let Some(pair) = &axes.pair {
        unconstrained(section, pair);
    }
    residuals(section, id, axes);
    fields(section, axes);
    orientations(section, axes);
}

fn cosine(cosine: f64) -> String {
    number::fixed(cosine, 8)
}

/// The report's unconstrained solution of one sensor and one coil.
fn unconstrained(section: &mut Section, pair: &PairComparison) {
    let each = [
        (format!("sensor {}", pair.sensor), pair.unconstrained_sensor, pair.sensor_difference_arcsec),
        (format!("coil {}", pair.coil), pair.unconstrained_coil, pair.coil_difference_arcsec),
    ];
    let each = each.into_iter().map(|(name, vector, difference)| {
        let [x, y, z] = vector.map(cosine);
        (name, x, y, z, Cell::Figures(difference, 3))
    });
    section.rows(
        "Without the unit-length constraint (minimum norm), and how far the directions are from those above",
        "vector | x | y | z | difference [arcsec]",
        each,
    );
}

fn cosines(section: &mut Section, of: &str, frame: &str, directions: &AxesDirections) {
    let each = Axis::ALL.into_iter().filter_map(|axis| {
        let [x, y, z] = directions.direction(axis)?.map(cosine);
        let std = directions.std_arcsec.as_ref().and_then(|std| std.get(axis));
        let off = directions.off_nominal_arcsec.as_ref().and_then(|off| off.get(axis));
        Some((axis, x, y, z, Cell::figures(std, 2), off))
    });
    section.rows(
        format!("Directions of the {of} in {frame}"),
        "axis | x | y | z | largest standard uncertainty [arcsec] | off nominal [arcsec]",
        each,
    );
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
        let mut plot =
            Plot::new(format!("{id}-residuals{end}"), title).axes("reading", "reading less prediction [nT]");
        for axis in Axis::ALL {
            let of = |row: &usize| readings.sensor.get(*row) == Some(&axis) && shown(*row);
            let rows = (0..readings.residual_nt.len()).filter(of);
            let (x, y): (Vec<f64>, Vec<f64>) =
                rows.map(|row| ((row + 1) as f64, readings.residual_nt[row])).unzip();
            plot.push(Series::points(format!("sensor {axis}"), axis.index(), &x, &y));
        }
        plot
    };
    section.plot(draw("", "Residuals of the readings, orientation by orientation", &|_| true));
    if !axes.doubtful.is_empty() {
        let title = "The same without the outliers";
        section.plot(draw("-left", title, &|row| !doubtful(row)));
    }
    let outliers = axes.doubtful.iter().map(|one| {
        let [off, t] =
            [(one.leave_one_out_nt, 4), (one.t, 3)].map(|(size, digits)| Cell::Figures(size, digits));
        let p = Cell::Probability(one.p_adjusted);
        (&one.recording, one.orientation, one.row, one.coil, one.sensor, off, t, p)
    });
    section.rows(
        "Outliers",
        "recording | orientation | row | coil | sensor | from the prediction of the others [nT] | t | p",
        outliers,
    );
}

fn fields(section: &mut Section, axes: &AxesCalibration) {
    let mut table =
        Table::new("Fields fitted together with the directions", "what | x [nT] | y [nT] | z [nT]");
    for (what, each) in [
        ("residual field, GEO", &axes.residual_field_nt),
        ("correction to each sensor's offset", &axes.offsets_nt),
    ] {
        if each.is_some() {
            let [x, y, z] = cells(each.as_ref());
            table.row((what, x, y, z));
        }
    }
    section.table(table);
    let Some(scales) = &axes.scales else { return };
    section.say(sentence(&scales.verdict));
    let mut table = Table::new(
        "Scale factors, fitted and compared with the calibration",
        "scale | fitted | calibration's own standard uncertainty | distance from 1 [std] | p",
    );
    let mut row = |name: String, scale: &ScaleResult| {
        let fitted = Cell::Uncertain { value: scale.value, std: scale.std };
        let sigmas = Cell::figures(scale.sigmas, 2);
        let p = Cell::probability(scale.p_value);
        table.row((name, fitted, Cell::Figures(scale.calibration_std, 2), sigmas, p));
    };
    scales.sensors.iter().for_each(|(axis, scale)| row(format!("sensor {axis}"), scale));
    scales.coils.iter().for_each(|(axis, scale)| row(format!("coil {axis}"), scale));
    row("common".into(), &scales.common);
    section.table(table);
}

fn orientations(section: &mut Section, axes: &AxesCalibration) {
    let orientations = axes.orientations.iter().map(|one| {
        let [x, y, z] = cells(one.correction_arcsec.as_ref());
        let (rms, moved) = (Cell::Figures(one.rms_nt, 3), Cell::Figures(one.orthogonalised_by_arcsec, 2));
        (one.recordings.join(", "), one.readings, rms, x, y, z, moved)
    });
    section.rows(
        "Orientations: the small rotation about the SEN axes that corrects each",
        "recordings | readings | rms [nT] | about x [arcsec] | about y [arcsec] | about z [arcsec] | \
         moved to the nearest rotation by [arcsec]",
        orientations,
    );
    let phases = axes.phases.iter().map(|one| {
        let (p, delay) = (Cell::Probability(one.p_value), Cell::Figures(one.delay_s, 3));
        (one.sensor, one.drive_hz, &one.phase_rad, p, delay)
    });
    section.rows(
        "Phases against an AC drive (negative: the reading lags)",
        "sensor | drive [Hz] | phase [rad] | p | as a delay [s]",
        phases,
    );
    let assumptions = axes.assumptions.iter().map(|one| {
        let [nt, arcsec] = [one.arcsec_per_nt, one.arcsec_per_arcsec].map(|turn| Cell::figures(turn, 2));
        (&one.assumed, nt, arcsec)
    });
    section.rows(
        "Assumptions that the recordings do not test, and their effect on a direction",
        "assumed | for each nT [arcsec] | for each arcsec [arcsec]",
        assumptions,
    );
}
