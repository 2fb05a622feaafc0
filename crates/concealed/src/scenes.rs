//! Campaigns at random: instruments, drives, temperatures, orbits and variations of realistic sizes.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

use crate::draw::Draw;
use crate::scene::{Attitude, Bench, Campaign, Run, SceneKind, World};
use crate::signal::{Signal, cycle, held, mixed, over, quiet_before, sines, wandering};

/// How long the runs are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// About 300 rows in all.
    Short,
    /// About 540.
    Medium,
    /// About 960.
    Long,
    /// About 3 000.
    Campaign,
    /// About 9 000: a day at ten seconds.
    Day,
    /// Up to 30 000.
    Longest,
}

impl Length {
    /// Those of the short sets.
    pub const ALL: [Length; 3] = [Length::Short, Length::Medium, Length::Long];

    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Length::Short => "short",
            Length::Medium => "medium",
            Length::Long => "long",
            Length::Campaign => "campaign",
            Length::Day => "day",
            Length::Longest => "longest",
        }
    }

    /// That of so many rows.
    pub fn of(rows: usize) -> Length {
        match rows {
            0..400 => Length::Short,
            400..720 => Length::Medium,
            720..1700 => Length::Long,
            1700..5200 => Length::Campaign,
            5200..16_000 => Length::Day,
            _ => Length::Longest,
        }
    }

    fn rows(self) -> usize {
        match self {
            Length::Short => 300,
            Length::Medium => 540,
            Length::Long => 960,
            Length::Campaign => 3000,
            Length::Day => 9000,
            Length::Longest => 30_000,
        }
    }
}

/// Speed of a spacecraft's wheel, and the longest step at which it is told: its turns could not be counted at
/// longer ones.
pub const WHEEL: &str = "wheel_1_hz";
const WHEEL_STEP_S: f64 = 2.0;

/// A campaign of a kind. `step_s` overrides the usual step.
pub fn campaign(
    kind: SceneKind,
    length: Length,
    apart: bool,
    step_s: Option<f64>,
    draw: &mut Draw,
) -> Campaign {
    of_rows(kind, length.rows(), apart, step_s, draw)
}

/// A campaign of a kind with so many rows in all.
pub fn of_rows(kind: SceneKind, rows: usize, apart: bool, step_s: Option<f64>, draw: &mut Draw) -> Campaign {
    let bench = bench(kind, draw);
    let usual = match kind {
        SceneKind::Coils => draw.between(6.0, 15.0),
        SceneKind::Fast => 0.01,
        SceneKind::Held => 0.002,
        SceneKind::Site => 60.0,
        SceneKind::Craft => draw.between(10.0, 20.0),
        SceneKind::Pair => 120.0,
    };
    // Whole milliseconds, as loggers have them; a step that was asked for is taken as it is.
    let step = step_s.unwrap_or((usual * 1000.0).round() / 1000.0);
    let runs = match kind {
        SceneKind::Coils => coils(rows / 3, step, apart, draw),
        SceneKind::Fast | SceneKind::Held => vec![fast(kind, rows, step, draw)],
        SceneKind::Site => vec![site(rows, step, apart, draw)],
        SceneKind::Craft => vec![craft(rows, step, apart, draw)],
        SceneKind::Pair => vec![pair(rows, step, apart, draw)],
    };
    Campaign { bench, runs, reference_c: [23.0, 26.0, 21.0], code_nt: 0.01, kind, apart }
}

fn bench(kind: SceneKind, draw: &mut Draw) -> Bench {
    let arcsec = 4.848e-6;
    // Each column turned from its nominal axis by up to a degree.
    let mut turned = |most: f64| {
        let mut matrix = Matrix3::identity();
        for k in 0..3 {
            let column = Vector3::from_fn(|j, _| if j == k { 1.0 } else { most * draw.between(-1.0, 1.0) });
            matrix.set_column(k, &column.normalize());
        }
        matrix
    };
    let (mut eta, mu) = (turned(1000.0 * arcsec), turned(3000.0 * arcsec));
    if kind == SceneKind::Pair {
        for k in 0..3 {
            let scale = 1.0 + 2e-3 * draw.between(-1.0, 1.0);
            let column = eta.column(k) * scale;
            eta.set_column(k, &column);
        }
    }
    Bench {
        coil_nt_per_a: std::array::from_fn(|_| draw.between(30_000.0, 41_000.0)),
        eta,
        mu,
        sensitivity: std::array::from_fn(|_| 1.0 + 1e-3 * draw.between(-1.0, 1.0)),
        offset_nt: std::array::from_fn(|_| draw.between(-8.0, 8.0)),
    }
}

fn standing(matrix: Matrix3<f64>) -> Attitude {
    Arc::new(move |_| matrix)
}

