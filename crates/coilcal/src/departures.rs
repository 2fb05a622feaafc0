//! What a straight line may leave out, each as one further column of the fit.

use common::{Departure, Quantity};
use estimate::linear::{self, LinearFit};
use estimate::stats;
use faer::Mat;

use crate::Result;
use crate::readings::Reading;
use crate::scatter::{Level, Scatter, scatter};

/// A departure is claimed below this probability, adjusted for all that were looked for.
const FOUND_BELOW: f64 = 0.01;
/// A departure whose χ² is within this of the best one's is as good: 99 % of one degree of freedom.
const RIVAL_WITHIN: f64 = 6.63;
/// Departures that are fitted together at most.
const MOST: usize = 2;

/// A departure from B = k I + B0 (fields signed by the current).
struct DepartureKind {
    /// Its name in documents.
    name: &'static str,
    parameter: &'static str,
    /// Its column, by a reading and its time from the middle of the run.
    column: fn(&Reading, f64) -> f64,
    adds: bool,
}

static ALL: [DepartureKind; 7] = [
    // c I²: a curvature, opposite in the two ranges.
    kind("quadratic", "curvature_nt_per_a2", |reading, _| reading.current_a * reading.current_a),
    // d I³: a curvature, alike in both ranges.
    kind("cubic", "curvature_nt_per_a3", |reading, _| reading.current_a.powi(3)),
    // A field across the coil that is not nulled: |B| = √((kI + B0)² + B⊥²) ≈ |kI + B0| + B⊥²/(2 |kI + B0|).
    DepartureKind {
        adds: true,
        ..kind("transverse_field", "transverse_squared_nt2", |reading, _| 0.5 / reading.field_nt)
    },
    // The negative range is moved against the positive one.
    kind("jump_between_ranges", "negative_less_positive_nt", |reading, _| {
        f64::from(u8::from(reading.current_a < 0.0))
    }),
    // The constant of the negative range differs from that of the positive one.
    kind("constant_between_ranges", "negative_less_positive_nt_per_a", |reading, _| {
        reading.current_a.min(0.0)
    }),
    // The constant changes through the run, as when the coil heats.
    kind("constant_drift", "rate_nt_per_a_per_s", |reading, time_s| reading.current_a * time_s),
    // The offset changes through the run.
    kind("offset_drift", "rate_nt_per_s", |_, time_s| time_s),
];

const fn kind(
    name: &'static str,
    parameter: &'static str,
    column: fn(&Reading, f64) -> f64,
) -> DepartureKind {
    DepartureKind { name, parameter, column, adds: false }
}

/// Readings in levels, with their relative standard deviations and the one that is declared, nT.
pub struct Run<'a> {
    pub readings: &'a [Reading],
    pub levels: &'a [Level],
    pub relative_std: &'a [f64],
    pub declared: Option<f64>,
}

pub struct Found {
    /// Offset, constant, and the departures that were found.
    pub fit: LinearFit,
    pub names: Vec<&'static str>,
    pub departures: Vec<Departure>,
    /// Names of those that explain the readings about as well as the first.
    pub rivals: Vec<String>,
}

/// A departure beside those that are fitted already, in a common fit. The scatter is that of this fit.
struct Beside {
    kind: &'static DepartureKind,
    size: f64,
    std: f64,
    /// Reduction of the sum of squares, nT².
    gain: f64,
    scatter: Scatter,
}

impl Beside {
    /// Probability that it is zero, by Student's t of its size.
    fn p_value(&self) -> f64 {
        let two_sided = stats::two_sided_p(self.size / self.std, self.scatter.freedom);
        match self.kind.adds {
            true if self.size < 0.0 => 1.0 - two_sided / 2.0,
            true => two_sided / 2.0,
            false => two_sided,
        }
    }

    /// Variance of a reading's residual, nT².
    fn variance(&self) -> f64 {
        self.scatter.std_nt.powi(2)
    }
}

impl Run<'_> {
    /// Fits offset, constant and some departures to the readings.
    fn fit(&self, kinds: &[&DepartureKind]) -> Result<LinearFit> {
        let readings = self.readings;
        let middle_s = readings.iter().map(|reading| reading.time_s).sum::<f64>() / readings.len() as f64;
        let design = Mat::from_fn(readings.len(), 2 + kinds.len(), |row, column| match column {
            0 => 1.0,
            1 => readings[row].current_a,
            _ => (kinds[column - 2].column)(&readings[row], readings[row].time_s - middle_s),
        });
        let y: Vec<f64> = readings.iter().map(|reading| reading.field_nt).collect();
        Ok(linear::fit(design.as_ref(), &y, Some(self.relative_std))?)
    }

    /// Each departure that the readings can show beside those of a fit.
    fn beside(&self, kinds: &[&'static DepartureKind], fit: &LinearFit) -> Result<Vec<Beside>> {
        let (mut all, last) = (Vec::new(), kinds.len() + 2);
        for kind in ALL.iter().filter(|kind| kinds.iter().all(|fitted| fitted.name != kind.name)) {
            let wider = self.fit(&[kinds, &[kind]].concat())?;
            // What belongs to one range alone is no further column where there is only one.
            if wider.rank > last && wider.freedom >= 1.0 {
                let scatter = scatter(self.levels, &wider, self.declared);
                let std = wider.covariance[(last, last)].sqrt() * scatter.std_nt;
                let gain = (fit.sum_of_squares - wider.sum_of_squares).max(0.0);
                all.push(Beside { kind, size: wider.coefficients[last], std, gain, scatter });
            }
        }
        Ok(all)
    }

    /// Fits the line, then departures, the most significant first, as long as another one is left.
    pub fn search(&self) -> Result<Found> {
        let (mut kinds, mut fit) = (Vec::new(), self.fit(&[])?);
        let (mut departures, mut rivals) = (Vec::new(), Vec::new());
        let mut count = 0.0;
        while kinds.len() < MOST {
            let mut all = self.beside(&kinds, &fit)?;
            if kinds.is_empty() {
                count = all.len() as f64;
                departures.extend(all.iter().map(|one| {
                    let p_value = one.p_value();
                    let size = Quantity::new(one.size, one.std);
                    Departure {
                        departure: one.kind.name.into(),
                        parameter: [(one.kind.parameter.to_string(), size)].into_iter().collect(),
                        p_value,
                        p_adjusted: (p_value * count).min(1.0),
                        found: false,
                    }
                }));
            }
            all.retain(|one| {
                let p = || stats::two_sided_p((one.gain / one.variance()).sqrt(), one.scatter.freedom);
                let opposite = one.kind.adds && one.size < 0.0;
                !opposite && one.scatter.freedom >= 1.0 && p() * count < FOUND_BELOW
            });
            all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            let [best, others @ ..] = &all[..] else { break };
            if kinds.is_empty() {
                let as_good = |other: &&Beside| best.gain - other.gain < RIVAL_WITHIN * best.variance();
                rivals = others.iter().filter(as_good).map(|other| other.kind.name.to_string()).collect();
            }
            kinds.push(best.kind);
            fit = self.fit(&kinds)?;
        }
        let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
        for departure in &mut departures {
            departure.found = names.contains(&departure.departure.as_str());
        }
        Ok(Found { fit, names, departures, rivals })
    }
}
