//! In which form a cause acts: at once or late, straight or bent.

use crate::problem::{Cause, Covariate, Problem};

/// The shortest relaxation, in steps, and the factor from one to the next.
const SHORTEST_STEPS: f64 = 1.0;
const FACTOR: f64 = 1.7;
/// The longest relaxation, as a share of the recording's length.
const LONGEST: f64 = 0.5;
/// Whole samples by which a column may be logged late or early.
const ROWS: i32 = 3;
/// A column of which more than this share of the samples equals the one before is a state: it holds from one
/// sample to the next.
const HELD: f64 = 0.5;
/// A column of fewer values than this cannot be bent.
const BENT: usize = 4;
/// The fast part of what is late relaxes so many times as fast.
const FASTER: f64 = 8.0;
/// Powers of a column from zero on, as of a current that is known by its power, and of time, as of creep; with its
/// square a column is bent.
const POWERS: [f64; 5] = [0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 1.5];
/// The least of such a column is this share of its largest at most: any power of another is nearly straight.
const FROM_ZERO: f64 = 0.5;

/// How a cause enters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Form {
    /// Time constant of a relaxation, s: τ dx/dt = column − x; 0 for none. Of time: of the exponential that
    /// dies out.
    pub late_s: f64,
    /// Samples by which the column is logged late: the reading follows a sample that comes so many later.
    pub rows: i32,
    /// With its square; of a clock: with a rate.
    pub bent: bool,
    /// The exponent of the column, or of time, where that is not one.
    pub power: Option<f64>,
    /// With a part that relaxes faster, as of heat that diffuses through a wall.
    pub fast: bool,
    /// Of a column that mostly stays as it was: on lines between its samples, where else it holds each until the
    /// next.
    pub lines: bool,
    /// Which of the shapes of a course.
    pub shape: usize,
}

impl Form {
    /// The forms in which a cause may act.
    pub fn all(problem: &Problem, cause: Cause) -> Vec<Self> {
        let plain = Self::default();
        let lates = || {
            let from = SHORTEST_STEPS * problem.step_s();
            let longest = LONGEST * problem.length_s();
            std::iter::successors(Some(from), |late| Some(late * FACTOR))
                .take_while(move |late| *late <= longest)
        };
        let late = |late_s: f64| Self { late_s, ..plain };
        match cause {
            Cause::Clock => vec![plain, Self { bent: true, ..plain }],
            Cause::Course(number) => {
                (0..problem.courses[number].shapes.len()).map(|shape| Self { shape, ..plain }).collect()
            }
            Cause::Time => {
                let powers = POWERS.into_iter().map(|power| Self { power: Some(power), ..plain });
                [plain].into_iter().chain(powers).chain(lates().map(late)).collect()
            }
            Cause::Covariate(number) => {
                let covariate = &problem.covariates[number];
                let bent = covariate.bends().then_some(Self { bent: true, ..plain });
                let powers = POWERS.into_iter().filter(|_| covariate.bends() && covariate.is_from_zero());
                let powers = powers.map(|power| Self { power: Some(power), ..plain });
                let rows = (1..=ROWS).flat_map(|rows| [rows, -rows]).map(|rows| Self { rows, ..plain });
                let lined =
                    lates().filter(|_| covariate.holds()).map(|late_s| Self { late_s, lines: true, ..plain });
                let curved = bent.into_iter().chain(powers);
                [plain].into_iter().chain(curved).chain(rows).chain(lates().map(late)).chain(lined).collect()
            }
        }
    }

    /// The columns of a covariate in this form at some times, each about its mean.
    pub fn of(&self, covariate: &Covariate, at_s: &[f64]) -> Vec<Vec<f64>> {
        self.about(covariate, at_s).0
    }

    /// The same, and the mean of the first.
    pub fn about(&self, covariate: &Covariate, at_s: &[f64]) -> (Vec<Vec<f64>>, f64) {
        let mut values = covariate.shifted(self.rows);
        if let Some(power) = self.power {
            values.iter_mut().for_each(|value| *value = value.abs().powf(power).copysign(*value));
        }
        let held = covariate.holds() && !self.lines;
        let late = |late_s: f64| {
            sampled(&covariate.time_s, &relaxed(&covariate.time_s, &values, late_s, held), at_s, held)
        };
        let own = if self.late_s > 0.0 {
            late(self.late_s)
        } else {
            sampled(&covariate.time_s, &values, at_s, held)
        };
        let mean = estimate::stats::mean(&own);
        let straight = centred(own);
        let square = self.bent.then(|| centred(straight.iter().map(|x| x * x).collect()));
        let fast = self.fast.then(|| centred(late(self.late_s / FASTER)));
        ([straight].into_iter().chain(square).chain(fast).collect(), mean)
    }

