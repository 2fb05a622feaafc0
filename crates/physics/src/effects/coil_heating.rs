use common::Axis;
use nalgebra::Vector3;

use crate::memory::first_order_lag;
use crate::{Effect, Error, ParameterInfo, Place, Real, Surroundings};

/// A coil constant that falls as the coil heats: k = k₀ (1 − a P), τ dP/dt = I² − P, P = 0 at the first row.
/// Along the coil's axis, so that it is the same in GEO for every sensor and orientation.
pub struct CoilHeating;

impl Effect for CoilHeating {
    const NAME: &'static str = "coil_heating";
    const TITLE: &'static str = "coil constant falls as the coil heats itself";
    const PHYSICS: &'static str = "The current warms the winding, its former expands, and the same current \
        makes less field; the warmth comes and goes with the coil's thermal time constant.";
    const EQUATION: &'static str = "B = k (1 - a P) I, tau dP/dt = I^2 - P";
    const SOURCE: &'static str =
        "thermal expansion of the former, k ~ 1/size; JCGM 100 for its place in a budget";
    const PLACE: Place = Place::Coil;
    const PARAMETERS: &'static [ParameterInfo] = &[
        ParameterInfo { name: "fall_ppm_per_a2", low: 1.0, high: 2000.0, positive: false },
        ParameterInfo { name: "lag_s", low: 30.0, high: 20_000.0, positive: true },
    ];

    fn apply<T: Real>(
        parameters: &[T],
        axis: Axis,
        signal: &mut [Vector3<T>],
        around: &Surroundings<'_, T>,
    ) -> Result<(), Error> {
        let context = around.context;
        let time = context.times(Self::NAME)?;
        let squared: Vec<f64> =
            context.current_a.iter().map(|current| current[axis.index()].powi(2)).collect();
        let warmth = first_order_lag(time, &squared, parameters[1], Some(0.0));
        for (field, warmth) in signal.iter_mut().zip(warmth) {
            let own = field[axis.index()];
            field[axis.index()] -= own * warmth * parameters[0] * 1e-6;
        }
        Ok(())
    }
}
