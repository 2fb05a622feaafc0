//! What limits a direction, and what more of each thing would give.

use nalgebra::{DMatrix, SMatrix};
use physics::frames::ARCSEC;
use serde::Serialize;

use super::given::{Given, Setting, faces};
use super::information::{ALL, Derivatives, Information, Said};
use super::least::{Recordings, Search, Target, block, covariance};
use super::radius::axes;

/// One source of the error of the direction that errs most.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Limit {
    pub source: String,
    /// Its part of the variance.
    pub share: f64,
    /// What it makes by itself: the largest standard deviation of that direction, arcsec.
    pub arcsec: f64,
}

/// What a change would give.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct More {
    pub change: String,
    /// Largest error of a direction then, arcsec.
    pub worst_arcsec: f64,
    /// Time at the facility that it takes besides, h.
    pub hours: f64,
}

/// Covariance of the turns by source: by name, those of the whole as it is.
pub fn by_source(search: &Search<'_>, recordings: &Recordings) -> Option<Vec<(String, Information)>> {
    let given = search.given;
    let setting = &recordings.setting;
    let (prior, readings) = (given.prior(), given.readings(setting));
    let unrounded = Given { quantisation_nt: 0.0, ..given.clone() };
    let white = unrounded.with_noise(|noise| {
        (noise.flicker_nt2_per_hz_at_1hz, noise.random_walk_nt_per_sqrt_s) = (None, None);
    });
    let [own_rad, shared_rad] = [
        given.theodolite_arcsec / (setting.theodolite_readings as f64).sqrt(),
        given.theodolite_shared_arcsec,
    ]
    .map(|arcsec| arcsec * ARCSEC);
    let std_rad = own_rad.hypot(shared_rad);
    // The information first: gains need the covariance.
    let pieces = given.pieces(search.candidates, setting);
    let said = Said::of(recordings.orientations.iter().map(|orientation| pieces[*orientation].said(std_rad)));
    let alone = Said { gradients: SMatrix::zeros(), ..said.clone() };
    let own = covariance(&alone, &prior)?;
    let mut parts: Vec<(String, Information)> = Vec::new();
    let mut add = |source: &str, part: Information| match parts.iter_mut().find(|(name, _)| name == source) {
        Some((_, sum)) => *sum += part,
        None => parts.push((source.into(), part)),
    };
    let count = readings.drives_nt.len();
    let of =
        |given: &Given, sensor: usize| given.covariance(setting, &readings.drives_nt, &given.noise[sensor]);
    let white_nt2: Vec<DMatrix<f64>> = (0..3).map(|sensor| of(&white, sensor)).collect();
    let slow_nt2: Vec<DMatrix<f64>> =
        (0..3).map(|sensor| of(&unrounded, sensor) - &white_nt2[sensor]).collect();
    for orientation in &recordings.orientations {
        let rotation = &search.candidates[*orientation];
        let Derivatives { jacobian, common, own: turned, .. } =
            Derivatives::of(rotation, &faces(rotation), &readings);
        let rows = 3 * count;
        let by_common = DMatrix::from_fn(rows, ALL, |row, k| jacobian[(row, common[k])]);
        let by_turns = DMatrix::from_fn(rows, 3, |row, k| jacobian[(row, turned[k])]);
        // V⁻¹ = 1 − T (1/s² + TᵀT)⁻¹ Tᵀ in whitened readings.
        let mut weighed = by_common.clone();
        if std_rad > 0.0 {
            let inner = by_turns.transpose() * &by_turns + DMatrix::identity(3, 3) / (std_rad * std_rad);
            weighed -= &by_turns * inner.try_inverse()? * (by_turns.transpose() * &by_common);
        }
        let gain = DMatrix::from_fn(ALL, ALL, |i, j| own[(i, j)]) * weighed.transpose();
        let turned = &gain * &by_turns;
        let theodolites = fixed(&(&turned * turned.transpose()));
        add("theodolites, shared error", theodolites * shared_rad * shared_rad);
        add("theodolites, single readings", theodolites * own_rad * own_rad);
        for sensor in 0..3 {
            let root = readings.covariance[sensor].clone().cholesky()?.unpack();
            let gain = gain.columns(sensor * count, count).into_owned();
            // Back to readings in nT: K = G L⁻¹.
            let gain = root.transpose().solve_upper_triangular(&gain.transpose())?.transpose();
            let of = |part: &DMatrix<f64>| fixed(&(&gain * part * gain.transpose()));
            let all = &readings.covariance[sensor];
            add("white noise", of(&white_nt2[sensor]));
            add("slow noise", of(&slow_nt2[sensor]));
            add("quantisation", of(&(all - &white_nt2[sensor] - &slow_nt2[sensor])));
        }
    }
    let known = [
        ("sensitivities", 12..15),
        ("coil constants", 15..18),
        ("residual field", 18..21),
        ("offsets", 21..24),
    ];
    for (source, places) in known {
        for place in places {
            let moved = own.column(place) * prior[(place, place)].sqrt();
            add(source, moved * moved.transpose());
        }
    }
    let pushed = own * said.gradients;
    add("gradients of the coils", pushed * pushed.transpose());
    Some(parts)
}

