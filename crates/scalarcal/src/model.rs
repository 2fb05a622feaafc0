//! The parameters, and the coefficients of the products as a function of them.

use faer::prelude::ReborrowMut;
use faer::{ColRef, Mat, MatMut};
use nalgebra::Matrix3;

use crate::terms::{ONE, Terms};

/// Pairs of axes whose cosines are parameters.
pub const PAIRS: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];
/// Parameters of the sensors: sensitivities, offsets, cosines.
pub const NINE: usize = 9;

/// One parameter.
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
        /// Number of the effect and of its parameter.
        number: [usize; 2],
        /// The column z that its contribution to each sensor follows, and the factor on it.
        follows: [Option<(usize, f64)>; 3],
        /// In words.
        name: String,
    },
    /// β: what the reference reads too much, over the typical magnitude.
    ReferenceOffset,
    /// The magnitude over the assumed one, where it is constant and not known.
    Magnitude,
    /// Turn of all sensors together about an axis of SEN, rad; the magnitude does not show it.
    Turn(usize),
}

/// Axes in words.
pub const AXES: [&str; 3] = ["x", "y", "z"];

impl Parameter {
    /// In words.
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
    /// The products.
    pub terms: Terms,
    /// The parameters.
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

    /// Nominal sensors: no offset, axes at right angles, no effects.
    pub fn nominal(&self) -> State {
        let of = |parameter: &Parameter| match parameter {
            Parameter::Sensitivity(_) | Parameter::Magnitude => 1.0,
            _ => 0.0,
        };
        self.parameters.iter().map(of).collect()
    }

    /// L: what each sensor reads along its axis, by the columns z.
    fn along(&self, state: &State) -> Mat<f64> {
        let mut along = Mat::zeros(3, self.terms.columns());
        for (parameter, value) in self.parameters.iter().zip(state) {
            match parameter {
                Parameter::Sensitivity(axis) => along[(*axis, *axis)] = *value,
                Parameter::Offset(axis) => along[(*axis, ONE)] = *value,
                // What an effect adds is to be taken off.
                Parameter::Effect { follows, .. } => {
                    for (axis, column) in follows.iter().enumerate() {
                        if let Some((column, factor)) = column {
                            along[(axis, *column)] -= factor * value;
                        }
                    }
                }
                Parameter::Cosine(_)
                | Parameter::ReferenceOffset
                | Parameter::Magnitude
                | Parameter::Turn(_) => {}
            }
        }
        along
    }

    /// The coefficients p of the products in the residual; None where the cosines are none of three axes.
    /// Where the magnitude is a parameter m, all are over m k, k the mean sensitivity: so the residual is in
    /// the unit of the readings, and no common scale of sensors and field makes it small.
    pub fn coefficients(&self, state: &State) -> Option<Vec<f64>> {
        let along = self.along(state);
        let inverse = cosines(state).try_inverse()?;
        let mixed = mixed(&inverse, &along);
        let columns = self.terms.columns();
        let square = |f: usize, g: usize| (0..3).map(|k| along[(k, f)] * mixed[(k, g)]).sum::<f64>();
        let (offset, magnitude) = (self.value(state, Parameter::ReferenceOffset), self.magnitude(state));
        let unit = magnitude * self.scale(state);
        let of = |[f, g]: [usize; 2]| {
            if g == columns {
                if f == columns { -magnitude * magnitude } else { 2.0 * offset }
            } else {
                let own = if [f, g] == [ONE, ONE] { offset * offset } else { 0.0 };
                if f == g { square(f, g) - own } else { 2.0 * square(f, g) }
            }
        };
        Some(self.terms.pairs().iter().map(|pair| of(*pair) / unit).collect())
    }

    /// The derivative of the coefficients by each parameter, one column a parameter.
    pub fn slopes(&self, state: &State) -> Option<Mat<f64>> {
        let along = self.along(state);
        let inverse = cosines(state).try_inverse()?;
        let mixed = mixed(&inverse, &along);
        let columns = self.terms.columns();
        let mut slopes = Mat::zeros(self.terms.count(), self.parameters.len());
        for (j, parameter) in self.parameters.iter().enumerate() {
            // Twice ∂|B|²/∂L along one element, symmetric in f and g.
            let mut element = |axis: usize, column: usize, sign: f64| {
                for other in 0..columns {
                    let place = self.terms.place(column, other).expect("a product without F");
                    // z_column (G⁻¹L)_axis,other appears twice; on the diagonal the pair stands once.
                    slopes[(place, j)] += sign * 2.0 * mixed[(axis, other)];
                }
            };
            match parameter {
                Parameter::Sensitivity(axis) => element(*axis, *axis, 1.0),
                Parameter::Offset(axis) => element(*axis, ONE, 1.0),
                Parameter::Effect { follows, .. } => {
                    for (axis, column) in follows.iter().enumerate() {
                        if let Some((column, factor)) = column {
                            element(axis, *column, -factor);
                        }
                    }
                }
                Parameter::Cosine(pair) => {
                    let [a, b] = PAIRS[*pair];
                    for (place, [f, g]) in self.terms.pairs().iter().enumerate() {
                        if *g < columns {
                            let both = mixed[(a, *f)] * mixed[(b, *g)] + mixed[(b, *f)] * mixed[(a, *g)];
                            slopes[(place, j)] = if f == g { -both } else { -2.0 * both };
                        }
                    }
                }
                Parameter::ReferenceOffset => {
                    let offset = self.value(state, Parameter::ReferenceOffset);
                    let place = self.terms.place(ONE, ONE).expect("a product without F");
                    slopes[(place, j)] = -2.0 * offset;
                    slopes[(self.terms.count() - 2, j)] = 2.0;
                }
                Parameter::Magnitude => slopes[(self.terms.count() - 1, j)] = -2.0 * self.magnitude(state),
                Parameter::Turn(_) => {}
            }
        }
        if let Some(place) = self.place(&Parameter::Magnitude) {
            let coefficients = self.coefficients(state)?;
            let (magnitude, scale) = (self.magnitude(state), self.scale(state));
            slopes *= faer::Scale(1.0 / (magnitude * scale));
            for (row, value) in coefficients.iter().enumerate() {
                slopes[(row, place)] -= value / magnitude;
                (0..3).for_each(|axis| slopes[(row, axis)] -= value / (3.0 * scale));
            }
        }
        Some(slopes)
    }

