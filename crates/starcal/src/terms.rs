//! What the coefficients of a flight are made of: the twelve of the sensors and the first camera, and what may add to
//! them, each a few directions in the space of all coefficients.

use common::{AttitudeFrame, Axis};
use nalgebra::{Matrix3, Vector3};
use physics::frames::ARCSEC;
use physics::{Kind, SUN_HARMONICS};

use crate::axes::Axes;
use crate::layout::{FIELD_NT, Layout, SUN, Signal, WARM_K};

/// Harmonics of the Sun's direction in the order of the effect of the first degree: lit, cosine, sine, up.
const FIRST_DEGREE: [usize; 4] = [0, 2, 3, 1];

/// One parameter: what it adds to the coefficients for each of its units. Coefficients are three components, each of all
/// signals, then the delays.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    pub coefficients: Vec<(usize, f64)>,
    /// Times the time, which runs from −1 to 1.
    pub by_time: bool,
}

impl Direction {
    /// How much it counts at a time.
    pub fn factor(&self, time: f64) -> f64 {
        if self.by_time { time } else { 1.0 }
    }
}

/// What something follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Follows {
    Temperature(usize),
    Time,
}

/// A term beside the twelve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    /// The first camera turns against the sensors.
    Turn(Follows),
    Offset(Follows),
    Scale(Follows),
    Current(usize),
    /// The field of the Sun's direction, to the first degree, and that of the second.
    Sun,
    SunBeyond,
    /// The readings, the attitudes or the rotation of the Earth are shifted in time.
    Readings,
    Attitude,
    Earth,
}

impl Term {
    /// All that the columns allow.
    pub fn all(layout: &Layout) -> Vec<Self> {
        let mut all = Vec::new();
        for follows in Follows::all(layout) {
            all.push(Self::Turn(follows));
            let column = follows.column(layout);
            if column.is_none_or(|name| ["sensor_temperature_c", "electronics_temperature_c"].contains(&name))
            {
                all.extend([Self::Offset(follows), Self::Scale(follows)]);
            }
        }
        all.extend((0..layout.currents.len()).map(Self::Current));
        all.extend([Self::Sun, Self::SunBeyond].into_iter().filter(|_| layout.sun));
        all.extend([Self::Readings, Self::Attitude]);
        all.extend(Some(Self::Earth).filter(|_| layout.frame == AttitudeFrame::Icrf));
        all
    }

    /// The effect of the catalogue that it is, for each sensor or with a column.
    pub fn kind(self, layout: &Layout) -> Option<Kind> {
        let electronics = self.column(layout) == Some("electronics_temperature_c");
        let name = match self {
            Self::Offset(Follows::Temperature(_)) if electronics => "offset_electronics_temperature",
            Self::Scale(Follows::Temperature(_)) if electronics => "sensitivity_electronics_temperature",
            Self::Offset(Follows::Temperature(_)) => "offset_temperature",
            Self::Scale(Follows::Temperature(_)) => "sensitivity_temperature",
            Self::Current(_) => "stray_current",
            Self::Sun => "sun_thermoelectric",
            Self::SunBeyond => "sun_thermoelectric_harmonics",
            _ => return None,
        };
        Kind::named(name)
    }

    /// The simpler term without which it is not looked at.
    pub fn after(self) -> Option<Self> {
        (self == Self::SunBeyond).then_some(Self::Sun)
    }

    pub fn column(self, layout: &Layout) -> Option<&str> {
        match self {
            Self::Turn(follows) | Self::Offset(follows) | Self::Scale(follows) => follows.column(layout),
            Self::Current(number) => Some(&layout.currents[number]),
            _ => None,
        }
    }

    /// Names of its parameters with their units, and how much one of the fit's units is in them; `day` is a day in units
    /// of the time.
    pub fn parameters(self, layout: &Layout, day: f64) -> Vec<(String, f64)> {
        match self {
            Self::Turn(follows) => follows.parameters("arcsec", day),
            Self::Offset(follows) => follows.parameters("nt", day),
            Self::Scale(follows) => follows.parameters("ppm", day),
            Self::Current(_) => Axis::ALL.map(|axis| (format!("{axis}_nt_per_a"), 1.0)).to_vec(),
            Self::Sun | Self::SunBeyond => {
                let infos = self.kind(layout).map_or(&[][..], |kind| kind.parameters());
                let degrees = if self == Self::Sun { 0..SUN_HARMONICS } else { FIRST_DEGREE.len()..SUN };
                let beyond = |(k, _): &(usize, _)| degrees.contains(&(k % SUN_HARMONICS));
                let all = infos.iter().enumerate().filter(beyond);
                all.map(|(_, info)| (info.name.to_string(), 1.0)).collect()
            }
            Self::Readings => vec![("readings_late_s".into(), 1.0)],
            Self::Attitude => vec![("attitude_late_s".into(), 1.0)],
            Self::Earth => vec![("utc_later_s".into(), 1.0)],
        }
    }

