//! The whole way: campaigns at the coils, calibrated by the other programs, and readings of the true instrument corrected with what
//! they found, over the sphere of fields up to 64 000 nT and the temperatures of the calibration.
//!
//! `FLUXCAL_CAMPAIGNS=500 cargo test --release -p correct --test it campaign:: -- --nocapture` after `cargo build --release`.

use common::{Column, Document, Recording, procedure};
use correct::Options;
use physics::{References, Setting};
use serde_json::Value;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const FIELDS: usize = 400;
const LARGEST_NT: f64 = 64_000.0;

/// Numbers from 0 to 1 that follow each other without pattern.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Fields of every direction and size, at temperatures of sensors and electronics from −7 to 53 degC, a day after the beginning.
pub fn flight(seed: u64) -> Recording {
    let mut numbers = Numbers(seed);
    let mut columns: Vec<(&str, Vec<f64>)> = [
        "time_s",
        "ambient_x_nt",
        "ambient_y_nt",
        "ambient_z_nt",
        "sensor_temperature_c",
        "electronics_temperature_c",
    ]
    .map(|name| (name, Vec::new()))
    .into();
    for row in 0..FIELDS {
        let size = LARGEST_NT * numbers.next().cbrt();
        let (height, azimuth) = (2.0 * numbers.next() - 1.0, std::f64::consts::TAU * numbers.next());
        let across = (1.0 - height * height).sqrt();
        let field = [azimuth.cos() * across, azimuth.sin() * across, height].map(|part| size * part);
        let temperatures = [60.0 * numbers.next() - 7.0, 60.0 * numbers.next() - 7.0];
        let values = [row as f64].into_iter().chain(field).chain(temperatures);
        columns.iter_mut().zip(values).for_each(|((_, column), value)| column.push(value));
    }
    Recording {
        id: "flight".into(),
        procedure: procedure::FREE_RUN.into(),
        start: Some("1977-05-24T08:00:00-05:00".into()),
        columns: columns.into_iter().map(|(name, values)| (name.to_string(), Column::from(values))).collect(),
        ..Recording::default()
    }
}

/// A campaign as it was simulated, and the truth.
pub fn campaign(seed: u64) -> (Document, Value) {
    let text = std::fs::read_to_string(testkit::fixture("plans/magsat.json")).expect("a plan");
    let mut plan: Value = serde_json::from_str(&text).expect("JSON");
    plan["seed"] = seed.into();
    let plan = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    let simulate::Campaign { document, truth, .. } = simulate::campaign(&plan).expect("simulated");
    (document, serde_json::to_value(truth).expect("JSON"))
}

/// The document that the programs make of another, one after the other.
pub fn stages(programs: &[&str], document: &Document) -> Document {
    let folder = Path::new(env!("CARGO_BIN_EXE_correct")).parent().expect("a folder");
    programs.iter().fold(document.clone(), |document, program| {
        let mut run = Command::new(folder.join(program))
            .arg("-q")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("a program");
        let text = common::to_text(&document);
        let mut stdin = run.stdin.take().expect("its input");
        let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
        let run = run.wait_with_output().expect("its output");
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        writer.join().expect("written").expect("read");
        Document::parse(&String::from_utf8_lossy(&run.stdout)).expect("a document")
    })
}

/// What the true instrument reads, rounded to codes.
pub fn read(truth: &Value, mut recording: Recording) -> Recording {
    let mut document =
        Document::parse(&serde_json::json!({"fluxcal": 1, "calibration": truth["calibration"]}).to_string())
            .expect("a document");
    document.model = serde_json::from_value(truth["model"].clone()).expect("a model");
    if let Some(model) = &mut document.model {
        // The facility stays behind.
        model.effects.retain(|effect| effect.sensor.is_some());
    }
    // Days count from the beginning of the campaign.
    let first = Recording {
        id: "beginning".into(),
        start: Some("1977-05-23T08:00:00-05:00".into()),
        ..recording.clone()
    };
    document.recordings = vec![first, recording.clone()];
    let effects = physics::adopt(&document).expect("adopted");
    let setting = Setting::of(&document, &recording, References::of(&document)).expect("a setting");
    let readings = physics::predict(&setting.basic, &effects, &setting.context).expect("predicted").readings;
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        let volts = readings.iter().map(|reading| (reading[k] / 1e-5).round() * 1e-5);
        recording.columns.insert(format!("sensor_{axis}_v"), volts.collect());
    }
    recording
}

#[test]
fn corrected_fields_are_true_within_what_is_stated() {
    let campaigns = testkit::campaigns(1);
    let (mut inside, mut tried, mut first) = (0, 0, 0);
    let (mut squares, mut worst, mut stated, mut ratios) = (0.0, 0.0_f64, 0.0, Vec::new());
    for seed in 1..=campaigns {
        let (document, truth) = campaign(seed);
        let mut document = stages(&["coilcal", "sensorcal", "axescal"], &document);
        document.recordings = vec![read(&truth, flight(seed))];
        let document = correct::run(document, &Options::default()).expect("corrected");
        let recording = &document.recordings[0];
        let column = |name: String| recording.column(&name).expect("a column");
        let mut own: f64 = 0.0;
        for axis in ["x", "y", "z"] {
            let [found, std, truth] =
                ["field", "field_std", "ambient"].map(|quantity| column(format!("{quantity}_{axis}_nt")));
            for row in 0..FIELDS {
                let off = found[row] - truth[row];
                let holds = off.abs() <= 1.96 * std[row];
                inside += usize::from(holds);
                first += usize::from(holds && row == 0);
                tried += 1;
                squares += off * off;
                stated += std[row] * std[row];
                worst = worst.max(off.abs());
                own += (off / std[row]).powi(2);
            }
        }
        ratios.push((own / (3 * FIELDS) as f64).sqrt());
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "{campaigns} campaigns: rms error {:.3} nT, stated {:.3} nT, largest {worst:.2} nT; 95 % intervals hold {:.1} % of {tried}; \
         error over stated, by campaign: {:.2} to {:.2}",
        (squares / f64::from(tried)).sqrt(),
        (stated / f64::from(tried)).sqrt(),
        100.0 * inside as f64 / f64::from(tried),
        ratios[0],
        ratios[ratios.len() - 1]
    );
    assert!(worst < 5.0, "{worst}");
    // One field of each campaign and component: those are independent of each other but for the components.
    assert!(testkit::agrees(first, 3 * campaigns as usize, [0.93, 1.0], 1), "{first} of {}", 3 * campaigns);
}
