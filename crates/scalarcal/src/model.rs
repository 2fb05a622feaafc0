//! The parameters, and the coefficients of the products as a function of them.

use faer::prelude::ReborrowMut;
use faer::{ColRef, Mat, MatMut};
use nalgebra::Matrix3;
use num_dual::Dual64;
use physics::Real;

use crate::linear::Linear;
use crate::terms::{ONE, Terms};

/// Pairs of axes whose cosines are parameters.
pub const PAIRS: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];
/// Parameters of the sensors: sensitivities, offsets, cosines.
pub const NINE: usize = 9;

#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// Sensitivity of a sensor over the nominal one.
    Sensitivity(usize),
    /// Offset of a sensor over the typical magnitude.
    Offset(usize),
    /// Cosine of the angle between the axes of a pair of [`PAIRS`].
    Cosine(usize),
    /// Size of an effect, in units in which it adds the order of the typical magnitude.
    Effect {
        number: [usize; 2],
        /// What one unit of the state is in the unit of its parameter.
        unit: f64,
        /// The column z that its contribution to each sensor follows, and the factor on it.
        follows: [Option<(usize, f64)>; 3],
        name: String,
    },
    /// β: what the reference reads too much, over the typical magnitude.
    ReferenceOffset,
    /// The magnitude over the assumed one, where it is constant and not known.
    Magnitude,
    /// Turn of all sensors together about an axis of SEN, rad; the magnitude does not show it.
    Turn(usize),
}

pub const AXES: [&str; 3] = ["x", "y", "z"];

impl Parameter {
    pub fn name(&self) -> String {
        match self {
            Parameter::Sensitivity(axis) => format!("sensitivity of {}", AXES[*axis]),
            Parameter::Offset(axis) => format!("offset of {}", AXES[*axis]),
            Parameter::Cosine(pair) => {
                let [a, b] = PAIRS[*pair];
                format!("angle between {} and {}", AXES[a], AXES[b])
            }
            Parameter::Effect { name, .. } => name.clone(),
            Parameter::ReferenceOffset => "offset of the reference".into(),
            Parameter::Magnitude => "magnitude of the field".into(),
            Parameter::Turn(axis) => format!("turn of the sensors about {}", AXES[*axis]),
        }
    }
}

/// A calibration: one value for each parameter.
pub type State = Vec<f64>;

/// Which parameters there are, in the order of a state. The nine of the sensors come first.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    pub terms: Terms,
    pub parameters: Vec<Parameter>,
}

impl Model {
    /// The nine parameters of the sensors, and more.
    pub fn new(columns: usize, more: impl IntoIterator<Item = Parameter>) -> Self {
        let nine = (0..3)
            .map(Parameter::Sensitivity)
            .chain((0..3).map(Parameter::Offset))
            .chain((0..3).map(Parameter::Cosine));
        Self { terms: Terms::new(columns), parameters: nine.chain(more).collect() }
    }

    /// The same without the turn of the sensors, which stands last.
    pub fn by_magnitude(&self) -> Self {
        let shown = |parameter: &&Parameter| !matches!(parameter, Parameter::Turn(_));
        Self {
            terms: self.terms.clone(),
            parameters: self.parameters.iter().filter(shown).cloned().collect(),
        }
    }

    /// The nine parameters of the sensors by another state, and no effects.
    pub fn with(&self, nine: &[f64]) -> State {
        let mut state = self.nominal();
        state[..NINE].copy_from_slice(&nine[..NINE]);
        state
    }

    /// Nominal sensors: no offset, axes at right angles, no effects.
    pub fn nominal(&self) -> State {
        let of = |parameter: &Parameter| match parameter {
            Parameter::Sensitivity(_) | Parameter::Magnitude => 1.0,
            _ => 0.0,
        };
        self.parameters.iter().map(of).collect()
    }

