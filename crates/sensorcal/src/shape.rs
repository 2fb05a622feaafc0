//! The noise on which the intervals of a fit rest.

use common::{Axis, Document, Noise, SensorNoise};
use physics::References;

use crate::Result;
use crate::allowed::{Allowed, Memory, More, Rows, WEIGHTY, undetermined};

/// A recording longer than this sees the field in the coils drift, s.
const DRIFTS_S: f64 = 7200.0;
/// Readings of a fit with a full covariance matrix, at most: beyond, it is a sum of processes in one pass.
const FULL: usize = 2000;
/// Variance of a recording's own level over that of its readings, where several share their constants.
const LEVELS: [f64; 4] = [0.0, 0.25, 1.0, 4.0];
/// Powers of a reading's noise with which slow noise scatters: with the fast noise, not at all, with its
/// variance.
const POWERS: [f64; 3] = [1.0, 0.0, 2.0];

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// In the field of a coil, which has a noise of its own.
    Coils,
    /// The same in several recordings that share their constants, so that each may have a level of its own.
    Levels,
    Shield,
}

#[derive(Clone, Debug)]
pub struct Shape {
    known: Option<Noise>,
    /// That of the field in the coils beside it, as the facility declares it.
    field: Option<Noise>,
    /// Where from: `measured`, `declared`, `residuals`.
    source: &'static str,
    /// Variance of rounding, nT².
    rounding_nt2: f64,
    /// Readings in one fit up to which its covariance is a full matrix: [`FULL`], except in tests.
    pub full: usize,
}

/// A sensor of a document, with its noise where that was measured.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    pub document: &'a Document,
    pub references: References,
    pub sensor: Axis,
    pub measured: Option<&'a SensorNoise>,
}

impl Subject<'_> {
    /// Its noise as it was measured in this document; else as the instrument declares it; else from the
    /// residuals. Beside noise that is known counts that of the field in the coils as the facility declares
    /// it. Rounding to codes of `code_nt` counts as white noise.
    pub fn shape(&self, code_nt: f64) -> Shape {
        let Subject { document, sensor, measured, .. } = *self;
        let declared = document.instrument.as_ref().and_then(|instrument| instrument.noise_of(sensor));
        let noisy = |noise: &Noise| noise.rms_nt(1e3, 1.0) > 0.0;
        let measured = measured.map(crate::noise::as_noise).filter(noisy);
        let (known, source) = match (measured, declared.filter(|noise| noisy(noise))) {
            (Some(measured), _) => (Some(measured), "measured"),
            (None, Some(declared)) => (Some(declared.clone()), "declared"),
            (None, None) => (None, "residuals"),
        };
        let field = document.facility.as_ref().and_then(|facility| facility.noise.clone());
        let field = field.filter(|noise| known.is_some() && noisy(noise));
        Shape { known, field, source, rounding_nt2: code_nt * code_nt / 12.0, full: FULL }
    }
}

impl Shape {
    pub fn is_known(&self) -> bool {
        self.known.is_some()
    }

