//! What a flight gives, and what a faulty plan gets.

use common::Recording;
use mainfield::{Celestial, Model, Place, itrf_to_geo};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use physics::frames::{ARCSEC, matrix, small_rotation};
use serde_json::{Value, json};
use simulate::{FlightPlan, MadeFlight};

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

/// A plan without noise and errors of the field, with what calibration is for.
fn exact(frame: &str) -> Value {
    json!({
        "fluxcal": 1, "seed": 4, "days": 0.2, "step_s": 20, "attitude_frame": frame, "write_model": true,
        "cameras": [{"turn_deg": [140, 0, 0], "std_arcsec": [0, 0, 0]}, {"std_arcsec": [0, 0, 0], "gap_share": 0}],
        "sensors": {"noise_nt": 0, "offset_nt_per_k": [0.1, -0.2, 0.3]}, "sun": {"lit_nt": 2},
        "field": {"model_std_nt": 0, "auroral_nt": 0, "ring_nt": 0},
        "bench": {"turn_arcsec_per_k": [3, -2, 1]}, "current": {"nt_per_a": [0.5, 1, -1]}
    })
}

fn made(plan: &Value) -> MadeFlight {
    simulate::flight(&FlightPlan::parse(&plan.to_string()).expect("a plan")).expect("a flight")
}

fn number(set: &Recording, name: &str, row: usize) -> f64 {
    set.column(name).unwrap_or_else(|| panic!("{name}"))[row]
}

fn vector(set: &Recording, name: &str, row: usize) -> Vector3<f64> {
    Vector3::from(["x", "y", "z"].map(|axis| number(set, &name.replace('*', axis), row)))
}

/// From the frame of reference to a head that sees stars.
fn attitude(set: &Recording, head: usize, row: usize) -> Option<UnitQuaternion<f64>> {
    let [w, x, y, z] =
        ["w", "x", "y", "z"].map(|part| number(set, &format!("camera_{}_{part}", head + 1), row));
    w.is_finite().then(|| UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)))
}

/// Readings by the truth, the attitude of a head, and the field by its model.
#[test]
fn the_truth_gives_the_readings() {
    for frame in ["geo", "itrf", "icrf"] {
        let MadeFlight { document, truth } = made(&exact(frame));
        let set = &document.recordings[0];
        let (start, mut celestial) = (set.start().expect("a start"), Celestial::default());
        let (mut compared, mut lit_rows) = (0, 0.0);
        for row in 0..set.rows() {
            let at = |name: &str| number(set, name, row);
            let [latitude_deg, longitude_deg] = ["latitude_deg", "longitude_deg"].map(at);
            let place = Place { latitude_deg, longitude_deg, height_m: at("height_m") };
            let now = start.after(at("time_s"));
            let geo = Model::Igrf14.field_nt(&place, now.year().expect("a year")).expect("in its years");
            let geo = Vector3::from(geo);
            assert!((geo - vector(set, "ambient_*_nt", row)).norm() < 1e-6);
            let to_geo = itrf_to_geo(latitude_deg.to_radians(), longitude_deg.to_radians());
            let field = match frame {
                "geo" => geo,
                "itrf" => to_geo.transpose() * geo,
                _ => (to_geo * celestial.to_earth(now.unix_s).expect("after 1972")).transpose() * geo,
            };
            let ((sine, cosine), (up, level)) =
                (at("sun_azimuth_rad").sin_cos(), at("sun_elevation_rad").sin_cos());
            let sun = ["x", "y", "z"].map(|axis| {
                let of = |name: &str| truth.sun[&format!("{axis}_{name}_nt")];
                of("lit") + level * (of("cosine") * cosine + of("sine") * sine) + of("up") * up
            });
            let current = Vector3::from(truth.current.nt_per_a) * at("panel_current_a");
            let added = Vector3::from(sun) * at("sunlit") + current;
            let warm = at("sensor_temperature_c") - truth.mean_sensor_c;
            let offset = Vector3::from(truth.offset_nt) + Vector3::from(truth.offset_nt_per_k) * warm;
            let bent_arcsec = at("bench_temperature_c") - truth.mean_bench_c;
            let bent = Vector3::from(truth.bench.turn_arcsec_per_k) * bent_arcsec * ARCSEC;
            for (head, camera) in truth.cameras.iter().enumerate() {
                let Some(seen) = attitude(set, head, row) else { continue };
                let in_sen = (matrix(camera) * small_rotation(&bent)).transpose() * (seen * field) + added;
                let read = (matrix(&truth.mu) * in_sen - offset).component_div(&Vector3::from(truth.k));
                assert!((read - vector(set, "sensor_*_nt", row)).norm() < 1e-6, "{frame} {row} {head}");
                compared += 1;
            }
            lit_rows += at("sunlit") / set.rows() as f64;
        }
        // One head of the two is blinded at times; a third of the orbit is in the shadow.
        assert!(compared > set.rows() && compared < 2 * set.rows(), "{compared}");
        assert!((0.55..0.75).contains(&lit_rows), "{lit_rows}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let plan = testkit::read_fixture("plans/flight.json");
    let run = |seed: &str| testkit::run(SIMULATE, &["flight", "-q", "--seed", seed], &plan).stdout;
    assert!(run("7") == run("7") && run("7") != run("8"));
    // Long readings go beside the document.
    let folder = tempfile::tempdir().expect("a folder");
    let output = folder.path().join("flight.json");
    let output = output.to_str().expect("UTF-8");
    let long = plan.replace("\"step_s\": 60", "\"step_s\": 8");
    assert_eq!(testkit::run(SIMULATE, &["flight", "-q", "-o", output], &long).code, 0);
    assert!(folder.path().join("flight.parquet").exists());
}

const FAULTS: &str = r#"
days = -1
    days: found −1; expected 0.001 to 1000
step_s = 3600
    step_s: found 5 rows; expected 10
start = "2029-12-31T23:00:00Z"
    start: found "2029-12-31T23:00:00Z"; expected a moment
cameras = []
    cameras: found 0; expected 1 to 3
cameras = [{}, {"gap_share": 2}]
    cameras[1].gap_share: found 2; expected 0 to 1
latency = {"readings_s": -1}
    latency.readings_s: found −1; expected 0 to 60
field = {"auroral_nt": -1}
    field.auroral_nt: found −1
attitude_frame = "gei"
    attitude_frame
height_km = 460
    height_km
"#;

#[test]
fn faulty_plans_are_refused_with_their_place() {
    assert_eq!(crate::build::refused("flight", &exact("icrf"), FAULTS), 9);
}
