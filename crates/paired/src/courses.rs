//! What acts on a pair without a column of its own: a sensor that answers late, is nonlinear or has a scale factor that
//! follows a temperature; a line, a step, codes that are coarse or uneven. Each is a course of the engine at the rows of a
//! problem. `striking` looks for those that are not weighed in any case.

use common::Column;
use explain::{Course, Covariate, Problem, Term, sampled};
use physics::FULL_NT;
use std::f64::consts::TAU;

use crate::look::turned;

/// Where no component of the field varies by so much, nT, a change of a scale factor cannot be told from one of an offset.
const TURNS_NT: f64 = 1000.0;
/// Steps so near, as a share of the length, are one.
const NEAR: f64 = 0.01;
/// Harmonics of uneven codes.
const HARMONICS: usize = 5;

/// What acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Acting {
    /// A sensor answers late: what is seen is the first order of its lag, be it constant or a loop's. What a loop does
    /// besides, noise of the reference does too.
    Late(usize),
    /// A field of one frequency, Hz.
    Line(f64),
    /// A sensor's readings are whole numbers of codes so wide, nT.
    Coarse(usize, f64),
    /// A sensor's codes are uneven with a period.
    Uneven(usize, Uneven),
    /// The level changes at a time, s.
    Step(f64),
    /// What was given with this number.
    Given(usize),
    /// A sensor's response has a term in this power of the field along it.
    Nonlinear(usize, i32),
    /// A sensor's scale factor follows the covariate with this number.
    ScaleFactor(usize, usize),
}

/// What repeats along a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uneven {
    /// Period of its harmonics, nT.
    pub period_nt: f64,
    /// Where it is a bit of a wrong weight: twice the bit's width, nT, and from which share of that on it is set.
    pub bit: (f64, f64),
}

/// A course that is known beforehand, in some shapes.
#[derive(Clone, Debug)]
pub struct Given {
    /// Rising times of its samples, s.
    pub time_s: Vec<f64>,
    /// Its samples in each shape.
    pub shapes: Vec<Vec<f64>>,
}

/// The sensors of the instrument under test at the rows of a problem.
pub struct Sensors {
    /// The field in each, nT.
    fields: Vec<Vec<f64>>,
    /// What each reads more for each second that it is late, nT/s.
    late: Vec<Vec<f64>>,
    /// What one nT more in each is in each channel.
    shows: Vec<Vec<f64>>,
}

impl Sensors {
    /// Of the reference, its rates with the sign of what is late, and how each channel answers: three channels are
    /// sensors beside the reference; one is a magnitude beside the sensors.
    pub fn of(base: &[Vec<f64>], late: &[Vec<f64>; 3], answers: &[[f64; 3]]) -> Self {
        let components: [Vec<f64>; 3] = std::array::from_fn(|component| base[component].clone());
        if let [answer] = answers {
            let shows = answer.iter().map(|slope| vec![-slope]).collect();
            return Self { fields: components.into(), late: late.to_vec(), shows };
        }
        let of = |columns: &[Vec<f64>; 3]| answers.iter().map(|answer| turned(columns, answer)).collect();
        let own = |sensor: usize| {
            (0..answers.len()).map(|channel| f64::from(u8::from(channel == sensor))).collect()
        };
        Self { fields: of(&components), late: of(late), shows: (0..answers.len()).map(own).collect() }
    }

    pub fn at(&self, rows: &[usize]) -> Self {
        let of = |columns: &[Vec<f64>]| {
            columns.iter().map(|column| rows.iter().map(|row| column[*row]).collect()).collect()
        };
        Self { fields: of(&self.fields), late: of(&self.late), shows: self.shows.clone() }
    }

    pub fn count(&self) -> usize {
        self.fields.len()
    }

    /// The channel in which a sensor shows alone; None beside a magnitude.
    pub fn channel(&self, sensor: usize) -> Option<usize> {
        (self.shows[sensor].len() > 1).then_some(sensor)
    }

    /// What is read more in a sensor, in each channel.
    fn shown(&self, sensor: usize, more: &[f64]) -> Term {
        let of = |shows: &f64| more.iter().map(|value| shows * value).collect();
        Term::Tied(self.shows[sensor].iter().map(of).collect())
    }

