//! Noise that nobody declared, as a residual shows it beside what the fit has taken out of it.

use common::Noise;
use explain::{power_law, thinned};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use noise::Whitening;
use std::collections::BTreeMap;

use super::declared::{kinds, least_nt2};
use super::whitening;
use crate::Error;
use crate::algebra::orthonormal;
use crate::channel::Channel;
use crate::observed::Observed;

/// Exponents of flicker noise, and decimal logarithms of its ratio to white noise at a period of twenty steps.
const EXPONENTS: [f64; 3] = [1.0, 1.5, 2.0];
const RATIOS: [f64; 5] = [-1.5, -0.5, 0.5, 1.5, 2.5];
/// How far beside the likeliest ratio others are tried then, from the first distance to the last.
const APART: f64 = 1.0;
const FINEST: f64 = 0.25;
/// By how much ln of the likelihood must be larger.
const BETTER: f64 = 0.01;
/// Of more rows of a channel so many are looked at, in so many blocks that are spread over all.
const ROWS: usize = 1 << 13;
const BLOCKS: usize = 16;
/// How often all kinds of channels are gone through, and how often a scale is found anew for each law.
const SWEEPS: usize = 2;
const SCALINGS: usize = 3;

/// White noise of one, and flicker noise beside it: exponent and ratio.
type Law = Option<(f64, f64)>;

/// Noise of each channel, alike in all that one sensor read: white noise and a power law of the greatest
/// restricted likelihood,
///
/// −½ (ln |C| + ln |QᵀC⁻¹Q| + rᵀ(C⁻¹ − C⁻¹Q (QᵀC⁻¹Q)⁻¹ QᵀC⁻¹) r),
///
/// of a residual r (nT, stacked) beside the columns Q that were fitted: a fit takes the slowest noise out of
/// its residual, whose spectrum by itself is too low there.
///
/// Source: H. D. Patterson and R. Thompson, Recovery of inter-block information when block sizes are unequal,
/// Biometrika 58 (1971) 545–554.
pub fn restricted(
    observed: &Observed<'_>,
    columns: &[Vec<f64>],
    residual: &[f64],
) -> Result<Vec<Noise>, Error> {
    let basis = orthonormal(&Mat::from_fn(observed.rows, columns.len(), |i, j| columns[j][i]))?;
    let names = kinds(observed);
    let mut kinds: BTreeMap<&str, Kind<'_>> = BTreeMap::new();
    for (channel, name) in observed.channels.iter().zip(&names) {
        let time = observed.times(channel).unwrap_or_default();
        let length = time.last().zip(time.first()).map_or(0.0, |(last, first)| last - first);
        let own = kinds.entry(name).or_insert_with(|| Kind { step_s: 0.0, channels: Vec::new() });
        own.step_s = own.step_s.max(length / time.len().max(2) as f64);
        own.channels.push(channel);
    }
    let places: BTreeMap<&str, usize> = kinds.keys().copied().zip(0..).collect();
    let kinds: Vec<Kind<'_>> = kinds.into_values().collect();
    let products = |number: usize, law: Law| kinds[number].products(observed, (&basis, residual), law);
    let mut chosen = (0..kinds.len()).map(|number| products(number, None)).collect::<Result<Vec<_>, _>>()?;
    let mut tried: Vec<Vec<Products>> = chosen.iter().map(|white| vec![white.clone()]).collect();
    let mut likeliest = |chosen: &mut Vec<Products>, number: usize, laws: Vec<Law>| -> Result<(), Error> {
        let mut best = likelihood(chosen, number);
        for law in laws {
            let known = tried[number].iter().position(|other| other.law == law);
            let place = known.unwrap_or(tried[number].len());
            if known.is_none() {
                tried[number].push(products(number, law)?);
            }
            let before = std::mem::replace(&mut chosen[number], tried[number][place].clone());
            let log = likelihood(chosen, number);
            if log > best + BETTER { best = log } else { chosen[number] = before }
        }
        Ok(())
    };
    let grid = || EXPONENTS.iter().flat_map(|exponent| RATIOS.map(|ratio| Some((*exponent, ratio))));
    for number in (0..SWEEPS).flat_map(|_| 0..kinds.len()) {
        // Without times there is white noise only.
        let laws = grid().filter(|_| kinds[number].step_s > 0.0).chain([None]).collect();
        likeliest(&mut chosen, number, laws)?;
        let mut apart = APART;
        while let Some((exponent, ratio)) = chosen[number].law.filter(|_| apart >= FINEST) {
            let beside = [ratio - apart, ratio + apart].map(|ratio| Some((exponent, ratio)));
            likeliest(&mut chosen, number, beside.to_vec())?;
            if chosen[number].law == Some((exponent, ratio)) {
                apart *= 0.5;
            }
        }
    }
    let noise = |(channel, name): (&Channel, &String)| {
        let Products { law, scale, .. } = chosen[places[name.as_str()]];
        let noise = kinds[places[name.as_str()]].noise(law, scale);
        let white = noise.white_rms_nt.unwrap_or(0.0).max(least_nt2(observed, channel).sqrt());
        Noise { white_rms_nt: Some(white), ..noise }
    };
    Ok(observed.channels.iter().zip(&names).map(noise).collect())
}

