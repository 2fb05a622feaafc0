//! What moves with time, known at every instant and not only where it was sampled.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::draw::Draw;

/// A function of the time on the campaign's clock, s.
pub type Signal = Arc<dyn Fn(f64) -> f64 + Send + Sync>;

/// The same value always.
pub fn held(value: f64) -> Signal {
    Arc::new(move |_| value)
}

/// A sum of sines: (size, period in s, phase in rad).
pub fn sines(waves: Vec<(f64, f64, f64)>) -> Signal {
    Arc::new(move |t| waves.iter().map(|(size, period, phase)| size * (TAU * t / period + phase).sin()).sum())
}

/// A level with another signal on top.
pub fn over(level: f64, signal: Signal) -> Signal {
    Arc::new(move |t| level + signal(t))
}

/// Σ factor · signal.
pub fn mixed(parts: Vec<(f64, Signal)>) -> Signal {
    Arc::new(move |t| parts.iter().map(|(factor, signal)| factor * signal(t)).sum())
}

/// What a signal was at `from` for all earlier times: the operator waited until all was quiet.
pub fn quiet_before(signal: Signal, from: f64) -> Signal {
    Arc::new(move |t| signal(t.max(from)))
}

/// Up, held, down and held below, with rounded corners: how a chamber is driven. Sizes of the two levels, s
/// of the whole cycle.
pub fn cycle(up: f64, down: f64, period: f64, phase: f64) -> Signal {
    Arc::new(move |t| {
        let x = (t / period + phase).rem_euclid(1.0);
        let edge = |at: f64| 1.0 / (1.0 + (-(x - at) / 0.025).exp());
        up * (edge(0.12) - edge(0.38)) - down * (edge(0.6) - edge(0.86))
    })
}

/// A smooth random course without a period: `count` sines of random periods between two, about `size` rms.
pub fn wandering(draw: &mut Draw, size: f64, periods: [f64; 2], count: usize) -> Signal {
    let each = size * (2.0 / count as f64).sqrt();
    let wave = |_| (each, draw.octaves(periods[0], periods[1]), draw.between(0.0, TAU));
    sines((0..count).map(wave).collect())
}
