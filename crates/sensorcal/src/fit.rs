//! A fit of the chain's parameters to recordings of one sensor, by the predictions of `physics`.

use common::uncertainty::{self, By};
use common::{Axis, FitNoise, Quantity, Uncertainty};
use estimate::correlated::{self, CorrelatedFit, Scale};
use estimate::gauss_newton::{Control, Damping, Descent, Minimum, Tolerance};
use faer::{ColRef, Mat};
use physics::{Basic, EffectInstance, Kind, Parameter};

use crate::allowed::{Allowed, Rows};
use crate::readings::Run;
use crate::shape::{Place, Shape};
use crate::{Error, Result};

/// The iteration: a step that moves no prediction by more than 1e-7 nT is the last one, and one may make the
/// fit twice as bad under the first of the covariances, for it is the mean of those under all.
const ITERATION: Control = Control {
    most: 30,
    tolerance: 1e-7,
    damping: Damping { first: 0.0, least: 0.0, from: 1.0 },
    raise: Tolerance { absolute: 0.0, relative: 1.0 },
    idle: None,
    keep: false,
    reach: None,
};

#[derive(Clone)]
pub enum Unknown {
    /// A parameter of the chain, in some of the runs; an effect's parameter is one in all.
    Chain(Parameter, Vec<usize>),
    /// A contribution to the field that is read, nT for each unit: a series for each run.
    Column(Vec<Vec<f64>>),
}

/// Parameters that are known with a covariance, in all runs.
#[derive(Clone)]
pub struct KnownParameters {
    pub parameters: Vec<Parameter>,
    pub covariance: Mat<f64>,
    /// What it rests on: parameters of the document, each with how these move with it.
    pub rests_on: By,
}

#[derive(Clone)]
pub struct Problem<'a, 'b> {
    /// The recordings; constants of the sensor start as they stand there.
    pub runs: &'a [Run<'b>],
    /// Effects that act, with the values from which unknown ones start.
    pub effects: Vec<EffectInstance>,
    pub unknowns: Vec<Unknown>,
    pub known: Vec<KnownParameters>,
    pub allowed: &'a Allowed,
}

pub fn noise(runs: &[Run<'_>], shape: &Shape, place: Place) -> Result<Allowed> {
    let rows: Vec<Rows> = runs.iter().map(|run| (run.rows.len(), run.times())).collect();
    shape.allowed(&rows, place, None)
}

#[derive(Clone)]
pub struct Fit {
    pub values: Vec<f64>,
    /// A factor of the linear fit's covariance.
    pub widened: f64,
    /// Covariance from what is known with an uncertainty, common to all readings.
    pub common: Mat<f64>,
    /// How the unknowns move with what is known with an uncertainty: parameters of the document.
    pub by: By,
    /// The linear fit at the minimum; its residuals are in nT.
    pub linear: CorrelatedFit,
    /// Derivatives of the predicted field by the unknowns, nT, over the used rows of all runs.
    pub design: Mat<f64>,
    pub noise: FitNoise,
}

impl Fit {
    /// How some of the unknowns move with parameters of the document.
    pub fn by(&self, unknowns: &[usize]) -> By {
        let of = |moved: &Vec<f64>| unknowns.iter().map(|unknown| moved[*unknown]).collect();
        self.by.iter().map(|(path, moved)| (path.clone(), of(moved))).collect()
    }

    pub fn scatter(&self, i: usize, j: usize) -> f64 {
        self.widened * self.linear.covariance(i, j)
    }

    pub fn scatter_of(&self, unknowns: &[usize]) -> Mat<f64> {
        Mat::from_fn(unknowns.len(), unknowns.len(), |i, j| self.scatter(unknowns[i], unknowns[j]))
    }

    /// Standard uncertainty from scatter.
    pub fn type_a(&self, unknown: usize) -> f64 {
        self.scatter(unknown, unknown).sqrt()
    }

    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        self.scatter(i, j) + self.common[(i, j)]
    }

    pub fn quantity(&self, unknown: usize) -> Quantity {
        Quantity::new(self.values[unknown], self.covariance(unknown, unknown).sqrt())
    }

    /// Σ of the squared whitened residuals, in units of the noise that was allowed for.
    pub fn sum_of_squares(&self) -> f64 {
        self.linear.variance_factor * self.linear.freedom
    }
}

#[derive(Clone)]
struct State {
    basics: Vec<Basic>,
    effects: Vec<EffectInstance>,
    /// Coefficients of the columns, in the order of the unknowns; zero for the others.
    columns: Vec<f64>,
}

/// A state, its residuals, the derivatives of the predicted field, nT, and χ² under the first covariance.
pub struct At {
    state: State,
    residual: Vec<f64>,
    design: Mat<f64>,
    cost: f64,
}

