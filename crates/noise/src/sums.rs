//! Sums of values that each process forgets as time goes on.

use crate::Process;
use crate::filter::LANES;

/// Σ_j v_j exp(−λ(t − t_j)) of each process over values of some series before a time t that goes on.
pub struct Sums<'a> {
    processes: &'a [Process],
    time_s: f64,
    /// The last step, and what each process keeps over it.
    step_s: f64,
    kept: Vec<f64>,
    sums: Vec<[f64; LANES]>,
}

impl<'a> Sums<'a> {
    /// Of nothing yet.
    pub fn of(processes: &'a [Process]) -> Self {
        let (kept, sums) = (vec![1.0; processes.len()], vec![[0.0; LANES]; processes.len()]);
        Self { processes, time_s: f64::NEG_INFINITY, step_s: 0.0, kept, sums }
    }

    fn go_to(&mut self, time_s: f64) {
        let step = time_s - self.time_s;
        self.time_s = time_s;
        // Equal but for the rounding of times.
        if (step - self.step_s).abs() > 1e-9 * step {
            self.step_s = step;
            let rates = self.processes.iter().map(|process| process.rate_per_s);
            self.kept.iter_mut().zip(rates).for_each(|(kept, rate)| *kept = (-rate * step).exp());
        }
        self.sums.iter_mut().zip(&self.kept).for_each(|(sum, kept)| *sum = sum.map(|sum| sum * kept));
    }

    /// Adds the values at a time.
    pub fn add(&mut self, time_s: f64, values: [f64; LANES]) {
        self.go_to(time_s);
        for sum in &mut self.sums {
            *sum = std::array::from_fn(|lane| sum[lane] + values[lane]);
        }
    }

    /// All processes times their variances at a time.
    pub fn at(&mut self, time_s: f64) -> [f64; LANES] {
        self.go_to(time_s);
        let mut all = [0.0; LANES];
        for (sum, process) in self.sums.iter().zip(self.processes) {
            all = std::array::from_fn(|lane| all[lane] + process.variance_nt2 * sum[lane]);
        }
        all
    }
}
