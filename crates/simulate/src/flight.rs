//! A flight: a vector magnetometer beside star cameras, with the errors that both have in orbit.

mod errors;
mod orbit;
mod plan;

use common::{Axis, Conditions, Document, Error, Matrix3x3, Recording, procedure};
use mainfield::Celestial;
use nalgebra::{Matrix3x4, Vector2, Vector3, Vector4};
use noise::Stream;
use physics::Kind;
use physics::frames::{ARCSEC, matrix, rows, small_rotation, turned};
use rayon::prelude::*;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::aboard::quaternion;
use crate::planned::columns;
use errors::{Field, Waves, normal, uniform};
use orbit::{DAY_S, Moment, Motion};
pub use plan::{
    BenchPlan, CameraPlan, CurrentPlan, FieldPlan, FlightPlan, LatencyPlan, SensorsPlan, SunPlan,
};

/// The document of a flight, and what is true behind it.
#[derive(Clone, Debug)]
pub struct MadeFlight {
    /// One recording.
    pub document: Document,
    /// What calibration should find.
    pub truth: FlightTruth,
}

/// What is true of a flight. Sensor i reads (mu_i · B − O_i)/k_i, where B is the field in SEN.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlightTruth {
    /// Of each head, SEN -> head, at the mean temperature of the bench.
    pub cameras: Vec<Matrix3x3>,
    /// Scale factors k, nT/nT.
    pub k: [f64; 3],
    /// Offsets O at the mean temperature of the sensors, nT.
    pub offset_nt: [f64; 3],
    /// Directions of the sensors in SEN, a row for each.
    pub mu: Matrix3x3,
    /// What a kelvin adds to O.
    pub offset_nt_per_k: [f64; 3],
    /// The bench: a head's rotation is C exp([turn (T − mean)]×), so that the turn is about the axes of SEN.
    pub bench: BenchPlan,
    /// Mean of `sensor_temperature_c`, degC.
    pub mean_sensor_c: f64,
    /// Mean of `bench_temperature_c`, degC.
    pub mean_bench_c: f64,
    /// The field of the current, SEN.
    pub current: CurrentPlan,
    /// Parameters of the effect `sun_thermoelectric`.
    pub sun: BTreeMap<String, f64>,
    /// How much earlier than its row something was.
    pub latency: LatencyPlan,
}

/// All that a row is made of.
struct Flight<'a> {
    plan: &'a FlightPlan,
    truth: FlightTruth,
    sun: Matrix3x4<f64>,
    motion: Motion<'a>,
    field: Field,
    load: Waves,
    noise_nt: Vec<Vector3<f64>>,
    heads: Vec<Head>,
}

/// What is drawn of a head: its noise, rad, and when it is blinded, s.
struct Head {
    noise: Vec<Vector3<f64>>,
    blinded: Vec<[f64; 2]>,
}

/// Carries out a plan. Errors: a plan that [`FlightPlan::parse`] refuses.
pub fn flight(plan: &FlightPlan) -> Result<MadeFlight, Error> {
    let (start, years) = plan.check()?;
    let motion = Motion::new(plan, start);
    let mut stream = Stream::new(plan.seed, "sun");
    let sun = Matrix3x4::from_fn(|_, _| plan.sun.lit_nt * stream.normal());
    let mut stream = Stream::new(plan.seed, "noise");
    let flight = Flight {
        plan,
        truth: FlightTruth::draw(plan, &motion, &sun),
        sun,
        motion,
        field: Field::new(plan, years),
        load: Waves::new(plan, "load", 0.3, [600.0, 6000.0], 0.0),
        noise_nt: (0..plan.rows()).map(|_| normal(&mut stream) * plan.sensors.noise_nt).collect(),
        heads: (0..plan.cameras.len()).map(|number| Head::draw(plan, number)).collect(),
    };
    let made = (0..plan.rows()).into_par_iter();
    let made: Vec<Vec<f64>> =
        made.map_init(Celestial::default, |celestial, row| flight.row(row, celestial)).collect();
    let columns = columns(flight.names(), &made);
    let extra = [("attitude_frame".to_string(), json!(plan.attitude_frame))];
    let recording = Recording {
        id: "flight".into(),
        procedure: procedure::FREE_RUN.into(),
        start: Some(plan.start.clone()),
        conditions: Conditions { extra: extra.into_iter().collect(), ..Conditions::default() },
        columns,
        ..Recording::default()
    };
    let title = Some("A magnetometer beside star cameras, simulated".into());
    let document = Document { fluxcal: 1, title, recordings: vec![recording], ..Document::default() };
    Ok(MadeFlight { document, truth: flight.truth })
}

impl FlightTruth {
    fn draw(plan: &FlightPlan, motion: &Motion<'_>, sun: &Matrix3x4<f64>) -> Self {
        let (of, mut stream) = (&plan.sensors, Stream::new(plan.seed, "sensors"));
        let k = normal(&mut stream).map(|draw| 1.0 + 1e-6 * of.scale_std_ppm * draw).into();
        let offset_nt = (normal(&mut stream) * of.offset_std_nt).into();
        let mut across = || of.angle_std_arcsec * ARCSEC * stream.normal();
        let mu = Axis::ALL.map(|axis| turned(&Vector3::ith(axis.index(), 1.0), [across(), across()]).into());
        let mut stream = Stream::new(plan.seed, "mounting");
        let mut mounted = |camera: &CameraPlan| {
            let off = small_rotation(&(normal(&mut stream) * plan.turn_std_arcsec * ARCSEC));
            rows(&(off * orbit::turned(camera.turn_deg)))
        };
        let names = Kind::named("sun_thermoelectric").map_or(&[][..], Kind::parameters).iter();
        let sum =
            (0..plan.rows()).map(|row| temperatures(motion, row as f64 * plan.step_s)).sum::<Vector2<f64>>();
        let mean = sum / plan.rows() as f64;
        Self {
            cameras: plan.cameras.iter().map(&mut mounted).collect(),
            k,
            offset_nt,
            mu,
            offset_nt_per_k: of.offset_nt_per_k,
            bench: plan.bench.clone(),
            mean_sensor_c: mean.x,
            mean_bench_c: mean.y,
            current: plan.current.clone(),
            sun: names.map(|of| of.name.to_string()).zip(sun.transpose().iter().copied()).collect(),
            latency: plan.latency.clone(),
        }
    }
}