    /// The covariances that are allowed for, over several recordings that share nothing: the times of each,
    /// or how many rows it has. Where the sensor's noise is known and a coil makes the field, white and
    /// flicker noise of the field may come on top, and in recordings of more than two hours a random walk;
    /// where it is not known, white noise alone or with flicker noise in every proportion.
    ///
    /// With sizes and weights, the noise of each reading has a size of its own, by recording and row; in one
    /// pass, each recording. What is slower than the readings follow each other scatters with a power of that,
    /// any of [`POWERS`]: traffic by day may add more to the slow noise than to the fast. Only of what has some
    /// of the weights, which a fit gave to those without.
    pub fn allowed(
        &self,
        recordings: &[Rows],
        place: Place,
        sized: Option<(&[Vec<f64>], &[f64])>,
    ) -> Result<Allowed> {
        let (sizes, weights) = sized.unzip();
        let weighty = |number: usize| weights.is_none_or(|weights| weights[number] >= WEIGHTY);
        let extra: Vec<More> = match (&self.known, place) {
            (None, _) => More::unknown(),
            (Some(_), Place::Shield) => vec![More::NONE],
            (Some(_), Place::Coils | Place::Levels) => {
                std::iter::once(More::NONE).chain(More::of_field(recordings.iter().any(drifts))).collect()
            }
        };
        let source = match (self.source, place) {
            ("residuals", _) | (_, Place::Shield) => self.source.to_string(),
            (source, _) => format!("{source}, with noise of the applied field"),
        };
        let mut allowed = Allowed::none(source, self.known.is_some());
        // White noise of all that is known together in the first, what has memory in each.
        let mut known = vec![self.known.clone().unwrap_or_default()];
        known.extend(self.field.clone().filter(|_| place != Place::Shield));
        let white = known.iter().map(|noise| noise.white_rms_nt.unwrap_or(0.0).powi(2)).sum::<f64>();
        let white = if self.known.is_some() { white + self.rounding_nt2 } else { 1.0 };
        known.iter_mut().for_each(|noise| noise.white_rms_nt = None);
        known[0].white_rms_nt = Some(white.sqrt());
        if recordings.iter().map(|(rows, _)| rows).sum::<usize>() > self.full {
            for (_, more) in extra.into_iter().enumerate().filter(|(number, _)| weighty(*number)) {
                allowed.add_long(recordings, &known, more)?;
            }
            return Ok(match sizes {
                Some(sizes) => allowed.scaled(&sizes.iter().map(|sizes| sizes[0]).collect::<Vec<_>>()),
                None => allowed,
            });
        }
        let parts: Vec<[Vec<f64>; 3]> = recordings
            .iter()
            .map(|(rows, time)| {
                let mut own = vec![0.0; rows * rows];
                for noise in &known {
                    let one = covariance(noise, *rows, time.as_deref())?;
                    own.iter_mut().zip(one).for_each(|(sum, one)| *sum += one);
                }
                if mean_variance(&own, *rows) == 0.0 {
                    // Noise with memory alone, and no times: the readings are as good as independent.
                    (0..*rows).for_each(|row| own[row * rows + row] = 1.0);
                }
                let flicker = covariance(&Memory::Flicker.noise(1.0), *rows, time.as_deref())?;
                let walk = covariance(&Memory::Walk.noise(1.0), *rows, time.as_deref())?;
                Ok([own, flicker, about_mean(walk, *rows)])
            })
            .collect::<Result<_>>()?;
        let levels = if place == Place::Levels { &LEVELS[..] } else { &LEVELS[..1] };
        let powers = if sizes.is_some() { &POWERS[..] } else { &POWERS[..1] };
        let each = levels.iter().flat_map(|level| extra.iter().map(move |more| (*more, *level)));
        let each = each.enumerate().filter(|(number, _)| weighty(*number));
        let each = each.flat_map(|(_, one)| powers.iter().map(move |power| (one, *power)));
        for ((more, level), power) in each {
            allowed.add(recordings, more.probability, |number, rows| {
                let [own, flicker, walk] = &parts[number];
                let shape = match more.memory {
                    Memory::Flicker => flicker,
                    Memory::Walk => walk,
                };
                let (mean, size) = (mean_variance(own, rows), mean_variance(shape, rows));
                let scale = if size > 0.0 { more.slow * mean / size } else { 0.0 };
                let total = 1.0 + more.white + more.slow;
                let level = level * mean * total;
                let mut all: Vec<f64> =
                    own.iter().zip(shape).map(|(own, shape)| own + scale * shape + level).collect();
                let added = more.white * mean;
                (0..rows).for_each(|row| all[row * rows + row] += added);
                if let Some(sizes) = sizes.map(|sizes| &sizes[number]) {
                    let slow: Vec<f64> = sizes.iter().map(|size| size.powf(2.0 * power)).collect();
                    for row in 0..rows {
                        all[row * rows + row] -= white + added;
                        (0..rows).for_each(|other| all[row * rows + other] *= slow[row].min(slow[other]));
                        all[row * rows + row] += sizes[row].powi(2) * (white + added);
                    }
                }
                Ok((all, 1.0 - (white / mean + more.white) / total))
            })?;
        }
        Ok(allowed)
    }
}

fn covariance(noise: &Noise, rows: usize, time: Option<&[f64]>) -> Result<Vec<f64>> {
    noise::covariance(noise, rows, time).map_err(undetermined)
}

fn mean_variance(covariance: &[f64], rows: usize) -> f64 {
    (0..rows).map(|row| covariance[row * rows + row]).sum::<f64>() / rows as f64
}

/// The covariance of readings less their mean: C − C1ᵀ/n − 1C/n + 1ᵀC1/n².
fn about_mean(mut covariance: Vec<f64>, rows: usize) -> Vec<f64> {
    let of_mean: Vec<f64> =
        covariance.chunks(rows.max(1)).map(|row| row.iter().sum::<f64>() / rows as f64).collect();
    let mean = of_mean.iter().sum::<f64>() / rows as f64;
    for i in 0..rows {
        (0..rows).for_each(|j| covariance[i * rows + j] += mean - of_mean[i] - of_mean[j]);
    }
    covariance
}

