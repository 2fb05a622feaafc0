//! What a campaign gives, and what a faulty plan gets.

use serde_json::{Value, json};

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

fn plan() -> Value {
    serde_json::from_str(&testkit::read_fixture("plans/magsat-axes.json")).expect("a plan")
}

fn document(plan: &Value) -> Value {
    let run = testkit::run(SIMULATE, &["campaign", "-q"], &plan.to_string());
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).expect("JSON")
}

#[test]
fn newsim_gives_table_4() {
    // NEWSIM's inputs are Tables 2 and 3; its 63 outputs are Table 4, of which two do not survive (see
    // nasa_tables.py).
    let printed: Value =
        serde_json::from_str(&testkit::read_fixture("nasa-1977/table-4.json")).expect("JSON");
    let truth: Value = serde_json::from_str(&testkit::read_fixture("nasa-1977/table-2.json")).expect("JSON");
    let plan = json!({
        "fluxcal": 1,
        "instrument": {"sensors": ["x", "y", "z"]},
        "calibration": printed["calibration"],
        "truth": {"calibration": {"axes": truth["calibration"]["axes"]}},
        "procedures": [{"procedure": "axes_orientation", "id": "orientation", "orientations": "nasa_table_3", "drive_nt": 50000}]
    });
    let simulated = document(&plan);
    let mut far = Vec::new();
    for (number, (ours, theirs)) in recordings(&simulated).iter().zip(recordings(&printed)).enumerate() {
        for sensor in ["x", "y", "z"] {
            for row in 0..3 {
                let name = format!("sensor_{sensor}_v");
                let value = |recording: &Value| recording["columns"][&name][row].as_f64().expect("a reading");
                // Half of the sixth decimal, and columns of Table 2 that are longer than 1 by up to 4.65e-6
                // (sensor z) and 1.71e-6 (coil y); the simulation makes unit vectors of them.
                if (value(ours) - value(&theirs)).abs() > 6.9e-6 {
                    far.push((number + 1, row + 1, sensor));
                }
            }
        }
    }
    assert_eq!(far, [(1, 2, "x"), (4, 1, "y")]);
}

fn recordings(document: &Value) -> Vec<Value> {
    document["recordings"].as_array().expect("a list").clone()
}

#[test]
fn long_recordings_go_beside_the_document() {
    let plan = json!({
        "fluxcal": 1,
        "instrument": {"noise": {"white_rms_nt": 0.01}},
        "procedures": [
            {"procedure": "sensor_noise", "id": "shield", "series": [
                {"length_s": 120.0, "step_s": 0.01},
                {"length_s": 100.0, "step_s": 1.0}
            ]}
        ]
    });
    let whole = document(&plan);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("campaign.json");
    let path = file.to_str().expect("UTF-8");
    let run = testkit::run(SIMULATE, &["campaign", "--beside", "-o", path], &plan.to_string());
    assert!(run.code == 0 && run.stderr.contains("12100 rows"), "{}", run.stderr);
    let text = std::fs::read_to_string(&file).expect("a document");
    let mut beside = common::Document::parse(&text).expect("a document");
    assert_eq!(beside.recordings[0].table.as_deref(), Some("shield-1.parquet"));
    assert_eq!((beside.recordings[0].rows(), beside.recordings[1].rows()), (0, 100));
    program::beside::read(&mut beside, folder.path(), &["sensor_noise"]).expect("the table");
    let of = |recording: &common::Recording| recording.column("sensor_x_nt").expect("readings").to_vec();
    let whole = common::Document::parse(&whole.to_string()).expect("a document");
    assert!(of(&beside.recordings[0]) == of(&whole.recordings[0]), "the same readings to the last digit");
}

#[test]
fn the_truth_goes_to_its_own_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("truth.json");
    let path = file.to_str().expect("UTF-8");
    let run = testkit::run(SIMULATE, &["campaign", "--truth", path], &plan().to_string());
    assert!(run.code == 0 && run.stderr.contains("7 recordings, 56 rows, seed 1977"), "{}", run.stderr);
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(&file).expect("there")).expect("JSON");
    assert_eq!(truth["residual_field_nt"], json!([0.15, -0.1, 0.2]));
    assert_eq!(truth["orientations"].as_array().map(Vec::len), Some(7));
    for word in ["truth", "residual_field_nt", "0.99875"] {
        assert!(!run.stdout.contains(word), "the document tells {word}");
    }
}