impl Head {
    fn draw(plan: &FlightPlan, number: usize) -> Self {
        let camera = &plan.cameras[number];
        let mut stream = Stream::new(plan.seed, &format!("camera-{}", number + 1));
        let std = Vector3::from(camera.std_arcsec) * ARCSEC;
        let noise = (0..plan.rows()).map(|_| normal(&mut stream).component_mul(&std)).collect();
        // In the clear for a while, then blinded for 2 to 8 minutes.
        let (mut at, mut blinded) = (0.0, Vec::new());
        while camera.gap_share > 0.0 && at < plan.days * DAY_S {
            at -= 300.0 * (1.0 / camera.gap_share - 1.0) * uniform(&mut stream).ln();
            let until = at + 120.0 + 360.0 * uniform(&mut stream);
            blinded.push([at, until]);
            at = until;
        }
        Self { noise, blinded }
    }

    fn sees(&self, time_s: f64) -> bool {
        let next = self.blinded.partition_point(|[_, until]| *until <= time_s);
        self.blinded.get(next).is_none_or(|[from, _]| *from > time_s)
    }
}

/// Of the sensors and of the bench, degC: with the orbit and within a month.
fn temperatures(motion: &Motion<'_>, time_s: f64) -> Vector2<f64> {
    let (angle, slow) = (motion.orbit.angle(time_s), TAU * time_s / (30.0 * DAY_S));
    let at = |mean: f64, later: f64| mean + 3.0 * (angle - later).sin() + 10.0 * (slow - 2.0 * later).sin();
    Vector2::new(at(10.0, 1.0), at(18.0, 0.0))
}

impl Flight<'_> {
    /// The columns, in the order of [`Self::row`].
    fn names(&self) -> Vec<String> {
        let mut names = "time_s sensor_x_nt sensor_y_nt sensor_z_nt latitude_deg longitude_deg height_m \
            sensor_temperature_c bench_temperature_c panel_current_a sun_azimuth_rad sun_elevation_rad sunlit"
            .to_string();
        if self.plan.write_model {
            names += " ambient_x_nt ambient_y_nt ambient_z_nt";
        }
        for head in 1..=self.heads.len() {
            ["w", "x", "y", "z"].iter().for_each(|part| names += &format!(" camera_{head}_{part}"));
        }
        names.split(' ').map(String::from).collect()
    }

    fn row(&self, row: usize, celestial: &mut Celestial) -> Vec<f64> {
        let (plan, truth, time_s) = (self.plan, &self.truth, row as f64 * self.plan.step_s);
        let [now, read, seen] = [0.0, plan.latency.readings_s, plan.latency.attitude_s]
            .map(|late_s| self.motion.at(time_s - late_s, celestial));
        let mut values = vec![time_s];
        values.extend(&(self.reading(&read) + self.noise_nt[row]));
        values.extend([now.place.latitude_deg, now.place.longitude_deg, now.place.height_m]);
        values.extend(&temperatures(&self.motion, time_s));
        values.extend([self.panel_a(&now), now.sun.y.atan2(now.sun.x), now.sun.z.asin(), now.lit]);
        if plan.write_model {
            values.extend(&self.field.main(&now));
        }
        let warm = temperatures(&self.motion, seen.time_s).y - truth.mean_bench_c;
        let flexed = small_rotation(&(Vector3::from(plan.bench.turn_arcsec_per_k) * ARCSEC * warm));
        let attitude = flexed * seen.attitude(plan.attitude_frame);
        for (head, camera) in self.heads.iter().zip(&truth.cameras) {
            let q = quaternion(&(small_rotation(&head.noise[row]) * matrix(camera) * attitude));
            let sees = head.sees(time_s);
            values.extend([q.w, q.i, q.j, q.k].map(|part| if sees { part } else { f64::NAN }));
        }
        values
    }

    /// What the sensors read without noise, nT.
    fn reading(&self, moment: &Moment) -> Vector3<f64> {
        let (truth, sun) = (&self.truth, moment.sun);
        let main = self.field.main(moment);
        let of_sun = self.sun * Vector4::new(1.0, sun.x, sun.y, sun.z) * moment.lit;
        let of_current = Vector3::from(truth.current.nt_per_a) * self.panel_a(moment);
        let field = moment.sen * (main + self.field.besides(moment, &main)) + of_sun + of_current;
        let warm = temperatures(&self.motion, moment.time_s).x - truth.mean_sensor_c;
        let offset = Vector3::from(truth.offset_nt) + Vector3::from(truth.offset_nt_per_k) * warm;
        (matrix(&truth.mu) * field - offset).component_div(&Vector3::from(truth.k))
    }

    /// What the panels on the upper side give, and a load that changes, A.
    fn panel_a(&self, moment: &Moment) -> f64 {
        1.5 + self.load.at(moment.time_s, &Vector3::zeros()).x + 3.0 * moment.lit * (-moment.sun.z).max(0.0)
    }
}
