//! Noise with memory of the sensors.
//!
//! A sensor's noise e_i shows in the residual |B| − F as u_i e_i, u_i = ∂|B|/∂b_i, which changes as the
//! sensors are turned. So noise that is slow in a sensor looks white in the residual, and still makes the
//! sensor's offset uncertain. A Kalman filter whitens the rows under
//!
//! ```text
//! residual(t) = Σ_i u_i(t) Σ_j x_ij(t) + white,
//! ```
//!
//! x_ij Ornstein–Uhlenbeck processes whose sum has the density A f^-α, alike and independent for the three
//! sensors. Where nothing measured the magnitude while the sensors were turned (it is stated, constant, or
//! from a model), it may have changed: then one such sum with u = 1 is allowed for as well, about a mean over
//! each recording that is the stated one. Which A and α, and whose, the readings say by restricted
//! likelihood; the models that are allowed for are averaged by it, white noise among them.

use common::{Noise, covariance};
use estimate::Svd;
use estimate::mixture::{Component, Mixture};
use faer::{ColRef, Mat};
use rayon::prelude::*;
use std::ops::Range;

use crate::Error;
use crate::design::Rows;
use crate::fit::{FittedState, about};
use crate::kalman::{Filter, Form, Memory};
use crate::linear::{Linear, RANK_TOLERANCE, root};
use crate::model::{Model, own};
use crate::read::{Series, Source};
use crate::terms::{Factor, compressed};

/// Exponents that are allowed for in sensors.
const EXPONENTS: [f64; 3] = [0.7, 1.0, 1.5];
/// The same of few groups, which hardly show an exponent: one that is too small would promise too much.
const STEEP: [f64; 2] = [1.0, 1.5];
/// The same for the magnitude: the field of the Earth varies as a random walk does.
const EXPONENTS_OF_MAGNITUDE: [f64; 3] = [1.0, 1.5, 2.0];
/// Flicker noise at 1/(10 steps) over white noise, in density, from one to the next.
const RATIO_STEP: f64 = 4.0;
/// Steps of the ratio on either side of one.
const RATIOS: i32 = 4;
/// Rows filtered one by one; beyond, groups of rows are, over which noise with memory stands still.
const FILTERED: usize = 8192;
/// Fewer rows than these say nothing of memory.
const LEAST: usize = 64;
/// Where the derivatives by the offsets stand in a row, behind the residual: they are u.
const ALONG: usize = 4;
/// Odds beforehand that noise is white where none is declared, against all other forms together.
const ODDS: f64 = 9.0;
/// A model of less weight than this does not count.
const NEGLIGIBLE: f64 = 1e-4;

/// Rows that are filtered at one time: residual, derivatives, and how each reads a noise of the field.
pub struct Group {
    span_s: [f64; 2],
    rows: Vec<Vec<f64>>,
}

impl Group {
    /// What rows of a recording make, or where that is more, its factor of so many columns.
    pub fn of(series: &Series, rows: Range<usize>, all: Vec<Vec<f64>>, columns: usize) -> Self {
        let time = series.time_s.as_deref();
        let span_s = time.map_or([0.0; 2], |time| [time[rows.start], time[rows.end - 1]]);
        Self { span_s, rows: compressed(all, columns) }
    }

    fn time_s(&self) -> f64 {
        0.5 * (self.span_s[0] + self.span_s[1])
    }
}

/// Recordings as rows of residual and derivatives about a fit, over the typical magnitude.
pub struct Groups {
    recordings: Vec<Vec<Group>>,
    /// Columns of a row that are residual and derivatives.
    columns: usize,
    pub rows: f64,
    /// Rows of a group, in the mean.
    each: f64,
    exponents: &'static [f64],
    memories: &'static [Memory],
}

/// What a form makes of the rows.
pub struct Filtered {
    pub form: Form,
    pub linear: Linear,
    /// Variance σ² of the white noise, over the square of the typical magnitude.
    pub variance: f64,
    /// ln of prior times restricted likelihood.
    log_weight: f64,
}

/// The mean of estimates by several forms.
pub struct Average {
    /// From the state about which the rows are.
    pub step: Vec<f64>,
    /// Within and between the forms.
    pub covariance: Mat<f64>,
    /// Whether by every form the rows determine all parameters.
    pub full: bool,
}

