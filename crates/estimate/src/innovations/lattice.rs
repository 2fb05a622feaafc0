//! Innovations of an even stationary series by its reflection coefficients, without a matrix.

use fourier::{Complex, Forward, Inverse, Planner};

use crate::Error;

/// Rows that go through the lattice one by one; longer windows are halved.
const BASE: usize = 128;

/// The lattice filter of a stationary series.
///
/// With the errors f_k(t) of predicting x_t from the k values before it and b_k(t) of x_(t−k) from the k after it,
///
/// f_(k+1)(t) = f_k(t) − κ_k b_k(t−1), b_(k+1)(t) = b_k(t−1) − κ_k f_k(t), f_0 = b_0 = x,
///
/// the innovation of row t is f_t(t), its variance v_t = r_0 Π (1 − κ_k²) over k < t. Half of a window's steps at once are a
/// product with polynomials, [f; b] → [A f + B β; B̃ f + Ã β], β(t) = b(t−1), Ã the coefficients of A backwards: so each
/// half of a window is done after the other, by transforms.
pub(super) struct Lattice {
    rows: usize,
    reflections: Vec<f64>,
    /// √v_t.
    deviations: Vec<f64>,
    levels: Vec<Level>,
}

/// Windows of one length: twice `half`.
struct Level {
    half: usize,
    forward: Forward,
    inverse: Inverse,
    /// The first half of each window's steps.
    transfers: Vec<Transfer>,
}

/// The transforms of A and B, over the window's length, so that the inverse transform needs no factor.
struct Transfer {
    a: Vec<Complex<f64>>,
    b: Vec<Complex<f64>>,
}

