//! How much readings scatter about a fit: all of them, or those with constant drives and the amplitudes of AC
//! runs apart, whose standard deviations come from different sources.

use estimate::{Fit, stats};

use crate::{AxesState, NoiseFactors, Observation, Observations};

/// Readings whose noise is judged together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ReadingKind {
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

    /// Its factor.
    pub fn factor(self, noise: NoiseFactors) -> f64 {
        if self == ReadingKind::Ac { noise.ac } else { noise.constant }
    }

    /// The factors with another one for this kind.
    pub fn with(self, noise: NoiseFactors, factor: f64) -> NoiseFactors {
        match self {
            ReadingKind::All => NoiseFactors::both(factor),
            ReadingKind::Constant => NoiseFactors { constant: factor, ..noise },
            ReadingKind::Ac => NoiseFactors { ac: factor, ..noise },
        }
    }

    /// What to call its readings.
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
pub(crate) struct Spread {
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