impl Groups {
    /// Rows about a fit; None for a few rows or without needed times.
    ///
    /// The derivatives are taken at the most likely field, b̂ = b (1 − φ r) and F̂ = F + (1 − φ) r with φ the
    /// sensors' share of the noise: at what was read, they would be correlated with the residual. What noise
    /// adds to the residual in second order, (σ² tr G⁻¹ − σ_F²)/2F, is taken off. So the estimate is without
    /// bias in second order.
    ///
    /// Source: J. M. G. Merayo et al., Meas. Sci. Technol. 11 (2000) 120–132, for the second-order term.
    pub fn of(rows: &Rows<'_>, model: &Model, found: &FittedState, timed: bool) -> Option<Self> {
        let all: usize = rows.pieces.iter().map(|(_, rows)| rows.len()).sum();
        if all < LEAST {
            return None;
        }
        let state = &found.state;
        let (slopes, coefficients) = (model.slopes(state)?, model.coefficients(state)?);
        let inverse = crate::model::cosines(state).try_inverse()?;
        // What a residual of one is along the field, over the magnitude.
        let unit = model.scale(state) / model.magnitude(state);
        let added = 0.5 * (found.sensor * inverse.trace() - found.reference) * unit;
        let share = if found.sensor > 0.0 { found.sensor / (found.sensor + found.reference) } else { 0.0 };
        let count = model.parameters.len();
        let along = model.along(state);
        let by: Vec<&[f64]> = (0..count).map(|j| slopes.col_as_slice(j)).collect();
        let row = |_: usize, z: &mut [f64], products: &mut [f64]| -> Vec<f64> {
            let residual: f64 = products.iter().zip(&coefficients).map(|(a, b)| a * b).sum();
            let own = own(&along, z);
            (0..3).for_each(|axis| z[axis] -= share * residual * unit * own[axis] / state[axis]);
            let read = z[model.terms.columns];
            z[model.terms.columns] += (1.0 - share) * residual * unit;
            let residual = residual * read / z[model.terms.columns];
            model.terms.fill(z, products);
            let derivative = |by: &&[f64]| products.iter().zip(*by).map(|(value, by)| value * by).sum();
            // Observed less predicted: what is to be explained is −r.
            std::iter::once(added / z[model.terms.columns] - residual)
                .chain(by.iter().map(derivative))
                .chain([1.0])
                .collect()
        };
        // As many rows of factors as rows could be.
        let each = if all <= FILTERED { 1 } else { (all * (count + 1)).div_ceil(FILTERED) };
        let of = |number: usize, some: Range<usize>| {
            let all = rows.map(&model.terms, number, some.clone(), &row);
            Group::of(&rows.series[number], some, all, count + 2)
        };
        let recordings = rows.each(each, of);
        let ordered = |((number, _), groups): (&(usize, Range<usize>), &Vec<Group>)| {
            rows.series[*number].time_s.is_some()
                && groups.is_sorted_by(|one, next| next.time_s() >= one.time_s())
        };
        if timed && !rows.pieces.iter().zip(&recordings).all(ordered) {
            return None;
        }
        let measured = rows.series.iter().all(|one| one.source == Source::Scalar);
        let memories: &[Memory] =
            if measured { &[Memory::Sensors] } else { &[Memory::Sensors, Memory::Magnitude] };
        Some(Self {
            recordings,
            columns: count + 1,
            rows: all as f64,
            each: each as f64,
            exponents: &EXPONENTS,
            memories,
        })
    }

    /// Rows against a known field: behind so many columns, what each reads of the noise of the field.
    pub fn of_rows(recordings: Vec<Vec<Group>>, columns: usize, rows: f64) -> Self {
        let memories = &[Memory::Sensors, Memory::Field];
        Self { recordings, columns, rows, each: 1.0, exponents: &EXPONENTS, memories }
    }

    /// The same of factors of the products, each of the rows between two moments; None for a few rows.
    pub fn of_factors(factors: &[([f64; 2], &Factor)], model: &Model, found: &FittedState) -> Option<Self> {
        let all: u64 = factors.iter().map(|(_, factor)| factor.rows).sum();
        if all < LEAST as u64 {
            return None;
        }
        let plain: Vec<&Factor> = factors.iter().map(|(_, factor)| *factor).collect();
        let of = |((span_s, _), rows): (&([f64; 2], &Factor), Mat<f64>)| Group {
            span_s: *span_s,
            rows: covariance::rows(&rows),
        };
        let groups: Vec<Group> = factors.iter().zip(about(model, found, &plain)?).map(of).collect();
        Some(Self {
            columns: model.parameters.len() + 1,
            rows: all as f64,
            each: all as f64 / groups.len() as f64,
            exponents: &STEEP,
            memories: &[Memory::Sensors],
            recordings: vec![groups],
        })
    }

    /// The usual time from one group to the next, s.
    fn step_s(&self) -> Option<f64> {
        let mut steps: Vec<f64> = self
            .recordings
            .iter()
            .flat_map(|groups| groups.windows(2).map(|pair| pair[1].time_s() - pair[0].time_s()))
            .filter(|step| *step > 0.0)
            .collect();
        (!steps.is_empty()).then(|| estimate::stats::median_of(&mut steps))
    }