    /// The same with another relaxation.
    pub fn late(&self, late_s: f64) -> Self {
        Self { late_s, ..*self }
    }

    /// Time, a power of it, or an exponential that dies out.
    pub fn of_time(&self, at_s: &[f64]) -> Vec<Vec<f64>> {
        let first = at_s.first().copied().unwrap_or(0.0);
        let of = |t: &f64| match self.power {
            Some(power) => (t - first).powf(power),
            None if self.late_s > 0.0 => (-(t - first) / self.late_s).exp(),
            None => t - first,
        };
        vec![centred(at_s.iter().map(of).collect())]
    }

    /// The rates of the channels, and these times the time from the middle.
    pub fn of_clock(&self, at_s: &[f64], rates: &[Vec<f64>]) -> Vec<Vec<Vec<f64>>> {
        let middle = at_s.first().zip(at_s.last()).map_or(0.0, |(first, last)| 0.5 * (first + last));
        let growing = |rate: &Vec<f64>| rate.iter().zip(at_s).map(|(rate, t)| rate * (t - middle)).collect();
        let more = self.bent.then(|| rates.iter().map(growing).collect());
        [rates.to_vec()].into_iter().chain(more).collect()
    }

    /// The same with other relaxations around its own.
    pub fn near(&self, by: f64) -> Vec<Self> {
        [-2.0, -1.0, 1.0, 2.0]
            .map(|power: f64| Self { late_s: self.late_s * by.powf(power), ..*self })
            .to_vec()
    }

    /// The same without a fast part, and with one that is as fast as this or faster.
    pub fn through(&self) -> Vec<Self> {
        let with = |times: f64| Self { fast: true, ..self.late(times * self.late_s) };
        vec![Self { fast: false, ..*self }, with(1.0), with(FASTER.sqrt()), with(FASTER)]
    }
}

impl Covariate {
    /// Whether it keeps its value from one sample to the next.
    pub fn holds(&self) -> bool {
        let same = self.values.windows(2).filter(|pair| pair[0] == pair[1]).count();
        same as f64 > HELD * self.values.len() as f64
    }

    fn bends(&self) -> bool {
        let mut values = self.values.clone();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values.len() >= BENT
    }

    /// Whether it has one sign, and comes near zero.
    fn is_from_zero(&self) -> bool {
        let (low, high) =
            self.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(*value), high.max(*value))
            });
        low * high >= 0.0 && low.abs().min(high.abs()) <= FROM_ZERO * low.abs().max(high.abs())
    }

    /// Its samples moved by whole ones; the ends are held.
    fn shifted(&self, rows: i32) -> Vec<f64> {
        let last = self.values.len() as i64 - 1;
        (0..=last).map(|row| self.values[(row + i64::from(rows)).clamp(0, last) as usize]).collect()
    }
}

/// First-order relaxation τ dx/dt = u − x at the times of the samples, in equilibrium at the first; u keeps its
/// sample until the next, or goes to it on a straight line.
fn relaxed(time_s: &[f64], u: &[f64], late_s: f64, held: bool) -> Vec<f64> {
    let mut x = u.first().copied().unwrap_or(0.0);
    let (mut steps, mut kept) = (0.0, 1.0);
    let mut all = Vec::with_capacity(u.len());
    for row in 0..u.len() {
        if row > 0 {
            let next = (time_s[row] - time_s[row - 1]) / late_s;
            if next != steps {
                (steps, kept) = (next, (-next).exp());
            }
            let (from, to) = (u[row - 1], u[row]);
            // On a line the answer lags by τ behind it.
            let slope = if held || steps == 0.0 { 0.0 } else { (to - from) / steps };
            let end = if held { from } else { to };
            x = end - slope + kept * (x - (from - slope));
        }
        all.push(x);
    }
    all
}

/// Time constants by which a series is extended at its ends to be smoothed.
const BEYOND: f64 = 20.0;

