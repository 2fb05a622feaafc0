//! Which real recordings are tried as hosts, and how they are cut.
//!
//! Nobody chooses by what is found in them later: of each instrument that lay still the quiet stretches that
//! its notes name, whole days or nights. Those of which diagnose says anything but `agrees` are told and not
//! used.

use recorded::{Error, Series, Stages};

use crate::matrix::matrix;

const DIDD: &str = include_str!("../../../fixtures/ingest/real/didd.json");
const HAMSCI: &str = include_str!("../../../fixtures/ingest/real/hamsci.json");
const MARG: &str = include_str!("../../../fixtures/ingest/real/marg.json");
const MARG_TEMPERATURE: &str = include_str!("../../../fixtures/real/marg-temperature.json");
const MESON_HALL: &str = include_str!("../../../fixtures/real/meson-hall-pair.json");
const DAY_S: f64 = 86_400.0;
const HOUR_S: f64 = 3600.0;
/// What the LEMI-025 of Cobenzl stamps its minutes too early by, s: `diffmag --correct-clock` over twelve
/// days.
const COBENZL_EARLY_S: f64 = 18.38;

/// A recording that may become a host.
#[derive(Debug)]
pub struct Candidate {
    /// Its name in scores.
    pub name: &'static str,
    /// Folder of the recordings.
    pub folder: &'static str,
    /// What it is and how it was cut.
    pub words: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// What is added to the readings of the sensors, as maker or logger state it, nT.
    pub offset_nt: [f64; 3],
    /// Width of a code; 0 where readings are means, whose codes are gone.
    pub code_nt: f64,
    /// Reads it.
    pub read: fn(&Stages) -> Result<Series, Error>,
}

const CONRAD: &str = "wic-conrad-2022-08";
const BOULDER: &str = "usgs-bou-2016-01";
const BY_CONRAD: &str = "Conrad Observatory, GeoSphere Austria (CC-BY-4.0)";
const BY_COBENZL: &str = "github.com/geomagpy/magpy (GPL-3 at that commit)";
const BY_USGS: &str = "U.S. Geological Survey (public domain)";
const CONRAD_COMPENSATION_NT: [f64; 3] = [20_680.0, 0.0, 43_450.0];

