//! What the readings in one orientation say, by the same derivatives as the fit.

use common::Axis;
use nalgebra::{DMatrix, Matrix3, SMatrix, Vector3};
use physics::Unit;
use physics::frames::Orientation;
use std::borrow::Borrow;

use crate::observations::Together;
use crate::unknowns::Unknown;
use crate::{
    AxesProblem, AxesState, Freedom, NoiseFactors, NoiseSource, Observation, Observations, OrientationGroup,
};

/// Turns of the six directions.
pub const TURNS: usize = 12;
/// These, the scales of sensors and coils, the residual field and the offsets, in the order of the fit.
pub const ALL: usize = 24;

/// Information on all that orientations have in common.
pub type Information = SMatrix<f64, ALL, ALL>;

/// Readings in one orientation.
#[derive(Clone, Debug)]
pub struct Readings {
    /// Field along each coil for each drive, in order, nT.
    pub drives_nt: Vec<Vector3<f64>>,
    /// Covariance of each sensor's readings of them, nT².
    pub covariance: [DMatrix<f64>; 3],
    /// What one standard uncertainty of each coil's gradient makes at each sensor in an orientation of the
    /// block: the share of the drive for each metre, and the places of the sensors in SEN, m.
    pub gradient_per_m: [f64; 3],
    pub positions_m: [Vector3<f64>; 3],
}

/// Jᵀ V⁻¹ J with J by what is common, by the turns of this orientation, and by the gradients of the coils.
#[derive(Clone, Debug)]
pub struct Pieces {
    common: Information,
    both: SMatrix<f64, ALL, 3>,
    own: Matrix3<f64>,
    gradients: SMatrix<f64, ALL, 3>,
    own_gradients: Matrix3<f64>,
}

/// What orientations say, and how the gradients of the coils push it.
#[derive(Clone, Debug)]
pub struct Said {
    pub information: Information,
    /// Jᵀ V⁻¹ times what one standard uncertainty of each coil's gradient adds to the readings.
    pub gradients: SMatrix<f64, ALL, 3>,
}

impl Said {
    /// Of several orientations together.
    pub fn of(each: impl Iterator<Item = impl Borrow<Self>>) -> Self {
        let mut sum = Self { information: Information::zeros(), gradients: SMatrix::zeros() };
        for one in each {
            sum.information += one.borrow().information;
            sum.gradients += one.borrow().gradients;
        }
        sum
    }
}

impl Pieces {
    /// With nominal axes; `turns` is L with L Lᵀ = covariance of the small rotation for errors of 1 rad.
    pub fn of(rotation: &Matrix3<f64>, turns: &Matrix3<f64>, readings: &Readings) -> Self {
        let Derivatives { jacobian, common, own, gradients } = Derivatives::of(rotation, turns, readings);
        let rows = gradients.nrows();
        let product =
            |a: usize, b: usize| (0..rows).map(|row| jacobian[(row, a)] * jacobian[(row, b)]).sum::<f64>();
        let pushed = |a: usize, coil: usize| {
            (0..rows).map(|row| jacobian[(row, a)] * gradients[(row, coil)]).sum::<f64>()
        };
        Self {
            common: Information::from_fn(|i, j| product(common[i], common[j])),
            both: SMatrix::from_fn(|i, j| product(common[i], own[j])),
            own: Matrix3::from_fn(|i, j| product(own[i], own[j])),
            gradients: SMatrix::from_fn(|i, coil| pushed(common[i], coil)),
            own_gradients: Matrix3::from_fn(|i, coil| pushed(own[i], coil)),
        }
    }

    /// What it says where the theodolites err by `std_rad`: A − B (1/s² + C)⁻¹ Bᵀ.
    pub fn said(&self, std_rad: f64) -> Said {
        let own = self.own + Matrix3::identity() / (std_rad * std_rad);
        match own.try_inverse().filter(|_| std_rad > 0.0) {
            Some(inverse) => Said {
                information: self.common - self.both * inverse * self.both.transpose(),
                gradients: self.gradients - self.both * inverse * self.own_gradients,
            },
            None => Said { information: self.common, gradients: self.gradients },
        }
    }
}