#[test]
fn seeds_and_channels() {
    let first = document(&plan());
    assert_eq!(first, document(&plan()));
    let other = testkit::run(SIMULATE, &["campaign", "-q", "--seed", "3"], &plan().to_string());
    assert_ne!(
        first["recordings"],
        serde_json::from_str::<Value>(&other.stdout).expect("JSON")["recordings"]
    );
    // A channel less leaves the others as they were.
    let mut fewer = plan();
    fewer["procedures"][0]["sensors"] = json!(["x", "z"]);
    for (all, fewer) in recordings(&first).iter().zip(recordings(&document(&fewer))) {
        assert_eq!(all["columns"]["sensor_z_v"], fewer["columns"]["sensor_z_v"]);
        assert!(fewer["columns"].get("sensor_y_v").is_none());
    }
}

#[test]
fn what_the_truth_does_not_mention_is_as_stated() {
    let mut partial = plan();
    partial["truth"]["calibration"]["coils"] = json!({"x": {"constant_nt_per_a": 41000.0}});
    let (all, partial) = (document(&plan()), document(&partial));
    let reading = |document: &Value, row: usize| {
        document["recordings"][0]["columns"]["sensor_x_v"][row].as_f64().expect("a reading")
    };
    // Row 1 drives coil x, row 3 coil y.
    assert!((reading(&partial, 1) / reading(&all, 1) - 41000.0 / 41234.5).abs() < 1e-4);
    assert_eq!(reading(&partial, 3), reading(&all, 3));
}

#[test]
fn an_effect_of_temperature_needs_its_reference() {
    let mut plan = json!({
        "fluxcal": 1,
        "calibration": {"coils": {"x": {"constant_nt_per_a": 40000.0}}},
        "truth": {"model": {"effects": [{"effect": "offset_temperature_lag", "sensor": "x",
            "parameters": {"coefficient_nt_per_k": 1.0, "lag_s": 1e-6}}]}},
        "procedures": [{"procedure": "free_run", "id": "run", "columns": {
            "time_s": [0.0, 600.0], "coil_x_a": [0.0, 0.0], "sensor_temperature_c": [20.0, 26.0]}}]
    });
    let refused = testkit::run(SIMULATE, &["campaign", "-q"], &plan.to_string());
    assert_eq!(refused.code, 2, "{}", refused.stderr);
    let said = "offset_temperature_lag without calibration.reference_conditions.sensor_temperature_c";
    assert!(refused.stderr.contains(said), "{}", refused.stderr);
    plan["calibration"]["reference_conditions"] = json!({"sensor_temperature_c": 23.0});
    assert_eq!(document(&plan)["recordings"][0]["columns"]["sensor_x_nt"][0], json!(-3.0));
}

/// What is set in the plan, and below it what is said.
const FAULTS: &str = r#"
procedures.0.drive_nt = 70000
    procedures[0].drive_nt: found 70000 nT on coil x; expected at most 60000 nT
procedures.0.drive_nt = 0
    procedures[0].drive_nt: found 0; expected a positive number
procedures.0.repeats = 0
    procedures[0].repeats: found 0
procedures.0.drives.1 = "up"
    procedures[0].drives[1]: found "up"; expected "x", "-x"
procedures.0.orientations = "sphere"
    procedures[0].orientations: found "sphere"
procedures.0.orientations = [[[1, 0, 0], [0, 1, 0], [0, 0, -1]]]
    procedures[0].orientations[0]: found a left-handed matrix
procedures.0.ac = {"hz": 0.1, "cycles": 1e9, "rate_hz": 100}
    procedures[0].ac: found 1·10¹² samples in one recording; expected at least 5 and at most 5·10⁷
procedures.0 = {"procedure": "orbit", "id": "o", "length_s": 1e9, "step_s": 20}
    procedures[0]: found 5·10⁷ samples in one recording; expected at least 5 and at most 5000000
procedures.0.ac = {"hz": 0.1, "cycles": 0, "rate_hz": 100}
    procedures[0].ac.cycles: found 0; expected a positive number
