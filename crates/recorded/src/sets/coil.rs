//! Fluxgates beside coils and magnets.

use serde_json::{Value, json};

use crate::Error;
use crate::known::KnownFact;
use crate::page::{Page, array, plus_minus, three, verdict};
use crate::series::{Series, mean, rms};
use crate::stages::Stages;

const GRADIOMETER: &str = include_str!("../../../../fixtures/ingest/real/gradiometer.json");
/// Half of the stated 5 V from peak to peak over the stated 21.5 ohm, A.
const DRIVE_A: f64 = 2.5 / 21.5;
/// A reading belongs to a level of the square wave within so much, nT.
const LEVEL_NT: f64 = 100.0;
/// What the readings of one level scatter by, nT, as the rows of the run before the first switching show.
const NOISE_NT: f64 = 5.0;

/// The drive was not recorded: its sign is taken from z, and it is unknown beside a switching.
fn drive(z: &[f64]) -> Vec<f64> {
    let mut sorted = z.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (sorted[sorted.len() / 10], sorted[sorted.len() - 1 - sorted.len() / 10]);
    let sign = |row: usize| if z[row] > (low + high) / 2.0 { 1.0 } else { -1.0 };
    let at_level = |row: usize| (z[row] - if sign(row) > 0.0 { high } else { low }).abs() < LEVEL_NT;
    let held = |row: usize| {
        let near = row.saturating_sub(1)..(row + 2).min(z.len());
        row == 0 || near.clone().all(|other| other == 0 || (at_level(other) && sign(other) == sign(row)))
    };
    (0..z.len()).map(|row| if held(row) { sign(row) * DRIVE_A } else { f64::NAN }).collect()
}

/// A fluxgate in the laboratory's field beside a coil; the first row of the logger is known to be an
/// artefact, and diagnose is not told.
pub fn square_wave(stages: &Stages) -> Result<Page, Error> {
    let file = stages.file("tucan-coil-tests/squareCoil_F=0.1Hz_Resistor.csv")?;
    let series = stages.ingest(&[file], None)?;
    let drive = drive(series.column("sensor_z_nt"));
    let step = |axis: &str, rows: std::ops::Range<usize>| {
        let values = series.column(&format!("sensor_{axis}_nt"));
        let level = |sign: f64| {
            let at: Vec<f64> =
                rows.clone().filter(|row| drive[*row] * sign > 0.0).map(|row| values[row]).collect();
            let middle = mean(at.iter().copied());
            (middle, rms(at.iter().map(|value| value - middle)) / (at.len() as f64).sqrt())
        };
        let ((high, high_std), (low, low_std)) = (level(1.0), level(-1.0));
        (high - low, high_std.hypot(low_std))
    };
    let half = series.rows() / 2;
    let steps = |rows: std::ops::Range<usize>| {
        ["x", "y", "z"].map(|axis| step(axis, rows.clone())).map(|(nt, std)| plus_minus(nt, std)).join("; ")
    };
    let mut page = Page::default();
    page.say(format!(
        "One fluxgate, a coil, 5 V from peak to peak at 0.1 Hz through 21.5 ohm. The drive itself was not recorded: its sign is taken from z, and rows beside a switching are \
         given no drive. The switching moves x; y; z by {} nT in the first half (its first row left out) and by {} nT in the second (± as if readings were independent).",
        steps(1..half),
        steps(half..series.rows()),
    ));
    let ambient = |axis: &str| {
        let values = series.column(&format!("sensor_{axis}_nt"));
        vec![mean(values[1..].iter().copied()); series.rows()]
    };
    let mut driven = series.clone().with("coil_z_a", drive.clone());
    for axis in ["x", "y", "z"] {
        driven = driven.with(format!("ambient_{axis}_nt"), ambient(axis));
    }
    let coil = json!({"calibration": {"coils": {"z": {"constant_nt_per_a": 3000.0}}}});
    let with_noise =
        json!({"calibration": coil["calibration"], "instrument": {"noise": {"white_rms_nt": NOISE_NT}}});
    for (what, given) in
        [("With a scatter of 5 nT declared:", with_noise), ("Without any noise declared:", coil)]
    {
        page.say(what);
        match stages.stage("diagnose", &[], vec![driven.recording("square", "free_run")], &given)? {
            Ok(document) => {
                let first = |effect: &&Value| {
                    let time = &effect["parameters"]["time_s"];
                    effect["effect"] == "spike" && time.as_f64().or(time["value"].as_f64()) == Some(0.0)
                };
                let found = array(&document["diagnosis"][0]["effects"]).filter(first).count();
                page.known.push(KnownFact {
                    from: "notes of the square wave",
                    what: "the logger's first row is a start-up artefact",
                    stage: "diagnose",
                    answer: format!("{what} a spike in the first row of {found} of three axes")
                        .replace(':', ""),
                    found: found == 3,
                });
                page.head(format!(
                    "{what} the known artefact of the first row is found in {found} of three axes; {}.",
                    verdict(&document)
                ));
                page.diagnosis(&document);
            }
            Err(words) => page.refused("diagnose", &words),
        }
    }
    page.say("The logger's first row is known to be an artefact; diagnose was not told.");
    let total: Vec<f64> = series.vectors("sensor").into_iter().map(crate::series::length).collect();
    let scalar = Series::default().with("coil_z_a", drive).with("reference_nt", total);
    let mut recording = scalar.recording("square", "coil_constant");
    recording["conditions"] = json!({"coil": "z"});
    if let Err(words) = stages.stage("coilcal", &[], vec![recording], &json!({}))? {
        page.refused("coilcal", &words);
    }
    page.undecided(
        "the coil's constant apart from the fluxgate's sensitivity (only their product is seen), and either in nT per ampere, because the current was never measured; whether the slow \
         change beside the switching is the laboratory's field or the coil that warms: one run, no thermometer.",
    );
    Ok(page)
}