impl Descent for Problem<'_, '_> {
    type Point = At;
    type Linear = CorrelatedFit;
    type Error = Error;

    fn cost(&self, at: &At) -> f64 {
        at.cost
    }

    fn linear(&self, at: &At, _: Option<&CorrelatedFit>) -> Result<CorrelatedFit> {
        Ok(correlated::fit(at.design.as_ref(), &at.residual, &self.allowed.whitenings, Scale::Fitted)?)
    }

    fn moved(&self, at: &At, step: &[f64]) -> Result<At> {
        self.at(self.advance(&at.state, step))
    }
}

impl Problem<'_, '_> {
    pub fn with(&self, unknowns: Vec<Unknown>) -> Self {
        Self { unknowns, ..self.clone() }
    }

    /// The minimum, by Gauss-Newton steps of generalised least squares.
    pub fn solve(&self) -> Result<Fit> {
        let Minimum { at, linear, settled, .. } =
            estimate::minimise(self, self.at(self.first())?, None, &ITERATION)?;
        if settled {
            return self.finish(&at.state, linear, &at.design);
        }
        Err(Error::Unanswerable(format!(
            "recording \"{}\": the fit does not converge within {} iterations; are drives and temperatures collinear?",
            self.runs[0].context.recording.id, ITERATION.most
        )))
    }

    fn at(&self, state: State) -> Result<At> {
        let (residual, design) = self.linearise(&state)?;
        let cost = self.allowed.whitenings[0].apply_to(&residual).iter().map(|r| r * r).sum();
        Ok(At { state, residual, design, cost })
    }

    fn finish(&self, state: &State, linear: CorrelatedFit, design: &Mat<f64>) -> Result<Fit> {
        let unknowns = self.unknowns.len();
        let mut common = Mat::zeros(unknowns, unknowns);
        let mut by = By::new();
        let all: Vec<usize> = (0..self.runs.len()).collect();
        for known in &self.known {
            let parameters = known.parameters.iter().map(|parameter| Unknown::Chain(*parameter, all.clone()));
            let (_, derivatives) = self.with(parameters.collect()).linearise(state)?;
            // An error of what is known leaves the readings where they are: the unknowns take it up.
            let mut shifts = Mat::zeros(unknowns, known.parameters.len());
            for (at, mut shift) in shifts.col_iter_mut().enumerate() {
                let taken = self.taken_up(design, &linear, derivatives.col_as_slice(at))?;
                shift.copy_from(-ColRef::from_slice(&taken));
            }
            common += &shifts * &known.covariance * shifts.transpose();
            by.extend(known.rests_on.iter().map(|(path, weights)| {
                (path.clone(), (&shifts * ColRef::from_slice(weights)).iter().copied().collect())
            }));
        }
        Ok(Fit {
            values: (0..unknowns).map(|unknown| self.value(state, unknown)).collect(),
            widened: 1.0,
            common,
            by,
            design: design.clone(),
            noise: self.allowed.describe(&linear),
            linear,
        })
    }

    /// How the unknowns of a fit take up what is added to its readings, under the likeliest covariance.
    pub fn taken_up(&self, design: &Mat<f64>, linear: &CorrelatedFit, added: &[f64]) -> Result<Vec<f64>> {
        let one = self.allowed.likeliest(linear);
        Ok(correlated::fit(design.as_ref(), added, &one.whitenings, Scale::Fitted)?.coefficients)
    }

    /// Residuals and derivatives of the predicted field, nT, over the used rows of all runs.
    fn linearise(&self, state: &State) -> Result<(Vec<f64>, Mat<f64>)> {
        let total: usize = self.runs.iter().map(|run| run.rows.len()).sum();
        let mut residual = Vec::with_capacity(total);
        let mut design = Mat::zeros(total, self.unknowns.len());
        for (number, run) in self.runs.iter().enumerate() {
            let from = residual.len();
            let at = run.sensor.index();
            let basic = &state.basics[number];
            let k = basic.sensors[at].sensitivity;
            let in_chain = |(index, unknown): (usize, &Unknown)| match unknown {
                Unknown::Chain(parameter, runs) if runs.contains(&number) => Some((index, *parameter)),
                _ => None,
            };
            let chain: Vec<_> = self.unknowns.iter().enumerate().filter_map(in_chain).collect();
            let parameters: Vec<Parameter> = chain.iter().map(|(_, parameter)| *parameter).collect();
            let (prediction, derivatives) =
                physics::predict_with_jacobian(basic, &state.effects, &run.context, &parameters)
                    .map_err(|error| error.at(&run.path))?;
            for row in &run.rows {
                residual.push(k * (run.reading[*row] - prediction.readings[*row][at]));
            }
            for ((index, _), derivative) in chain.iter().zip(&derivatives) {
                for (i, row) in run.rows.iter().enumerate() {
                    design[(from + i, *index)] = k * derivative.readings[*row][at];
                }
            }
            for (index, unknown) in self.unknowns.iter().enumerate() {
                if let Unknown::Column(series) = unknown {
                    for (i, row) in run.rows.iter().enumerate() {
                        let value = series[number].get(*row).copied().unwrap_or(0.0);
                        design[(from + i, index)] = value;
                        residual[from + i] -= value * state.columns[index];
                    }
                }
            }
        }
        Ok((residual, design))
    }

