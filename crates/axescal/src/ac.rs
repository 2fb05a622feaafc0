//! AC drive: the amplitude of every channel in phase with the drive (NASA, "Errors in Magnetic Axis
//! Orientation Given Direction Cosines of the Calibration Coils").

use common::number::{significant, uncertain};
use common::{Axis, Code, Instrument, PhaseResult, Quantity};
use estimate::sine::{self, Basis, Quantiser, Sine};
use estimate::stats;
use nalgebra::{Complex, DMatrix, DVector, Vector3};
use physics::{Basic, Context};
use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, PoisonError, RwLock};

use crate::added::Added;
use crate::observations::{Observation, Observations, sensor_column};
use crate::{Error, Result};

/// Phases with a smaller chance than this, among all sensors, are reported as a finding.
const PHASE_P: f64 = 1e-3;

/// A run that is shorter than this many cycles does not tell a sine from a drift.
const LEAST_CYCLES: f64 = 0.99;
/// Coils whose currents differ in phase by more than this are out of phase, rad.
const OUT_OF_PHASE: f64 = 1e-6;
/// No amplitude is better known than this share of the drive: rounding.
const LEAST_STD: f64 = 1e-11;

/// What one AC run gives: phasors relative to the coil with the largest drive.
pub struct AcRun {
    recording: usize,
    orientation: usize,
    hz: f64,
    /// Each coil's phasor, turned so that the largest is real, nT.
    drive_nt: Vector3<Complex<f64>>,
    /// Each sensor's phasor and the standard uncertainty of its parts, nT.
    sensors: Vec<(Axis, Complex<f64>, f64)>,
}

/// Sines fitted to the channels of AC runs: however often effects are subtracted, each is fitted once.
#[derive(Default)]
pub struct Fits {
    sines: RwLock<HashMap<(usize, String), Sine>>,
    /// By recording, whose times are those of all its series.
    bases: RwLock<HashMap<usize, Arc<Basis>>>,
}

fn once<K: Eq + Hash, V: Clone, E>(
    made: &RwLock<HashMap<K, V>>,
    key: K,
    make: impl FnOnce() -> Result<V, E>,
) -> Result<V, E> {
    if let Some(value) = made.read().unwrap_or_else(PoisonError::into_inner).get(&key) {
        return Ok(value.clone());
    }
    let value = make()?;
    made.write().unwrap_or_else(PoisonError::into_inner).insert(key, value.clone());
    Ok(value)
}