/// Whether the daily variation, of which some thousandths leak through the nulling, drifts in a recording.
fn drifts((_, time): &Rows) -> bool {
    time.as_ref()
        .and_then(|time| Some(time.last()? - time.first()?))
        .is_some_and(|length_s| length_s > DRIFTS_S)
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimate::correlated::{self, CorrelatedFit, Scale};
    use faer::Mat;

    /// A sweep up and down with noise of its own kind: what both mechanisms make of it.
    fn both(noise: &str, time: &[f64]) -> [CorrelatedFit; 2] {
        let noise: Noise = serde_json::from_str(noise).expect("a noise");
        let rows = time.len();
        let shape = |full: usize| Shape {
            known: Some(noise.clone()),
            field: None,
            source: "declared",
            rounding_nt2: 0.0,
            full,
        };
        let design = Mat::from_fn(rows, 3, |i, j| (2.0 * (i % 11) as f64 / 10.0 - 1.0).powi(j as i32));
        let y = noise::series(&noise, 7, "readings", rows, Some(time)).expect("noise");
        [usize::MAX, 0].map(|full| {
            let recordings = [(rows, Some(time.to_vec()))];
            let allowed = shape(full).allowed(&recordings, Place::Coils, None).expect("covariances");
            correlated::fit(design.as_ref(), &y, &allowed.whitenings, Scale::Fitted).expect("a fit")
        })
    }

    #[test]
    fn one_pass_agrees_with_full_matrices() {
        let even: Vec<f64> = (0..800).map(|i| 11.0 * f64::from(i)).collect();
        let uneven: Vec<f64> = (0..800).map(|i| 11.0 * f64::from(i) + 600.0 * f64::from(i / 11)).collect();
        for noise in [
            r#"{"white_rms_nt": 0.1}"#,
            r#"{"white_rms_nt": 0.1, "flicker_nt2_per_hz_at_1hz": 0.002}"#,
            r#"{"white_rms_nt": 0.02, "flicker_nt2_per_hz_at_1hz": 0.01, "flicker_exponent": 0.9}"#,
        ] {
            for time in [&even, &uneven] {
                let [full, pass] = both(noise, time);
                // At uneven times flicker noise is read off an even grid by straight lines: smaller.
                let within = if time == &even { 0.01 } else { 0.2 };
                for at in 0..3 {
                    let [a, b] = [&full, &pass].map(|fit| fit.covariance(at, at).sqrt());
                    let apart = (full.coefficients[at] - pass.coefficients[at]).abs() / a;
                    println!(
                        "{noise}, {} s: coefficient {at}: {:.4} as uncertain, {apart:.4} apart",
                        time[799],
                        b / a
                    );
                    assert!((b / a - 1.0).abs() < within && apart < 0.2, "{noise}: {at}: {} {apart}", b / a);
                }
            }
        }
    }

    #[test]
    fn the_declared_noise_of_the_field_counts_in_coils_and_not_in_a_shield() {
        let noise = |text: &str| serde_json::from_str::<Noise>(text).expect("a noise");
        let of = |known: &str, field: Option<&str>| Shape {
            known: Some(noise(known)),
            field: field.map(noise),
            source: "declared",
            rounding_nt2: 0.0,
            full: FULL,
        };
        let (white, walk) = (r#"{"white_rms_nt": 0.1}"#, r#"{"random_walk_nt_per_sqrt_s": 0.01}"#);
        let (both, apart) =
            (of(r#"{"white_rms_nt": 0.1, "random_walk_nt_per_sqrt_s": 0.01}"#, None), of(white, Some(walk)));
        let recordings = [(30, Some((0..30).map(|i| 11.0 * f64::from(i)).collect::<Vec<f64>>()))];
        let y: Vec<f64> = (0..30).map(|i| f64::from(i * i % 7)).collect();
        let first = |shape: &Shape, full: usize, place: Place| {
            let allowed =
                Shape { full, ..shape.clone() }.allowed(&recordings, place, None).expect("covariances");
            allowed.whitenings[0].apply_to(&y)
        };
        let differ = |one: &[f64], other: &[f64]| {
            one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / y[3]
        };
        for full in [FULL, 0] {
            assert!(differ(&first(&both, full, Place::Coils), &first(&apart, full, Place::Coils)) < 1e-9);
            let shield = first(&apart, full, Place::Shield);
            assert!(differ(&first(&of(white, None), full, Place::Shield), &shield) < 1e-9);
            assert!(differ(&first(&both, full, Place::Shield), &shield) > 1e-3);
        }
    }
}
