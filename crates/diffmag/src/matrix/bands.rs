//! The matrix as a transfer function, T = R Z(f): whether it is real and the same at all periods.

mod transfer;
pub mod words;

use std::ops::Range;

use common::{Axis, BandAxis, OneMatrix, PhaseClock, Quantity, TransferBand, TransferBands};
use estimate::cross_spectrum::CrossSpectra;
use estimate::stats;
use faer::Mat;
use transfer::{Transfer, effective, transfer};

use crate::Error;
use crate::constancy::{self, Estimate};
use crate::regression::AxisFit;
use crate::windows::Noise;
use joined::Pair;

/// Sine tapers: they see the density within two Fourier frequencies and leave out what is farther, which the
/// natural field's steep spectrum would else put in.
const TAPERS: usize = 3;
/// The first ordinate that the mean which is taken off does not reach.
const LOWEST: usize = 2;
/// A band is half a decade wide.
const WIDTH: f64 = 3.162_277_660_168_379_5;
/// A band has at least this many ordinates.
const LEAST: usize = 5;
/// A band is tested when its noise has at least this many degrees of freedom.
const TESTED_FROM: f64 = 4.0;
/// The longest series that is transformed whole; of longer ones the short periods come from segments of this
/// length, the long ones from means.
const LONGEST: usize = 1 << 17;
/// Longer periods are those of the day's course, the day and its half: tilt and temperature have them.
const LONG_S: f64 = 41_400.0;

struct Band {
    ordinates: Range<usize>,
    effective: f64,
    spectra: usize,
}

/// Z in bands of half a decade from the longest periods to the Nyquist frequency, and whether it is one real
/// matrix.
pub fn bands(pair: &Pair, fits: &[AxisFit; 3], noise: &Noise<'_>) -> Result<TransferBands, Error> {
    let differences = fits.iter().map(|fit| fit.difference.as_slice());
    let channels: Vec<&[f64]> = pair.reference.iter().map(AsRef::as_ref).chain(differences).collect();
    let spectra = spectra(&channels, pair.step_s)?;
    let bands = divide(&spectra);
    let mut columns = [const { Vec::new() }; 3];
    for (j, column) in columns.iter_mut().enumerate() {
        for band in &bands {
            let density = |f: f64| noise.density(j, f);
            let eta = &fits[j].fit.weighted;
            let (of, step_s) = &spectra[band.spectra];
            let found = transfer(of, band.ordinates.clone(), j, eta, &density, band.effective, *step_s);
            column.push(found.ok_or_else(|| {
                Error::Unanswerable("the field does not vary in three directions in a band of periods".into())
            })?);
        }
    }
    let mut found = TransferBands::default();
    for (number, band) in bands.into_iter().enumerate() {
        let of = &spectra[band.spectra].0.frequency_hz;
        let mut written = TransferBand {
            from_period_s: 1.0 / of[band.ordinates.end - 1],
            to_period_s: 1.0 / of[band.ordinates.start],
            freedom: 2.0 * (band.effective - 3.0),
            ..TransferBand::default()
        };
        written.tested = written.freedom >= TESTED_FROM;
        for (axis, column) in Axis::ALL.into_iter().zip(&columns) {
            write(&mut written, axis, &column[number]);
        }
        found.bands.push(written);
    }
    let chosen = |longest_s: f64| -> Vec<usize> {
        let fits = |band: &TransferBand| band.tested && band.to_period_s < longest_s;
        (0..found.bands.len()).filter(|i| fits(&found.bands[*i])).collect()
    };
    let (all, short) = (chosen(f64::INFINITY), chosen(LONG_S));
    let tests = fit_each(&columns, &all, 0.0)?;
    for (axis, test) in Axis::ALL.into_iter().zip(&tests) {
        for (number, left) in all.iter().zip(&test.each) {
            if let Some(of) = found.bands[*number].axes.entry(axis) {
                of.p = Some(stats::chi_squared_p(*left, 6.0));
            }
        }
    }
    found.one_matrix = together(&tests, 0.0, noise);
    let (offset_s, clock) = clock(&columns, &all)?;
    found.clock = clock;
    let with_clock = |bands: &[usize]| -> Result<OneMatrix, Error> {
        Ok(together(&fit_each(&columns, bands, offset_s)?, 1.0, noise))
    };
    found.one_matrix_with_clock = with_clock(&all)?;
    found.one_matrix_short_periods = (short.len() > 1).then(|| with_clock(&short)).transpose()?;
    Ok(found)
}