    /// The field in the sensor of a channel; beside a magnitude what is read but for what is left.
    pub fn seen(&self, problem: &Problem, channel: usize, left: &[f64]) -> Vec<f64> {
        match self.channel(channel) {
            Some(_) => self.fields[channel].clone(),
            None => less(&problem.channels[channel], left),
        }
    }

    /// What a sensor reads but for what is left.
    pub fn predicted(&self, problem: &Problem, sensor: usize, left: &[Vec<f64>]) -> Vec<f64> {
        match self.channel(sensor) {
            Some(channel) => less(&problem.channels[channel], &left[channel]),
            None => self.fields[sensor].clone(),
        }
    }
}

impl Acting {
    /// Its course at the rows of a problem of which so much is left; it was found among so many.
    pub fn course(
        &self,
        (problem, sensors): (&Problem, &Sensors),
        left: &[Vec<f64>],
        given: &[Given],
        looks: f64,
    ) -> Course {
        let shapes = match *self {
            Self::Late(sensor) => vec![vec![sensors.shown(sensor, &sensors.late[sensor])]],
            Self::Nonlinear(sensor, power) => {
                let more = sensors.fields[sensor].iter().map(|nt| (nt / FULL_NT).powi(power));
                vec![vec![sensors.shown(sensor, &more.collect::<Vec<f64>>())]]
            }
            Self::ScaleFactor(sensor, number) => {
                let of = &problem.covariates[number];
                let along = sampled(&of.time_s, &of.values, &problem.time_s, of.holds());
                let mean = estimate::stats::mean(&along);
                let more = sensors.fields[sensor].iter().zip(&along).map(|(nt, at)| nt * (at - mean));
                vec![vec![sensors.shown(sensor, &more.collect::<Vec<f64>>())]]
            }
            Self::Given(number) => {
                let Given { time_s, shapes, .. } = &given[number];
                let at =
                    |values: &Vec<f64>| vec![Term::Alike(sampled(time_s, values, &problem.time_s, false))];
                shapes.iter().map(at).collect()
            }
            Self::Step(_) | Self::Line(_) => {
                let columns = self.of_time(&problem.time_s).unwrap_or_default();
                vec![columns.into_iter().map(Term::Alike).collect()]
            }
            Self::Coarse(sensor, width_nt) => {
                let error = coarse(&sensors.predicted(problem, sensor, left), width_nt);
                vec![vec![sensors.shown(sensor, &error)]]
            }
            Self::Uneven(sensor, Uneven { period_nt, bit: (width_nt, from) }) => {
                let along = sensors.predicted(problem, sensor, left);
                let harmonic =
                    |k: usize| waves(&along, k as f64 / period_nt).map(|wave| sensors.shown(sensor, &wave));
                let upto = |most: usize| (1..=most).flat_map(harmonic).collect();
                vec![vec![sensors.shown(sensor, &bit(&along, width_nt, from))], upto(1), upto(HARMONICS)]
            }
        };
        Course { shapes, looks }
    }

    /// The columns of what is known at any time.
    pub fn of_time(&self, time_s: &[f64]) -> Option<Vec<Vec<f64>>> {
        match *self {
            Self::Step(at_s) => Some(vec![time_s.iter().map(|t| f64::from(u8::from(*t >= at_s))).collect()]),
            Self::Line(hz) => Some(waves(time_s, hz).to_vec()),
            _ => None,
        }
    }

    /// Whether both would be found as one over times and fields of such lengths.
    pub fn is_near(&self, other: &Self, problem: &Problem, sensors: &Sensors) -> bool {
        match (*self, *other) {
            (Self::Line(a), Self::Line(b)) => (a - b).abs() * problem.length_s() < 1.0,
            (Self::Step(a), Self::Step(b)) => are_one_step(a, b, problem.length_s()),
            (Self::Coarse(own, a), Self::Coarse(sensor, b))
            | (
                Self::Uneven(own, Uneven { period_nt: a, .. }),
                Self::Uneven(sensor, Uneven { period_nt: b, .. }),
            ) => own == sensor && (1.0 / a - 1.0 / b).abs() * range(&sensors.fields[own]) < 1.0,
            _ => self == other,
        }
    }

