//! AC drive: the amplitude of every channel in phase with the drive (NASA, "Errors in Magnetic Axis
//! Orientation Given Direction Cosines of the Calibration Coils").

use common::{Axis, Instrument, PhaseResult, Quantity};
use estimate::sine::{self, Quantiser};
use estimate::stats;
use nalgebra::{Complex, Vector3};
use physics::{Basic, Context, Unit};

use crate::Error;
use crate::observations::{Observation, Observations, sensor_column};

/// Phases with a smaller chance than this, among all sensors, are reported as a finding.
const PHASE_P: f64 = 1e-3;

/// What one AC run gives: phasors relative to the coil with the largest drive.
pub(crate) struct AcRun {
    recording: usize,
    orientation: usize,
    hz: f64,
    /// In-phase amplitude of each coil's field, nT.
    drive_nt: Vector3<f64>,
    /// Each sensor's phasor and the standard uncertainty of its parts, nT.
    sensors: Vec<(Axis, Complex<f64>, f64)>,
}

/// Fits a sine of the known frequency to every channel of a run.
pub(crate) fn run(
    recording: usize,
    orientation: usize,
    hz: f64,
    instrument: Option<&Instrument>,
    context: &Context<'_>,
    basic: &Basic,
    sensors: &[Axis],
) -> Result<AcRun, Error> {
    let path = format!("recordings[{recording}]");
    if !(hz.is_finite() && hz > 0.0) {
        return Err(common::Error::document(
            format!("{path}.conditions.drive_hz"),
            hz.to_string(),
            "the frequency of the drive, a positive number",
        )
        .into());
    }
    let time = context
        .times("an AC drive")
        .map_err(|source| Error::Physics { path: format!("{path}.columns"), source })?;
    let fit = |values: &[f64], column: String, quantiser: Option<Quantiser>| {
        sine::fit(time, values, hz, quantiser).map_err(|error| {
            Error::from(common::Error::document(
                format!("{path}.columns.{column}"),
                format!("readings that determine no sine of {hz} Hz ({error})"),
                "at least a good part of a cycle, sampled more than twice a cycle",
            ))
        })
    };
    // y = a cos ωt + b sin ωt is the real part of (a − i b) e^(iωt).
    let mut coils = [Complex::new(0.0, 0.0); 3];
    for axis in Axis::ALL {
        let current: Vec<f64> = context.current_a.iter().map(|current| current[axis.index()]).collect();
        if current.iter().any(|value| *value != 0.0) {
            let sine = fit(&current, format!("coil_{axis}_a"), None)?;
            coils[axis.index()] =
                Complex::new(sine.cos, -sine.sin) * basic.coils[axis.index()].constant_nt_per_a;
        }
    }
    let main = coils.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
    let turn = if main.norm() > 0.0 { main.conj() / main.norm() } else { Complex::new(1.0, 0.0) };
    let sensors = sensors
        .iter()
        .map(|&sensor| {
            let (name, column) = sensor_column(context.recording, sensor).unwrap_or_default();
            let sensitivity = basic.sensors[sensor.index()].sensitivity;
            let sine = fit(column, name, quantiser(instrument, context.unit, sensor, sensitivity))?;
            Ok((sensor, Complex::new(sine.cos, -sine.sin) * turn * sensitivity, sine.std * sensitivity.abs()))
        })
        .collect::<Result<_, Error>>()?;
    Ok(AcRun {
        recording,
        orientation,
        hz,
        drive_nt: Vector3::from(coils.map(|coil| (coil * turn).re)),
        sensors,
    })
}

/// The converter of a sensor, in the unit of its readings.
fn quantiser(
    instrument: Option<&Instrument>,
    unit: Unit,
    sensor: Axis,
    sensitivity: f64,
) -> Option<Quantiser> {
    let step = match unit {
        Unit::Volt => instrument?.quantisation_v,
        Unit::Nanotesla => instrument?.quantisation_nt,
    };
    let noise =
        instrument?.noise_of(sensor).and_then(|noise| noise.white_rms_nt).map(|rms| rms / sensitivity.abs());
    Some(Quantiser { step: step?, noise })
}

/// Takes each sensor's phase off its phasors and adds the amplitudes to the readings.
///
/// A sensor lags every field of one frequency by the same phase φ, so that its phasors Z lie on one line
/// through zero: φ = ½ arg Σ Z², with standard uncertainty σ/√Σ|Z|².
pub(crate) fn join(runs: Vec<AcRun>, all: &mut Observations) {
    let mut frequencies: Vec<f64> = runs.iter().map(|run| run.hz).collect();
    frequencies.sort_by(f64::total_cmp);
    frequencies.dedup();
    for hz in frequencies {
        for sensor in all.sensors.clone() {
            let own = |run: &AcRun| run.sensors.iter().find(|(axis, ..)| *axis == sensor).copied();
            let phasors: Vec<(&AcRun, Complex<f64>, f64)> = runs
                .iter()
                .filter(|run| run.hz == hz)
                .filter_map(|run| own(run).map(|(_, phasor, std)| (run, phasor, std)))
                .collect();
            let squares: Complex<f64> = phasors.iter().map(|(_, z, _)| z * z).sum();
            let phase = 0.5 * squares.arg();
            let power: f64 = phasors.iter().map(|(_, z, _)| z.norm_sqr()).sum();
            let variance: f64 = phasors.iter().map(|(_, z, std)| (z.norm_sqr() * std * std) / power).sum();
            let std = (variance / power).sqrt();
            let p_value = stats::two_sided_p(phase / std, f64::INFINITY);
            let delay_s = -phase / (std::f64::consts::TAU * hz);
            if p_value * (all.sensors.len() as f64) < PHASE_P {
                all.findings.push(format!(
                    "sensor {sensor} answers {:.2e} ± {std:.1e} rad {} the drive at {hz} Hz, as a delay of {:.3} ms would make it",
                    phase.abs(),
                    if phase < 0.0 { "behind" } else { "ahead of" },
                    delay_s * 1e3
                ));
            }
            all.phases.push(PhaseResult {
                sensor,
                drive_hz: hz,
                phase_rad: Quantity::new(phase, std),
                p_value,
                delay_s,
            });
            let turn = Complex::from_polar(1.0, -phase);
            for (run, phasor, std) in phasors {
                all.readings.push(Observation {
                    orientation: run.orientation,
                    recording: run.recording,
                    row: 0,
                    sensor,
                    drive_nt: run.drive_nt,
                    value_nt: (phasor * turn).re,
                    std_nt: std,
                    constant: false,
                });
            }
        }
    }
}