truth.model = {"effects": [{"effect": "gremlins", "sensor": "x"}]}
    truth.model.effects[0]: found the effect "gremlins"; expected one of quadratic_nonlinearity, cubic_nonlinearity
truth.model = {"effects": [{"effect": "coil_heating", "coil": "x", "parameters": {"fall_ppm_per_a2": 10, "lag_s": -1}}]}
    truth.model.effects[0]: found lag_s = -1; expected a positive number
instrument.noise.flicker_exponent = 3
    instrument.noise.flicker_exponent: found 3; expected an exponent from 0 (white) to 2 (random walk)
procedures.0.procedure = "dance"
    procedures[0].procedure: found "dance"; expected one of "coil_constant"
procedures.0.repeats = 1000000000
    procedures[0]: found 1.92·10¹¹ rows so far; expected at most 5·10⁷
procedures.0.drives = []
    procedures[0].drives: found an empty list
procedures = []
    procedures: found an empty list
procedures.0.drive_nT = 1
    procedures[0]: found the unknown key "drive_nT"; expected one of
procedures = [{"procedure": "free_run", "id": "axes-1", "columns": {"time_s": [0]}}, {"procedure": "axes_orientation", "id": "axes", "orientations": "cube", "drive_nt": 1}]
    procedures[1].orientations[0]: found a second recording "axes-1"
procedures.0 = {"procedure": "free_run", "id": "run", "columns": {"time_s": [0.0, 1.0], "coil_x_a": [1.0]}}
    recordings[0].columns.coil_x_a: found 1 row where another column has 2
procedures.0 = {"procedure": "free_run", "id": "run", "columns": {"coil_x_a": [9.0]}}
    procedures[0].columns.coil_x_a: found 371110 nT on coil x; expected at most 60000 nT
procedures.0 = {"procedure": "free_run", "id": "run", "columns": {"coil_x_v": [9.0]}}
    procedures[0].columns.coil_x_v: found a drive in V; expected `coil_x_a`
procedures.0 = {"procedure": "free_run", "id": "run", "columns": {"time_s": []}}
    procedures[0].columns: found no rows
procedures.0 = {"procedure": "coil_constant", "id": "coil", "coil": "x", "to_nt": 61000}
    procedures[0].to_nt: found 61000 nT on coil x; expected at most 60000 nT
procedures.0 = {"procedure": "coil_constant", "id": "coil", "coil": "x", "from_nt": 15000}
    procedures[0].from_nt: found 15000 nT, which the scalar magnetometer does not read; expected 20000 to 60000 nT
procedures.0 = {"procedure": "nulling_residual", "id": "null", "series": []}
    procedures[0].series: found an empty list
procedures.0 = {"procedure": "sensor_noise", "id": "noise", "series": [{"length_s": 1e12, "step_s": 1}]}
    procedures[0].series[0]: found 1·10¹² samples in one recording
procedures.0 = {"procedure": "temperature_run", "id": "warm", "monitor_s": 3600}
    procedures[0].monitor_s: found 3600, longer than the 1800 s of timing.temperature_settle_s
procedures.0 = {"procedure": "offset_drift", "id": "drift"}
    start: found no such key; expected the moment at which the campaign begins
procedures.0 = {"procedure": "differential", "id": "pair"}
    truth.outside: found no such key; expected the natural field
start = "1977-05-26T09:00:00"
    start: found "1977-05-26T09:00:00"; expected a moment with its offset
timing = {"reading_s": -1}
    timing.reading_s: found -1; expected a positive number
truth.model = {"effects": [{"effect": "stray_current", "column": "panel_current_a", "parameters": {"x_nt_per_a": 1, "y_nt_per_a": 1, "z_nt_per_a": 1}}]}
    truth.model.effects[0].column: found "panel_current_a"; expected a column that one of the recordings has
calibration.reference_conditions = {"sensor_temperature_c": 23}
truth.model = {"effects": [{"effect": "offset_temperature", "sensor": "x", "parameters": {"coefficient_nt_per_k": 1, "curvature_nt_per_k2": 0}}]}
    expected the column `sensor_temperature_c`; state `temperatures` in the plan
"#;

#[test]
fn faulty_plans_are_refused_with_their_place() {
    assert_eq!(crate::build::refused("campaign", &plan(), FAULTS), 33);
}