/// Room for the transforms of the longest window.
pub(super) struct Workspace {
    time: Vec<f64>,
    f: Vec<Complex<f64>>,
    b: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl Lattice {
    /// From r_0 … r_(n−1): the Schur algorithm, which is the same lattice fed with the autocovariance,
    /// κ_k = u_k(k+1)/w_k(k), u_0 = w_0 = r.
    ///
    /// Source: G. S. Ammar and W. B. Gragg, Superfast solution of real positive definite Toeplitz systems, SIAM J. Matrix
    /// Anal. Appl. 9 (1988) 61–76.
    pub(super) fn of(lags: &[f64]) -> Result<Self, Error> {
        let rows = lags.len();
        let mut planner = Planner::new();
        let mut levels = Vec::new();
        let mut length = BASE;
        while length < rows {
            let half = length;
            length *= 2;
            let (forward, inverse) = (planner.forward(length), planner.inverse(length));
            levels.push(Level { half, forward, inverse, transfers: Vec::new() });
        }
        let mut lattice =
            Lattice { rows, reflections: Vec::with_capacity(rows), deviations: vec![lags[0].sqrt()], levels };
        let (mut u, mut w) = (vec![0.0; length], vec![0.0; length]);
        u[..rows - 1].copy_from_slice(&lags[1..]);
        w[..rows].copy_from_slice(lags);
        let mut workspace = lattice.workspace();
        lattice.schur(lattice.levels.len(), 0, &mut u, &mut w, &mut workspace)?;
        Ok(lattice)
    }

    /// Σ ln v_t.
    pub(super) fn log_determinant(&self) -> f64 {
        self.deviations.iter().map(|deviation| 2.0 * deviation.ln()).sum()
    }

    pub(super) fn workspace(&self) -> Workspace {
        let length = self.length();
        let zero = Complex::new(0.0, 0.0);
        let scratch = |level: &Level| level.forward.get_scratch_len().max(level.inverse.get_scratch_len());
        Workspace {
            time: vec![0.0; length],
            f: vec![zero; length / 2 + 1],
            b: vec![zero; length / 2 + 1],
            scratch: vec![zero; self.levels.iter().map(scratch).max().unwrap_or(0)],
        }
    }

    /// f_t(t)/√v_t.
    pub(super) fn whiten(&self, series: &[f64], workspace: &mut Workspace) -> Vec<f64> {
        let length = self.length();
        let (mut f, mut b) = (vec![0.0; length], vec![0.0; length]);
        f[..self.rows].copy_from_slice(series);
        b[1..self.rows].copy_from_slice(&series[..self.rows - 1]);
        self.run(self.levels.len(), 0, &mut f, &mut b, workspace);
        f.truncate(self.rows);
        f
    }

    fn length(&self) -> usize {
        BASE << self.levels.len()
    }

    /// The rows from `start`: f holds f_start(start + i), b holds b_start(start − 1 + i); f becomes the innovations.
    fn run(&self, level: usize, start: usize, f: &mut [f64], b: &mut [f64], workspace: &mut Workspace) {
        let Some(below) = level.checked_sub(1) else {
            for k in 0..BASE.min(self.rows - start) {
                let innovation = f[k];
                if let Some(&reflection) = self.reflections.get(start + k) {
                    step(reflection, &mut f[k..], b);
                }
                f[k] = innovation / self.deviations[start + k];
            }
            return;
        };
        let half = self.levels[below].half;
        if start + half < self.rows {
            let transfer = &self.levels[below].transfers[start / (2 * half)];
            self.levels[below].pass(transfer, f, b, workspace);
            self.run(below, start + half, &mut f[half..], &mut b[half..], workspace);
        }
        self.run(below, start, &mut f[..half], &mut b[..half], workspace);
    }

    /// The same for u and w, which gives the reflection coefficients; and A and B of the whole window if a later one needs them.
    fn schur(
        &mut self,
        level: usize,
        start: usize,
        u: &mut [f64],
        w: &mut [f64],
        workspace: &mut Workspace,
    ) -> Result<Option<[Vec<f64>; 2]>, Error> {
        let needed = start + u.len() < self.rows;
        let Some(below) = level.checked_sub(1) else {
            for k in 0..BASE.min(self.rows - 1 - start) {
                let reflection = u[k] / w[0];
                if reflection.is_nan() || reflection.abs() >= 1.0 {
                    let reason =
                        format!("the autocovariance is not positive definite at lag {}", start + k + 1);
                    return Err(Error::Decomposition { rows: self.rows, columns: self.rows, reason });
                }
                self.reflections.push(reflection);
                self.deviations.push(self.deviations[start + k] * (1.0 - reflection * reflection).sqrt());
                step(reflection, &mut u[k..], w);
            }
            return Ok(needed.then(|| polynomials(&self.reflections[start..])));
        };
        let half = u.len() / 2;
        if start + half >= self.rows {
            return self.schur(below, start, &mut u[..half], &mut w[..half], workspace);
        }
        let (mut first_u, mut first_w) = (u[..half].to_vec(), w[..half].to_vec());
        let Some(first) = self.schur(below, start, &mut first_u, &mut first_w, workspace)? else {
            return Ok(None);
        };
        let scale = 1.0 / u.len() as f64;
        let transfer = self.levels[below].transfer(&first, scale, workspace);
        self.levels[below].pass(&transfer, u, w, workspace);
        let second = self.schur(below, start + half, &mut u[half..], &mut w[half..], workspace)?;
        let level = &mut self.levels[below];
        let both = second.filter(|_| needed).map(|second| {
            let second = level.transfer(&second, 1.0, workspace);
            level.joined(&transfer, &second, workspace)
        });
        level.transfers.push(transfer);
        Ok(both)
    }
}

impl Level {
    fn transfer(&self, [a, b]: &[Vec<f64>; 2], scale: f64, workspace: &mut Workspace) -> Transfer {
        let mut transformed = |values: &[f64]| {
            let time = &mut workspace.time[..2 * self.half];
            time[..self.half].iter_mut().zip(values).for_each(|(time, value)| *time = scale * value);
            time[self.half..].fill(0.0);
            let mut output = self.forward.make_output_vec();
            forward(&self.forward, time, &mut output, &mut workspace.scratch);
            output
        };
        Transfer { a: transformed(a), b: transformed(b) }
    }

    /// The second half of a window after the steps of its first half, from the whole window before them.
    fn pass(&self, transfer: &Transfer, f: &mut [f64], b: &mut [f64], workspace: &mut Workspace) {
        let half = self.half;
        let time = &mut workspace.time[..2 * half];
        let (after_f, after_b) = (&mut workspace.f[..half + 1], &mut workspace.b[..half + 1]);
        time.copy_from_slice(f);
        forward(&self.forward, time, after_f, &mut workspace.scratch);
        time.copy_from_slice(b);
        forward(&self.forward, time, after_b, &mut workspace.scratch);
        for (((f, b), p), q) in after_f.iter_mut().zip(after_b.iter_mut()).zip(&transfer.a).zip(&transfer.b) {
            // B̃ and Ã are the conjugates, which makes b early by half − 1: it then starts the window.
            (*f, *b) = (p * *f + q * *b, q.conj() * *f + p.conj() * *b);
        }
        inverse(&self.inverse, after_f, time, &mut workspace.scratch);
        f[half..].copy_from_slice(&time[half..]);
        inverse(&self.inverse, after_b, time, &mut workspace.scratch);
        b[half..].copy_from_slice(&time[..half]);
    }

