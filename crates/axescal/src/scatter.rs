//! The noise of the readings: as it is declared, or as they scatter about the fit, which changes with it.
//! Readings with constant drives and amplitudes of AC runs are judged apart where both are there: their
//! standard deviations come from different sources.

use common::number::{counted, p_value, plural, significant};
use common::{Code, Finding};
use estimate::{Fit, Options as Iteration, Problem, robust, stats};

use crate::{
    AxesProblem, AxesState, Error, Freedom, NoiseFactors, NoiseSource, Observation, Observations, Options,
    Result,
};

/// A χ² less probable than this is not taken for chance: the uncertainties are then scaled to the residuals.
const CHI_SQUARED_P: f64 = 1e-3;
/// A robust scale is not taken for the declared one beyond this over √(degrees of freedom) (four σ).
const ROBUST_EXCESS: f64 = 4.0;
/// Rounds in which noise and fit settle.
const ROUNDS: usize = 30;
/// Relative change of the noise at which it has settled: far below what is ever known of it.
const SETTLED: f64 = 1e-5;
/// Rounding of a reading, as a share of the largest.
const ROUNDING: f64 = 1e-13;

/// Readings whose noise is judged together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReadingKind {
    All,
    Constant,
    Ac,
}

impl ReadingKind {
    /// Both kinds where both are there, unless they are to be judged together.
    pub fn of(observations: &Observations, together: bool) -> Vec<ReadingKind> {
        let there = |constant: bool| observations.readings.iter().any(|reading| reading.constant == constant);
        if together || !(there(true) && there(false)) {
            vec![ReadingKind::All]
        } else {
            vec![ReadingKind::Constant, ReadingKind::Ac]
        }
    }

    fn holds(self, reading: &Observation) -> bool {
        match self {
            ReadingKind::All => true,
            ReadingKind::Constant => reading.constant,
            ReadingKind::Ac => !reading.constant,
        }
    }

    pub fn factor(self, noise: NoiseFactors) -> f64 {
        if self == ReadingKind::Ac { noise.ac } else { noise.constant }
    }

    pub fn with(self, noise: NoiseFactors, factor: f64) -> NoiseFactors {
        match self {
            ReadingKind::All => NoiseFactors::both(factor),
            ReadingKind::Constant => NoiseFactors { constant: factor, ..noise },
            ReadingKind::Ac => NoiseFactors { ac: factor, ..noise },
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            ReadingKind::All => "the readings",
            ReadingKind::Constant => "the readings with constant drives",
            ReadingKind::Ac => "the amplitudes of AC runs",
        }
    }
}

/// Residuals of one kind of readings, in units of their standard deviations.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    pub sum_of_squares: f64,
    /// Readings, by their weight, less what the fit takes of them: Σ (w − h).
    pub degrees_of_freedom: f64,
}

impl Spread {
    /// That of a fit, with the weights of a robust one.
    pub fn of(
        observations: &Observations,
        fit: &Fit<AxesState>,
        weights: Option<&[f64]>,
        kind: ReadingKind,
    ) -> Spread {
        let leverage = fit.svd.leverage();
        let own = observations.readings.iter().enumerate().filter(|(_, reading)| kind.holds(reading));
        let (mut sum_of_squares, mut degrees_of_freedom) = (0.0, 0.0);
        for (row, _) in own {
            sum_of_squares += fit.residual[row].powi(2);
            degrees_of_freedom += weights.map_or(1.0, |weights| weights[row]) - leverage[row];
        }
        Spread { sum_of_squares, degrees_of_freedom }
    }

    /// Standard deviation of a reading, in units of the one that was put in.
    pub fn scale(&self) -> f64 {
        (self.sum_of_squares / self.degrees_of_freedom.max(1e-9)).sqrt()
    }

    /// Probability of as large a χ² where the noise is what was put in.
    pub fn p(&self) -> f64 {
        stats::chi_squared_p(self.sum_of_squares, self.degrees_of_freedom)
    }
}

pub struct Estimate {
    pub fit: Fit<AxesState>,
    pub weights: Option<Vec<f64>>,
    pub spread: Spread,
    /// Standard deviation of a reading, in units of the one that was put in.
    scale: f64,
}

impl Estimate {
    fn spread_of(&self, observations: &Observations, kind: ReadingKind) -> Spread {
        Spread::of(observations, &self.fit, self.weights.as_deref(), kind)
    }
}

/// A plain fit, or a robust one where it was asked for.
fn estimated(
    problem: &AxesProblem<'_>,
    start: AxesState,
    known_scale: bool,
    options: &Options,
) -> Result<Estimate> {
    let (fit, weights, robust_scale) = if options.robust {
        let robust = robust::solve_robust(problem, start, known_scale)?;
        (robust.fit, Some(robust.weights), Some(robust.scale))
    } else {
        (estimate::solve(problem, start, None, &Iteration::default())?, None, None)
    };
    let spread = Spread::of(problem.observations, &fit, weights.as_deref(), ReadingKind::All);
    Ok(Estimate { scale: robust_scale.unwrap_or(spread.scale()), fit, weights, spread })
}

pub struct Settled<'a> {
    observations: &'a Observations,
    pub estimate: Estimate,
    pub noise: NoiseFactors,
    /// The readings whose standard deviations were taken from their scatter.
    scattering: Vec<(ReadingKind, Spread)>,
    /// χ² over the declared noise with its probability, where noise is declared.
    pub chi_squared: Option<(f64, f64)>,
}