/// An empty scan as the simulation against which another empty scan, and one with a foil, are held.
pub fn gradiometer(stages: &Stages) -> Result<Page, Error> {
    let read = |name: &str| -> Result<Series, Error> {
        let file = stages.file(&format!("tucan-coil-tests/{name}.csv"))?;
        let scan = stages.ingest(&[file], Some(GRADIOMETER))?;
        Ok(scan.only(|column| !column.starts_with("test")).renamed("reference", "sensor"))
    };
    let empty = read("2021-03-03_16-00-03-background-2")?;
    let mut page = Page::default();
    let mut told = Vec::new();
    page.say(
        "A fluxgate through 0.8 m of gradient, 974 places. The scan of the empty holder is the prediction (`--against`); held against it are a scan with a magnetised foil, and the empty holder \
         again ten minutes after. How far two empty scans differ is what a foil must exceed.",
    );
    for (what, name) in [
        ("The empty holder again:", "2021-03-03_16-10-01-background-3"),
        ("With the foil:", "2021-03-03_16-03-59-FOIL4-Primary"),
    ] {
        let scan = read(name)?;
        let differences = ["x", "y", "z"].map(|axis| {
            let column = format!("sensor_{axis}_nt");
            let pairs = scan.column(&column).iter().zip(empty.column(&column));
            let differences: Vec<f64> = pairs.map(|(a, b)| a - b).collect();
            three(rms(differences))
        });
        page.say(format!("{what} rms of the difference x; y; z {} nT.", differences.join("; ")));
        let scan = scan.with("position_m", empty.column("position_m").to_vec());
        let recordings = |series: &Series| vec![series.recording("scan", "free_run")];
        match stages.against(recordings(&scan), recordings(&empty))? {
            Ok(document) => {
                page.head(format!("{what} {}.", verdict(&document)));
                page.diagnosis(&document);
                told.push(verdict(&document));
            }
            Err(words) => page.refused("diagnose", &words),
        }
    }
    if let [empty, foil] = &told[..] {
        page.known.push(KnownFact {
            from: "notes of the gradiometer",
            what: "a magnetised foil in one scan, the holder empty in the other",
            stage: "diagnose",
            answer: format!("{foil} with the foil, {empty} of the empty holder"),
            found: foil != "agrees" && empty == "agrees",
        });
    }
    page.undecided(
        "the foil's size and place: the catalogue's nearest is a vehicle that passes, a dipole on a straight path, right in form and wrong in name; and below some 10 nT nothing at all, because two empty scans \
         differ by as much: the carriage does not come back to the same place in the gradient.",
    );
    Ok(page)
}