    /// A₂A₁ + z B₂B̃₁ and A₂B₁ + z B₂Ã₁, z a delay by one row.
    fn joined(&self, first: &Transfer, second: &Transfer, workspace: &mut Workspace) -> [Vec<f64>; 2] {
        let mut product = |straight: &[Complex<f64>], reversed: &[Complex<f64>]| {
            let output = &mut workspace.f[..self.half + 1];
            for (k, output) in output.iter_mut().enumerate() {
                // Reversed and delayed by one: conjugate and delayed by half the window.
                let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                *output = second.a[k] * straight[k] + second.b[k] * reversed[k].conj() * sign;
            }
            let mut values = vec![0.0; 2 * self.half];
            inverse(&self.inverse, output, &mut values, &mut workspace.scratch);
            values
        };
        [product(&first.a, &first.b), product(&first.b, &first.a)]
    }
}

fn forward(plan: &Forward, input: &mut [f64], output: &mut [Complex<f64>], scratch: &mut [Complex<f64>]) {
    plan.process_with_scratch(input, output, scratch).expect("buffers of the plan's lengths");
}

fn inverse(plan: &Inverse, input: &mut [Complex<f64>], output: &mut [f64], scratch: &mut [Complex<f64>]) {
    plan.process_with_scratch(input, output, scratch).expect("buffers of the plan's lengths, real ends");
}

/// One step of the lattice; the first of `b` stands one row before the first of `f`.
fn step(reflection: f64, f: &mut [f64], b: &mut [f64]) {
    for (f, b) in f.iter_mut().zip(b.iter_mut()) {
        (*f, *b) = (*f - reflection * *b, *b - reflection * *f);
    }
}

/// A and B of steps one after the other.
fn polynomials(reflections: &[f64]) -> [Vec<f64>; 2] {
    let (mut a, mut b) = (vec![1.0], vec![-reflections[0]]);
    for reflection in &reflections[1..] {
        let delayed = |values: &[f64]| -> Vec<f64> {
            std::iter::once(0.0).chain(values.iter().rev().map(|value| reflection * value)).collect()
        };
        let (from_b, from_a) = (delayed(&b), delayed(&a));
        a.push(0.0);
        b.push(0.0);
        a.iter_mut().zip(from_b).for_each(|(a, term)| *a -= term);
        b.iter_mut().zip(from_a).for_each(|(b, term)| *b -= term);
    }
    [a, b]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlated::Whitening;
    use faer::Mat;

    #[test]
    fn it_is_the_cholesky_factor_at_any_length() {
        for rows in
            [1, 2, 3, BASE - 1, BASE, BASE + 1, 2 * BASE - 1, 2 * BASE, 2 * BASE + 1, 3 * BASE + 1, 1000]
        {
            let lags: Vec<f64> = (0..rows)
                .map(|m| if m == 0 { 3.1 } else { 2.0 / (1.0 + 0.01 * m as f64) + 0.9_f64.powi(m as i32) })
                .collect();
            let covariance = Mat::from_fn(rows, rows, |i, j| lags[i.abs_diff(j)]);
            let dense = Whitening::of(&[covariance]).expect("a factor");
            let series: Vec<f64> = (0..rows).map(|i| 5.0 + ((i * i) as f64).sin()).collect();
            let lattice = Lattice::of(&lags).expect("a lattice");
            let white = lattice.whiten(&series, &mut lattice.workspace());
            for (white, expected) in white.iter().zip(dense.apply_to(&series)) {
                assert!((white - expected).abs() < 1e-11, "{rows} rows: {white} and {expected}");
            }
            assert!((lattice.log_determinant() - dense.log_determinant()).abs() < 1e-10);
        }
    }

    #[test]
    fn no_autocovariance_is_refused() {
        assert!(matches!(Lattice::of(&[1.0, 0.9, 0.1]), Err(Error::Decomposition { .. })));
    }
}