/// Fits from a start, and takes the noise from the scatter where it is not declared, or where the readings
/// scatter more than that by more than chance.
pub fn settle<'a>(
    observations: &'a Observations,
    freedom: &Freedom,
    start: AxesState,
    options: &Options,
) -> Result<Settled<'a>> {
    let known_scale = observations.noise != NoiseSource::Residuals;
    let problem = AxesProblem::new(observations, freedom, NoiseFactors::ONE);
    let mut estimate = estimated(&problem, start, known_scale, options)?;
    // Weighed-down residuals are no χ²; a robust fit judges the declared noise by its own scale.
    let chi_squared =
        (known_scale && !options.robust).then(|| (estimate.spread.sum_of_squares, estimate.spread.p()));
    let excess = 1.0 + ROBUST_EXCESS / estimate.spread.degrees_of_freedom.max(1.0).sqrt();
    let scattering: Vec<(ReadingKind, Spread)> =
        ReadingKind::of(observations, options.robust || !known_scale)
            .into_iter()
            .map(|kind| (kind, estimate.spread_of(observations, kind)))
            .filter(|(_, spread)| match chi_squared {
                Some(_) => {
                    spread.p() < CHI_SQUARED_P && spread.degrees_of_freedom >= 1.0 && spread.scale() > 1.0
                }
                None => !known_scale || estimate.scale > excess,
            })
            .collect();
    let mut noise = NoiseFactors::ONE;
    if !scattering.is_empty() {
        if estimate.spread.degrees_of_freedom < 0.5 {
            return Err(Error::Unanswerable(format!(
                "{} {} no degrees of freedom to estimate the noise; declare it in instrument.noise, or record more orientations",
                counted(problem.readings(), "reading"),
                plural(problem.readings(), "leaves", "leave")
            )));
        }
        // With priors the fit changes with the noise, and the noise with the fit: a few rounds settle it.
        let largest = observations.readings.iter().map(|r| r.value_nt.abs()).fold(0.0, f64::max);
        for _ in 0..ROUNDS {
            let before = noise;
            for (kind, _) in &scattering {
                let scale = if *kind == ReadingKind::All {
                    estimate.scale
                } else {
                    estimate.spread_of(observations, *kind).scale()
                };
                noise = kind.with(noise, (kind.factor(before) * scale).max(ROUNDING * largest));
            }
            let settled = scattering
                .iter()
                .all(|(kind, _)| (kind.factor(noise) / kind.factor(before) - 1.0).abs() < SETTLED);
            let problem = AxesProblem::new(observations, freedom, noise);
            estimate = estimated(&problem, estimate.fit.state, false, options)?;
            if settled {
                break;
            }
        }
    }
    Ok(Settled { observations, estimate, noise, scattering, chi_squared })
}

impl Settled<'_> {
    /// Degrees of freedom of noise taken from the scatter; infinite where it is known.
    pub fn freedom(&self) -> f64 {
        let of = |(kind, _): &(ReadingKind, Spread)| {
            self.estimate.spread_of(self.observations, *kind).degrees_of_freedom
        };
        self.scattering.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    pub fn findings(&self) -> Vec<Finding> {
        if self.observations.noise == NoiseSource::Residuals {
            return Vec::new();
        }
        let told = self.scattering.iter().map(|(kind, spread)| {
            scatters(*kind, kind.factor(self.noise), self.chi_squared.is_some().then_some(spread))
        });
        let mut findings: Vec<Finding> = told.collect();
        if let Some((sum, _)) = self.chi_squared.filter(|(_, p)| 1.0 - p < CHI_SQUARED_P)
            && self.scattering.is_empty()
            && self.observations.noise == NoiseSource::Declared
        {
            findings.push(Code::NoiseOverstated.said(format!(
                "the readings scatter only {} times as much as declared; the declared noise may be too large",
                significant((sum / self.estimate.spread.degrees_of_freedom).sqrt(), 3)
            )));
        }
        findings
    }

    /// Where the standard deviations come from, kind by kind where only one of them was scaled.
    pub fn source(&self) -> String {
        let own = match self.observations.noise {
            NoiseSource::Declared => "declared",
            NoiseSource::SineFits => "sine fits",
            NoiseSource::Residuals => return "residuals".into(),
        };
        match self.scattering.as_slice() {
            [] => own.into(),
            [(ReadingKind::Constant, _)] => format!("{own}, that of constant drives scaled to the residuals"),
            [(ReadingKind::Ac, _)] => format!("{own}, that of AC runs scaled to the residuals"),
            _ => format!("{own}, scaled to the residuals"),
        }
    }
}

fn scatters(kind: ReadingKind, factor: f64, spread: Option<&Spread>) -> Finding {
    let test = spread.map_or_else(String::new, |spread| {
        let freedom = counted(spread.degrees_of_freedom.round() as usize, "degree");
        format!(
            " (χ² = {} with {freedom} of freedom, {})",
            significant(spread.sum_of_squares, 3),
            p_value(spread.p())
        )
    });
    Code::ExcessScatter.said(format!(
        "{} scatter {} times as much as declared{test}; their standard deviations are scaled up accordingly. --free-scales shows whether a constant is wrong, --robust the effect of outliers",
        kind.name(),
        significant(factor, 3)
    ))
}
