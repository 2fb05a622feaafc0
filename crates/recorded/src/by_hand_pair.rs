//! A pair of vector magnetometers by a few lines of least squares, without any code of the stages: what the
//! programs are held against.

use crate::affine::least_squares;
use crate::series::{Series, mean, rms};
use crate::split::Split;

/// Steps of the coarse and of the fine search of a lag, in steps of the reference; the coarse one goes this
/// far on both sides.
const COARSE: f64 = 0.5;
const FINE: f64 = 0.05;
const FARTHEST: f64 = 3.0;
/// Share of the fitted part on which ways are fitted; the rest chooses among them.
const FIRST: f64 = 2.0 / 3.0;
const AXES: [&str; 3] = ["x", "y", "z"];

/// Both instruments side by side if the test instrument's times are late by so much, s.
pub type SideBySide<'a> = dyn Fn(f64) -> Series + 'a;

/// One way to explain a test axis.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Way {
    matrix: bool,
    drift: bool,
    temperature: bool,
    lag: bool,
}

impl Way {
    fn words(self, late_s: f64) -> String {
        if !self.matrix {
            return "levels alone".into();
        }
        let mut words = "3×3 and offset".to_string();
        for (has, what) in [(self.drift, ", straight drift"), (self.temperature, ", line in the temperature")]
        {
            words += if has { what } else { "" };
        }
        let lag = if late_s < 0.0 { "early" } else { "late" };
        words + &if self.lag { format!(", clock {:.3} s {lag}", late_s.abs()) } else { String::new() }
    }

    fn columns(self, series: &Series) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![1.0; series.rows()]];
        columns.extend(AXES.map(|axis| series.column(&format!("reference_{axis}_nt")).to_vec()));
        if self.drift {
            columns.push(series.column("time_s").iter().map(|t| t / 3600.0).collect());
        }
        if self.temperature {
            columns.push(series.column(TEMPERATURE).to_vec());
        }
        columns
    }
}

const TEMPERATURE: &str = "sensor_temperature_c";

/// The best of some ways, of each axis.
#[derive(Clone, Debug)]
pub struct Best {
    /// The ways in words.
    pub words: [String; 3],
    /// What each leaves of the part that was left out: its scatter, nT.
    pub scatter_nt: [f64; 3],
    /// The mean of that, nT.
    pub level_nt: [f64; 3],
}

/// Fits all ways to the first two thirds of what is fitted, takes of each axis the one that predicts the rest
/// of it best, fits that to all of it, and predicts what was left out, which has no part in the choice.
pub fn best(fitted: &SideBySide<'_>, left_out: &SideBySide<'_>) -> Best {
    let late_s = lag(fitted);
    let has_temperature = fitted(0.0).holds(TEMPERATURE);
    let mut ways = vec![Way { matrix: false, drift: false, temperature: false, lag: false }];
    for (drift, temperature, lag) in [false, true]
        .into_iter()
        .flat_map(|d| [false, true].map(|t| (d, t)))
        .flat_map(|(d, t)| [false, true].map(|l| (d, t, l)))
    {
        if (has_temperature || !temperature) && (late_s != 0.0 || !lag) {
            ways.push(Way { matrix: true, drift, temperature, lag });
        }
    }
    // By whether the clock is corrected.
    let fitted = [fitted(0.0), fitted(late_s)];
    let left_out = [left_out(0.0), left_out(late_s)];
    let tried = fitted.each_ref().map(|series| Split::share(series, FIRST));
    let one = |axis: usize| {
        let scatter = |way: &Way| {
            let Split { fitted, left_out } = &tried[usize::from(way.lag)];
            left(*way, axis, fitted, left_out).map_or(f64::INFINITY, |left| about_mean(&left))
        };
        let best = ways.iter().copied().min_by(|a, b| scatter(a).total_cmp(&scatter(b))).unwrap_or(ways[0]);
        let number = usize::from(best.lag);
        (best.words(late_s), left(best, axis, &fitted[number], &left_out[number]).unwrap_or_default())
    };
    let all = [one(0), one(1), one(2)];
    Best {
        words: all.each_ref().map(|(words, _)| words.clone()),
        scatter_nt: all.each_ref().map(|(_, left)| about_mean(left)),
        level_nt: all.each_ref().map(|(_, left)| mean(left.iter().copied())),
    }
}

/// What is left of an axis of one part by constants that are fitted to another; None where columns are
/// dependent.
fn left(way: Way, axis: usize, fitted: &Series, part: &Series) -> Option<Vec<f64>> {
    let name = AXES[axis];
    let test = |series: &Series| series.column(&format!("test_{name}_nt")).to_vec();
    if !way.matrix {
        let alike = |series: &Series| -> Vec<f64> {
            let reference = series.column(&format!("reference_{name}_nt"));
            test(series).iter().zip(reference).map(|(test, reference)| test - reference).collect()
        };
        let level = mean(alike(fitted));
        return Some(alike(part).into_iter().map(|d| d - level).collect());
    }
    let found = least_squares(&way.columns(fitted), &test(fitted))?;
    let columns = way.columns(part);
    let predicted = |row: usize| columns.iter().zip(&found).map(|(column, c)| c * column[row]).sum::<f64>();
    Some(test(part).iter().enumerate().map(|(row, test)| test - predicted(row)).collect())
}