    /// L: what each sensor reads along its axis, by the columns z.
    pub fn along<T: Real>(&self, state: &[T]) -> [Vec<T>; 3] {
        let mut along = [(); 3].map(|()| vec![T::zero(); self.terms.columns]);
        for (parameter, value) in self.parameters.iter().zip(state) {
            match parameter {
                Parameter::Sensitivity(axis) => along[*axis][*axis] = *value,
                Parameter::Offset(axis) => along[*axis][ONE] = *value,
                // What an effect adds is to be taken off.
                Parameter::Effect { follows, .. } => {
                    for (along, follows) in along.iter_mut().zip(follows) {
                        if let Some((column, factor)) = follows {
                            along[*column] -= *value * *factor;
                        }
                    }
                }
                _ => {}
            }
        }
        along
    }

    /// The coefficients p of the products in the residual; None where the cosines are none of three axes.
    /// Where the magnitude is a parameter m, all are over m k, k the mean sensitivity: so the residual is in
    /// the unit of the readings, and no common scale of sensors and field makes it small.
    pub fn coefficients<T: Real>(&self, state: &[T]) -> Option<Vec<T>> {
        let along = self.along(state);
        let inverse = inverse_cosines(state)?;
        let columns = self.terms.columns;
        let square = |f: usize, g: usize| {
            let pairs = (0..3).flat_map(|k| (0..3).map(move |l| (k, l)));
            pairs.fold(T::zero(), |sum, (k, l)| sum + along[k][f] * inverse[k][l] * along[l][g])
        };
        let (offset, magnitude) = (self.value(state, Parameter::ReferenceOffset), self.magnitude(state));
        let unit = magnitude * self.scale(state);
        let of = |[f, g]: [usize; 2]| {
            if g == columns {
                if f == columns { -magnitude * magnitude } else { offset * 2.0 }
            } else {
                let own = if [f, g] == [ONE, ONE] { offset * offset } else { T::zero() };
                if f == g { square(f, g) - own } else { square(f, g) * 2.0 }
            }
        };
        Some(self.terms.pairs.iter().map(|pair| of(*pair) / unit).collect())
    }

    /// The derivative of the coefficients by each parameter, one column a parameter.
    pub fn slopes(&self, state: &State) -> Option<Mat<f64>> {
        let by = |j: usize| {
            let dual = |(k, value): (usize, &f64)| Dual64::new(*value, f64::from(u8::from(k == j)));
            self.coefficients(&state.iter().enumerate().map(dual).collect::<Vec<_>>())
        };
        let by: Vec<Vec<Dual64>> = (0..self.parameters.len()).map(by).collect::<Option<_>>()?;
        Some(Mat::from_fn(self.terms.count(), by.len(), |place, j| by[j][place].eps))
    }

    pub fn place(&self, parameter: &Parameter) -> Option<usize> {
        self.parameters.iter().position(|own| own == parameter)
    }

    fn value<T: Real>(&self, state: &[T], parameter: Parameter) -> T {
        self.place(&parameter).map_or(T::zero(), |place| state[place])
    }

    /// The unit of a residual, over the typical magnitude: the mean sensitivity where that is fitted, else 1.
    pub fn scale<T: Real>(&self, state: &[T]) -> T {
        match self.place(&Parameter::Magnitude) {
            Some(_) => (state[0] + state[1] + state[2]) / 3.0,
            None => T::one(),
        }
    }

    pub fn magnitude<T: Real>(&self, state: &[T]) -> T {
        self.place(&Parameter::Magnitude).map_or(T::one(), |place| state[place])
    }
}

/// What each sensor reads along its axis by L, over the typical magnitude.
pub fn own(along: &[Vec<f64>; 3], z: &[f64]) -> [f64; 3] {
    along.each_ref().map(|along| along.iter().zip(z).map(|(factor, value)| factor * value).sum())
}