/// All of them.
pub const CANDIDATES: &[Candidate] = &[
    Candidate {
        name: "conrad-scalar-20s",
        folder: CONRAD,
        words: "suspended fluxgate FGE S0252 beside the potassium magnetometer GP20S3, a tunnel's quiet day (2022-08-03), means of 20 s",
        source: BY_CONRAD,
        offset_nt: CONRAD_COMPENSATION_NT,
        code_nt: 0.0,
        read: |stages| conrad_scalar(stages, "2022-08-03", 20.0),
    },
    Candidate {
        name: "conrad-scalar-60s",
        folder: CONRAD,
        words: "the same two a week later (2022-08-10), means of a minute",
        source: BY_CONRAD,
        offset_nt: CONRAD_COMPENSATION_NT,
        code_nt: 0.0,
        read: |stages| conrad_scalar(stages, "2022-08-10", 60.0),
    },
    Candidate {
        name: "conrad-vectors",
        folder: CONRAD,
        words: "LEMI-036, 2022-08-10, means of a minute, in the field as the FGE 200 m away has it (by a matrix and offsets of least squares)",
        source: BY_CONRAD,
        offset_nt: [0.0; 3],
        code_nt: 0.0,
        read: |stages| Ok(in_the_field(&conrad_pair(stages)?.means(60.0))),
    },
    Candidate {
        name: "conrad-fge",
        folder: CONRAD,
        words: "the FGE by itself at night, 2022-08-10, 2 to 2.25 h, as it was read each second; its scatter is the field's own variation",
        source: BY_CONRAD,
        offset_nt: [0.0; 3],
        code_nt: 0.001,
        read: |stages| {
            let file = stages.file(&format!("{CONRAD}/fge_s0252_2022-08-10_1s.csv"))?;
            Ok(between(stages.ingest(&[file], None)?.complete(), 2.0 * HOUR_S, 2.25 * HOUR_S))
        },
    },
    Candidate {
        name: "vernadsky",
        folder: "aia-vernadsky-2020-03-03",
        words: "LEMI-025 and a scalar magnetometer in the Antarctic, 2020-03-03, as they were read every ten seconds",
        source: "github.com/geomagpy/magpy (BSD-3-Clause)",
        offset_nt: [19_777.5, 5_570.0, -31_837.5],
        code_nt: 0.01,
        read: |stages| {
            let file = stages.file("aia-vernadsky-2020-03-03/SXY20200303vsec.sec")?;
            Ok(stages.ingest(&[file], None)?.complete())
        },
    },
    Candidate {
        name: "boulder-8",
        folder: BOULDER,
        words: "fluxgate and independent scalar magnetometer of an observatory, minutes of 8 January 2016",
        source: BY_USGS,
        offset_nt: [0.0; 3],
        code_nt: 0.01,
        read: |stages| boulder(stages, 8),
    },
    Candidate {
        name: "boulder-16",
        folder: BOULDER,
        words: "the same two on 16 January 2016",
        source: BY_USGS,
        offset_nt: [0.0; 3],
        code_nt: 0.01,
        read: |stages| boulder(stages, 16),
    },
    Candidate {
        name: "boulder-25",
        folder: BOULDER,
        words: "the same two on 25 January 2016",
        source: BY_USGS,
        offset_nt: [0.0; 3],
        code_nt: 0.01,
        read: |stages| boulder(stages, 25),
    },
    Candidate {
        name: "hmc5883l",
        folder: "marg-hmc5883l-sunsided",
        words: "HMC5883L lying still indoors for eleven minutes, with the thermometer of another chip on its board, means of 0.2 s",
        source: "github.com/sunsided/sensor-fusion (EUPL-1.2)",
        offset_nt: [0.0; 3],
        code_nt: 0.0,
        read: hmc5883l,
    },
    Candidate {
        name: "w2naf-night",
        folder: "hamsci-w2naf-2024-05-10",
        words: "RM3100 with two thermometers, 2 to 8 h UTC before a storm, means of 30 s; its scatter is the field's own variation",
        source: "github.com/HamSCI/mag_lab (GPL-3.0)",
        offset_nt: [0.0; 3],
        code_nt: 0.0,
        read: w2naf,
    },
    Candidate {
        name: "conrad-pair",
        folder: CONRAD,
        words: "FGE S0252 and LEMI-036 in buildings 200 m apart, 2022-08-10, means of two minutes",
        source: BY_CONRAD,
        offset_nt: [0.0; 3],
        code_nt: 0.0,
        read: |stages| Ok(conrad_pair(stages)?.means(120.0)),
    },
    Candidate {
        name: "boulder-published",
        folder: BOULDER,
        words: "minutes of 8 January 2016 as the fluxgate gave them and as the observatory published them, a moving field; its scatter is two roundings",
        source: BY_USGS,
        offset_nt: [0.0; 3],
        code_nt: 0.01,
        read: |stages| boulder_published(stages, 8),
    },
    Candidate {
        name: "cobenzl-night",
        folder: "wik-cobenzl-2011-09a",
        words: "DIDD and LEMI-025 at the edge of a city, 22 to 7.5 h of 2 September 2011, the LEMI's minutes moved by 18.38 s",
        source: BY_COBENZL,
        offset_nt: [0.0; 3],
        code_nt: 0.0,
        read: cobenzl,
    },
    Candidate {
        name: "meson-hall",
        folder: "tucan-fluxgates-2019-08-09-quiet",
        words: "two fluxgates under a cyclotron, read each second for eleven minutes",
        source: "github.com/jmartin1454/tucan-magnetics-mapping-201908 (no licence stated; figures only)",
        offset_nt: [0.0; 3],
        code_nt: 0.0,
        read: meson_hall,
    },
];

/// What lies between two moments, on a clock that is zero at the first.
fn between(series: Series, from_s: f64, to_s: f64) -> Series {
    let time = series.column("time_s").to_vec();
    let start_s = series.start_s;
    let cut = series.filter(|row| time[row] >= from_s && time[row] < to_s);
    // Where no moment is stated there is none to move.
    if start_s > 0.0 { cut.on_clock(start_s + from_s) } else { cut }
}

fn conrad_scalar(stages: &Stages, date: &str, step_s: f64) -> Result<Series, Error> {
    let read = |name: String| stages.ingest(&[stages.file(&format!("{CONRAD}/{name}"))?], None);
    let vector = read(format!("fge_s0252_{date}_1s.csv"))?;
    let scalar = read(format!("gp20s3_scalar_{date}.csv"))?.renamed("sensor", "reference");
    let scalar = scalar.on_clock(vector.start_s);
    Ok(vector.means(step_s).joined(&scalar.means(step_s)).complete())
}