    /// The rows whitened by a form of noise over σ, as a factor, and the logarithm of the determinant of
    /// their covariance (σ = 1); `whole` where the mean magnitude of each recording is known.
    fn whitened(&self, form: Form, whole: bool) -> Option<(Mat<f64>, f64)> {
        let of = |groups: &Vec<Group>| {
            let mut factor = Factor::new(self.columns);
            let take = &mut |_: usize, row: &[f64]| factor.row(row.iter().copied());
            let logarithm = innovations(groups, self.columns, form, take)?;
            if form.of == Memory::Magnitude && whole {
                factor.row(mean(groups, self.columns));
            }
            Some((factor.finish(), logarithm))
        };
        let parts: Vec<(Factor, f64)> =
            self.recordings.par_iter().filter(|groups| !groups.is_empty()).map(of).collect::<Option<_>>()?;
        let logarithm = parts.iter().map(|(_, logarithm)| logarithm).sum();
        let factors = parts.iter().map(|(factor, _)| factor);
        Some((Factor::joined(self.columns, factors).upper(), logarithm))
    }

    /// The same of each group by itself, one after the other.
    pub fn each_whitened(&self, form: Form) -> Option<Vec<Mat<f64>>> {
        let mut all = Vec::new();
        for groups in &self.recordings {
            let mut factors = vec![Factor::new(self.columns); groups.len()];
            let take = &mut |number: usize, row: &[f64]| factors[number].row(row.iter().copied());
            innovations(groups, self.columns, form, take)?;
            all.extend(factors.into_iter().map(|factor| factor.finish().upper()));
        }
        Some(all)
    }

    /// The rows whitened by a form of noise with white variance σ²; `whole` for whole recordings.
    pub fn linear(&self, form: Form, variance: f64, whole: bool) -> Option<Linear> {
        let (upper, _) = self.whitened(form, whole)?;
        Some(Linear::of(&upper, variance))
    }

    /// What is made of the rows by forms of noise, the first of them `base`, or by that alone where none is
    /// searched for, weighed by restricted likelihood; one at least. None without times.
    pub fn weighed(&self, held: &Linear, (base, searched): (Form, bool)) -> Option<Vec<Filtered>> {
        let step = self.step_s()?;
        let mut forms = vec![base];
        let row = step / self.each;
        for of in self.memories.iter().filter(|_| searched) {
            let exponents = if *of == Memory::Magnitude { &EXPONENTS_OF_MAGNITUDE } else { self.exponents };
            for exponent in exponents.iter().copied() {
                // Equal densities of both, 2σ²Δt = A f^-α, at one over ten steps: of groups and rows.
                let equal = |step: f64| 2.0 * row * (0.1 / step).powf(exponent);
                let more = ((equal(row) / equal(step)).ln() / RATIO_STEP.ln() - 1e-9).ceil() as i32;
                let ratios = (-RATIOS..=RATIOS + more).map(|k| equal(step) * RATIO_STEP.powi(k));
                forms.extend(ratios.map(|ratio| Form { of: *of, ratio, exponent }));
            }
        }
        let prior = |place: usize| if place == 0 { ODDS } else { 1.0 / (forms.len() - 1) as f64 };
        let weigh = |(place, form): (usize, &Form)| {
            let (upper, logarithm) = self.whitened(*form, true)?;
            let (variance, log_likelihood) =
                restricted(&Linear::of(&upper, 1.0), held, self.rows, logarithm)?;
            let (linear, log_weight) = (Linear::of(&upper, variance), prior(place).ln() + log_likelihood);
            Some(Filtered { form: *form, linear, variance, log_weight })
        };
        let mut all: Vec<Filtered> = forms.par_iter().enumerate().filter_map(weigh).collect();
        let best = heaviest(&all)?.log_weight;
        let total: f64 = all.iter().map(|one| (one.log_weight - best).exp()).sum();
        all.retain(|one| (one.log_weight - best).exp() / total > NEGLIGIBLE);
        Some(all)
    }

    /// Averages a fit over the forms of noise, the first of them `base`, or takes that alone where none is
    /// searched for. `held` is what no reading shows, `known` that with what is known beforehand. Gives the
    /// heaviest form with its noise, nT; None where nothing was done.
    ///
    /// Errors: [`Error::Fit`] where a decomposition fails.
    pub fn average(
        &self,
        found: &mut FittedState,
        (held, known): (&Linear, &Linear),
        (base, searched, unit_nt): (Form, bool, f64),
    ) -> Result<Option<(Form, Noise)>, Error> {
        let Some(forms) = self.weighed(held, (base, searched)) else { return Ok(None) };
        let Some(heaviest) = heaviest(&forms) else { return Ok(None) };
        let joint = average(&forms, known, &found.state)?;
        let alone = average(&forms, held, &found.state)?;
        found.jacobian =
            if alone.full { root(&alone.covariance) } else { heaviest.linear.and(held).jacobian };
        found.state.iter_mut().zip(&joint.step).for_each(|(value, step)| *value += step);
        found.covariance = joint.covariance;
        found.seen = Svd::of(found.jacobian.as_ref(), RANK_TOLERANCE)?;
        Ok(Some((heaviest.form, heaviest.noise(unit_nt))))
    }
}