    /// How a state reads rows.
    pub fn chain(&self, state: &State) -> Chain {
        let along = self.along(state);
        let columns = |axis: usize| (0..self.terms.columns()).map(|f| along[(axis, f)]).collect();
        Chain(std::array::from_fn(columns))
    }

    /// Where a parameter stands.
    pub fn place(&self, parameter: &Parameter) -> Option<usize> {
        self.parameters.iter().position(|own| own == parameter)
    }

    fn value(&self, state: &State, parameter: Parameter) -> f64 {
        self.place(&parameter).map_or(0.0, |place| state[place])
    }

    /// The unit of a residual, over the typical magnitude: the mean sensitivity where the magnitude is a
    /// parameter, else one.
    pub fn scale(&self, state: &State) -> f64 {
        if self.place(&Parameter::Magnitude).is_some() { state[..3].iter().sum::<f64>() / 3.0 } else { 1.0 }
    }

    /// The magnitude over the assumed one.
    pub fn magnitude(&self, state: &State) -> f64 {
        self.place(&Parameter::Magnitude).map_or(1.0, |place| state[place])
    }
}

/// L of a state, sensor by sensor.
pub struct Chain([Vec<f64>; 3]);

impl Chain {
    /// What each sensor reads along its axis, over the typical magnitude.
    pub fn own(&self, z: &[f64]) -> [f64; 3] {
        self.0.each_ref().map(|along| along.iter().zip(z).map(|(factor, value)| factor * value).sum())
    }
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

/// G⁻¹ L.
fn mixed(inverse: &Matrix3<f64>, along: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(3, along.ncols(), |i, j| (0..3).map(|k| inverse[(i, k)] * along[(k, j)]).sum())
}

/// Least squares of the coefficients by a triangular factor U of the products, with what is known beforehand.
pub struct Problem<'a> {
    /// The model.
    pub model: &'a Model,
    /// U, over the standard deviation of a residual.
    pub upper: &'a Mat<f64>,
    /// What is known beforehand: independent combinations of parameters, each with its value, over its
    /// standard deviation.
    pub known: &'a [(Vec<f64>, f64)],
}

impl estimate::Problem for Problem<'_> {
    type State = State;

    fn unknowns(&self) -> usize {
        self.model.parameters.len()
    }

    fn rows(&self) -> usize {
        self.upper.nrows() + self.known.len()
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
        for (row, (weights, value)) in self.known.iter().enumerate() {
            let predicted: f64 = weights.iter().zip(state).map(|(weight, value)| weight * value).sum();
            residual[rows + row] = value - predicted;
            (0..self.unknowns()).for_each(|j| jacobian[(rows + row, j)] = weights[j]);
        }
    }

    fn advance(&self, state: &State, step: &[f64]) -> State {
        state.iter().zip(step).map(|(value, step)| value + step).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_and_slopes() {
        let effect = Parameter::Effect {
            number: [0, 0],
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
        let own = nalgebra::Vector3::from(model.chain(&state).own(&z));
        let magnitude = own.dot(&(cosines(&state).try_inverse().expect("axes") * own)).sqrt();
        // (mF)² with m, then (F − β)² in place of F².
        let expected = (magnitude.powi(2) - (1.01 * z[6]).powi(2) + 2.0 * 0.004 * z[6] - 0.004_f64.powi(2))
            / (2.0 * z[6] * 1.01 * (1.1 + 0.9 + 1.02) / 3.0);
        assert!((residual - expected).abs() < 1e-15, "{residual} {expected}");
        let slopes = model.slopes(&state).expect("axes");
        for j in 0..state.len() {
            let moved = |by: f64| {
                let mut state = state.clone();
                state[j] += by;
                model.coefficients(&state).expect("axes")
            };
            let (up, down) = (moved(1e-6), moved(-1e-6));
            for place in 0..model.terms.count() {
                let slope = (up[place] - down[place]) / 2e-6;
                assert!((slope - slopes[(place, j)]).abs() < 1e-8, "parameter {j}, product {place}");
            }
        }
    }
}