fn conrad_pair(stages: &Stages) -> Result<Series, Error> {
    let read = |name: &str| stages.ingest(&[stages.file(&format!("{CONRAD}/{name}"))?], None);
    let reference = read("fge_s0252_2022-08-10_1s.csv")?.renamed("sensor", "reference");
    let test = read("lemi036_xyz_2022-08-10_1s.csv")?.renamed("sensor", "test");
    Ok(reference.joined(&test).complete())
}

/// The test instrument of a pair in the field that the other one tells it has.
fn in_the_field(pair: &Series) -> Series {
    let Some((eta, offset_nt)) = matrix(pair) else { return Series::default() };
    let field = |reference: [f64; 3]| {
        let own = |j: usize| offset_nt[j] + (0..3).map(|i| reference[i] * eta[(i, j)]).sum::<f64>();
        [own(0), own(1), own(2)]
    };
    let ambient: Vec<[f64; 3]> = pair.vectors("reference").into_iter().map(field).collect();
    let test = pair.vectors("test");
    pair.clone().only(|name| name == "time_s").with_vectors("ambient", &ambient).with_vectors("sensor", &test)
}

fn boulder(stages: &Stages, day: u32) -> Result<Series, Error> {
    let month = stages.ingest(&[stages.file(&format!("{BOULDER}/BOU201601vmin.min"))?], None)?.complete();
    let from = f64::from(day - 1) * DAY_S;
    Ok(between(month, from, from + DAY_S))
}

fn boulder_published(stages: &Stages, day: u32) -> Result<Series, Error> {
    let read = |name: &str| stages.ingest(&[stages.file(&format!("{BOULDER}/{name}"))?], None);
    let raw = read("BOU201601vmin.min")?.only(|name| name != "reference_nt").renamed("sensor", "reference");
    let adjusted = read("BOU201601adj.min")?.only(|name| name != "reference_nt").renamed("sensor", "test");
    let from = f64::from(day - 1) * DAY_S;
    Ok(between(raw.joined(&adjusted).complete(), from, from + DAY_S))
}

fn hmc5883l(stages: &Stages) -> Result<Series, Error> {
    let file = |name: &str| stages.file(&format!("marg-hmc5883l-sunsided/{name}"));
    let field = stages.ingest(&[file("set2_static_10min_mag.csv")?], Some(MARG))?.means_of_all(0.2);
    let temperature = [file("set2_static_10min_temp_decim10.csv")?];
    let temperature = stages.ingest(&temperature, Some(MARG_TEMPERATURE))?.means_of_all(0.2);
    Ok(field.joined(&temperature).complete())
}

fn w2naf(stages: &Stages) -> Result<Series, Error> {
    let file = stages.file("hamsci-w2naf-2024-05-10/w2naf-20240510-runmag.csv")?;
    let day = stages.ingest(&[file], Some(HAMSCI))?;
    Ok(between(day, 2.0 * HOUR_S, 8.0 * HOUR_S).means_of_all(30.0).complete())
}

fn cobenzl(stages: &Stages) -> Result<Series, Error> {
    let folder = "wik-cobenzl-2011-09a";
    let didd = stages.ingest(&stages.files(&format!("{folder}/didd"), ".WIK")?, Some(DIDD))?;
    let lemi = stages.ingest(&stages.files(&format!("{folder}/lemi025"), ".min")?, None)?;
    let reference = didd.only(|name| name != "reference_nt").renamed("sensor", "reference");
    let times = reference.column("time_s").to_vec();
    let stamps: Vec<f64> = times.iter().map(|t| t - COBENZL_EARLY_S).collect();
    let test = lemi.only(|name| name == "time_s" || name.starts_with("sensor")).renamed("sensor", "test");
    let test = test.on_clock(reference.start_s).at(&stamps).with("time_s", times);
    let both = reference.joined(&test).complete();
    Ok(between(both, DAY_S - 2.0 * HOUR_S, DAY_S + 7.5 * HOUR_S))
}

/// The longest part without a gap.
fn meson_hall(stages: &Stages) -> Result<Series, Error> {
    let file = stages.file("tucan-fluxgates-2019-08-09-quiet/online_data.csv")?;
    let series = stages.ingest_with(&[file], Some(MESON_HALL), &["--sort"])?.complete();
    let last = series.column("time_s").last().copied().unwrap_or(0.0);
    Ok(between(series, last - 1000.0, last + 1.0))
}
