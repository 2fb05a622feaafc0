//! Whether the calibration holds over the time: that of parts against that of all.

use common::{ScalarStability, ScalarWindow};
use estimate::{Svd, stats};
use faer::ColRef;

use crate::linear::Linear;
use crate::noise::Groups;
use crate::read::Series;
use crate::result::described;
use crate::solved::{Detail, Solved};
use crate::weakest::UNDETERMINED;
use crate::{Error, Options};

/// Parts of one recording at most, where none are asked for.
pub const PARTS: usize = 8;
/// Windows at most, where they are asked for.
pub const MOST_WINDOWS: f64 = 10_000.0;
/// Rows of a part for each parameter, at least.
pub const ROWS_PER_PARAMETER: usize = 20;
/// Singular values of a part below this share of the largest say nothing of its own.
const RANK_TOLERANCE: f64 = 1e-6;
/// Fewer parts than these cannot be compared.
const FEWEST_PARTS: usize = 2;

pub struct Part {
    pub span_s: [f64; 2],
    pub rows: u64,
    /// Rms of the residual about the calibration of all, nT.
    pub rms_nt: f64,
    /// Its rows about that; None where they are too few.
    pub groups: Option<Groups>,
}

/// χ² of the parts: with r the residuals of all and J their derivatives, Σ |P_J r|² over the parts, P_J on
/// the range of a part's derivatives, is what the parts gain by parameters of their own. None for fewer than
/// two parts.
pub fn of(solved: &Solved, parts: Vec<Part>) -> Result<Option<ScalarStability>, Error> {
    // By the magnitude, which does not show the turn of the sensors; what is held is then of the turn too.
    let turned = solved.scalar.vector.is_some();
    let count = solved.model.by_magnitude().parameters.len();
    if parts.len() < FEWEST_PARTS {
        return Ok(None);
    }
    let (mut chi_squared, mut rank, mut rows) = (0.0, 0, 0.0);
    let mut windows = Vec::new();
    let variance = solved.white_variance();
    // What is held stays where it is.
    let fixed = if turned { Linear::none(count) } else { solved.held.fixed() };
    for part in parts {
        let [from_s, to_s] = part.span_s;
        let mut window =
            ScalarWindow { from_s, to_s, rows: part.rows, rms_nt: part.rms_nt, ..ScalarWindow::default() };
        let linear = part.groups.and_then(|groups| groups.linear(solved.form, variance, false));
        if let Some(linear) = linear {
            let Linear { jacobian, right } = linear.and(&fixed);
            let svd = Svd::of(jacobian.as_ref(), RANK_TOLERANCE)?;
            let step = svd.solve(&right);
            chi_squared += (&jacobian * ColRef::from_slice(&step)).squared_norm_l2();
            rank += svd.rank();
            rows += part.rows as f64;
            let covariance = svd.covariance();
            let std: Vec<f64> = (0..count).map(|place| covariance[(place, place)].max(0.0).sqrt()).collect();
            // Effects and what else is fitted have units of their own.
            let sure = std.iter().take(crate::model::NINE).all(|std| *std < UNDETERMINED);
            if svd.rank() == count && sure {
                let of = |place: usize| described(solved, place);
                window.values = (0..count).map(|place| of(place).2 + step[place] * of(place).3).collect();
                window.std = (0..count).map(|place| std[place] * of(place).3.abs()).collect();
            }
        }
        windows.push(window);
    }
    let degrees_of_freedom = rank.saturating_sub(count) as f64;
    if degrees_of_freedom < 1.0 {
        return Ok(None);
    }
    // Against the scatter about parameters of the parts' own, which a change does not raise.
    let freedom = (rows - rank as f64).max(1.0);
    let left = (rows - chi_squared - rank as f64).max(1.0);
    let f = (chi_squared / degrees_of_freedom) / (left / freedom);
    let p_value = stats::f_p(f, degrees_of_freedom, freedom);
    // The same scatter is that of the windows.
    let scatter = (left / freedom).sqrt();
    windows.iter_mut().flat_map(|window| &mut window.std).for_each(|std| *std *= scatter);
    Ok(Some(ScalarStability { windows, chi_squared, degrees_of_freedom, p_value }))
}

/// The parts of recordings whose rows are at hand: windows where they are asked for.
///
/// # Errors
///
/// Windows without times to cut by, or so short that there are too many.
pub fn parts(solved: &Solved, detail: &Detail, options: &Options) -> Result<Vec<Part>, Error> {
    let model = solved.model.by_magnitude();
    let pieces = match options.windows_s {
        Some(length) => by_time(&detail.series, length)?,
        None => pieces(&detail.series, model.parameters.len()),
    };
    if pieces.len() < FEWEST_PARTS {
        return Ok(Vec::new());
    }
    let all = detail.rows(solved.scales);
    let of = |(number, from, to): (usize, usize, usize)| {
        let rows = all.part(number, from..to);
        let plain = solved.white.then(|| rows.factor(&solved.model.terms));
        let groups = solved.groups(&rows, plain.as_ref(), &model, &solved.found);
        let time = detail.series[number].time_s.as_ref();
        let [from_s, to_s] = [from, to - 1].map(|row| time.map_or(row as f64, |time| time[row]));
        let squares: f64 = detail.residuals[number][from..to].iter().map(|value| value * value).sum();
        let rms_nt = (squares / (to - from) as f64).sqrt();
        Part { span_s: [from_s, to_s], rows: (to - from) as u64, rms_nt, groups }
    };
    let parts: Vec<Part> = pieces.into_iter().map(of).collect();
    // Of parts that nobody asked for all are compared, or none.
    let whole = options.windows_s.is_some() || parts.iter().all(|part| part.groups.is_some());
    Ok(if whole { parts } else { Vec::new() })
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

/// The same by windows of one length from the beginning of each recording, s.
fn by_time(series: &[Series], length_s: f64) -> Result<Vec<(usize, usize, usize)>, Error> {
    let mut all = Vec::new();
    for (number, one) in series.iter().enumerate() {
        let times = one.time_s.as_deref().filter(|times| times.windows(2).all(|pair| pair[1] >= pair[0]));
        let Some(times) = times else {
            let found = format!("no increasing times of the rows of \"{}\"", one.id);
            let expected = "`time_s`, which --windows needs";
            return Err(Error::document(format!("{}.columns.time_s", one.path()), found, expected));
        };
        let Some((first, last)) = times.first().zip(times.last()) else { continue };
        let window = |time: f64| ((time - first) / length_s).floor();
        if window(*last) >= MOST_WINDOWS {
            return Err(Error::Request(format!(
                "--windows {length_s}: found {} windows in \"{}\"; expected at most {MOST_WINDOWS}: use longer ones",
                window(*last) + 1.0,
                one.id
            )));
        }
        let mut from = 0;
        for to in 1..=times.len() {
            if to == times.len() || window(times[to]) > window(times[from]) {
                all.push((number, from, to));
                from = to;
            }
        }
    }
    Ok(all)
}