/// Channels that share their noise.
struct Kind<'c> {
    /// Mean step of the slowest, s; zero without times.
    step_s: f64,
    channels: Vec<&'c Channel>,
}

/// Columns and residual (last) of the channels of a kind, whitened by a law, in products.
#[derive(Clone)]
struct Products {
    law: Law,
    /// Variance of the white part, nT².
    scale: f64,
    rows: f64,
    log_determinant: f64,
    gram: Mat<f64>,
}

impl Kind<'_> {
    /// A law times a variance as a document states it.
    fn noise(&self, law: Law, scale: f64) -> Noise {
        let white = Noise { white_rms_nt: Some(scale.sqrt()), ..Noise::default() };
        let Some((exponent, ratio)) = law else { return white };
        let at_1hz = power_law(self.step_s, exponent, 10.0_f64.powf(ratio));
        Noise { flicker_nt2_per_hz_at_1hz: Some(scale * at_1hz), flicker_exponent: Some(exponent), ..white }
    }

    fn products(
        &self,
        observed: &Observed<'_>,
        (basis, residual): (&Mat<f64>, &[f64]),
        law: Law,
    ) -> Result<Products, Error> {
        let width = basis.ncols() + 1;
        let (mut rows, mut log_determinant, mut gram) = (0.0, 0.0, Mat::<f64>::zeros(width, width));
        for channel in &self.channels {
            let kept = thinned(channel.rows.len(), ROWS, BLOCKS);
            let rows_kept = kept.iter().map(|row| channel.rows[*row]).collect();
            let some = Channel { rows: rows_kept, ..(*channel).clone() };
            let whitening: Whitening = whitening(observed, &some, &self.noise(law, 1.0), false)?;
            let of = |column: usize| -> Vec<f64> {
                let all = if column + 1 == width { residual } else { basis.col_as_slice(column) };
                kept.iter().map(|row| all[channel.at + row]).collect()
            };
            let (there, mut white): (Vec<usize>, Vec<Vec<f64>>) = (0..width)
                .map(|column| (column, of(column)))
                .filter(|(_, values)| values.iter().any(|x| *x != 0.0))
                .unzip();
            whitening.whiten_all(&mut white);
            let own = estimate::gram_of(&white);
            for (i, row) in there.iter().enumerate() {
                for (j, column) in there.iter().enumerate() {
                    gram[(*row, *column)] += own[(i, j)];
                }
            }
            rows += kept.len() as f64;
            log_determinant += whitening.log_determinant();
        }
        let scale = gram[(width - 1, width - 1)] / rows;
        Ok(Products { law, scale, rows, log_determinant, gram })
    }
}

/// ln of the restricted likelihood of all kinds at the best scale of one, which it is given.
fn likelihood(kinds: &mut [Products], number: usize) -> f64 {
    let width = kinds[0].gram.ncols();
    let base = width - 1;
    let mut log = f64::NEG_INFINITY;
    for _ in 0..SCALINGS {
        let mut all = Mat::<f64>::zeros(width, width);
        for kind in kinds.iter() {
            all += &kind.gram * faer::Scale(1.0 / kind.scale);
        }
        let Ok(factor) = all.submatrix(0, 0, base, base).llt(Side::Lower) else { return f64::NEG_INFINITY };
        let size = factor.solve(all.submatrix(0, base, base, 1));
        let left: f64 = all[(base, base)] - (0..base).map(|i| size[(i, 0)] * all[(i, base)]).sum::<f64>();
        let log_products: f64 = (0..base).map(|i| 2.0 * factor.L()[(i, i)].ln()).sum();
        let determinants: f64 =
            kinds.iter().map(|kind| kind.log_determinant + kind.rows * kind.scale.ln()).sum();
        log = -0.5 * (determinants + log_products + left);
        // What it leaves of its own readings, and how many unknowns they determine.
        let own = &mut kinds[number];
        let with = |i: usize| if i == base { 1.0 } else { -size[(i, 0)] };
        let left: f64 =
            (0..width).map(|i| with(i) * (0..width).map(|j| own.gram[(i, j)] * with(j)).sum::<f64>()).sum();
        let share = factor.solve(own.gram.submatrix(0, 0, base, base));
        let unknowns: f64 = (0..base).map(|i| share[(i, i)] / own.scale).sum();
        own.scale = (left / (own.rows - unknowns).max(1.0)).max(f64::MIN_POSITIVE.sqrt());
    }
    log
}