/// A series without what is faster than a time constant, and without delay: the mean of what a relaxation makes of
/// it forwards and backwards. Its ends are extended by reflection through the end points, so that a slope of a series longer
/// than 20 time constants passes unchanged.
pub fn smoothed(time_s: &[f64], u: &[f64], late_s: f64) -> Vec<f64> {
    let last = time_s.len().saturating_sub(1);
    let about = |end: usize, row: usize| (2.0 * time_s[end] - time_s[row], 2.0 * u[end] - u[row]);
    let is_near = |end: usize, row: usize| (time_s[row] - time_s[end]).abs() <= BEYOND * late_s;
    let before = (1..=last).take_while(|row| is_near(0, *row)).count();
    let rows = time_s.iter().copied().zip(u.iter().copied());
    let all = (1..=before).rev().map(|row| about(0, row)).chain(rows);
    let after = (0..last).rev().take_while(|row| is_near(last, *row)).map(|row| about(last, row));
    let (time, series): (Vec<f64>, Vec<f64>) = all.chain(after).unzip();
    let turned = |series: &[f64]| -> Vec<f64> { series.iter().rev().copied().collect() };
    let back: Vec<f64> = time.iter().rev().map(|t| -t).collect();
    let forwards = relaxed(&time, &series, late_s, false);
    let backwards = turned(&relaxed(&back, &turned(&series), late_s, false));
    let both = forwards.iter().zip(&backwards).map(|(a, b)| 0.5 * (a + b));
    both.skip(before).take(u.len()).collect()
}

/// Samples at other times; beyond their ends the first and the last.
pub fn sampled(time_s: &[f64], values: &[f64], at_s: &[f64], held: bool) -> Vec<f64> {
    let mut after = 0;
    let at = |t: &f64| {
        while after < time_s.len() && time_s[after] <= *t {
            after += 1;
        }
        match after {
            0 => values[0],
            k if k == time_s.len() || held || time_s[k - 1] == *t => values[k - 1],
            k => {
                let share = (t - time_s[k - 1]) / (time_s[k] - time_s[k - 1]);
                values[k - 1] + share * (values[k] - values[k - 1])
            }
        }
    };
    at_s.iter().map(at).collect()
}

fn centred(mut column: Vec<f64>) -> Vec<f64> {
    let mean = estimate::stats::mean(&column);
    column.iter_mut().for_each(|value| *value -= mean);
    column
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_is_smooth_up_to_its_ends() {
        let time: Vec<f64> = (0..6000).map(|k| f64::from(k) + if k < 100 { 0.0 } else { 37.0 }).collect();
        let slope: Vec<f64> = time.iter().map(|t| 25_000.0 - 30.0 * t).collect();
        for late_s in [4.0, 32.0, 256.0] {
            let found = smoothed(&time, &slope, late_s);
            assert!(found.iter().zip(&slope).all(|(a, b)| (a - b).abs() < 1e-3), "{late_s}");
        }
        assert_eq!((smoothed(&[], &[], 4.0).len(), smoothed(&[1.0], &[7.0], 4.0)), (0, vec![7.0]));
    }

    fn covariate(values: &[f64]) -> Covariate {
        Covariate {
            name: "load_a".into(),
            time_s: (0..values.len()).map(|t| t as f64).collect(),
            values: values.into(),
        }
    }

    #[test]
    fn a_relaxation_of_a_ramp_lags_by_its_time_constant() {
        let time: Vec<f64> = (0..200).map(f64::from).collect();
        let x = relaxed(&time, &time, 5.0, false);
        assert!((x[199] - (199.0 - 5.0)).abs() < 1e-9);
        let step: Vec<f64> = time.iter().map(|t| f64::from(u8::from(*t >= 10.0))).collect();
        let x = relaxed(&time, &step, 5.0, true);
        assert!(x[10] == 0.0 && (x[15] - (1.0 - (-1f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn samples_are_held_or_on_lines_and_rows_are_counted_in_samples() {
        let (time, values) = ([0.0, 2.0], [1.0, 5.0]);
        assert_eq!(sampled(&time, &values, &[-1.0, 0.0, 1.0, 2.0, 3.0], false), [1.0, 1.0, 3.0, 5.0, 5.0]);
        assert_eq!(sampled(&time, &values, &[1.9, 2.0], true), [1.0, 5.0]);
        assert_eq!(covariate(&[1.0, 2.0, 3.0]).shifted(1), [2.0, 3.0, 3.0]);
        assert_eq!(covariate(&[1.0, 2.0, 3.0]).shifted(-1), [1.0, 1.0, 2.0]);
        let root = Form { power: Some(0.5), ..Form::default() };
        assert_eq!(root.of(&covariate(&[0.0, 4.0, 16.0]), &[0.0, 1.0, 2.0]), [[-2.0, 0.0, 2.0]]);
        let through = Form { late_s: 8.0, fast: true, ..Form::default() };
        let [slow, fast] = [8.0, 1.0].map(|late_s| Form::default().late(late_s));
        let (load, at) = (covariate(&[0.0, 3.0, 1.0]), [0.0, 1.0, 2.0]);
        assert_eq!(through.of(&load, &at), [slow.of(&load, &at), fast.of(&load, &at)].concat());
        assert!(covariate(&[0.0, 0.0, 0.0, 1.0, 1.0]).holds() && !covariate(&[0.0, 0.1, 0.2]).holds());
    }
}