/// Derivatives of the readings in one orientation with nominal axes, whitened by their noise.
pub struct Derivatives {
    pub jacobian: DMatrix<f64>,
    /// The columns of what is common, in the order of [`Information`].
    pub common: Vec<usize>,
    /// The columns of the turns of this orientation.
    pub own: Vec<usize>,
    /// What one standard uncertainty of each coil's gradient adds.
    pub gradients: DMatrix<f64>,
}

impl Derivatives {
    /// Rows sensor by sensor, drive by drive.
    pub fn of(rotation: &Matrix3<f64>, turns: &Matrix3<f64>, readings: &Readings) -> Self {
        let observations = observations(rotation, turns, readings);
        // Everything moves; what is known of it beforehand comes in elsewhere.
        let freedom = Freedom {
            known_coils: None,
            sensor_scale: [Some(f64::INFINITY); 3],
            coil_scale: [Some(f64::INFINITY); 3],
            orientations: true,
            residual_field: Some([f64::INFINITY; 3]),
            offsets: [Some(f64::INFINITY); 3],
        };
        let problem = AxesProblem::new(&observations, &freedom, NoiseFactors::ONE);
        let state = AxesState::new(Matrix3::identity(), Matrix3::identity(), 1);
        let (_, jacobian) = estimate::linearised(&problem, &state);
        let (own, common) = (0..jacobian.ncols())
            .partition(|place| matches!(problem.meaning[*place], Unknown::Correction(..)));
        let mut gradients = DMatrix::zeros(observations.readings.len(), 3);
        for coil in 0..3 {
            let pushed = |reading: &Observation| {
                let sensor = reading.sensor.index();
                // m·R (3 n (n·p) − p) B g/2 with m = 1, n = 1 and p = Rᵀ place.
                let place = &readings.positions_m[sensor];
                let coil_sen = rotation.column(coil);
                let seen = 0.5 * (3.0 * coil_sen[sensor] * coil_sen.dot(place) - place[sensor]);
                seen * readings.gradient_per_m[coil] * reading.drive_nt[coil] / reading.std_nt
            };
            let mut column: Vec<f64> = observations.readings.iter().map(pushed).collect();
            problem.whiten(&mut column);
            gradients.column_mut(coil).copy_from_slice(&column);
        }
        Self {
            jacobian: DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, j| jacobian[(i, j)]),
            common,
            own,
            gradients,
        }
    }
}

fn observations(rotation: &Matrix3<f64>, turns: &Matrix3<f64>, readings: &Readings) -> Observations {
    let of = |sensor: Axis, row: usize| Observation {
        orientation: 0,
        recording: 0,
        row,
        sensor,
        drive_nt: readings.drives_nt[row],
        value_nt: 0.0,
        std_nt: readings.covariance[sensor.index()][(row, row)].sqrt(),
        ambient_nt: Vector3::zeros(),
        constant: true,
    };
    let count = readings.drives_nt.len();
    let together = |sensor: Axis| Together {
        recording: 0,
        sensor,
        rows: (0..count).collect(),
        covariance: readings.covariance[sensor.index()].clone(),
    };
    Observations {
        orientations: vec![OrientationGroup {
            orientation: Orientation { rotation: *rotation, uncertainty: *turns, moved_rad: 0.0 },
            recordings: Vec::new(),
        }],
        readings: Axis::ALL.iter().flat_map(|sensor| (0..count).map(|row| of(*sensor, row))).collect(),
        together: Axis::ALL.map(together).into(),
        noise: NoiseSource::Declared,
        unit: Unit::Nanotesla,
        sensors: Axis::ALL.into(),
        coils: Axis::ALL.into(),
        phases: Vec::new(),
        findings: Vec::new(),
    }
}
