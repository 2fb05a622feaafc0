//! Kalman filter of rows that read noise with memory: of three sensors by factors, or of the magnitude.

use common::Noise;
use noise::{Process, Whitening};

/// Longest period of noise with memory, in lengths of a recording: it did not begin with it. Below that
/// frequency the density levels off: the corner of its slowest process is near 1/100T.
const OLDEST: f64 = 8.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Each sensor: the noise turns with the sensors.
    Sensors,
    /// Each component of the known field in GEO.
    Field,
    /// The magnitude: the field changed, and nobody measured it.
    Magnitude,
}

impl Memory {
    pub fn name(self) -> &'static str {
        match self {
            Memory::Sensors => "sensors",
            Memory::Field => "field",
            Memory::Magnitude => "magnitude",
        }
    }

    /// How many have noise of their own.
    pub fn channels(self) -> usize {
        match self {
            Memory::Sensors | Memory::Field => 3,
            Memory::Magnitude => 1,
        }
    }
}

/// Noise of one form: A/σ² and α, σ the white noise of a residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    pub of: Memory,
    /// A over the variance of the white noise, 1/Hz at 1 Hz.
    pub ratio: f64,
    pub exponent: f64,
}

pub const WHITE: Form = Form { of: Memory::Sensors, ratio: 0.0, exponent: 1.0 };

/// The processes of one channel for σ = 1, and the white part that goes with them.
fn processes(time: &[f64], form: Form) -> Option<(Vec<Process>, f64)> {
    if form.ratio <= 0.0 {
        return Some((Vec::new(), 0.0));
    }
    let noise = Noise {
        flicker_nt2_per_hz_at_1hz: Some(form.ratio),
        flicker_exponent: Some(form.exponent),
        ..Noise::default()
    };
    let length = time.last()? - time.first()?;
    let whitening = Whitening::of(&noise, Some(time), time.len(), OLDEST * length).ok()?;
    Some((whitening.processes().to_vec(), whitening.white_nt2()))
}

/// The states of all channels' processes given the rows before, for each column of the rows.
pub struct Filter {
    processes: Vec<Process>,
    white: f64,
    covariance: Vec<f64>,
    /// What an innovation of the last row adds to each state.
    gain: Vec<f64>,
    estimates: Vec<Vec<f64>>,
}

impl Filter {
    /// Before the rows of so many columns at some times, with σ = 1; None where the times are in no order.
    pub fn new(times: &[f64], form: Form, columns: usize) -> Option<Self> {
        let (processes, white) = processes(times, form)?;
        let states = form.of.channels() * processes.len();
        let mut covariance = vec![0.0; states * states];
        for state in 0..states {
            covariance[state * (states + 1)] = processes[state % processes.len()].variance_nt2;
        }
        let estimates = vec![vec![0.0; states]; columns];
        Some(Self { processes, white: 1.0 + white, covariance, gain: vec![0.0; states], estimates })
    }

    pub fn wait(&mut self, step_s: f64) {
        let states = self.gain.len();
        if step_s <= 0.0 || states == 0 {
            return;
        }
        let one: Vec<f64> =
            self.processes.iter().map(|process| (-process.rate_per_s * step_s).exp()).collect();
        let kept: Vec<f64> = (0..states).map(|state| one[state % one.len()]).collect();
        for i in 0..states {
            let row = &mut self.covariance[i * states..(i + 1) * states];
            row.iter_mut().zip(&kept).for_each(|(value, other)| *value *= kept[i] * other);
            row[i] += self.processes[i % one.len()].variance_nt2 * (1.0 - kept[i] * kept[i]);
        }
        for estimate in &mut self.estimates {
            estimate.iter_mut().zip(&kept).for_each(|(value, kept)| *value *= kept);
        }
    }

    /// Whitens the columns of a row with these factors; gives the variance of an innovation.
    pub fn row(&mut self, along: &[f64], columns: &[f64], whitened: &mut [f64]) -> f64 {
        let variance = self.read(along);
        let (each, deviation) = (self.processes.len(), variance.sqrt());
        for ((to, estimate), value) in whitened.iter_mut().zip(&mut self.estimates).zip(columns) {
            let innovation = value - read(along, estimate, each);
            estimate.iter_mut().zip(&self.gain).for_each(|(state, gain)| *state += gain * innovation);
            *to = innovation / deviation;
        }
        variance
    }

