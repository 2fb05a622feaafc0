//! The field at the observatory, and what the variometer reads of it.

use nalgebra::Vector3;
use noise::Stream;
use physics::Components;
use std::f64::consts::TAU;

use super::{DAY_S, ObservatoryPlan};

const YEAR_S: f64 = 365.25 * DAY_S;
/// Amplitude of the daily variation, north, east and down, nT.
const DAILY_NT: [f64; 3] = [12.0, 20.0, 10.0];
/// Amplitudes of shorter variations with their periods, nT and s.
const SHORT: [(f64, f64); 4] = [(3.0, 5_400.0), (2.0, 1_500.0), (1.0, 420.0), (0.3, 110.0)];
/// The variometer's room: mean and annual wave, degC.
const ROOM_C: [f64; 2] = [18.0, 3.0];
/// Points of the random walk, one a day, so long before and after.
const SPARE: usize = 2;

/// The field, the variometer's frame and its baselines as functions of the time since the start, s.
pub struct Field {
    components: Components,
    main: Vector3<f64>,
    phases: Vec<Vector3<f64>>,
    baseline: Vector3<f64>,
    drift: Vector3<f64>,
    annual: [Vector3<f64>; 2],
    walk: Vec<Vector3<f64>>,
    steps: Vec<(f64, Vector3<f64>)>,
    nt_per_k: Vector3<f64>,
    horizontal: f64,
}

impl Field {
    pub fn new(plan: &ObservatoryPlan) -> Self {
        let mut stream = Stream::new(plan.seed, "observatory");
        let mut vector = |std: f64| Vector3::from_fn(|_, _| std * stream.normal());
        let main = Vector3::from(plan.main_field_nt);
        let components = Components::of(&plan.components).unwrap_or_default();
        let horizontal = main.x.hypot(main.y);
        // Set up by hand: some nT, and some minutes of arc, from what it reads.
        let installed = match components {
            Components::Xyz => vector(30.0),
            Components::Hez => {
                let off = vector(20.0);
                Vector3::new(off.x, main.y.atan2(main.x) + off.y / horizontal, off.z)
            }
        };
        let of = &plan.baseline;
        let mut at = Vector3::zeros();
        let days = plan.weeks * 7 + SPARE;
        let walk = (0..days).map(|_| {
            at += vector(of.walk_nt * (DAY_S / YEAR_S).sqrt());
            at
        });
        let walk = walk.collect();
        let steps = of.step_days.iter().map(|day| (day * DAY_S, vector(of.step_nt))).collect();
        Self {
            components,
            main,
            phases: (0..1 + SHORT.len()).map(|_| vector(2.0)).collect(),
            baseline: installed,
            drift: vector(of.drift_nt_per_year),
            annual: [vector(of.annual_nt), vector(of.annual_nt)],
            walk,
            steps,
            nt_per_k: Vector3::from(of.nt_per_k),
            horizontal,
        }
    }

    /// The field north, east and down, nT.
    pub fn total(&self, time: f64) -> Vector3<f64> {
        let wave = |phase: &Vector3<f64>, period: f64| phase.map(|phase| (TAU * time / period + phase).sin());
        let daily = wave(&self.phases[0], DAY_S).component_mul(&Vector3::from(DAILY_NT));
        let short = SHORT
            .iter()
            .zip(&self.phases[1..])
            .map(|((amplitude, period), phase)| wave(phase, *period) * *amplitude);
        self.main + daily + short.sum::<Vector3<f64>>()
    }

    pub fn temperature_c(&self, time: f64) -> f64 {
        let [mean, annual] = ROOM_C;
        mean + annual * (TAU * time / YEAR_S).sin() + 0.3 * (TAU * time / DAY_S).sin()
    }

    /// The baseline values, nT, or rad of a declination.
    pub fn baseline(&self, time: f64) -> Vector3<f64> {
        let years = time / YEAR_S;
        let day = (time / DAY_S).max(0.0);
        let at = (day as usize).min(self.walk.len() - 2);
        let walk = self.walk[at].lerp(&self.walk[at + 1], day - at as f64);
        let steps =
            self.steps.iter().filter(|(when, _)| time >= *when).map(|(_, size)| size).sum::<Vector3<f64>>();
        let [sine, cosine] = self.annual;
        let warm = self.nt_per_k * (self.temperature_c(time) - ROOM_C[0]);
        let moved = self.drift * years
            + sine * (TAU * years).sin()
            + cosine * (TAU * years).cos()
            + walk
            + steps
            + warm;
        let units = match self.components {
            Components::Xyz => Vector3::new(1.0, 1.0, 1.0),
            Components::Hez => Vector3::new(1.0, 1.0 / self.horizontal, 1.0),
        };
        self.baseline + moved.component_mul(&units)
    }

    /// What the variometer reads, and the field.
    pub fn read(&self, time: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (total, baseline) = (self.total(time), self.baseline(time));
        (self.components.reading_nt(&total, &baseline), total)
    }
}
