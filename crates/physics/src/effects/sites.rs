use super::iron::{MATRIX, add_matrix};
use super::prelude::*;
use crate::context::Thermometer;
use crate::frames::ARCSEC;
use crate::memory::Signal;

/// ΔB = G B at the test instrument, G in ppm: what the field at its pillar differs from the reference's in proportion.
pub struct PillarGradient;

impl Effect for PillarGradient {
    const ABOUT: About = About {
        name: "pillar_gradient",
        title: "field differs between the pillars in proportion",
        physics: "Rock or iron near one pillar is magnetised by the field, so that the test instrument sees a slightly \
            other field than the reference. A constant matrix is the same as other axes and scales.",
        equation: "dB_test = G B_reference 1e-6, G[row][column], row = component added",
        source: "Jankowski and Sucksdorff 1996, IAGA Guide for Magnetic Measurements and Observatory Practice (pillar \
            differences)",
        place: Place::Sites,
        stage: Stage::Block,
        acts: Acts::Everything,
        parameters: MATRIX,
        needs: &["a differential recording"],
        invertible: true,
    };

    fn apply<T: Real>(
        parameters: &[T],
        signal: &mut [Vector3<T>],
        _: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        add_matrix(parameters, signal);
        Ok(())
    }
}

/// ΔB_z = Σ c_k (B_k − L_k), τ dL_k/dt = B_k − L_k, in equilibrium at the first row: only what is faster than τ counts.
pub struct InductionDifference;

impl Effect for InductionDifference {
    const ABOUT: About = About {
        name: "induction_difference",
        title: "induced currents differ between the sites",
        physics: "Rapid variations induce currents in the ground; where it conducts differently below the two pillars, \
            the vertical component differs in proportion to the faster part of the field.",
        equation: "dB_z = sum_k c_k (B_k - L_k) 1e-6, tau dL_k/dt = B_k - L_k",
        source: "Parkinson 1959, Directions of rapid geomagnetic fluctuations, Geophys. J. 2, 1",
        place: Place::Sites,
        stage: Stage::Block,
        acts: Acts::Everything,
        parameters: &[
            ParameterInfo::amplitude("north_ppm", 100.0, 500_000.0),
            ParameterInfo::amplitude("east_ppm", 100.0, 500_000.0),
            ParameterInfo::amplitude("down_ppm", 100.0, 500_000.0),
            ParameterInfo::shape("time_constant_s", 1.0, 100_000.0),
        ],
        needs: &["time_s", "a differential recording"],
        invertible: true,
    };

    fn apply<T: Real>(
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        let time = around.context.times(Self::ABOUT.name)?;
        let mut added = vec![T::from(0.0); signal.len()];
        for axis in 0..3 {
            let series = Signal::new(time, signal.iter().map(|field| field[axis]).collect());
            for ((added, lagged), field) in
                added.iter_mut().zip(series.lagged(parameters[3], None)).zip(signal.iter())
            {
                *added += (field[axis] - lagged) * parameters[axis] * 1e-6;
            }
        }
        signal.iter_mut().zip(added).for_each(|(field, added)| field[2] += added);
        Ok(())
    }
}

/// The pillar turns with temperature: ΔB = −ω × B, ω = (a, b, 0) (T_lag − T_ref), τ dT_lag/dt = T_S − T_lag.
pub struct PillarTilt;

impl Effect for PillarTilt {
    const ABOUT: About = About {
        name: "pillar_tilt",
        title: "pillar tilts with temperature",
        physics: "The pillar or its foundation warms unevenly and tilts, and the horizontal sensors take in a part of \
            the vertical field.",
        equation: "dB = -omega x B, omega = (a, b, 0) (T_lag - T_ref), tau dT_lag/dt = T_S - T_lag",
        source: "Rasmussen and Kring Lauridsen 1990, Improving baseline drift in fluxgate magnetometers caused by \
            foundation movements, Phys. Earth Planet. Inter. 59, 78",
        place: Place::Sites,
        stage: Stage::Block,
        acts: Acts::Everything,
        parameters: &[
            ParameterInfo::amplitude("about_x_arcsec_per_k", 0.05, 50.0),
            ParameterInfo::amplitude("about_y_arcsec_per_k", 0.05, 50.0),
            ParameterInfo::shape("lag_s", 10.0, 1_000_000.0),
        ],
        needs: &["time_s", Thermometer::Sensor.column()],
        invertible: true,
    };

    fn apply<T: Real>(
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        let time = around.context.times(Self::ABOUT.name)?;
        let (column, reference) = around.context.temperature(Thermometer::Sensor, Self::ABOUT.name)?;
        let warmer = column.iter().map(|t| T::from(t - reference)).collect();
        let warmer = Signal::new(time, warmer).lagged(parameters[2], None);
        tilt(parameters, |row| warmer[row], signal);
        Ok(())
    }
}

/// The pillar settles: ΔB = −ω × B, ω = (a, b, 0) t, t on the campaign's clock in days.
pub struct PillarSettling;

impl Effect for PillarSettling {
    const ABOUT: About = About {
        name: "pillar_settling",
        title: "pillar settles",
        physics: "The foundation gives way slowly and the pillar tilts more each day.",
        equation: "dB = -omega x B, omega = (a, b, 0) t",
        source: "Rasmussen and Kring Lauridsen 1990, Improving baseline drift in fluxgate magnetometers caused by \
            foundation movements, Phys. Earth Planet. Inter. 59, 78",
        place: Place::Sites,
        stage: Stage::Block,
        acts: Acts::Everything,
        parameters: &[
            ParameterInfo::amplitude("about_x_arcsec_per_day", 0.01, 20.0),
            ParameterInfo::amplitude("about_y_arcsec_per_day", 0.01, 20.0),
        ],
        needs: &["time_s"],
        invertible: true,
    };

    fn apply<T: Real>(
        parameters: &[T],
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        let clock = around.context.clock(Self::ABOUT.name)?;
        tilt(parameters, |row| T::from(clock[row] / DAY_S), signal);
        Ok(())
    }
}

/// B − ω × B with ω = (a, b, 0) grown by `by(row)`, a and b in arcsec.
fn tilt<T: Real>(parameters: &[T], by: impl Fn(usize) -> T, signal: &mut [Vector3<T>]) {
    for (row, field) in signal.iter_mut().enumerate() {
        let (a, b) = (parameters[0] * by(row) * ARCSEC, parameters[1] * by(row) * ARCSEC);
        let [x, y, z] = [field[0], field[1], field[2]];
        *field -= Vector3::new(b * z, -a * z, a * y - b * x);
    }
}
