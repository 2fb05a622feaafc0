//! Recordings as columns: what `ingest` read, cut, averaged and put side by side.

use common::time::Start;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Columns of one length by name; NaN where a reading is missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Seconds since 1970 at which `time_s` is zero; zero where no moment is stated.
    pub start_s: f64,
    columns: BTreeMap<String, Vec<f64>>,
}

impl Series {
    /// The first recording of a document; None where it has none with columns.
    pub fn of(document: &Value) -> Option<Self> {
        let recording = document.pointer("/recordings/0")?;
        let start_s = recording["start"].as_str().and_then(Start::parse).map_or(0.0, |start| start.unix_s);
        let values = |column: &Value| -> Option<Vec<f64>> {
            Some(column.as_array()?.iter().map(|value| value.as_f64().unwrap_or(f64::NAN)).collect())
        };
        let columns = recording["columns"].as_object()?;
        let columns =
            columns.iter().filter_map(|(name, column)| Some((name.clone(), values(column)?))).collect();
        Some(Self { start_s, columns })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.values().next().map_or(0, Vec::len)
    }

    /// Whether there is a column of that name.
    pub fn holds(&self, name: &str) -> bool {
        self.columns.contains_key(name)
    }

    /// A column; empty where there is none of that name.
    pub fn column(&self, name: &str) -> &[f64] {
        self.columns.get(name).map_or(&[], Vec::as_slice)
    }

    /// The rows of `{quantity}_x_nt`, `{quantity}_y_nt`, `{quantity}_z_nt`.
    pub fn vectors(&self, quantity: &str) -> Vec<[f64; 3]> {
        let [x, y, z] = ["x", "y", "z"].map(|axis| self.column(&format!("{quantity}_{axis}_nt")));
        x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z]).collect()
    }

    /// With a column set; what stands there is replaced.
    pub fn with(mut self, name: impl Into<String>, values: Vec<f64>) -> Self {
        self.columns.insert(name.into(), values);
        self
    }

    /// With the three columns of a vector.
    pub fn with_vectors(self, quantity: &str, vectors: &[[f64; 3]]) -> Self {
        ["x", "y", "z"].into_iter().enumerate().fold(self, |series, (k, axis)| {
            series.with(format!("{quantity}_{axis}_nt"), vectors.iter().map(|vector| vector[k]).collect())
        })
    }

    /// The columns of which `keep` says yes.
    pub fn only(mut self, keep: impl Fn(&str) -> bool) -> Self {
        self.columns.retain(|name, _| keep(name));
        self
    }

    /// Readings of `from` under the name of `to`, `sensor_x_nt` as `test_x_nt`.
    pub fn renamed(self, from: &str, to: &str) -> Self {
        let name = |name: String| match name.strip_prefix(from) {
            Some(rest) if rest.ends_with("_nt") => format!("{to}{rest}"),
            _ => name,
        };
        let columns = self.columns.into_iter().map(|(key, values)| (name(key), values)).collect();
        Self { columns, ..self }
    }

    /// The rows of which `keep` says yes.
    pub fn filter(&self, keep: impl Fn(usize) -> bool) -> Self {
        let rows: Vec<usize> = (0..self.rows()).filter(|row| keep(*row)).collect();
        let cut = |values: &Vec<f64>| rows.iter().map(|row| values[*row]).collect();
        let columns = self.columns.iter().map(|(name, values)| (name.clone(), cut(values))).collect();
        Self { columns, ..*self }
    }

    /// Every so many-th row: an instrument that turns must not be averaged.
    pub fn every(&self, number: usize) -> Self {
        self.filter(|row| row % number == 0)
    }

    /// The rows with every reading there.
    pub fn complete(&self) -> Self {
        self.filter(|row| self.columns.values().all(|values| values[row].is_finite()))
    }

    /// Means over blocks of `step_s` of the clock, at the middle of the block; blocks that have less than 0.9
    /// of the usual rows are left out, and so is a mean with a reading missing.
    pub fn means(&self, step_s: f64) -> Self {
        self.blocks(step_s, 0.9)
    }

    /// Means over blocks of whatever rows they have: for loggers that read at uneven times.
    pub fn means_of_all(&self, step_s: f64) -> Self {
        self.blocks(step_s, 0.0)
    }

    fn blocks(&self, step_s: f64, least: f64) -> Self {
        let block = |row: usize| (self.column("time_s")[row] / step_s).floor();
        let mut blocks: Vec<(f64, std::ops::Range<usize>)> = Vec::new();
        for row in 0..self.rows() {
            match blocks.last_mut() {
                Some((last, rows)) if *last == block(row) => rows.end = row + 1,
                _ => blocks.push((block(row), row..row + 1)),
            }
        }
        let mut lengths: Vec<usize> = blocks.iter().map(|(_, rows)| rows.len()).collect();
        lengths.sort_unstable();
        let usual = lengths.get(lengths.len() / 2).copied().unwrap_or(0);
        blocks.retain(|(_, rows)| rows.len() as f64 >= least * usual as f64);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let average =
            |values: &Vec<f64>| blocks.iter().map(|(_, rows)| mean(&values[rows.clone()])).collect();
        let columns = self.columns.iter().map(|(name, values)| (name.clone(), average(values))).collect();
        let middle = blocks.iter().map(|(block, _)| (block + 0.5) * step_s).collect();
        Self { columns, ..*self }.with("time_s", middle)
    }

    /// The same readings on the clock that is zero at `start_s`.
    pub fn on_clock(self, start_s: f64) -> Self {
        let shift = self.start_s - start_s;
        let time = self.column("time_s").iter().map(|t| t + shift).collect();
        Self { start_s, ..self }.with("time_s", time)
    }

    /// The rows whose times both have (to a millisecond of the clock of this one), with the columns of both.
    pub fn joined(&self, other: &Series) -> Self {
        let key = |t: f64| (1000.0 * t).round() as i64;
        let other = other.clone().on_clock(self.start_s);
        let places: BTreeMap<i64, usize> =
            other.column("time_s").iter().enumerate().map(|(row, t)| (key(*t), row)).collect();
        let place = |row: usize| places.get(&key(self.column("time_s")[row])).copied();
        let mut joined = self.filter(|row| place(row).is_some());
        let rows: Vec<usize> = (0..self.rows()).filter_map(place).collect();
        for (name, values) in other.columns.into_iter().filter(|(name, _)| name != "time_s") {
            joined = joined.with(name, rows.iter().map(|row| values[*row]).collect());
        }
        joined
    }

    /// The readings at other times, by straight lines between neighbours; NaN outside, and where neighbours
    /// are more than 1.5 of the usual step apart.
    pub fn at(&self, times: &[f64]) -> Self {
        let own = self.column("time_s");
        let mut steps: Vec<f64> = own.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        let longest = 1.5 * steps.get(steps.len() / 2).copied().unwrap_or(0.0);
        let line = |values: &Vec<f64>, t: f64| {
            let after = own.partition_point(|own| *own < t);
            if after < own.len() && own[after] == t {
                return values[after];
            }
            if after == 0 || after == own.len() || own[after] - own[after - 1] > longest {
                return f64::NAN;
            }
            let share = (t - own[after - 1]) / (own[after] - own[after - 1]);
            values[after - 1] + share * (values[after] - values[after - 1])
        };
        let columns = self
            .columns
            .iter()
            .map(|(name, values)| (name.clone(), times.iter().map(|t| line(values, *t)).collect()))
            .collect();
        Self { columns, ..*self }.with("time_s", times.to_vec())
    }

    /// A recording of a document.
    pub fn recording(&self, id: &str, procedure: &str) -> Value {
        let values = |values: &Vec<f64>| -> Value {
            values.iter().map(|value| if value.is_finite() { json!(value) } else { Value::Null }).collect()
        };
        let columns: Map<String, Value> =
            self.columns.iter().map(|(name, column)| (name.clone(), values(column))).collect();
        let mut recording = json!({"id": id, "procedure": procedure, "columns": columns});
        let start = Start { unix_s: self.start_s, offset_s: 0.0 };
        if let Some(text) = start.text().filter(|_| self.start_s > 0.0) {
            recording["start"] = json!(text);
        }
        recording
    }
}