/// Fits a sine of the known frequency to every channel of a run, less what effects add to it. The run stands
/// where its recording does in the document, in one of the orientations.
pub fn run(
    (recording, orientation): (usize, usize),
    hz: f64,
    instrument: Option<&Instrument>,
    context: &Context<'_>,
    basic: &Basic,
    (sensors, added, fits): (&[Axis], &Added, &Fits),
) -> Result<AcRun> {
    let path = format!("recordings[{recording}]");
    if !(hz.is_finite() && hz > 0.0) {
        let expected = "the frequency of the drive, a positive number";
        return Err(Error::document(format!("{path}.conditions.drive_hz"), hz.to_string(), expected));
    }
    let time = context.times("an AC drive").map_err(|error| error.at(&format!("{path}.columns")))?;
    let cycles = hz * (time.last().copied().unwrap_or(0.0) - time.first().copied().unwrap_or(0.0));
    let each_cycle = time.len() as f64 / cycles;
    if cycles.is_nan() || cycles < LEAST_CYCLES || each_cycle <= 2.0 {
        let [cycles, samples] = [cycles, each_cycle].map(|number| significant(number, 3));
        let found = format!("{cycles} cycles of {hz} Hz with {samples} samples in each");
        let expected = "at least one cycle, sampled more than twice in each";
        return Err(Error::document(format!("{path}.columns.time_s"), found, expected));
    }
    let undetermined = |column: &str, error: estimate::Error| {
        let found = format!("readings that do not determine a sine of {hz} Hz ({error})");
        let expected = "a large part of a cycle or more, sampled more than twice a cycle";
        Error::document(format!("{path}.columns.{column}"), found, expected)
    };
    let fit = |values: &[f64], column: &str, quantiser: Option<Quantiser>| {
        once(&fits.sines, (recording, column.to_string()), || {
            sine::fit(time, values, hz, quantiser).map_err(|error| undetermined(column, error))
        })
    };
    // y = a cos ωt + b sin ωt is the real part of (a − i b) e^(iωt).
    let mut coils = [Complex::new(0.0, 0.0); 3];
    for axis in Axis::ALL {
        let current: Vec<f64> = context.current_a.iter().map(|current| current[axis.index()]).collect();
        if current.iter().any(|value| *value != 0.0) {
            let sine = fit(&current, &format!("coil_{axis}_a"), None)?;
            coils[axis.index()] =
                Complex::new(sine.cos, -sine.sin) * basic.coils[axis.index()].constant_nt_per_a;
        }
    }
    let main = coils.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
    let turn = if main.norm() > 0.0 { main.conj() / main.norm() } else { Complex::new(1.0, 0.0) };
    let rounding = LEAST_STD * main.norm();
    let channel = |sensor: Axis| {
        let (name, column) = sensor_column(context.recording, sensor).unwrap_or_default();
        let sensitivity = basic.sensors[sensor.index()].sensitivity;
        // The converter, in the unit of the readings.
        let noise = instrument.and_then(|instrument| instrument.noise_of(sensor)?.white_rms_nt);
        let quantiser = context
            .unit
            .code_width(instrument)
            .map(|step| Quantiser { step, noise: noise.map(|rms| rms / sensitivity.abs()) });
        if quantiser.is_some() && column.windows(2).all(|pair| pair[0] == pair[1]) {
            return Err(Error::Unanswerable(format!(
                "recording \"{}\": the readings of sensor {sensor} stay within one quantisation step of the converter, which hides smaller fields; drive the other coils slightly as well (a dither of a few steps)",
                context.recording.id
            )));
        }
        let sine = fit(column, &name, quantiser)?;
        let mut phasor = Complex::new(sine.cos, -sine.sin) * turn * sensitivity;
        if let Some(added_nt) = added.along(recording, sensor) {
            let [cos, sin] = if added_nt.iter().chain(time).all(|value| value.is_finite()) {
                once(&fits.bases, recording, || Basis::new(time, hz).map(Arc::new))
                    .map(|basis| basis.cos_sin(&added_nt))
            } else {
                sine::fit(time, &added_nt, hz, None).map(|sine| [sine.cos, sine.sin])
            }
            .map_err(|error| undetermined(&name, error))?;
            phasor -= Complex::new(cos, -sin) * turn;
        }
        Ok((sensor, phasor, (sine.std * sensitivity.abs()).max(rounding)))
    };
    let sensors = sensors.iter().map(|sensor| channel(*sensor)).collect::<Result<_>>()?;
    Ok(AcRun { recording, orientation, hz, drive_nt: Vector3::from(coils.map(|coil| coil * turn)), sensors })
}

