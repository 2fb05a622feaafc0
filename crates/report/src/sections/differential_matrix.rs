//! Whether the matrix of two magnetometers holds still: in time, and from short to long periods.

use common::{Axis, DifferentialFit, MatrixStability};

use super::clock::Clock;
use super::effects::{self, findings};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table};

/// Tables and plots of the matrix's stability.
pub fn stability(section: &mut Section, fit: &DifferentialFit, matrix: &common::Matrix3x3) {
    let Some(stability) = &fit.stability else { return };
    section.warnings.extend(findings("", &stability.findings, &effects::differential::STABILITY, stability));
    let mut tests = Table::new("Constancy of the matrix", [("test", ""), ("p", "")]);
    let mut test = |of: &str, p: Option<f64>| {
        if let Some(p) = p {
            tests.row([of.into(), Cell::Probability(p)]);
        }
    };
    let windows = stability.windows.as_ref();
    test("windows of equal length", windows.map(|windows| windows.one_matrix.p));
    test("no linear trend through them", windows.map(|windows| windows.no_trend.p));
    let times = stability.quiet_disturbed.as_ref().and_then(|times| times.one_matrix.as_ref());
    test("quiet and disturbed times", times.map(|one| one.p));
    let bands = stability.bands.as_ref();
    test("bands of periods", bands.map(|bands| bands.one_matrix.p));
    test("bands of periods, clock offset removed", bands.map(|bands| bands.one_matrix_with_clock.p));
    for test in Axis::ALL {
        section.plot(in_time(stability, matrix, test));
    }
    for test in Axis::ALL {
        section.plot(by_period(stability, matrix, test));
    }
    section.table(tests);
}

fn in_time(stability: &MatrixStability, matrix: &common::Matrix3x3, test: Axis) -> Plot {
    let windows = stability.windows.as_ref().map(|windows| windows.windows.as_slice()).unwrap_or_default();
    let middles: Vec<f64> = windows.iter().map(|window| (window.from_s + window.to_s) / 2.0).collect();
    let clock = Clock::of(&middles);
    let mut plot = Plot::new(
        format!("matrix-windows-{test}"),
        format!("Matrix in windows of time, test axis {test}"),
        Dimension::linear("middle of the window", clock.unit),
        Dimension::linear("less that of the whole", "1e-6"),
    );
    let j = test.index();
    for reference in Axis::ALL {
        let i = reference.index();
        let change: Vec<f64> =
            windows.iter().map(|window| 1e6 * (window.estimate.matrix[i][j] - matrix[i][j])).collect();
        let std: Vec<f64> = windows.iter().map(|window| 1e6 * window.estimate.std[i][j]).collect();
        plot.push(
            Series::new(
                format!("from reference {reference}"),
                Mark::Points,
                i,
                &clock.times(&middles),
                &change,
            )
            .with_std(&std),
        );
    }
    plot
}

fn by_period(stability: &MatrixStability, matrix: &common::Matrix3x3, test: Axis) -> Plot {
    let bands = stability.bands.as_ref().map(|bands| bands.bands.as_slice()).unwrap_or_default();
    let middles: Vec<f64> = bands.iter().map(|band| (band.from_period_s * band.to_period_s).sqrt()).collect();
    let mut plot = Plot::new(
        format!("matrix-bands-{test}"),
        format!("Matrix by period, test axis {test}"),
        Dimension::log("period", "s"),
        Dimension::linear("real part less the matrix", "1e-6"),
    );
    let j = test.index();
    for reference in Axis::ALL {
        let i = reference.index();
        let change: Vec<f64> = bands.iter().map(|band| 1e6 * (band.real[i][j] - matrix[i][j])).collect();
        let std: Vec<f64> = bands.iter().map(|band| 1e6 * band.real_std[i][j]).collect();
        plot.push(
            Series::new(format!("from reference {reference}"), Mark::Points, i, &middles, &change)
                .with_std(&std),
        );
    }
    plot
}