    /// What is weighed in any case for the sensors: late answers; where the field turns also nonlinear responses, and scale
    /// factors that follow a recorded temperature.
    pub fn usual(reference: &[Column; 3], covariates: &[Covariate]) -> Vec<Self> {
        let mut all: Vec<Self> = (0..3).map(Self::Late).collect();
        if reference.iter().any(|component| range(component) > TURNS_NT) {
            let warm = |number: &usize| covariates[*number].name.ends_with("_c");
            let warm: Vec<usize> = (0..covariates.len()).filter(warm).collect();
            for sensor in 0..3 {
                all.extend([2, 3].map(|power| Self::Nonlinear(sensor, power)));
                all.extend(warm.iter().map(|number| Self::ScaleFactor(sensor, *number)));
            }
        }
        all
    }

    /// Whether it is weighed in any case.
    pub fn is_usual(&self) -> bool {
        matches!(self, Self::Late(_) | Self::Given(_) | Self::Nonlinear(..) | Self::ScaleFactor(..))
    }
}

/// Whether steps at these times would be found as one in so long a series.
pub fn are_one_step(a_s: f64, b_s: f64, length_s: f64) -> bool {
    (a_s - b_s).abs() < NEAR * length_s
}

fn less(y: &[f64], left: &[f64]) -> Vec<f64> {
    y.iter().zip(left).map(|(y, left)| y - left).collect()
}

/// Sine and cosine along something.
pub fn waves(along: &[f64], frequency: f64) -> [Vec<f64>; 2] {
    let (sine, cosine) = along.iter().map(|x| (TAU * frequency * x).sin_cos()).unzip();
    [sine, cosine]
}

/// One where a bit is set, less a half.
pub fn bit(along: &[f64], period: f64, from: f64) -> Vec<f64> {
    along.iter().map(|x| if (x / period - from).rem_euclid(1.0) < 0.5 { 0.5 } else { -0.5 }).collect()
}

/// What rounding to whole codes adds.
pub fn coarse(along: &[f64], width: f64) -> Vec<f64> {
    along.iter().map(|x| width * (x / width).round() - x).collect()
}

pub fn range(of: &[f64]) -> f64 {
    let ends =
        of.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    ends.1 - ends.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_beside_a_magnitude_shows_with_its_slope() {
        let base = [vec![1.0, 2.0], vec![0.0, 0.0], vec![3.0, 5.0]];
        let late = [vec![-1.0, -1.0], vec![0.0, 0.0], vec![-2.0, -2.0]];
        let beside = Sensors::of(&base, &late, &[[0.6, 0.0, 0.8]]);
        let problem = Problem { time_s: vec![0.0, 1.0], ..Problem::default() };
        let course = Acting::Late(2).course((&problem, &beside), &[], &[], 1.0);
        // z reads less of a growing field than there is, and the magnitude more than what follows from it.
        let [Term::Tied(columns)] = &course.shapes[0][..] else { panic!("one column") };
        assert_eq!((columns.len(), &columns[0]), (1, &vec![1.6, 1.6]));
        let three = Sensors::of(&base, &late, &[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.1, 0.0, 1.0]]);
        let course = Acting::Late(2).course((&problem, &three), &[], &[], 1.0);
        let [Term::Tied(columns)] = &course.shapes[0][..] else { panic!("one column") };
        assert_eq!(columns, &[vec![0.0, 0.0], vec![0.0, 0.0], vec![-2.1, -2.1]]);
    }

    #[test]
    fn bits_and_codes_along_a_reading() {
        assert_eq!(bit(&[0.5, 1.5, 2.5, -0.5], 2.0, 0.0), [0.5, -0.5, 0.5, -0.5]);
        assert_eq!(bit(&[0.5, 1.5], 2.0, 0.5), [-0.5, 0.5]);
        assert_eq!(coarse(&[1.0, 4.0, 5.0], 4.0), [-1.0, 0.0, -1.0]);
        assert_eq!(range(&[3.0, -1.0, 2.0]), 4.0);
    }
}