    /// What a fit misses unseen readings by, nT; `runs` are those of the problem with other rows.
    pub fn missed(&self, fit: &Fit, runs: &[Run<'_>]) -> Result<Vec<f64>> {
        let state = self.first();
        let step: Vec<f64> =
            (0..self.unknowns.len()).map(|at| fit.values[at] - self.value(&state, at)).collect();
        let (missed, _) = Problem { runs, ..self.clone() }.linearise(&self.advance(&state, &step))?;
        Ok(missed)
    }

    fn first(&self) -> State {
        let mut basics: Vec<Basic> = self.runs.iter().map(|run| run.basic.clone()).collect();
        for unknown in &self.unknowns {
            // What several runs share begins alike in all.
            if let Unknown::Chain(parameter, runs) = unknown {
                let shared = basics[runs[0]].constant_mut(*parameter).map(|value| *value);
                for run in runs {
                    if let (Some(value), Some(shared)) = (basics[*run].constant_mut(*parameter), shared) {
                        *value = shared;
                    }
                }
            }
        }
        State { basics, effects: self.effects.clone(), columns: vec![0.0; self.unknowns.len()] }
    }

    fn advance(&self, state: &State, step: &[f64]) -> State {
        let mut next = state.clone();
        for (index, unknown) in self.unknowns.iter().enumerate() {
            match unknown {
                Unknown::Column(_) => next.columns[index] += step[index],
                Unknown::Chain(Parameter::Effect(effect, number), _) => {
                    let info = &next.effects[*effect].kind.parameters()[*number];
                    let value = &mut next.effects[*effect].parameters[*number];
                    let moved = *value + step[index];
                    // A shape is positive: a step goes at most to a third of it.
                    *value = if info.role == physics::Role::Shape { moved.max(*value / 3.0) } else { moved };
                }
                Unknown::Chain(parameter, runs) => {
                    for number in runs {
                        if let Some(value) = next.basics[*number].constant_mut(*parameter) {
                            *value += step[index];
                        }
                    }
                }
            }
        }
        next
    }

    /// Which unknown a parameter of an effect is.
    pub fn place(&self, kind: Kind, parameter: usize) -> Option<usize> {
        self.unknowns.iter().position(|unknown| match unknown {
            Unknown::Chain(Parameter::Effect(effect, number), _) => {
                self.effects[*effect].kind == kind && *number == parameter
            }
            _ => false,
        })
    }

    fn value(&self, state: &State, unknown: usize) -> f64 {
        match &self.unknowns[unknown] {
            Unknown::Column(_) => state.columns[unknown],
            Unknown::Chain(Parameter::Effect(effect, number), _) => {
                state.effects[*effect].parameters[*number]
            }
            Unknown::Chain(parameter, runs) => {
                let mut basic = state.basics[runs[0]].clone();
                basic.constant_mut(*parameter).map_or(f64::NAN, |value| *value)
            }
        }
    }
}

/// Constants of the coils that were driven, with what is uncertain about the fields calculated with them.
pub fn coils(document: &common::Document, runs: &[Run<'_>]) -> Result<Vec<KnownParameters>> {
    let joint = Uncertainty::of(document)?;
    let driven = |run: &Run<'_>, coil: Axis| {
        run.coil == coil || run.context.current_a.iter().any(|current| current[coil.index()] != 0.0)
    };
    let known = |coil: Axis| {
        let k = runs[0].basic.coils[coil.index()].constant_nt_per_a;
        let driving = runs.iter().filter(|run| driven(run, coil)).map(|run| run.context.recording);
        let rests_on = uncertainty::drive(document, coil, k, driving);
        KnownParameters {
            parameters: vec![Parameter::CoilConstant(coil), Parameter::CoilOffset(coil)],
            covariance: joint.covariance_by(&rests_on),
            rests_on,
        }
    };
    let any = |coil: &Axis| runs.iter().any(|run| driven(run, *coil));
    let uncertain = |known: &KnownParameters| known.covariance.norm_max() > 0.0;
    Ok(Axis::ALL.into_iter().filter(any).map(known).filter(uncertain).collect())
}
