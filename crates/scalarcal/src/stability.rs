//! Whether the calibration holds over the time: that of parts against that of all.

use common::{ScalarStability, ScalarWindow};
use estimate::{Svd, stats};

use crate::Error;
use crate::design::Rows;
use crate::fit::Known;
use crate::kalman::WHITE;
use crate::linear::Linear;
use crate::noise::Groups;
use crate::read::Series;
use crate::result::described;
use crate::solve::{Detail, Solved};

/// Parts of one recording at most.
const PARTS: usize = 8;
/// Rows of a part for each parameter, at least.
const ROWS_PER_PARAMETER: usize = 20;
/// Singular values of a part below this share of the largest say nothing of its own.
const RANK_TOLERANCE: f64 = 1e-6;
/// Fewer parts than these cannot be compared.
const FEWEST_PARTS: usize = 2;

/// χ² of the parts: with r the residuals of all and J their derivatives, Σ |P_J r|² over the parts, P_J on the range of a part's
/// derivatives, is what the parts gain by parameters of their own. None for a recording too short to be cut.
pub fn of(solved: &Solved, detail: &Detail) -> Result<Option<ScalarStability>, Error> {
    let scales = &solved.scales;
    // By the magnitude, which does not show the turn of the sensors; what is held is then of the turn too.
    let turned = solved.vector.is_some();
    let (model, found) = (&solved.model.by_magnitude(), &solved.found);
    let count = model.parameters.len();
    let pieces = pieces(&detail.series, count);
    if pieces.len() < FEWEST_PARTS {
        return Ok(None);
    }
    let (mut chi_squared, mut rank) = (0.0, 0);
    let mut windows = Vec::new();
    let variance = (solved.noise.white_rms_nt.unwrap_or(0.0) / scales.magnitude_nt).powi(2);
    for (number, from, to) in pieces {
        let series = &detail.series[number];
        let part = cut(series, from, to);
        let follows = vec![detail.follows[number].iter().map(|column| column[from..to].to_vec()).collect()];
        let rows = Rows { series: std::slice::from_ref(&part), scales: *scales, follows, weights: None };
        let linear = Groups::of(&rows, model, found, solved.form != WHITE)
            .and_then(|groups| groups.linear(solved.form, variance));
        let Some(linear) = linear else { return Ok(None) };
        // What is held stays where it is.
        let fixed: Known =
            solved.held.iter().filter(|_| !turned).map(|(weights, _)| (weights.clone(), 0.0)).collect();
        let Linear { jacobian, right } = linear.with(&fixed, &vec![0.0; count]);
        let svd = Svd::of(jacobian.as_ref(), RANK_TOLERANCE)?;
        let step = svd.solve(&right);
        let gained: f64 = (0..jacobian.nrows())
            .map(|i| (0..count).map(|j| jacobian[(i, j)] * step[j]).sum::<f64>().powi(2))
            .sum();
        chi_squared += gained;
        rank += svd.rank();
        let covariance = svd.covariance();
        let time = |row: usize| series.time_s.as_ref().map_or(row as f64, |time| time[row]);
        let squares: f64 = detail.residuals[number][from..to].iter().map(|value| value * value).sum();
        let of = |place: usize| described(solved, place);
        windows.push(ScalarWindow {
            from_s: time(from),
            to_s: time(to - 1),
            rows: (to - from) as u64,
            rms_nt: (squares / (to - from) as f64).sqrt(),
            values: (0..count).map(|place| of(place).2 + step[place] * of(place).3).collect(),
            std: (0..count)
                .map(|place| covariance[(place, place)].max(0.0).sqrt() * of(place).3.abs())
                .collect(),
        });
    }
    let degrees_of_freedom = rank.saturating_sub(count) as f64;
    if degrees_of_freedom < 1.0 {
        return Ok(None);
    }
    // Against the scatter about parameters of the parts' own, which a change does not raise.
    let rows: f64 = windows.iter().map(|window| window.rows as f64).sum();
    let left = (rows - chi_squared - rank as f64).max(1.0);
    let f = (chi_squared / degrees_of_freedom) / (left / (rows - rank as f64).max(1.0));
    let p_value = stats::f_p(f, degrees_of_freedom, (rows - rank as f64).max(1.0));
    Ok(Some(ScalarStability { windows, chi_squared, degrees_of_freedom, p_value }))
}

/// Parts of the recordings: recording, first row, and the row after the last.
fn pieces(series: &[Series], parameters: usize) -> Vec<(usize, usize, usize)> {
    let of = |(number, one): (usize, &Series)| {
        let rows = one.len();
        let parts = (rows / (ROWS_PER_PARAMETER * parameters)).clamp(1, PARTS);
        (0..parts)
            .map(move |part| (number, rows * part / parts, rows * (part + 1) / parts))
            .collect::<Vec<_>>()
    };
    series.iter().enumerate().flat_map(of).filter(|(_, from, to)| to > from).collect()
}

fn cut(series: &Series, from: usize, to: usize) -> Series {
    let of = |column: &Vec<f64>| column[from..to].to_vec();
    Series {
        time_s: series.time_s.as_ref().map(of),
        rows: series.rows[from..to].to_vec(),
        readings: series.readings.each_ref().map(of),
        magnitude_nt: of(&series.magnitude_nt),
        id: series.id.clone(),
        ..*series
    }
}