/// The temperatures of a campaign: a chamber that is driven up and down, or the room's course; those of the
/// electronics and of the coil have courses of their own, or follow that of the sensor for the greater part.
fn temperatures(apart: bool, rows: usize, step: f64, draw: &mut Draw) -> [Signal; 3] {
    let span = rows as f64 * step;
    let chamber = draw.between(0.0, 1.0) < 0.5;
    let sensor = if chamber {
        let ripple = wandering(draw, 0.4, [0.05 * span, 0.2 * span], 3);
        let phase = draw.between(0.0, 1.0);
        mixed(vec![
            (1.0, cycle(draw.between(6.0, 10.0), draw.between(6.0, 10.0), span / 1.7, phase)),
            (1.0, ripple),
        ])
    } else {
        wandering(draw, 6.0, [0.15 * span, 1.2 * span], 4)
    };
    let mut own = |size: f64| wandering(draw, size, [0.08 * span, 0.9 * span], 4);
    let (electronics, coil) = (own(3.5), own(2.5));
    let followed = |own: Signal, share: f64| {
        if apart { own } else { mixed(vec![(0.5, own), (share, sensor.clone())]) }
    };
    let electronics = followed(electronics, 0.55);
    let coil = followed(coil, 0.35);
    [over(23.0, sensor), over(26.0, electronics), over(21.0, coil)]
}