/// Spectra of the whole series and its step; of one that is longer than that, of its segments and of means
/// over neighbouring samples.
fn spectra(channels: &[&[f64]], step_s: f64) -> Result<Vec<(CrossSpectra, f64)>, Error> {
    let rows = channels[0].len();
    let mut all = vec![(CrossSpectra::of(channels, step_s, LONGEST, TAPERS)?, step_s)];
    if rows > LONGEST {
        let together = rows.div_ceil(LONGEST);
        let mean = |rows: &[f64]| rows.iter().sum::<f64>() / together as f64;
        let means: Vec<Vec<f64>> =
            channels.iter().map(|channel| channel.chunks_exact(together).map(mean).collect()).collect();
        let means: Vec<&[f64]> = means.iter().map(Vec::as_slice).collect();
        let step_s = step_s * together as f64;
        all.push((CrossSpectra::of(&means, step_s, LONGEST, TAPERS)?, step_s));
    }
    Ok(all)
}

/// Bands from the Nyquist frequency down, long periods first; further spectra take over where the first have
/// too few ordinates.
fn divide(spectra: &[(CrossSpectra, f64)]) -> Vec<Band> {
    let mut bands: Vec<Band> = Vec::new();
    let mut high_hz = f64::INFINITY;
    for (number, (of, _)) in spectra.iter().enumerate() {
        let last = number + 1 == spectra.len();
        let segments = of.freedom[0] / (2.0 * TAPERS as f64);
        let mut end = of.frequency_hz.partition_point(|f| *f < high_hz);
        while end >= LOWEST - 1 + LEAST {
            let low_hz = of.frequency_hz[end - 1] / WIDTH;
            let mut start = of.frequency_hz.partition_point(|f| *f <= low_hz).max(LOWEST - 1);
            if start < LOWEST - 1 + LEAST {
                if !last {
                    break;
                }
                // What is left over is too little for a band of its own.
                start = LOWEST - 1;
            }
            bands.push(Band {
                ordinates: start..end,
                effective: segments * effective(TAPERS, end - start),
                spectra: number,
            });
            high_hz = of.frequency_hz[start];
            end = start;
        }
    }
    bands.reverse();
    bands
}

/// Fits one real η to the bands of each axis, an offset of the clock taken off.
fn fit_each(
    columns: &[Vec<Transfer>; 3],
    bands: &[usize],
    offset_s: f64,
) -> Result<Vec<constancy::Fitted>, Error> {
    let fit = |column: &Vec<Transfer>| {
        let estimates: Vec<Estimate> = bands.iter().map(|i| column[*i].less(offset_s)).collect();
        constancy::fit(&estimates, 3, |_| real())
    };
    columns.iter().map(fit).collect()
}

fn real() -> Mat<f64> {
    Mat::from_fn(6, 3, |i, k| if i == k { 1.0 } else { 0.0 })
}

/// The axes together, unknowns that they have in common taken from the degrees of freedom.
fn together(axes: &[constancy::Fitted], common: f64, noise: &Noise<'_>) -> OneMatrix {
    let tests = std::array::from_fn(|j| axes[j].chi_squared(common / 3.0));
    constancy::together(tests, &noise.correlation_squared)
}

/// The offset that each axis has, their weighted mean, and whether they are alike.
fn clock(columns: &[Vec<Transfer>; 3], bands: &[usize]) -> Result<(f64, PhaseClock), Error> {
    let (mut weight, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for column in columns {
        let estimates: Vec<Estimate> = bands.iter().map(|i| column[*i].less(0.0)).collect();
        let found = constancy::fit(&estimates, 4, |i| {
            let late = &column[bands[i]].late;
            Mat::from_fn(6, 4, |row, k| if k == 3 { late[row] } else { real()[(row, k)] })
        })?;
        let (value, w) = (found.unknowns[3], 1.0 / found.covariance[(3, 3)]);
        weight += w;
        sum += w * value;
        squares += w * value * value;
    }
    let offset_s = sum / weight;
    let alike_p = stats::chi_squared_p((squares - sum * offset_s).max(0.0), 2.0);
    Ok((offset_s, PhaseClock { offset_s: Quantity::new(offset_s, weight.sqrt().recip()), alike_p }))
}

fn write(band: &mut TransferBand, axis: Axis, found: &Transfer) {
    let j = axis.index();
    let std = |i: usize| found.estimate.covariance[(i, i)].sqrt();
    for i in 0..3 {
        band.real[i][j] = found.estimate.value[i];
        band.real_std[i][j] = std(i);
        band.imaginary[i][j] = found.estimate.value[3 + i];
        band.imaginary_std[i][j] = std(3 + i);
    }
    let residual_rms_nt = found.residual.max(0.0).sqrt();
    *band.axes.entry(axis) = Some(BandAxis { coherence: found.coherence, residual_rms_nt, p: None });
}