/// Takes each sensor's phase off its phasors and adds the amplitudes to the readings.
///
/// A sensor answers every field of one frequency with the same phase φ: z = e^(iφ) b B_c, b real, B_c the
/// coils' phasors in an orientation's runs. So z B_c⁻¹ (B_c⁺ where coils in phase were not each the main one)
/// lies on one line through zero, and φ = ½ arg Σ (z B_c⁻¹)². Coils out of phase with each other make the
/// imaginary part of z e^(−iφ) a reading of its own, with the imaginary part of the drive.
pub fn join(runs: Vec<AcRun>, all: &mut Observations) -> Result<()> {
    let mut frequencies: Vec<f64> = runs.iter().map(|run| run.hz).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    for hz in frequencies {
        let runs: Vec<&AcRun> = runs.iter().filter(|run| run.hz == hz).collect();
        for sensor in all.sensors.clone() {
            let channels = runs.iter().flat_map(|run| run.sensors.iter().map(move |channel| (*run, channel)));
            let own = channels.filter(|(_, (axis, ..))| *axis == sensor);
            let phasors: Vec<(&AcRun, Complex<f64>, f64)> =
                own.map(|(run, (_, phasor, std))| (run, *phasor, *std)).collect();
            let result = phase(sensor, hz, &phasors)?;
            let (phase, phase_std) = (result.phase_rad.value(), result.phase_rad.std().unwrap_or(0.0));
            if result.p_value * (all.sensors.len() as f64) < PHASE_P {
                let (rad, ms) = (uncertain(phase.abs(), phase_std), significant(result.delay_s * 1e3, 3));
                let way = if phase < 0.0 { "behind" } else { "ahead of" };
                all.findings.push(Code::PhaseLag.about(sensor).said(format!(
                    "sensor {sensor} responds {rad} rad {way} the drive at {hz} Hz, equivalent to a delay of {ms} ms"
                )));
            }
            all.phases.push(result);
            for (run, phasor, std) in phasors {
                let amplitude = phasor * Complex::from_polar(1.0, -phase);
                let mut add = |drive_nt: Vector3<f64>, value_nt: f64, other: f64| {
                    all.readings.push(Observation {
                        orientation: run.orientation,
                        recording: run.recording,
                        row: 0,
                        sensor,
                        drive_nt,
                        value_nt,
                        std_nt: std.hypot(other * phase_std),
                        ambient_nt: Vector3::zeros(),
                        constant: false,
                    });
                };
                add(run.drive_nt.map(|coil| coil.re), amplitude.re, amplitude.im);
                let quadrature = run.drive_nt.map(|coil| coil.im);
                if quadrature.amax() > std {
                    add(quadrature, amplitude.im, amplitude.re);
                }
            }
        }
    }
    Ok(())
}

/// A sensor's phase, from all runs of one frequency; its standard uncertainty is σ/√Σ|z|².
fn phase(sensor: Axis, hz: f64, phasors: &[(&AcRun, Complex<f64>, f64)]) -> Result<PhaseResult> {
    let mut orientations: Vec<usize> = phasors.iter().map(|(run, ..)| run.orientation).collect();
    orientations.sort_unstable();
    orientations.dedup();
    let mut squares = Complex::new(0.0, 0.0);
    for orientation in orientations {
        let own: Vec<&(&AcRun, Complex<f64>, f64)> =
            phasors.iter().filter(|(run, ..)| run.orientation == orientation).collect();
        let drive = DMatrix::from_fn(own.len(), 3, |row, coil| own[row].0.drive_nt[coil]);
        let answers = DVector::from_fn(own.len(), |row, _| own[row].1);
        let normal = drive.adjoint() * &drive;
        let size = normal.norm();
        let quadrature = drive.iter().map(|coil| coil.im.abs()).fold(0.0, f64::max);
        if normal.determinant().norm() < 1e-9 * size.powi(3) && quadrature > OUT_OF_PHASE * size.sqrt() {
            return Err(Error::Unanswerable(format!(
                "coils out of phase in fewer than three independent runs of an orientation: the phase of sensor {sensor} cannot be separated from the coils'. Drive the coils in phase, or each in turn as the main one (\"{hz} Hz\")"
            )));
        }
        // Minimum-norm solution of drive · b = answers through the normal equations, lightly damped: with
        // coils in phase it is real but for the sensor's phase, whatever the rank.
        let damping = DMatrix::identity(3, 3) * Complex::new(1e-12 * size, 0.0);
        if let Some(inverse) = (normal + damping).try_inverse() {
            let answer = inverse * (drive.adjoint() * answers);
            squares += answer.iter().map(|b| b * b).sum::<Complex<f64>>();
        }
    }
    let phase = 0.5 * squares.arg();
    let power: f64 = phasors.iter().map(|(_, z, _)| z.norm_sqr()).sum();
    let variance: f64 = phasors.iter().map(|(_, z, std)| z.norm_sqr() / power * std * std).sum();
    let std = (variance / power).sqrt();
    Ok(PhaseResult {
        sensor,
        drive_hz: hz,
        phase_rad: Quantity::new(phase, std),
        p_value: stats::two_sided_p(phase / std, f64::INFINITY),
        delay_s: -phase / (std::f64::consts::TAU * hz),
    })
}
