//! All measurements of a document, with one uncertainty of the circle for all.

use common::number::{counted, significant};
use common::{AbsoluteReading, AbsoluteSet, AdoptedBaselines, Code, Document, Quantity};
use estimate::influence::adjusted_p;
use estimate::stats::{chi_squared_p, coverage_factor};
use nalgebra::{Matrix3, SMatrix, Vector3};
use physics::frames::ARCSEC;

use crate::fit::{Found, Known, baseline, declination, fit, north};
use crate::read::{self, Set};
use crate::{Error, checks};

/// Rounds in which the uncertainty of a circle reading settles.
const ROUNDS: usize = 4;
/// Where it begins, arcsec.
const BEGINS_ARCSEC: f64 = 3.0;
/// No circle is read better, arcsec.
const FINEST_ARCSEC: f64 = 1e-3;
/// A reading that chance would give in fewer cases than this is an outlier.
pub const OUTLIER: f64 = 1e-3;
/// Share of chance from which readings scatter as usual.
const USUAL: f64 = 0.01;
/// Share of chance below which a measurement scatters more than its circle allows.
const SCATTERS: f64 = 1e-4;

pub struct Measured {
    pub sets: Vec<(Set, Found)>,
    pub known: Known,
    /// Of the uncertainty of the circle; infinite where it is stated.
    pub freedom: f64,
}

/// Fits all of them. The uncertainty of a circle reading is the stated one, or the scatter of all readings.
/// Errors: as [`fit`]; readings that fit no position.
pub fn measured(document: &Document, sets: Vec<Set>) -> Result<Measured, Error> {
    let facility = document.facility.as_ref();
    let stated = facility.and_then(|facility| facility.theodolite_arcsec).filter(|arcsec| *arcsec > 0.0);
    let scalar_nt = facility.and_then(|facility| facility.reference_std_nt).unwrap_or(0.0);
    let mut known = Known { circle: stated.unwrap_or(BEGINS_ARCSEC) * ARCSEC, scalar_nt };
    let fitted = |known: Known| sets.iter().map(|set| fit(set, known)).collect::<Result<Vec<_>, Error>>();
    let mut found = fitted(known)?;
    for (set, found) in sets.iter().zip(&found) {
        checks::position(set, found, known)?;
    }
    let mut freedom = f64::INFINITY;
    if stated.is_none() {
        for _ in 0..ROUNDS {
            let (mut chi_squared, mut free) = (0.0_f64, 0.0_f64);
            for found in &found {
                let (own, of) = found.circles();
                // A misread circle is not the scatter of the others.
                let worst = found.residuals().iter().map(|[_, _, t]| t.abs()).fold(0.0, f64::max);
                let outlier = of > 2.0 && adjusted_p(worst, of - 1.0, found.rows.len()) < OUTLIER;
                if !outlier {
                    (chi_squared, free) = (chi_squared + own, free + of);
                }
            }
            if free <= 0.0 {
                break;
            }
            known.circle = (known.circle * (chi_squared / free).sqrt()).max(FINEST_ARCSEC * ARCSEC);
            freedom = free;
            found = fitted(known)?;
        }
    }
    Ok(Measured { sets: sets.into_iter().zip(found).collect(), known, freedom })
}

/// The derivatives of D, I, F, H, X, Y, Z by the field, with their values; angles in rad.
fn elements(field: &Vector3<f64>) -> ([f64; 7], SMatrix<f64, 7, 3>) {
    let (h, f) = (field.x.hypot(field.y), field.norm());
    let by_h = Vector3::new(field.x / h, field.y / h, 0.0);
    let rows = [
        Vector3::new(-field.y, field.x, 0.0) / (h * h),
        (Vector3::z() * h - by_h * field.z) / (f * f),
        field / f,
        by_h,
        Vector3::x(),
        Vector3::y(),
        Vector3::z(),
    ];
    let by = SMatrix::from_fn(|i, j| rows[i][j]);
    ([declination(field), field.z.atan2(h), f, h, field.x, field.y, field.z], by)
}

impl Measured {
    /// The covariance of the baseline values by the readings alone.
    pub fn covariance(&self, at: usize) -> Matrix3<f64> {
        let all = self.sets[at].1.fit.svd.covariance();
        Matrix3::from_fn(|i, j| all[(i, j)])
    }

    /// By how much a standard uncertainty of the mark's azimuth, and one of the scalar with the pillars, moves the
    /// baseline values.
    pub fn common(&self, at: usize) -> [Vector3<f64>; 2] {
        let (set, found) = &self.sets[at];
        let (field, by) = found.field();
        // An azimuth that is too large turns the field with it.
        let turned = Vector3::new(-field.y, field.x, 0.0) * set.azimuth[1];
        let mark = by.try_inverse().map_or_else(Vector3::zeros, |inverse| inverse * turned);
        let pillar = Vector3::from_fn(|k, _| found.by_pillar[k]) * set.pillar[1].hypot(self.known.scalar_nt);
        [mark, pillar]
    }

    /// The baseline values of a measurement, in nT and rad.
    pub fn baseline(&self, at: usize) -> Vector3<f64> {
        baseline(&self.sets[at].1.fit.state)
    }

    /// Unix time of a measurement, s.
    pub fn time_s(&self, at: usize) -> f64 {
        read::time(&self.sets[at].0)
    }

    pub fn horizontal_nt(&self) -> f64 {
        let all = self.sets.iter().map(|(_, found)| found.field().0);
        all.map(|field| field.x.hypot(field.y)).sum::<f64>() / self.sets.len() as f64
    }