/// G: the cosines between the axes.
pub fn cosines(state: &State) -> Matrix3<f64> {
    let mut cosines = Matrix3::identity();
    for ([a, b], value) in PAIRS.iter().zip(&state[6..NINE]) {
        cosines[(*a, *b)] = *value;
        cosines[(*b, *a)] = *value;
    }
    cosines
}

/// G⁻¹; None where there is none.
fn inverse_cosines<T: Real>(state: &[T]) -> Option<[[T; 3]; 3]> {
    let (xy, yz, xz, one) = (state[6], state[7], state[8], T::one());
    let determinant = one + xy * yz * xz * 2.0 - xy * xy - yz * yz - xz * xz;
    let minors = [
        [one - yz * yz, xz * yz - xy, xy * yz - xz],
        [xz * yz - xy, one - xz * xz, xy * xz - yz],
        [xy * yz - xz, xy * xz - yz, one - xy * xy],
    ];
    (determinant.re() != 0.0).then(|| minors.map(|row| row.map(|minor| minor / determinant)))
}

/// Least squares of the coefficients by a triangular factor U of the products, with what is known beforehand.
pub struct Problem<'a> {
    pub model: &'a Model,
    /// U, over the standard deviation of a residual.
    pub upper: &'a Mat<f64>,
    pub known: &'a Linear,
}

impl estimate::Problem for Problem<'_> {
    type State = State;

    fn unknowns(&self) -> usize {
        self.model.parameters.len()
    }

    fn rows(&self) -> usize {
        self.upper.nrows() + self.known.right.len()
    }

    fn readings(&self) -> usize {
        self.upper.nrows()
    }

    fn linearise(&self, state: &State, residual: &mut [f64], mut jacobian: MatMut<'_, f64>) {
        let rows = self.upper.nrows();
        let found = self.model.coefficients(state).zip(self.model.slopes(state));
        let Some((coefficients, slopes)) = found else {
            residual.fill(f64::MAX.sqrt());
            return;
        };
        let found = self.upper * ColRef::from_slice(&coefficients);
        residual.iter_mut().zip(found.iter()).for_each(|(residual, found)| *residual = -found);
        jacobian.rb_mut().subrows_mut(0, rows).copy_from(self.upper * &slopes);
        let known = self.known.about(state);
        residual[rows..].copy_from_slice(&known.right);
        jacobian.subrows_mut(rows, known.right.len()).copy_from(&known.jacobian);
    }

    fn advance(&self, state: &State, step: &[f64]) -> State {
        state.iter().zip(step).map(|(value, step)| value + step).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_add_up_to_the_residual() {
        let effect = Parameter::Effect {
            number: [0, 0],
            unit: 1.0,
            follows: [Some((4, 1.0)), None, Some((5, 0.7))],
            name: String::new(),
        };
        let model = Model::new(6, [effect, Parameter::ReferenceOffset, Parameter::Magnitude]);
        let state = vec![1.1, 0.9, 1.02, 0.01, -0.02, 0.03, 0.05, -0.04, 0.02, 0.3, 0.004, 1.01];
        let coefficients = model.coefficients(&state).expect("axes");
        let z = [0.4, -0.3, 0.8, 1.0, 0.2, -0.6, 0.97];
        let mut row = vec![0.0; model.terms.count()];
        model.terms.fill(&z, &mut row);
        let residual: f64 = row.iter().zip(&coefficients).map(|(a, b)| a * b).sum();
        let own = nalgebra::Vector3::from(own(&model.along(&state), &z));
        let magnitude = own.dot(&(cosines(&state).try_inverse().expect("axes") * own)).sqrt();
        // (mF)² with m, then (F − β)² in place of F².
        let expected = (magnitude.powi(2) - (1.01 * z[6]).powi(2) + 2.0 * 0.004 * z[6] - 0.004_f64.powi(2))
            / (2.0 * z[6] * 1.01 * (1.1 + 0.9 + 1.02) / 3.0);
        assert!((residual - expected).abs() < 1e-15, "{residual} {expected}");
    }
}
