//! Which of two or three instruments the noise is of, and how they agree from short to long averages.

use common::{Axis, DifferentialFit, OwnNoise, PerAxis, ReferenceNoise};
use page::words::sentence;

use super::effects::{self, findings};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table, number};

/// What noise of the reference does to the matrix, and the noise of each instrument as far as it can be told.
pub fn noise(section: &mut Section, fit: &DifferentialFit) {
    let mut own = Table::new(
        "Noise of each instrument by itself",
        [
            ("instrument", ""),
            ("axis", ""),
            ("white, of a reading", "nT"),
            ("√A at 1 Hz", "nT/√Hz"),
            ("α", ""),
        ],
    );
    if let Some(noise) = &fit.reference_noise {
        section.warnings.extend(findings("", &noise.findings, &effects::differential::REFERENCE, noise));
        if !noise.ascribed.is_empty() {
            section.say(sentence(&noise.ascribed));
        }
        section.table(pulled(noise));
        add(&mut own, "test, noise of the reference removed", noise.test.as_ref());
    }
    if let Some(three) = &fit.three_cornered {
        section.say(format!(
            "Three instruments in one field; spectra that agree worse with independent noises: {}.",
            number::p_value(three.goodness_p)
        ));
        add(&mut own, "reference", Some(&three.reference));
        add(&mut own, "test", Some(&three.test));
        add(&mut own, "third", Some(&three.third));
    }
    section.table(own);
}

fn pulled(noise: &ReferenceNoise) -> Table {
    let mut table = Table::new(
        "Bias of each element by noise of the reference",
        [("element", ""), ("pulled", ""), ("corrected", ""), ("largest bias", ""), ("over its std", "")],
    );
    for (place, one) in &noise.elements {
        table.row([
            place.as_str().into(),
            Cell::Uncertain { value: one.pulled, std: one.pulled_std },
            one.corrected.as_ref().into(),
            Cell::Figures(one.largest_pull, 2),
            Cell::Figures(one.largest_pull_over_std, 2),
        ]);
    }
    table
}

fn add(table: &mut Table, instrument: &str, noise: Option<&PerAxis<OwnNoise>>) {
    for (axis, one) in noise.into_iter().flat_map(PerAxis::iter) {
        table.row([
            instrument.into(),
            axis.letter().into(),
            (&one.white_rms_nt).into(),
            (&one.density_at_1hz_nt_per_sqrt_hz).into(),
            (&one.flicker_exponent).into(),
        ]);
    }
}

/// The matrix by averaging time, where only statistics of long series are left.
pub fn octaves(section: &mut Section, fit: &DifferentialFit) {
    let Some(octaves) = &fit.octaves else { return };
    for (test, all) in octaves.iter() {
        let mut plot = Plot::new(
            format!("octaves-{test}"),
            format!("Matrix by averaging time, test axis {test}"),
            Dimension::log("averaging time", "s"),
            Dimension::linear("from differences of neighbours", ""),
        )
        .note("The differences are taken as independent.");
        for reference in Axis::ALL {
            let i = reference.index();
            let known = || all.iter().filter_map(|one| Some((one.averaging_s, one.matrix?[i], one.std?[i])));
            let x: Vec<f64> = known().map(|(x, ..)| x).collect();
            let y: Vec<f64> = known().map(|(_, y, _)| y).collect();
            let std: Vec<f64> = known().map(|(.., std)| std).collect();
            let name = format!("from reference {reference}");
            plot.push(Series::new(name, Mark::Points, i, &x, &y).with_std(&std));
        }
        section.plot(plot);
    }
}
