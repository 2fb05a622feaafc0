//! The settings of a plan for the person at the facility.

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

fn sheet(plan: &str) -> (Vec<Vec<String>>, String) {
    let plan = testkit::read_fixture(&format!("plans/{plan}.json"));
    let run = testkit::run(SIMULATE, &["campaign", "--run-sheet"], &plan);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(run.stdout.as_bytes());
    let rows = reader.records().map(|row| row.expect("a row").iter().map(String::from).collect()).collect();
    (rows, run.stderr)
}

#[test]
fn settings_of_the_magsat_campaign() {
    let (rows, said) = sheet("magsat");
    let head = "step,time_s,start,recording,orientation,coil_x_a,coil_y_a,coil_z_a,sensor_temperature_c,electronics_temperature_c,wait_s,readings,length_s,action";
    assert_eq!(rows[0].join(","), head);
    assert!(said.contains("5115 settings") && said.contains("7 d 17 h 33 min of work in 373 d 6 h 45 min"));
    // 20 000 nT with the stated 41 200 nT/A, ten readings of a second after ten seconds.
    assert_eq!(rows[2][3..13].join(","), "coil-x,x:+north y:+east z:+down,0.4854369,0,0,,,10,10,10");
    let hot = rows.iter().find(|row| row[13] == "sensor to 53 degC").expect("the hottest");
    assert_eq!(hot[8..13].join(","), "53,23,1800,0,0");
    // A sensor along coil z, and the block turned: nominal orientations, not what is true.
    assert!(rows.iter().any(|row| row[3] == "sensitivity-x" && row[4] == "x:+down y:+north z:+east"));
    assert!(rows.iter().any(|row| row[3] == "cross-turned-x-z" && row[4] == "x:+north y:-down z:+east"));
    // Time runs on, and the last date is a year later.
    let times: Vec<f64> = rows[1..].iter().map(|row| row[1].parse().expect("a time")).collect();
    assert!(times.windows(2).all(|pair| pair[1] >= pair[0]));
    assert!(times.last().is_some_and(|t| *t > 52.0 * 604_800.0));
}

#[test]
fn the_sheet_knows_nothing_of_the_truth() {
    let plan = testkit::read_fixture("plans/magsat.json");
    let mut other: serde_json::Value = serde_json::from_str(&plan).expect("JSON");
    other["truth"] = serde_json::json!({});
    other["seed"] = serde_json::json!(5);
    let sheet = |plan: &str| testkit::run(SIMULATE, &["campaign", "--run-sheet"], plan).stdout;
    assert_eq!(sheet(&plan), sheet(&other.to_string()));
}
