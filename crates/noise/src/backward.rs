//! What a whitening does in one pass from the last row to the first: its transpose, and the norms of steps.

use crate::filter::LANES;
use crate::whitening::Whitening;

impl Whitening {
    /// L⁻ᵀ of a series: of what was whitened, C⁻¹ y, in which a departure of a single row stands out. One pass
    /// from the last row to the first. Without what is known of the mean.
    pub fn whiten_transposed(&self, series: &[f64]) -> Vec<f64> {
        let mut column = series.to_vec();
        self.whiten_transposed_all(&mut [&mut column]);
        column
    }

    /// The same of each column in place, all by the same gains.
    pub fn whiten_transposed_all<C: AsMut<[f64]>>(&self, columns: &mut [C]) {
        if self.whitens_white(columns) {
            return;
        }
        for group in columns.chunks_mut(LANES) {
            let mut states = vec![[0.0; LANES]; self.filter().states()];
            self.backwards(|row, gain| {
                let mut innovations = [0.0; LANES];
                for (state, gain) in states.iter().zip(&gain.gains) {
                    innovations = std::array::from_fn(|lane| innovations[lane] + state[lane] * gain);
                }
                for (innovation, column) in innovations.iter_mut().zip(group.iter_mut()) {
                    *innovation += gain.inverse * column.as_mut()[row];
                    column.as_mut()[row] = *innovation;
                }
                for (state, decay) in states.iter_mut().zip(&gain.decays) {
                    *state = std::array::from_fn(|lane| decay * state[lane] - innovations[lane]);
                }
            });
        }
    }

    /// sᵀ C⁻¹ s of a step s at each row: one from there on, zero before (1/nT²).
    ///
    /// What is left to come of the squares of whitened ones is a quadratic form of the state, aᵀ N a + 2 bᵀ a + c, which a
    /// step begins with a = 0. With A = diag φ − g 1ᵀ, from the last row to the first: N ← Aᵀ N A + 1 1ᵀ/F,
    /// b ← Aᵀ (N g + b) − 1/F, c ← c + 2 bᵀ g + gᵀ N g + 1/F.
    pub fn step_norms(&self) -> Vec<f64> {
        let states = self.filter().states();
        let (mut n, mut b, mut c) = (vec![0.0; states * states], vec![0.0; states], 0.0);
        let mut norms = vec![0.0; self.rows()];
        self.backwards(|row, gain| {
            let (g, decays) = (&gain.gains, &gain.decays);
            let inverse = gain.inverse * gain.inverse;
            let ng: Vec<f64> = n.chunks_exact(states.max(1)).map(|row| dot(row, g)).collect();
            let (gng, bg) = (dot(g, &ng), dot(&b, g));
            c += 2.0 * bg + gng + inverse;
            for i in 0..states {
                b[i] = decays[i] * (ng[i] + b[i]) - (gng + bg) - inverse;
                for j in 0..states {
                    let own = &mut n[i * states + j];
                    *own =
                        decays[i] * decays[j] * *own - decays[i] * ng[i] - decays[j] * ng[j] + gng + inverse;
                }
            }
            norms[row] = c;
        });
        norms
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
