//! What acts beside another instrument without having been recorded, in the catalogue's names.

use common::{Axis, Document, Quantity, Recording};
use explain::{Amplitude, Cause};
use indexmap::IndexMap;
use paired::{Acting, Given, Uneven};
use physics::{Kind, machines_run};

use std::f64::consts::{PI, TAU};

use super::Compared;
use crate::lines::aliases;

/// A period is a width within this share.
const ALIKE: f64 = 0.1;
/// Moments at which machines start.
const STARTS: usize = 30;

/// Hours in which machines come to run, and stop.
const RAMPS_H: [f64; 4] = [0.0, 0.25, 0.5, 1.0];

/// How far machines run by the clocks of some recordings, where they begin with one.
pub fn working_hours(document: &Document, recordings: &[String]) -> Option<Given> {
    let of = |recording: &Recording| Some((recording.start()?, recording.column("time_s")?.to_vec()));
    let own = document.recordings.iter().filter(|recording| recordings.contains(&recording.id));
    let clocks: Vec<_> = own.filter_map(of).collect();
    let earliest = clocks.iter().map(|(start, _)| start.unix_s).fold(f64::INFINITY, f64::min);
    let mut all: Vec<(f64, [f64; 4])> = Vec::new();
    for (start, times) in clocks {
        let running = |t: &f64| RAMPS_H.map(|ramp_h| share_running(start.local_s() + t, ramp_h));
        all.extend(times.iter().filter(|t| t.is_finite()).map(|t| (start.unix_s - earliest + t, running(t))));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.dedup_by(|a, b| a.0 == b.0);
    let changes = all.iter().any(|(_, running)| running[0] != all[0].1[0]);
    let shape = |ramp: usize| all.iter().map(|(_, running)| running[ramp]).collect();
    changes.then(|| Given {
        time_s: all.iter().map(|(t, _)| *t).collect(),
        shapes: (0..RAMPS_H.len()).map(shape).collect(),
    })
}

/// How many of the machines run that start one after the other, and stop so: the mean over the slack.
fn share_running(local_s: f64, ramp_h: f64) -> f64 {
    let runs = |k: usize| machines_run(local_s, ramp_h * (k as f64 + 0.5) / STARTS as f64);
    (0..STARTS).filter(|k| runs(*k)).count() as f64 / STARTS as f64
}

/// What a cause is, where it is a course. Coarse codes repeat along the reading as uneven ones do.
fn acting(compared: &Compared, cause: Cause) -> Option<Acting> {
    let Cause::Course(number) = cause else { return None };
    let acting = compared.of.acting[number];
    let Acting::Uneven(sensor, uneven) = acting else { return Some(acting) };
    Some(compared.coarse_nt(sensor, uneven).map_or(acting, |width| Acting::Coarse(sensor, width)))
}

pub fn sensor(compared: &Compared, cause: Cause) -> Option<Axis> {
    match acting(compared, cause)? {
        Acting::Line(_) | Acting::Step(_) | Acting::Given(_) => None,
        Acting::Late(sensor)
        | Acting::Coarse(sensor, _)
        | Acting::Uneven(sensor, _)
        | Acting::Nonlinear(sensor, _)
        | Acting::ScaleFactor(sensor, _) => Some(Axis::ALL[sensor]),
    }
}

/// The effect that it is in a form.
pub fn kind(compared: &Compared, cause: Cause) -> Option<Kind> {
    Some(match acting(compared, cause)? {
        Acting::Late(_) => Kind::Delay,
        Acting::Line(hz) => line(compared, hz).0,
        Acting::Coarse(..) => Kind::Quantisation,
        Acting::Given(_) => Kind::WorkingHours,
        Acting::Step(_) => Kind::ReadingStep,
        Acting::Uneven(..) => Kind::DifferentialNonlinearity,
        Acting::Nonlinear(_, 2) => Kind::QuadraticNonlinearity,
        Acting::Nonlinear(..) => Kind::CubicNonlinearity,
        Acting::ScaleFactor(_, number) if compared.covariate(number).name.contains("electronics") => {
            Kind::SensitivityElectronicsTemperature
        }
        Acting::ScaleFactor(..) => Kind::SensitivityTemperature,
    })
}

/// The source that a line's frequency is an alias of.
fn line(compared: &Compared, hz: f64) -> (Kind, f64) {
    aliases(hz, compared.of.frame.step_s.recip()).first().copied().unwrap_or((Kind::PeriodicField, hz))
}

/// The column that it follows.
pub fn column(compared: &Compared, cause: Cause) -> Option<&str> {
    let Acting::ScaleFactor(_, number) = acting(compared, cause)? else { return None };
    Some(&compared.covariate(number).name)
}

pub fn name(compared: &Compared, cause: Cause) -> String {
    let kind = kind(compared, cause).map_or("", Kind::name);
    let of = sensor(compared, cause).map_or(kind.into(), |axis| format!("{kind} {axis}"));
    match column(compared, cause) {
        Some(column) => format!("{of} by {column}"),
        None => of,
    }
}

/// The name that it has as a loop's lag, where it may be one.
pub fn loop_name(compared: &Compared, cause: Cause) -> Option<String> {
    let Acting::Late(sensor) = acting(compared, cause)? else { return None };
    Some(format!("{} {}", Kind::LoopBandwidth.name(), Axis::ALL[sensor]))
}

pub fn parameters(compared: &Compared, one: &Amplitude) -> IndexMap<String, Quantity> {
    let mut all = IndexMap::new();
    let first = |place: usize| one.channels[0].get(place).cloned().unwrap_or(Quantity::Bare(0.0));
    match acting(compared, one.cause) {
        Some(Acting::Late(_)) => all.insert("delay_s".into(), first(0)),
        Some(Acting::Given(_)) => return compared.by_axis(one, &["nt"]),
        Some(Acting::Line(hz)) => {
            all = compared.by_axis(one, &["sine_nt", "cosine_nt"]);
            let of_all = one.channels.iter().map(Vec::as_slice);
            all.insert("frequency_hz".into(), compared.frequency(line(compared, hz).1, of_all))
        }
        Some(Acting::Nonlinear(..)) => all.insert("departure_nt".into(), first(0)),
        Some(Acting::ScaleFactor(..)) => {
            all.insert("coefficient_ppm_per_k".into(), super::effects::times(&first(0), 1e6))
        }
        Some(Acting::Coarse(_, width)) => all.insert("width_nt".into(), Quantity::Bare(width)),
        // The odd harmonics of a square wave of this height.
        Some(Acting::Uneven(_, Uneven { bit: (period, from), .. })) if one.form.shape == 0 => {
            for k in [1, 3, 5] {
                let (sine, cosine) = (TAU * f64::from(k) * from).sin_cos();
                let size = 2.0 / (PI * f64::from(k));
                for (part, times) in [("sine", size * cosine), ("cosine", -size * sine)] {
                    all.insert(harmonic(part, k), super::effects::times(&first(0), times));
                }
            }
            all.insert("period_nt".into(), Quantity::Bare(period))
        }
        Some(Acting::Uneven(_, uneven)) => {
            let sizes = one.channels.iter().max_by_key(|own| own.len()).into_iter().flatten();
            for (place, quantity) in sizes.enumerate() {
                all.insert(harmonic(["sine", "cosine"][place % 2], place as i32 / 2 + 1), quantity.clone());
            }
            all.insert("period_nt".into(), Quantity::Bare(uneven.period_nt))
        }
        Some(Acting::Step(at_s)) => {
            for (quantities, (_, axis)) in one.channels.iter().zip(&compared.channels) {
                let name = axis.map_or("height_nt".into(), |axis| format!("{axis}_height_nt"));
                all.insert(name, quantities[0].clone());
            }
            all.insert("time_s".into(), Quantity::Bare(at_s))
        }
        None => None,
    };
    all
}

/// The name of a part of a harmonic.
fn harmonic(part: &str, k: i32) -> String {
    if k == 1 { format!("{part}_nt") } else { format!("{part}_{k}_nt") }
}

impl Compared {
    /// The width of a sensor's coarse codes, nT, where what repeats along its reading does so with them.
    fn coarse_nt(&self, sensor: usize, uneven: Uneven) -> Option<f64> {
        let mut widths =
            self.coarse.iter().filter(|(axis, _)| axis.index() == sensor).map(|(_, width)| *width);
        widths.find(|width| (uneven.period_nt / width - 1.0).abs() < ALIKE)
    }

    /// A frequency with its uncertainty, by what the sizes of sines and cosines are uncertain: σ_f = √3 σ_A/(π T A)
    /// for one line (Rife and Boorstyn 1974, IEEE Trans. Inf. Theory 20, 591).
    fn frequency<'q>(&self, hz: f64, of: impl Iterator<Item = &'q [Quantity]>) -> Quantity {
        let ratio = |own: &[Quantity]| {
            let square: f64 = own.iter().map(|size| size.value().powi(2)).sum();
            let variance: f64 = own.iter().map(|size| size.std().unwrap_or(0.0).powi(2)).sum();
            square / (variance / own.len() as f64)
        };
        let information: f64 = of.map(ratio).filter(|ratio| ratio.is_finite()).sum();
        Quantity::new(hz, (3.0 / information).sqrt() / (PI * self.of.problem.length_s()))
    }
}
