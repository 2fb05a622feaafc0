//! What quick builds cost at run time: whole programs of the release profile against the same of the profile
//! `dist`, which optimises across crates.
//!
//! Each pair runs one after the other, in turn the one and the other first; the median of the ratios of a
//! program's pairs is told. The programs are those in `target/release` and `target/dist`: `cargo build
//! --release && cargo build --profile dist`.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Pairs of each program.
const PAIRS: usize = 9;
/// A ratio above this is to be mended.
const MOST: f64 = 1.05;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    let folders = ["release", "dist"].map(|profile| target.join(profile));
    let made = tempfile::tempdir().expect("a folder");
    let campaign = made.path().join("campaign.json");
    let (coils, sensors) = (made.path().join("coils.json"), made.path().join("sensors.json"));
    let plan = "fixtures/plans/magsat.json";
    let text = |path: &Path| path.to_str().expect("UTF-8").to_string();
    let [campaign, coils, sensors] = [&campaign, &coils, &sensors].map(|path| text(path));
    let fixed = |words: &[&str]| -> Vec<String> { words.iter().map(ToString::to_string).collect() };
    // Each is made by the one above it.
    let cases = [
        ("simulate", fixed(&["campaign", "-q", plan, "-o", &campaign])),
        ("coilcal", fixed(&["-q", &campaign, "-o", &coils])),
        ("sensorcal", fixed(&["-q", &coils, "-o", &sensors])),
        ("axescal", fixed(&["-q", &sensors])),
        ("diffmag", fixed(&["-q", "fixtures/diffmag/turned-pair/input.json"])),
        ("diagnose", fixed(&["-q", "fixtures/diagnose/orbit/input.json"])),
        ("diagnose", fixed(&["-q", "fixtures/diagnose/warm/input.json"])),
        ("report", fixed(&["-q", &sensors])),
    ];
    for (program, arguments) in &cases {
        let run = |folder: &PathBuf| seconds(&folder.join(program), arguments, &root);
        let mut ratios: Vec<f64> = (0..PAIRS)
            .map(|pair| {
                let (first, second) = (pair % 2, (pair + 1) % 2);
                let mut took = [0.0; 2];
                took[first] = run(&folders[first]);
                took[second] = run(&folders[second]);
                took[0] / took[1]
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        let (median, [low, high]) = (ratios[PAIRS / 2], [ratios[0], ratios[PAIRS - 1]]);
        let word = if median > MOST { ", too slow" } else { "" };
        println!(
            "{program:10} {median:.2} of the time with link-time optimisation ({low:.2} to {high:.2}){word}"
        );
    }
}

/// How long a program takes, s.
fn seconds(program: &Path, arguments: &[String], folder: &Path) -> f64 {
    let begun = Instant::now();
    let nowhere = File::create("/dev/null").expect("a device");
    let status = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::from(nowhere))
        .status()
        .unwrap_or_else(|error| panic!("{}: {error}; build both profiles first", program.display()));
    assert!(status.success(), "{} {arguments:?}", program.display());
    begun.elapsed().as_secs_f64()
}