    /// Takes a row into covariance and gain; gives the variance of its innovation.
    fn read(&mut self, along: &[f64]) -> f64 {
        let (states, each, white) = (self.gain.len(), self.processes.len(), self.white);
        let mut variance = white;
        for i in 0..states {
            self.gain[i] = read(along, &self.covariance[i * states..(i + 1) * states], each);
            variance += along[i / each] * self.gain[i];
        }
        // Negative weights of processes leave the sum positive; rounding may not.
        let variance = variance.max(1e-6 * white);
        for i in 0..states {
            let share = self.gain[i] / variance;
            let row = &mut self.covariance[i * states..(i + 1) * states];
            row.iter_mut().zip(&self.gain).for_each(|(value, gain)| *value -= share * gain);
        }
        self.gain.iter_mut().for_each(|gain| *gain /= variance);
        variance
    }
}

/// What a row reads of states, so many in each channel.
fn read(along: &[f64], states: &[f64], each: usize) -> f64 {
    let channels = along.iter().enumerate();
    channels.map(|(k, along)| along * states[k * each..(k + 1) * each].iter().sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::{Mat, Side};

    /// Innovations and determinant against Cholesky's factor of the covariance itself.
    #[test]
    fn the_filter_whitens_by_the_covariance() {
        let rows = 40;
        let along: Vec<[f64; 3]> = (0..rows)
            .map(|t| [0, 1, 2].map(|axis| (0.7 * f64::from(t) + 2.0 * f64::from(axis)).sin()))
            .collect();
        let time: Vec<f64> = (0..rows).map(|t| f64::from(t) + 0.2 * f64::from(t % 3)).collect();
        for (of, exponent) in
            [(Memory::Sensors, 0.7), (Memory::Sensors, 1.0), (Memory::Sensors, 1.5), (Memory::Magnitude, 1.0)]
        {
            let form = Form { of, ratio: 3.0, exponent };
            let (processes, white) = processes(&time, form).expect("processes");
            let read = |t: usize| &along[t][..of.channels()];
            let covariance = Mat::from_fn(rows as usize, rows as usize, |i, j| {
                let lag = (time[i] - time[j]).abs();
                let own: f64 = processes
                    .iter()
                    .map(|process| process.variance_nt2 * (-process.rate_per_s * lag).exp())
                    .sum();
                let together: f64 = read(i).iter().zip(read(j)).map(|(a, b)| a * b).sum();
                own * together + if i == j { 1.0 + white } else { 0.0 }
            });
            let lower = covariance.llt(Side::Lower).expect("positive");
            let series: Vec<f64> = (0..rows).map(|t| (1.3 * f64::from(t)).cos()).collect();
            let mut filter = Filter::new(&time, form, 1).expect("processes");
            let mut before = time[0];
            let mut white_series = Vec::new();
            for (t, reading) in series.iter().enumerate() {
                filter.wait(time[t] - before);
                before = time[t];
                let mut whitened = [0.0];
                let variance = filter.row(read(t), &[*reading], &mut whitened);
                white_series.extend(whitened);
                assert!((variance.sqrt() / lower.L()[(t, t)] - 1.0).abs() < 1e-9, "{t}");
            }
            for (t, reading) in series.iter().enumerate() {
                let product: f64 = (0..=t).map(|k| lower.L()[(t, k)] * white_series[k]).sum();
                assert!((product - reading).abs() < 1e-9, "{t}");
            }
        }
    }

    /// The variance of the mean over a recording of T is that of A/f down to 1/216T (600 rows) to 1/333T (21
    /// 600 rows): A (3/2 − γ − ln 2πfT) with Euler's γ.
    #[test]
    fn noise_is_older_than_the_recording() {
        for rows in [600_u32, 2400, 21_600] {
            let time: Vec<f64> = (0..rows).map(|row| 120.0 * f64::from(row)).collect();
            let length = 120.0 * f64::from(rows - 1);
            let form = Form { of: Memory::Sensors, ratio: 1.0, exponent: 1.0 };
            let of_mean = |process: &Process| {
                let x = process.rate_per_s * length;
                process.variance_nt2 * 2.0 / (x * x) * (x - 1.0 + (-x).exp())
            };
            let variance: f64 = processes(&time, form).expect("processes").0.iter().map(of_mean).sum();
            let lowest = (1.5 - 0.577_215_664_9 - variance).exp() / std::f64::consts::TAU;
            assert!((200.0..350.0).contains(&lowest.recip()), "{rows}: {variance} {}", lowest.recip());
        }
    }
}