/// The estimates with rows of what is known, about a state, averaged by the weights of the forms.
///
/// Errors: [`Error::Fit`] where a decomposition fails.
pub fn average(forms: &[Filtered], known: &Linear, state: &[f64]) -> Result<Average, Error> {
    let (known, count) = (known.about(state), state.len());
    let mut full = true;
    let of = |one: &Filtered| -> Result<Component, Error> {
        let linear = one.linear.and(&known);
        let svd = linear.svd()?;
        full &= svd.rank() == count;
        let (coefficients, covariance) = (svd.solve(&linear.right), svd.covariance());
        Ok(Component { log_weight: one.log_weight, coefficients, covariance })
    };
    let mixture = Mixture::of(forms.iter().map(of).collect::<Result<_, _>>()?, f64::INFINITY);
    let covariance = Mat::from_fn(count, count, |i, j| mixture.covariance(i, j));
    Ok(Average { step: mixture.coefficients().to_vec(), covariance, full })
}

/// The form of the largest weight.
pub fn heaviest(forms: &[Filtered]) -> Option<&Filtered> {
    forms.iter().max_by(|a, b| a.log_weight.total_cmp(&b.log_weight))
}

impl Filtered {
    /// The noise that it is, nT.
    pub fn noise(&self, unit_nt: f64) -> Noise {
        let sigma = self.variance.sqrt() * unit_nt;
        let flicker = Some(self.form.ratio * sigma * sigma).filter(|flicker| *flicker > 0.0);
        Noise {
            white_rms_nt: Some(sigma),
            flicker_nt2_per_hz_at_1hz: flicker,
            flicker_exponent: flicker.map(|_| self.form.exponent),
            ..Noise::default()
        }
    }
}

/// σ² and the restricted log likelihood, σ at its best: −½ ((n − p) ln σ² + ln |V| + ln |JᵀV⁻¹J|).
fn restricted(linear: &Linear, held: &Linear, rows: f64, logarithm: f64) -> Option<(f64, f64)> {
    let linear = linear.and(&held.fixed());
    let svd = linear.svd().ok()?;
    let Linear { jacobian, right } = linear;
    let step = svd.solve(&right);
    let left = (&jacobian * ColRef::from_slice(&step) - ColRef::from_slice(&right)).squared_norm_l2();
    let freedom = rows - svd.rank() as f64;
    let variance = left / freedom;
    // ln |JᵀJ| over what is seen; the lengths of the columns are in it.
    let lengths: f64 =
        (0..jacobian.ncols()).map(|j| jacobian.col(j).norm_l2().max(f64::MIN_POSITIVE).ln()).sum();
    let seen: f64 = svd.sigma()[..svd.rank()].iter().map(|sigma| sigma.ln()).sum();
    let log_likelihood = -0.5 * (freedom * variance.ln() + logarithm) - lengths - seen;
    log_likelihood.is_finite().then_some((variance, log_likelihood))
}

/// Gives the whitened rows of a recording with their groups; the logarithm of the covariance's determinant.
fn innovations(
    groups: &[Group],
    columns: usize,
    form: Form,
    take: &mut dyn FnMut(usize, &[f64]),
) -> Option<f64> {
    // Of one group the noise is that over its length.
    let times = match groups {
        [one] => one.span_s.to_vec(),
        all => all.iter().map(Group::time_s).collect(),
    };
    let mut filter = Filter::new(&times, form, columns)?;
    let first = if form.of == Memory::Sensors { ALONG } else { columns };
    let along = first..first + form.of.channels();
    let mut whitened = vec![0.0; columns];
    let mut logarithm = 0.0;
    let mut before = groups.first()?.time_s();
    for (number, group) in groups.iter().enumerate() {
        filter.wait(group.time_s() - before);
        before = group.time_s();
        for row in &group.rows {
            logarithm += filter.row(&row[along.clone()], row, &mut whitened).ln();
            take(number, &whitened);
        }
    }
    Some(logarithm)
}

/// The mean row over its standard deviation at σ = 1.
fn mean(groups: &[Group], columns: usize) -> Vec<f64> {
    let rows = || groups.iter().flat_map(|group| &group.rows);
    let count: f64 = rows().map(|row| row[columns].powi(2)).sum();
    (0..columns).map(|k| rows().map(|row| row[columns] * row[k]).sum::<f64>() / count.sqrt()).collect()
}