fn orientations() -> [Matrix3<f64>; 6] {
    let of = |rows: [[f64; 3]; 3]| Matrix3::from_fn(|i, j| rows[i][j]);
    [
        of([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        of([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        of([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
        of([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
        of([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]),
        of([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    ]
}

/// Three runs, a pause between them, sines of unlike periods on all coils.
fn coils(rows: usize, step: f64, apart: bool, draw: &mut Draw) -> Vec<Run> {
    let pause = draw.between(10.0, 60.0) * 60.0;
    let first = draw.below(4);
    let drive: [Signal; 3] = std::array::from_fn(|_| {
        let period = draw.between(38.0, 85.0) * step;
        let size = draw.between(0.75, 1.0);
        let second = (0.3 * size, period / draw.between(1.7, 2.6), draw.between(0.0, TAU));
        sines(vec![(size, period, draw.between(0.0, TAU)), second])
    });
    let warm = temperatures(apart, 3 * rows, step, draw);
    let panel = over(1.5, wandering(draw, 0.8, [30.0 * step, 130.0 * step], 3));
    let mut begin = 0.0;
    (0..3)
        .map(|number| {
            let from = begin;
            begin = ((from + rows as f64 * step + pause) / step).ceil() * step;
            Run {
                id: format!("run-{}", number + 1),
                times: (0..rows).map(|row| from + row as f64 * step).collect(),
                world: World::Coils(drive.clone()),
                attitude: standing(orientations()[(first + number) % 6]),
                still: true,
                temperatures: warm.clone().map(|signal| quiet_before(signal, from)),
                columns: vec![("panel_current_a".into(), panel.clone())],
            }
        })
        .collect()
}

/// Drives of some Hz, or held.
fn fast(kind: SceneKind, rows: usize, step: f64, draw: &mut Draw) -> Run {
    let drive: [Signal; 3] = std::array::from_fn(|_| {
        if kind == SceneKind::Held {
            return held(draw.between(-1.0, 1.0));
        }
        let period = draw.between(18.0, 45.0) * step;
        // Some hundred nT: more than that no supply drives at some Hz.
        let second = (0.0025, period / draw.between(1.6, 2.4), draw.between(0.0, TAU));
        sines(vec![(draw.between(0.006, 0.01), period, draw.between(0.0, TAU)), second])
    });
    let span = rows as f64 * step;
    let mut warm = |level: f64| over(level, wandering(draw, 0.05, [span, 4.0 * span], 2));
    Run {
        id: "run".into(),
        times: (0..rows).map(|row| row as f64 * step).collect(),
        world: World::Coils(drive),
        attitude: standing(orientations()[0]),
        still: true,
        temperatures: [warm(23.4), warm(26.2), warm(21.1)],
        columns: Vec::new(),
    }
}

/// The natural field's variation over a day: some tens of nT, a spectrum that falls.
fn variation(size: f64, step: f64, draw: &mut Draw) -> Signal {
    let slow = wandering(draw, size, [300.0 * step, 1500.0 * step], 3);
    let middle = wandering(draw, 0.4 * size, [40.0 * step, 300.0 * step], 5);
    let quick = wandering(draw, 0.1 * size, [12.0 * step, 40.0 * step], 5);
    mixed(vec![(1.0, slow), (1.0, middle), (1.0, quick)])
}

fn site(rows: usize, step: f64, apart: bool, draw: &mut Draw) -> Run {
    let mut run = coils(rows, step, apart, draw).swap_remove(0);
    run.id = "run".into();
    let outside: Vec<(String, Signal)> = [20_000.0, 300.0, 43_000.0]
        .into_iter()
        .zip(["x", "y", "z"])
        .map(|(level, axis)| (format!("outside_{axis}_nt"), over(level, variation(35.0, step, draw))))
        .collect();
    run.columns = outside;
    for axis in ["x", "y"] {
        let tilt = wandering(draw, 2e-5, [40.0 * step, 900.0 * step], 4);
        run.columns.push((format!("tilt_{axis}_rad"), tilt));
    }
    run
}

/// An orbit of 94 minutes in the field of a tilted dipole, seen from a body that looks down and is yawed and
/// rolled on the way.
fn craft(rows: usize, step: f64, apart: bool, draw: &mut Draw) -> Run {
    let period = 5640.0;
    let phase = draw.between(0.0, TAU);
    let field = move |axis: usize| -> Signal {
        Arc::new(move |t| {
            let (latitude, longitude) = (TAU * t / period + phase, TAU * t / 86_400.0);
            let tilt = 0.17 * longitude.cos();
            match axis {
                0 => 24_500.0 * (latitude + tilt).cos(),
                1 => 4_000.0 * (longitude + 0.4).sin() * latitude.cos() + 900.0 * (2.0 * latitude).sin(),
                _ => 46_000.0 * (latitude + tilt).sin(),
            }
        })
    };
    let (roll, yaw) = (
        wandering(draw, 0.5, [0.15 * period, 0.7 * period], 3),
        wandering(draw, 0.9, [0.2 * period, 1.1 * period], 3),
    );
    let attitude: Attitude = {
        let (roll, yaw) = (roll.clone(), yaw.clone());
        Arc::new(move |t| Rotation3::from_euler_angles(roll(t), 0.3 * roll(1.7 * t), yaw(t)).into_inner())
    };
    let sun_geo = Vector3::new(0.3, 0.75, -0.6).normalize();
    let lit: Signal = Arc::new(move |t| f64::from(u8::from((t / period + phase).rem_euclid(1.0) < 0.63)));
    let in_body = {
        let attitude = attitude.clone();
        move |t: f64| attitude(t) * sun_geo
    };
    let azimuth: Signal = {
        let in_body = in_body.clone();
        Arc::new(move |t| {
            let s = in_body(t);
            s.y.atan2(s.x)
        })
    };
    let elevation: Signal = Arc::new(move |t| in_body(t).z.clamp(-1.0, 1.0).asin());
    let warm = temperatures(apart, rows, step, draw);
    let panel = {
        let (lit, load) = (lit.clone(), wandering(draw, 0.7, [0.05 * period, 0.4 * period], 4));
        let share = wandering(draw, 0.15, [0.1 * period, 0.5 * period], 3);
        Arc::new(move |t| lit(t) * (2.2 + 2.2 * share(t)) + load(t)) as Signal
    };
    let mut columns = vec![
        ("panel_current_a".into(), panel),
        ("sunlit".into(), lit),
        ("sun_azimuth_rad".into(), azimuth),
        ("sun_elevation_rad".into(), elevation),
    ];
    if step <= WHEEL_STEP_S {
        let speed = draw.between(3.0, 25.0);
        let wander = wandering(draw, 0.08 * speed, [120.0 * step, 600.0 * step], 3);
        columns.push((WHEEL.into(), over(speed, wander)));
    }
    Run {
        id: "run".into(),
        times: (0..rows).map(|row| row as f64 * step).collect(),
        world: World::Natural(std::array::from_fn(field)),
        attitude,
        still: false,
        temperatures: warm,
        columns,
    }
}

fn pair(rows: usize, step: f64, apart: bool, draw: &mut Draw) -> Run {
    let levels = [21_000.0, 900.0, 43_000.0];
    let field = std::array::from_fn(|k| over(levels[k], variation(60.0, step, draw)));
    Run {
        id: "pair".into(),
        times: (0..rows).map(|row| row as f64 * step).collect(),
        world: World::Pair(field),
        attitude: standing(Matrix3::identity()),
        still: true,
        temperatures: temperatures(apart, rows, step, draw),
        columns: Vec::new(),
    }
}

/// The Sun in the body frame: a unit vector, or zero in eclipse.
pub fn sun(run: &Run, t: f64) -> [f64; 3] {
    let part = |name: &str| run.column(name).map_or(0.0, |signal| signal(t));
    let (azimuth, elevation, lit) = (part("sun_azimuth_rad"), part("sun_elevation_rad"), part("sunlit"));
    [lit * elevation.cos() * azimuth.cos(), lit * elevation.cos() * azimuth.sin(), lit * elevation.sin()]
}

/// A rotation as the unit quaternion w, x, y, z of the document.
pub fn quaternion(matrix: &Matrix3<f64>) -> [f64; 4] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*matrix));
    [q.w, q.i, q.j, q.k]
}