    /// Its directions, about sensors and camera as they were found.
    pub fn directions(self, layout: &Layout, axes: &Axes) -> Vec<Direction> {
        let space = Space { signals: layout.signals(0) };
        let count = space.signals.len();
        let field = |signal: Signal| {
            Axis::ALL.map(|axis| {
                let by = -axes.turn.column(axis.index()).into_owned();
                Direction { coefficients: space.at(&signal, by), by_time: false }
            })
        };
        let zero = Matrix3::zeros();
        let followed = |follows, linear, constant| space.followed(follows, &linear, &constant);
        let delay = |number: usize, size: f64| {
            vec![Direction { coefficients: vec![(3 * count + number, size)], by_time: false }]
        };
        match self {
            Self::Turn(follows) => {
                let of = |k: usize| followed(follows, turned(k) * axes.linear, turned(k) * axes.constant);
                (0..3).map(of).collect()
            }
            Self::Offset(follows) => (0..3).map(|k| followed(follows, zero, -axes.unit(k))).collect(),
            Self::Scale(follows) => {
                let of = |k: usize| {
                    let mut linear = zero;
                    linear.set_column(k, &(-1e-6 * axes.k[k] * axes.unit(k)));
                    followed(follows, linear, -1e-6 * axes.offset_nt[k] * axes.unit(k))
                };
                (0..3).map(of).collect()
            }
            Self::Current(number) => field(Signal::Current(number)).to_vec(),
            Self::Sun | Self::SunBeyond => {
                let beyond: Vec<usize> = (FIRST_DEGREE.len()..SUN).collect();
                let places = if self == Self::Sun { &FIRST_DEGREE[..] } else { &beyond };
                let by_axis =
                    |k: usize| places.iter().map(move |place| field(Signal::Sun(*place))[k].clone());
                (0..3).flat_map(by_axis).collect()
            }
            Self::Readings => delay(0, 1.0),
            Self::Attitude => delay(1, -1.0),
            Self::Earth => delay(2, -1.0),
        }
    }
}

impl Follows {
    pub fn all(layout: &Layout) -> Vec<Self> {
        (0..layout.temperatures.len()).map(Self::Temperature).chain([Self::Time]).collect()
    }

    pub fn column(self, layout: &Layout) -> Option<&str> {
        match self {
            Self::Temperature(number) => Some(&layout.temperatures[number]),
            Self::Time => None,
        }
    }

    /// Names of three parameters that follow it, and how much one of the fit's units is in them.
    pub fn parameters(self, unit: &str, day: f64) -> Vec<(String, f64)> {
        let (ending, factor) = match self {
            Self::Temperature(_) => ("k", 1.0),
            Self::Time => ("day", day),
        };
        Axis::ALL.map(|axis| (format!("{axis}_{unit}_per_{ending}"), factor)).to_vec()
    }
}

/// The space of the coefficients of a camera.
pub struct Space {
    pub signals: Vec<Signal>,
}

impl Space {
    /// A vector as the coefficients of a signal.
    pub fn at(&self, signal: &Signal, vector: Vector3<f64>) -> Vec<(usize, f64)> {
        let place = self.signals.iter().position(|one| one == signal);
        let of = |place: usize| (0..3).map(move |k| (k * self.signals.len() + place, vector[k]));
        place.into_iter().flat_map(of).collect()
    }

    /// The readings by a matrix, and one by a vector where it is a signal.
    pub fn still(&self, linear: &Matrix3<f64>, constant: &Vector3<f64>) -> Direction {
        let all = [0, 1, 2].map(|axis| (Signal::Reading(axis), linear.column(axis) * FIELD_NT));
        let all = all.into_iter().chain([(Signal::One, *constant)]);
        Direction {
            coefficients: all.flat_map(|(signal, by)| self.at(&signal, by)).collect(),
            by_time: false,
        }
    }

    /// The same times what is followed.
    pub fn followed(&self, follows: Follows, linear: &Matrix3<f64>, constant: &Vector3<f64>) -> Direction {
        let Follows::Temperature(number) = follows else {
            return Direction { by_time: true, ..self.still(linear, constant) };
        };
        let all = [0, 1, 2].map(|axis| (Signal::WarmReading(number, axis), linear.column(axis) * FIELD_NT));
        let all = all.into_iter().chain([(Signal::Warmth(number), *constant)]);
        let coefficients = all.flat_map(|(signal, by)| self.at(&signal, by * WARM_K)).collect();
        Direction { coefficients, by_time: false }
    }
}

/// What an arcsecond of a camera's turn about one of its axes adds to a field in its frame.
pub fn turned(axis: usize) -> Matrix3<f64> {
    -ARCSEC * Vector3::ith(axis, 1.0).cross_matrix()
}

/// The twelve: the coefficients of the three readings and of one.
pub fn twelve(count: usize) -> Vec<Direction> {
    let place = |k: usize| (k / 4) * count + k % 4;
    let of = |k: usize| Direction { coefficients: vec![(place(k), 1.0)], by_time: false };
    (0..12).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_parameter_has_a_direction() {
        let words = |text: &str| text.split(' ').map(String::from).collect();
        let layout = Layout {
            frame: AttitudeFrame::Icrf,
            cameras: vec![1],
            temperatures: words("electronics_temperature_c bench_temperature_c"),
            currents: words("panel_a torquer_a"),
            sun: true,
            ..Layout::default()
        };
        let twelve: Vec<f64> = (0..12).map(|k| if k % 5 == 0 { FIELD_NT } else { 0.1 * k as f64 }).collect();
        let axes = Axes::of(&twelve, &Matrix3::identity()).expect("axes");
        let all = Term::all(&layout);
        assert_eq!(all.len(), 14, "{all:?}");
        for term in all {
            let (names, directions) = (term.parameters(&layout, 1.0), term.directions(&layout, &axes));
            assert_eq!(names.len(), directions.len(), "{term:?}");
            let space = 3 * layout.signals(0).len() + crate::partial::DELAYS;
            assert!(directions.iter().flat_map(|one| &one.coefficients).all(|(place, _)| *place < space));
        }
    }
}
