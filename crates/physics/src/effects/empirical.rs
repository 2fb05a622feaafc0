use super::prelude::*;
use crate::memory::{Before, Signal};

/// Highest order of a polynomial.
const ORDER: usize = 6;
/// Parameters before the coefficients.
const BEFORE: usize = 3;

macro_rules! coefficients {
    ($($name:literal),+) => {
        &[
            ParameterInfo::of_recording("from", 0.001, 1.0),
            ParameterInfo::of_recording("to", 1.0, 1e6),
            ParameterInfo::span("lag_s", 0.1, 1e5),
            $(ParameterInfo::amplitude($name, 0.001, 10_000.0).or_zero()),+
        ]
    };
}

/// Chebyshev's polynomials of a number from the first order on: T_{k+1} = 2 x T_k − T_{k−1}.
pub fn chebyshev<T: Real>(x: T) -> impl Iterator<Item = T> {
    std::iter::successors(Some((T::one(), x)), move |(before, now)| Some((*now, x * *now * 2.0 - *before)))
        .map(|(_, now)| now)
}

/// For each sensor, T_k Chebyshev's polynomials. The covariate u is a recorded column, `time_s` on the campaign's clock,
/// `field_x`, `field_y`, `field_z` in SEN, `coils_a`, the sum of the sizes of the coil currents, or the product of two
/// such with a star between them. The lag is of first order, in equilibrium at the first row.
impl Effect for Empirical {
    const ABOUT: About = About {
        name: "empirical",
        title: "structure without a name follows something recorded",
        physics: "No physics: a smooth function of a recorded column, of time or of the field, fitted to what no effect \
            explains. It predicts readings in the same range of what it follows, and nothing outside it.",
        equation: "dB = c_1 T_1(x) + ... + c_6 T_6(x), x = (2 u - from - to) / (to - from) within -1 and 1, u the column, or by how much it is off its own past with tau > 0",
        source: "T. J. Rivlin 1990, Chebyshev Polynomials, 2nd ed., Wiley",
        parameters: coefficients!(
            "x_1_nt", "x_2_nt", "x_3_nt", "x_4_nt", "x_5_nt", "x_6_nt", "y_1_nt", "y_2_nt", "y_3_nt",
            "y_4_nt", "y_5_nt", "y_6_nt", "z_1_nt", "z_2_nt", "z_3_nt", "z_4_nt", "z_5_nt", "z_6_nt"
        ),
        needs: &["a column, `field_x`, `field_y`, `field_z`, or `coils_a`", "rows in the order taken"],
        ..About::of(Family::FollowsColumn, Place::Sensor, Stage::Sensor, Acts::WithColumn(""))
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let [from, to, lag_s] = [parameters[0], parameters[1], parameters[2]];
        let of = |name: &str| -> Result<Vec<T>> {
            let field = |axis: usize| around.field_sen.iter().map(|field| field[axis]).collect();
            Ok(match name {
                "field_x" => field(0),
                "field_y" => field(1),
                "field_z" => field(2),
                "coils_a" => around.context.coils_a().map(T::from).collect(),
                name => {
                    let zero = if name == "time_s" { around.context.clock_s } else { 0.0 };
                    around.column(name)?.iter().map(|value| T::from(value + zero)).collect()
                }
            })
        };
        let mut values = of(around.column.split('*').next().unwrap_or_default())?;
        for other in around.column.split('*').skip(1) {
            values.iter_mut().zip(of(other)?).for_each(|(value, other)| *value *= other);
        }
        if lag_s.re() > 0.0 {
            let time = around.times()?;
            let past = Signal::new(time, values.clone()).lagged(lag_s, Before::Equilibrium);
            values.iter_mut().zip(past).for_each(|(value, past)| *value -= past);
        }
        if from.re().partial_cmp(&to.re()) != Some(std::cmp::Ordering::Less) {
            return Ok(());
        }
        for (field, value) in signal.iter_mut().zip(values) {
            let place = (value * 2.0 - from - to) / (to - from);
            let place = if place.re().abs() > 1.0 { T::from(place.re().signum()) } else { place };
            for (order, polynomial) in chebyshev(place).take(ORDER).enumerate() {
                for sensor in 0..3 {
                    field[sensor] += parameters[BEFORE + ORDER * sensor + order] * polynomial;
                }
            }
        }
        Ok(())
    }
}
