//! The damped Gauss-Newton iteration that all nonlinear fits share.
//!
//! [`minimise`] is the iteration. [`solve`] is the same for problems that hand in dense rows, with steps by
//! the singular value decomposition; [`Directions`] makes the steps, from rows or from their products.

mod dense;
mod descent;
mod directions;

pub use dense::{Fit, Options, Problem, linearised, solve};
pub use descent::{Control, Damping, Descent, Linear, Minimum, Step, Tolerance, minimise};
pub use directions::Directions;

#[cfg(test)]
mod tests {
    use faer::{Mat, MatMut};

    use super::*;
    use crate::Error;

    /// A set of the NIST StRD: y against x by a model, which gives a prediction and its derivatives.
    struct Nist<const N: usize> {
        y: &'static [f64],
        model: fn(&[f64; N], usize) -> (f64, [f64; N]),
    }

    impl<const N: usize> Problem for Nist<N> {
        type State = [f64; N];
        fn unknowns(&self) -> usize {
            N
        }
        fn rows(&self) -> usize {
            self.y.len()
        }
        fn linearise(&self, b: &[f64; N], residual: &mut [f64], mut jacobian: MatMut<'_, f64>) {
            for (i, y) in self.y.iter().enumerate() {
                let (predicted, slopes) = (self.model)(b, i);
                residual[i] = y - predicted;
                slopes.into_iter().enumerate().for_each(|(j, slope)| jacobian[(i, j)] = slope);
            }
        }
        fn advance(&self, b: &[f64; N], step: &[f64]) -> [f64; N] {
            std::array::from_fn(|i| b[i] + step[i])
        }
    }

    #[test]
    fn nist_misra1a_from_both_starts() {
        // y = b1 (1 − e^(−b2 x)), lower difficulty; certified to 11 digits.
        const X: [f64; 14] =
            [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0];
        let misra1a: Nist<2> = Nist {
            y: &[
                10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47,
                81.78,
            ],
            model: |b, i| {
                let decay = (-b[1] * X[i]).exp();
                (b[0] * (1.0 - decay), [1.0 - decay, b[0] * X[i] * decay])
            },
        };
        for start in [[500.0, 1e-4], [250.0, 5e-4]] {
            let options = Options { tolerance: 1e-9, ..Options::default() };
            let fit = solve(&misra1a, start, None, &options).expect("a minimum");
            assert!((fit.state[0] / 2.389_421_291_8e2 - 1.0).abs() < 1e-9, "{:?}", fit.state);
            assert!((fit.state[1] / 5.501_564_318_1e-4 - 1.0).abs() < 1e-9);
            assert!((fit.cost / 1.245_513_889_4e-1 - 1.0).abs() < 1e-9);
            let variance = fit.cost / fit.degrees_of_freedom();
            let std = (variance * fit.svd.covariance()[(0, 0)]).sqrt();
            assert!((std / 2.707_007_524_1 - 1.0).abs() < 1e-8, "{std}");
        }
    }

    /// NIST StRD MGH10: y = b1 e^(b2/(x + b3)), higher difficulty; whole steps overflow.
    const MGH10: Nist<3> = Nist {
        y: &[
            34780.0, 28610.0, 23650.0, 19630.0, 16370.0, 13720.0, 11540.0, 9744.0, 8261.0, 7030.0, 6005.0,
            5147.0, 4427.0, 3820.0, 3307.0, 2872.0,
        ],
        model: |b, i| {
            let place = 50.0 + 5.0 * i as f64 + b[2];
            let rise = (b[1] / place).exp();
            (b[0] * rise, [rise, b[0] * rise / place, -b[0] * rise * b[1] / (place * place)])
        },
    };

    /// MGH10 with steps by products, the derivatives by b1 kept from step to step.
    struct Kept;

    impl Descent for Kept {
        type Point = [f64; 3];
        type Linear = Directions<Mat<f64>>;
        type Error = Error;
        fn cost(&self, b: &[f64; 3]) -> f64 {
            linearised(&MGH10, b).0.iter().map(|r| r * r).sum()
        }
        fn linear(&self, b: &[f64; 3], kept: Option<&Self::Linear>) -> Result<Self::Linear, Error> {
            let (residual, mut jacobian) = linearised(&MGH10, b);
            if let Some(kept) = kept {
                jacobian.col_as_slice_mut(0).copy_from_slice(kept.of.col_as_slice(0));
            }
            Directions::of_products(jacobian, &residual)
        }
        fn moved(&self, b: &[f64; 3], step: &[f64]) -> Result<[f64; 3], Error> {
            Ok(MGH10.advance(b, step))
        }
    }

    #[test]
    fn derivatives_that_are_kept_lead_to_the_same_minimum() {
        let control = Control {
            most: 1000,
            tolerance: 1e-6,
            damping: Damping { first: 1e-4, least: 1e-10, from: 1e-10 },
            raise: Tolerance { absolute: 0.0, relative: 0.0 },
            idle: None,
            keep: true,
            reach: None,
        };
        let found = minimise(&Kept, [0.02, 4000.0, 250.0], None, &control).expect("a descent");
        assert!(found.settled && found.steps.len() < 500);
        let certified = [5.609_636_471_0e-3, 6.181_346_346_3e3, 3.452_236_346_2e2];
        for (found, certified) in found.at.iter().zip(certified) {
            assert!((found / certified - 1.0).abs() < 1e-6, "{found}");
        }
        // The derivatives by b1 are new.
        let (_, jacobian) = linearised(&MGH10, &found.at);
        for (new, found) in jacobian.col_as_slice(0).iter().zip(found.linear.of.col_as_slice(0)) {
            assert!((found / new - 1.0).abs() < 1e-6, "{found} for {new}");
        }
    }
}