/// Root of the mean of squares, over what is there.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let squares: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).map(|v| v * v).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// Mean of what is there.
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, number) = values
        .into_iter()
        .filter(|value| value.is_finite())
        .fold((0.0, 0.0), |(sum, number), value| (sum + value, number + 1.0));
    sum / number
}

/// Length of a vector.
pub fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|component| component * component).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(time: &[f64], x: &[f64]) -> Series {
        Series { start_s: 100.0, ..Series::default() }
            .with("time_s", time.to_vec())
            .with("sensor_x_nt", x.to_vec())
    }

    #[test]
    fn blocks_that_lack_rows_are_left_out() {
        let all =
            series(&[0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 7.0, 8.0], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        let means = all.means(3.0);
        assert_eq!(means.column("time_s"), [1.5, 7.5]);
        assert_eq!(means.column("sensor_x_nt"), [2.0, 7.0]);
        assert_eq!(all.every(3).column("sensor_x_nt"), [1.0, 4.0, 7.0]);
    }

    #[test]
    fn two_clocks_are_joined_where_both_have_a_time() {
        let one = series(&[0.0, 1.0, 2.0], &[1.0, 2.0, 3.0]);
        let other = series(&[-9.0, -8.0], &[20.0, 30.0]).renamed("sensor", "test");
        let other = Series { start_s: 110.0, ..other };
        let joined = one.joined(&other);
        assert_eq!(joined.column("time_s"), [1.0, 2.0]);
        assert_eq!(joined.column("sensor_x_nt"), [2.0, 3.0]);
        assert_eq!(joined.column("test_x_nt"), [20.0, 30.0]);
    }

    #[test]
    fn lines_between_neighbours_and_nothing_beyond() {
        let all = series(&[0.0, 1.0, 2.0, 9.0], &[1.0, 3.0, 7.0, 8.0]);
        let at = all.at(&[-1.0, 0.5, 2.0, 5.0, 9.0, 10.0]);
        let found: Vec<Option<f64>> =
            at.column("sensor_x_nt").iter().map(|value| value.is_finite().then_some(*value)).collect();
        assert_eq!(found, [None, Some(2.0), Some(7.0), None, Some(8.0), None]);
        assert_eq!(at.complete().column("time_s"), [0.5, 2.0, 9.0]);
    }

    #[test]
    fn a_recording_comes_back_as_it_was() {
        let all = series(&[0.0, 1.0], &[1.0, f64::NAN]);
        let document = json!({"recordings": [all.recording("a", "free_run")]});
        assert_eq!(document["recordings"][0]["start"], "1970-01-01T00:01:40Z");
        let back = Series::of(&document).expect("columns");
        assert!(back.column("sensor_x_nt")[1].is_nan());
        assert_eq!((back.start_s, back.column("time_s")), (100.0, all.column("time_s")));
        assert_eq!((mean([1.0, f64::NAN, 3.0]), rms([3.0, -3.0])), (2.0, 3.0));
    }
}