fn fixed(matrix: &DMatrix<f64>) -> Information {
    Information::from_fn(|i, j| matrix[(i, j)])
}

/// The sources of the direction that errs most, the largest first; what adds nothing is left out.
pub fn limits(search: &Search<'_>, recordings: &Recordings, target: &Target) -> Vec<Limit> {
    let Some(parts) = by_source(search, recordings) else { return Vec::new() };
    let sum = parts.iter().fold(Information::zeros(), |sum, (_, part)| sum + part);
    let worst = (0..target.turns)
        .step_by(2)
        .max_by(|a, b| target.reach.of(block(&sum, *a)).total_cmp(&target.reach.of(block(&sum, *b))))
        .unwrap_or(0);
    let trace = |part: &Information| part[(worst, worst)] + part[(worst + 1, worst + 1)];
    let all = parts.iter().map(|(source, part)| Limit {
        source: source.clone(),
        share: trace(part) / trace(&sum),
        arcsec: axes(block(part, worst))[0] / ARCSEC,
    });
    let mut limits: Vec<Limit> = all.filter(|limit| limit.share > 1e-4).collect();
    limits.sort_by(|a, b| b.share.total_cmp(&a.share));
    limits
}

/// What more recordings and better instruments would give.
pub fn more(search: &Search<'_>, recordings: &Recordings, target: &Target) -> Vec<More> {
    let before = recordings.hours(search.given).total;
    let worst_arcsec = |given: &Given, recordings: &Recordings| {
        target.worst_arcsec(search.covariance(given, recordings).as_ref())
    };
    let Setting { theodolite_readings, cycles, readings, .. } = recordings.setting;
    let with = |setting: Setting| Recordings { setting, ..recordings.clone() };
    let one_more = search.with_one_more(recordings, target);
    let [theodolite_readings, cycles, readings] = [theodolite_readings, cycles, readings].map(|n| 2 * n);
    let recorded = [
        (format!("one setting more, {} in all", one_more.orientations.len()), one_more),
        (
            format!("{theodolite_readings} theodolite readings in each setting"),
            with(Setting { theodolite_readings, ..recordings.setting }),
        ),
        (
            format!("the drives {cycles} times in each setting"),
            with(Setting { cycles, ..recordings.setting }),
        ),
        (format!("{readings} readings of each drive"), with(Setting { readings, ..recordings.setting })),
    ];
    let mut all: Vec<More> = recorded
        .into_iter()
        .map(|(change, recordings)| More {
            change,
            worst_arcsec: worst_arcsec(search.given, &recordings),
            hours: recordings.hours(search.given).total - before,
        })
        .collect();
    type Change = fn(&Given) -> Given;
    let better: [(&str, Change); 6] = [
        ("theodolite readings with half the error", |given| Given {
            theodolite_arcsec: 0.5 * given.theodolite_arcsec,
            ..given.clone()
        }),
        ("half the shared error of theodolite readings", |given| Given {
            theodolite_shared_arcsec: 0.5 * given.theodolite_shared_arcsec,
            ..given.clone()
        }),
        ("half the white noise", |given| {
            given.with_noise(|noise| noise.white_rms_nt = noise.white_rms_nt.map(|rms| 0.5 * rms))
        }),
        ("half the slow noise", |given| {
            given.with_noise(|noise| {
                noise.flicker_nt2_per_hz_at_1hz = noise.flicker_nt2_per_hz_at_1hz.map(|power| 0.25 * power);
                noise.random_walk_nt_per_sqrt_s = noise.random_walk_nt_per_sqrt_s.map(|rate| 0.5 * rate);
            })
        }),
        ("gradients with half the uncertainty", |given| Given {
            gradient_per_m: given.gradient_per_m.map(|std| 0.5 * std),
            ..given.clone()
        }),
        ("twice the field of the weakest coil", |given| {
            let mut given = given.clone();
            let weakest = given.weakest();
            given.coil_nt[weakest] *= 2.0;
            given
        }),
    ];
    for (change, make) in better {
        let given = make(search.given);
        if given == *search.given {
            continue;
        }
        let worst_arcsec = worst_arcsec(&given, recordings);
        all.push(More { change: change.into(), worst_arcsec, hours: 0.0 });
    }
    all
}
