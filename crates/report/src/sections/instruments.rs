//! Two or three instruments in one field: whether the matrix holds still in time and from short to long
//! periods, and whose the noise is.

use common::{Axis, DifferentialFit, Matrix3x3, OwnNoise, PerAxis};
use page::words::sentence;

use super::effects::{self, findings};
use super::shared::Clock;
use crate::plot::{Dimension, Plot, Series};
use crate::{Cell, Section, Table, number};

/// A series for each reference axis, of x, y and the standard uncertainty of y.
fn from_each<I: Iterator<Item = [f64; 3]>>(plot: Plot, points: impl Fn(usize) -> I) -> Plot {
    Axis::ALL.into_iter().fold(plot, |plot, reference| {
        let i = reference.index();
        plot.with(Series::measured(format!("from reference {reference}"), i, points(i)))
    })
}

/// Tables and plots of the matrix's stability.
pub fn stability(section: &mut Section, fit: &DifferentialFit, matrix: &Matrix3x3) {
    let Some(stability) = &fit.stability else { return };
    section.warnings.extend(findings("", &stability.findings, &effects::differential::STABILITY, stability));
    let windows = stability.windows.as_ref();
    let times = stability.quiet_disturbed.as_ref().and_then(|times| times.one_matrix.as_ref());
    let bands = stability.bands.as_ref();
    let tests = [
        ("windows of equal length", windows.map(|windows| windows.one_matrix.p)),
        ("no linear trend through them", windows.map(|windows| windows.no_trend.p)),
        ("quiet and disturbed times", times.map(|one| one.p)),
        ("bands of periods", bands.map(|bands| bands.one_matrix.p)),
        ("bands of periods, clock offset removed", bands.map(|bands| bands.one_matrix_with_clock.p)),
    ];
    let windows = windows.map(|windows| windows.windows.as_slice()).unwrap_or_default();
    let middles: Vec<f64> = windows.iter().map(|window| (window.from_s + window.to_s) / 2.0).collect();
    let clock = Clock::of(&middles);
    let middles = clock.times(&middles);
    for test in Axis::ALL {
        let j = test.index();
        let plot = Plot::new(
            format!("matrix-windows-{test}"),
            format!("Matrix in windows of time, test axis {test}"),
        )
        .axes(Dimension::linear("middle of the window", clock.unit), "less that of the whole [1e-6]");
        section.plot(from_each(plot, |i| {
            windows.iter().zip(&middles).map(move |(window, middle)| {
                let found = &window.estimate;
                [*middle, 1e6 * (found.matrix[i][j] - matrix[i][j]), 1e6 * found.std[i][j]]
            })
        }));
    }
    let bands = bands.map(|bands| bands.bands.as_slice()).unwrap_or_default();
    for test in Axis::ALL {
        let j = test.index();
        let plot = Plot::new(format!("matrix-bands-{test}"), format!("Matrix by period, test axis {test}"))
            .axes(Dimension::log("period [s]"), "real part less the matrix [1e-6]");
        section.plot(from_each(plot, |i| {
            bands.iter().map(move |band| {
                let middle = (band.from_period_s * band.to_period_s).sqrt();
                [middle, 1e6 * (band.real[i][j] - matrix[i][j]), 1e6 * band.real_std[i][j]]
            })
        }));
    }
    let tests = tests.into_iter().filter_map(|(of, p)| Some((of, Cell::Probability(p?))));
    section.rows("Constancy of the matrix", "test | p", tests);
}

/// The matrix by averaging time, where only statistics of long series are left.
pub fn octaves(section: &mut Section, fit: &DifferentialFit) {
    let Some(octaves) = &fit.octaves else { return };
    for (test, all) in octaves.iter() {
        let title = format!("Matrix by averaging time, test axis {test}");
        let plot = Plot::new(format!("octaves-{test}"), title)
            .axes(Dimension::log("averaging time [s]"), "from differences of neighbours")
            .note("The differences are taken as independent.");
        section.plot(from_each(plot, |i| {
            all.iter().filter_map(move |one| Some([one.averaging_s, one.matrix?[i], one.std?[i]]))
        }));
    }
}

/// What noise of the reference does to the matrix, and the noise of each instrument as far as it can be told.
pub fn noise(section: &mut Section, fit: &DifferentialFit) {
    let mut own = Table::new(
        "Noise of each instrument by itself",
        "instrument | axis | white, of a reading [nT] | √A at 1 Hz [nT/√Hz] | α",
    );
    let mut add = |instrument: &str, noise: Option<&PerAxis<OwnNoise>>| {
        for (axis, one) in noise.into_iter().flat_map(PerAxis::iter) {
            let density = &one.density_at_1hz_nt_per_sqrt_hz;
            own.row((instrument, axis, &one.white_rms_nt, density, &one.flicker_exponent));
        }
    };
    if let Some(noise) = &fit.reference_noise {
        section.warnings.extend(findings("", &noise.findings, &effects::differential::REFERENCE, noise));
        if !noise.ascribed.is_empty() {
            section.say(sentence(&noise.ascribed));
        }
        let pulled = noise.elements.iter().map(|(place, one)| {
            let found = Cell::Uncertain { value: one.pulled, std: one.pulled_std };
            let [largest, over] = [one.largest_pull, one.largest_pull_over_std];
            (place, found, &one.corrected, Cell::Figures(largest, 2), Cell::Figures(over, 2))
        });
        section.rows(
            "Bias of each element by noise of the reference",
            "element | pulled | corrected | largest bias | over its std",
            pulled,
        );
        add("test, noise of the reference removed", noise.test.as_ref());
    }
    if let Some(three) = &fit.three_cornered {
        section.say(format!(
            "Three instruments in one field; spectra that agree worse with independent noises: {}.",
            number::p_value(three.goodness_p)
        ));
        add("reference", Some(&three.reference));
        add("test", Some(&three.test));
        add("third", Some(&three.third));
    }
    section.table(own);
}
