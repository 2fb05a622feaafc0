//! The unknowns of the fit, and what is known of them beforehand.

use common::Axis;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// What may move besides the directions of the sensors, and what is known of it beforehand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Freedom {
    /// η is found (None), or given: its directions, and their whitening; see [`KnownCoils`].
    pub known_coils: Option<KnownCoils>,
    /// Relative standard uncertainty of each sensor's sensitivity; infinite: free; None: exact.
    pub sensor_scale: [Option<f64>; 3],
    /// The same for each coil constant.
    pub coil_scale: [Option<f64>; 3],
    /// Whether each orientation may turn within its theodolites' uncertainty.
    pub orientations: bool,
    /// Standard uncertainty of the residual field's components (GEO), nT; infinite: free; None: zero.
    pub residual_field: Option<[f64; 3]>,
    /// Standard uncertainty of each sensor's remaining offset, nT; infinite: free; None: taken as zero.
    pub offsets: [Option<f64>; 3],
}

impl Freedom {
    /// The same with every constant that has a prior left free.
    pub fn without_priors(&self) -> Self {
        let free = |std: Option<f64>| std.map(|_| f64::INFINITY);
        Self {
            sensor_scale: self.sensor_scale.map(free),
            coil_scale: self.coil_scale.map(free),
            residual_field: self.residual_field.map(|_| [f64::INFINITY; 3]),
            offsets: self.offsets.map(free),
            ..self.clone()
        }
    }

    /// Takes the prior of a constant away. The residual field goes as a whole.
    pub fn release(&mut self, unknown: Unknown) {
        match unknown {
            Unknown::SensorScale(axis) => self.sensor_scale[axis.index()] = Some(f64::INFINITY),
            Unknown::CoilScale(axis) => self.coil_scale[axis.index()] = Some(f64::INFINITY),
            Unknown::ResidualField(_) => self.residual_field = Some([f64::INFINITY; 3]),
            Unknown::Offset(axis) => self.offsets[axis.index()] = Some(f64::INFINITY),
            Unknown::Sensor(..) | Unknown::Coil(..) | Unknown::Correction(..) => {}
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct KnownCoils {
    /// Unit vectors in GEO.
    pub directions: [Vector3<f64>; 3],
    /// W with Wᵀ W = inverse covariance of the turns along the driven coils' tangents; None: exact.
    pub whitening: Option<DMatrix<f64>>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct AxesState {
    /// Columns = sensors in SEN.
    pub mu: Matrix3<f64>,
    /// Columns = coils in GEO.
    pub eta: Matrix3<f64>,
    /// Reading over field, less one.
    pub sensor_scale: Vector3<f64>,
    /// Field over calibrated drive, less one.
    pub coil_scale: Vector3<f64>,
    /// Correction of each orientation in units of its own uncertainty.
    pub corrections: Vec<Vector3<f64>>,
    /// Field with no drive, GEO, nT.
    pub residual_field: Vector3<f64>,
    /// Offsets that the calibration left, nT.
    pub offsets: Vector3<f64>,
}

impl AxesState {
    /// Sensors and coils in the given directions, nothing else.
    pub fn new(mu: Matrix3<f64>, eta: Matrix3<f64>, orientations: usize) -> Self {
        Self {
            mu,
            eta,
            sensor_scale: Vector3::zeros(),
            coil_scale: Vector3::zeros(),
            corrections: vec![Vector3::zeros(); orientations],
            residual_field: Vector3::zeros(),
            offsets: Vector3::zeros(),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unknown {
    /// Turn of a sensor along one of its tangents, rad.
    Sensor(Axis, usize),
    /// Turn of a coil along one of its tangents, rad.
    Coil(Axis, usize),
    SensorScale(Axis),
    CoilScale(Axis),
    /// Correction of an orientation, in units of its uncertainty.
    Correction(usize, usize),
    ResidualField(usize),
    Offset(Axis),
}

impl Unknown {
    pub fn is_turn(self) -> bool {
        matches!(self, Unknown::Sensor(..) | Unknown::Coil(..))
    }
}

pub fn place(all: &[Unknown], unknown: Unknown) -> Option<usize> {
    all.iter().position(|one| *one == unknown)
}

pub fn turns(all: &[Unknown]) -> Vec<usize> {
    (0..all.len()).filter(|k| all[*k].is_turn()).collect()
}