/// The lag of least scatter of what a 3×3 matrix with an offset leaves, each axis over its scatter without a
/// lag, s.
fn lag(fitted: &SideBySide<'_>) -> f64 {
    let series = fitted(0.0);
    let time = series.column("time_s");
    let step_s =
        if time.len() > 1 { (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64 } else { return 0.0 };
    let way = Way { matrix: true, drift: false, temperature: false, lag: true };
    let of_each = |late_s: f64| -> Option<[f64; 3]> {
        let series = fitted(late_s);
        let all = [
            left(way, 0, &series, &series)?,
            left(way, 1, &series, &series)?,
            left(way, 2, &series, &series)?,
        ];
        Some(all.map(|left| about_mean(&left)))
    };
    let Some(without) = of_each(0.0) else { return 0.0 };
    let relative = |steps: f64| {
        let scatter = of_each(steps * step_s);
        scatter.map_or(f64::INFINITY, |s| (0..3).map(|k| s[k] / without[k]).sum::<f64>())
    };
    let least = |from: f64, step: f64, count: usize| {
        let places = (0..=count).map(|k| from + step * k as f64);
        places.min_by(|a, b| relative(*a).total_cmp(&relative(*b))).unwrap_or(0.0)
    };
    let coarse = least(-FARTHEST, COARSE, (2.0 * FARTHEST / COARSE) as usize);
    least(coarse - COARSE, FINE, (2.0 * COARSE / FINE) as usize) * step_s
}

fn about_mean(values: &[f64]) -> f64 {
    let level = mean(values.iter().copied());
    rms(values.iter().map(|value| value - level))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::scatter_of_each;

    /// Both instruments in one field, the test instrument turned by a little, in noise of 0.1 nT; `further`
    /// is added to test x.
    fn pair(rows: std::ops::Range<u32>, late_s: f64, further: fn(f64) -> f64) -> Series {
        let times: Vec<f64> = rows.map(|row| f64::from(row) * 60.0).collect();
        let field = |t: f64| [40.0 * (t / 900.0).sin(), 30.0 * (t / 1300.0).cos(), 20.0 * (t / 700.0).sin()];
        let noise = |t: f64, k: f64| 0.1 * (t * (12.9898 + k)).sin();
        let reference: Vec<[f64; 3]> = times.iter().map(|t| field(*t)).collect();
        // A reading that is stamped t + late was true at t; the side by side of a lag moves it back.
        let test: Vec<[f64; 3]> = times
            .iter()
            .map(|t| {
                let [x, y, z] = field(*t + late_s);
                [
                    x + 0.05 * y + noise(*t, 0.0) + further(*t),
                    y - 0.05 * x + noise(*t, 1.0),
                    z + noise(*t, 2.0),
                ]
            })
            .collect();
        Series::default()
            .with("time_s", times)
            .with_vectors("reference", &reference)
            .with_vectors("test", &test)
    }

    #[test]
    fn a_late_clock_is_found() {
        let late = |rows: std::ops::Range<u32>| move |by: f64| pair(rows.clone(), by - 30.0, |_| 0.0);
        let best = best(&late(0..600), &late(600..900));
        assert!(best.words.iter().all(|words| words.contains("clock 30.000 s late")), "{:?}", best.words);
        assert!(best.scatter_nt.iter().all(|nt| *nt < 0.08), "{best:?}");
    }

    #[test]
    fn a_drift_is_taken_where_it_predicts() {
        let drifting = |rows: std::ops::Range<u32>| move |by: f64| pair(rows.clone(), by, |t| t / 3600.0);
        let best = best(&drifting(0..600), &drifting(600..900));
        assert!(best.words[0].contains("straight drift"), "{:?}", best.words);
        assert!(best.scatter_nt[0] < 0.08 && best.level_nt[0].abs() < 0.1, "{best:?}");
    }

    #[test]
    fn dependent_columns_leave_levels() {
        let flat = |_: f64| {
            let alike = vec![[1.0, 2.0, 3.0]; 30];
            let times = (0..30).map(f64::from).collect();
            Series::default()
                .with("time_s", times)
                .with_vectors("reference", &alike)
                .with_vectors("test", &alike)
        };
        let best = best(&flat, &flat);
        assert_eq!(best.words[0], "levels alone");
        assert_eq!(best.scatter_nt, scatter_of_each(&[[0.0; 3]; 30]));
    }
}