    /// What is written of a measurement. Errors of all its readings, such as the levelling, show in the scatter of the
    /// measurements about the adopted baselines alone.
    pub fn written(&self, at: usize, adopted: Option<&AdoptedBaselines>) -> AbsoluteSet {
        let (set, found) = &self.sets[at];
        let (field, by_baseline) = found.field();
        let (values, by_field) = elements(&field);
        let common = self.common(at).iter().map(|moved| moved * moved.transpose()).sum::<Matrix3<f64>>();
        let by = by_field * by_baseline;
        let std = (by * (self.covariance(at) + common) * by.transpose())
            .diagonal()
            .map(|variance: f64| variance.max(0.0).sqrt());
        let factor = coverage_factor(0.95, self.freedom);
        let quantity =
            |k: usize, unit: f64| Quantity::new(values[k] / unit, std[k] / unit).covered_by(factor);
        let degree = 1_f64.to_radians();
        let in_nt = |k: usize| Some(quantity(k, 1.0));
        let state = &found.fit.state;
        let all = found.fit.svd.covariance();
        let unknown = |k: usize, unit: f64| {
            Quantity::new(state[k] / unit, all[(k, k)].sqrt() / unit).covered_by(factor)
        };
        let (chi_squared, degrees_of_freedom) = found.circles();
        let mut written = AbsoluteSet {
            recording: set.id.clone(),
            time: read::moment(read::time(set)),
            declination_deg: quantity(0, degree),
            inclination_deg: quantity(1, degree),
            f_nt: in_nt(2),
            h_nt: in_nt(3),
            x_nt: in_nt(4),
            y_nt: in_nt(5),
            z_nt: in_nt(6),
            sensor_offset_nt: unknown(5, 1.0),
            horizontal_collimation_arcsec: unknown(6, ARCSEC),
            vertical_collimation_arcsec: unknown(7, ARCSEC),
            mark_collimation_arcsec: unknown(4, ARCSEC),
            circle_north_deg: north(state).to_degrees().rem_euclid(360.0),
            chi_squared,
            degrees_of_freedom,
            readings: self.readings(at),
            ..AbsoluteSet::default()
        };
        if let Some(adopted) = adopted {
            let (keys, units) = (found.components.keys(), found.components.units());
            let scatter = Vector3::from_fn(|k, _| adopted.components[keys[k]].scatter_std * units[k]);
            let own = self.covariance(at) + Matrix3::from_diagonal(&scatter.component_mul(&scatter));
            let value = |k: usize| {
                let std = (own + common)[(k, k)].sqrt();
                (keys[k].into(), Quantity::new(state[k] / units[k], std / units[k]).covered_by(factor))
            };
            written.baseline = (0..3).map(value).collect();
            written.covariance =
                Some(std::array::from_fn(|i| std::array::from_fn(|j| own[(i, j)] / units[i] / units[j])));
        }
        written.findings.extend(self.outliers(at));
        written.findings.extend(read::silent(set).map(|words| Code::MissingSamples.said(words)));
        written
    }

    fn readings(&self, at: usize) -> Vec<AbsoluteReading> {
        let (_, found) = &self.sets[at];
        let magnetic_north = north(&found.fit.state) + declination(&found.field().0);
        let of = |(row, [residual, left_out, t]): (&read::Row, [f64; 3])| AbsoluteReading {
            row: row.row,
            position: row.position(magnetic_north),
            residual_arcsec: residual / ARCSEC,
            leave_one_out_arcsec: left_out / ARCSEC,
            t,
        };
        found.rows.iter().zip(found.residuals()).map(of).collect()
    }

    /// The worst reading of a measurement, where chance does not give it.
    pub fn outlier(&self, at: usize) -> Option<AbsoluteReading> {
        let readings = self.readings(at).into_iter().enumerate();
        let (place, worst) = readings.max_by(|a, b| a.1.t.abs().total_cmp(&b.1.t.abs()))?;
        let (_, found) = &self.sets[at];
        let (rest, free) = (found.without(place), found.circles().1 - 1.0);
        let count: usize = self.sets.iter().map(|(_, found)| found.rows.len()).sum();
        // Where the others scatter as those of all measurements do, that is what it is judged by; else by theirs.
        let usual = free > 0.0 && chi_squared_p(rest, free) > USUAL;
        let freedom = if usual { self.freedom } else { free };
        (freedom > 0.0 && adjusted_p(worst.t, freedom, count) < OUTLIER).then_some(worst)
    }

    fn outliers(&self, at: usize) -> Option<common::Finding> {
        let (set, found) = &self.sets[at];
        let (chi_squared, free) = found.circles();
        if let Some(worst) = self.outlier(at) {
            let (off, t) = (significant(worst.leave_one_out_arcsec, 2), significant(worst.t, 2));
            let AbsoluteReading { row, position, .. } = worst;
            let words = format!(
                "row {row} ({position}) is off by {off}″ from what the other readings give (t = {t}); read the circle of this position again, or correct the sheet"
            );
            return Some(Code::Outliers.about(&set.id).said(words));
        }
        (free > 0.0 && chi_squared_p(chi_squared, free) < SCATTERS).then(|| {
            Code::ExcessScatter.said(format!(
                "its {} scatter {} times more than the standard uncertainty of the circle allows; measure it again",
                counted(found.rows.len(), "reading"),
                significant((chi_squared / free).sqrt(), 2)
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_have_the_derivatives_of_differences() {
        let field = Vector3::new(20_900.0, 1_500.0, 43_800.0);
        let (_, by) = elements(&field);
        for k in 0..3 {
            let at = |step: f64| elements(&(field + Vector3::ith(k, step))).0;
            let (above, below) = (at(1.0), at(-1.0));
            for i in 0..7 {
                let slope = 0.5 * (above[i] - below[i]);
                assert!((slope - by[(i, k)]).abs() < 1e-8, "{i} {k}: {slope}");
            }
        }
    }
}
