//! What the nulling leaves: spectra in each condition of the site.

use common::{Axis, Document, SpectralLine};
use page::words::{cells, rounded};

use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let nulling = document.calibration.as_ref()?.nulling.as_ref()?;
    let mut section = Section::new("nulling", "Residual field after nulling");
    if let Some(quietest) = &nulling.quietest {
        section.words.push(format!("Quietest condition of the site: {quietest}."));
    }
    for axis in Axis::ALL {
        let mut plot = Plot::new(
            format!("nulling-{axis}"),
            format!("Spectrum by condition, sensor {axis}"),
            Dimension::log("frequency", "Hz"),
            Dimension::log("power density", "nT²/Hz"),
        )
        .note("Bands: 95 % intervals.");
        for (style, (site, spectra)) in nulling.sites.iter().enumerate() {
            let Some(spectrum) = spectra.spectra.get(axis) else { continue };
            plot.push(
                Series::new(site, Mark::Line, style, &spectrum.frequency_hz, &spectrum.density_nt2_per_hz)
                    .between(&spectrum.low_nt2_per_hz, &spectrum.high_nt2_per_hz),
            );
        }
        section.plot(plot);
    }
    let mut expected = Table::new(
        "Expected rms error of a measurement: √∫ P df from one over its length to the instrument's Nyquist frequency",
        [
            ("condition", ""),
            ("length", "s"),
            ("from", "Hz"),
            ("to", "Hz"),
            ("x", "nT"),
            ("y", "nT"),
            ("z", "nT"),
        ],
    );
    let mut lines = lines_table();
    let mut series = Table::new(
        "Series behind the spectra",
        [
            ("condition", ""),
            ("recording", ""),
            ("rate", "Hz"),
            ("segments", ""),
            ("degrees of freedom", ""),
            ("from", "Hz"),
            ("to", "Hz"),
        ],
    );
    for (site, spectra) in &nulling.sites {
        for one in &spectra.expected {
            let [x, y, z] = cells(Some(&one.rms_nt));
            let [from, to] = one.band_hz;
            expected.row([
                site.as_str().into(),
                one.length_s.into(),
                Cell::Number(rounded(from)),
                Cell::Number(rounded(to)),
                x,
                y,
                z,
            ]);
        }
        add_lines(&mut lines, &spectra.lines);
        for one in &spectra.series {
            let [from, to] = one.band_hz;
            series.row([
                site.as_str().into(),
                one.recording.as_str().into(),
                one.rate_hz.into(),
                one.segments.into(),
                Cell::Figures(one.freedom, 3),
                Cell::Number(rounded(from)),
                Cell::Number(rounded(to)),
            ]);
        }
        for [from, to] in &spectra.gaps_hz {
            section.words.push(format!(
                "{site}: no series shows {} to {} Hz.",
                crate::number::bare(*from),
                crate::number::bare(*to)
            ));
        }
    }
    section.table(expected);
    section.table(lines);
    section.table(series);
    (!section.items.is_empty()).then_some(section)
}

/// A table of spectral lines.
pub fn lines_table() -> Table {
    Table::new(
        "Spectral lines",
        [("recording", ""), ("sensor", ""), ("frequency", "Hz"), ("amplitude", "nT"), ("what it is", "")],
    )
}

/// Adds spectral lines to their table.
pub fn add_lines(table: &mut Table, lines: &[SpectralLine]) {
    for line in lines {
        table.row([
            line.recording.as_str().into(),
            line.sensor.as_str().into(),
            line.frequency_hz.into(),
            Cell::Figures(line.amplitude_nt, 3),
            line.name.clone().into(),
        ]);
    }
}
