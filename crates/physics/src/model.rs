//! The constants of the basic chain, as the document states them.

use common::{Axis, Calibration, Document, Quantity, SensorCalibration};
use nalgebra::{Matrix3, Vector3};

use crate::frames;
use crate::{Real, Unit};

/// B = k I + B0 along the coil's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoilConstants<T> {
    /// k, nT/A.
    pub constant_nt_per_a: T,
    /// B0, nT.
    pub offset_nt: T,
}

/// B = k reading + O along the sensor's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorConstants<T> {
    /// k, nT/V, or nT/nT for an instrument that gives field.
    pub sensitivity: T,
    /// O, nT.
    pub offset_nt: T,
}

/// One parameter of the chain, to be fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    /// k of a coil, nT/A.
    CoilConstant(Axis),
    /// B0 of a coil, nT.
    CoilOffset(Axis),
    /// Turn of a coil along one of its two tangents, rad.
    CoilTurn(Axis, usize),
    /// Turn of a sensor along one of its two tangents, rad.
    SensorTurn(Axis, usize),
    /// k of a sensor.
    Sensitivity(Axis),
    /// O of a sensor, nT.
    SensorOffset(Axis),
    /// A parameter of an effect: number of the effect, number of its parameter.
    Effect(usize, usize),
}

/// The basic chain: coils, η, μ, sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct Basic<T: Real = f64> {
    /// Coils x, y, z.
    pub coils: [CoilConstants<T>; 3],
    /// Columns = unit vectors of the coils in GEO.
    pub eta: Matrix3<T>,
    /// Columns = unit vectors of the sensors in SEN.
    pub mu: Matrix3<T>,
    /// Sensors x, y, z.
    pub sensors: [SensorConstants<T>; 3],
}

impl<T: Real> Basic<T> {
    /// Where a constant stands; None for turns, which are of η and μ, and for effects.
    pub fn constant_mut(&mut self, parameter: Parameter) -> Option<&mut T> {
        match parameter {
            Parameter::Sensitivity(axis) => Some(&mut self.sensors[axis.index()].sensitivity),
            Parameter::SensorOffset(axis) => Some(&mut self.sensors[axis.index()].offset_nt),
            Parameter::CoilConstant(axis) => Some(&mut self.coils[axis.index()].constant_nt_per_a),
            Parameter::CoilOffset(axis) => Some(&mut self.coils[axis.index()].offset_nt),
            Parameter::CoilTurn(..) | Parameter::SensorTurn(..) | Parameter::Effect(..) => None,
        }
    }
}

impl Basic<f64> {
    /// The chain that a document's calibration describes, for readings in `unit`. What is not stated is
    /// nominal: axes along their frame, offsets zero, sensitivity the instrument's nominal one. A coil of
    /// unknown constant makes no field, and a sensor of unknown sensitivity reads nT; a stage that needs them
    /// asks first.
    pub fn of(document: &Document, unit: Unit) -> Self {
        let empty = Calibration::default();
        let calibration = document.calibration.as_ref().unwrap_or(&empty);
        let value = |quantity: Option<&Quantity>| quantity.map(Quantity::value);
        let mut basic = Basic {
            coils: [CoilConstants { constant_nt_per_a: 0.0, offset_nt: 0.0 }; 3],
            eta: Matrix3::identity(),
            mu: Matrix3::identity(),
            sensors: [SensorConstants { sensitivity: 1.0, offset_nt: 0.0 }; 3],
        };
        for axis in Axis::ALL {
            if let Some(coil) = calibration.coil(axis) {
                basic.coils[axis.index()] = CoilConstants {
                    constant_nt_per_a: value(coil.constant_nt_per_a.as_ref()).unwrap_or(0.0),
                    offset_nt: value(coil.offset_nt.as_ref()).unwrap_or(0.0),
                };
            }
            let sensor = calibration.sensor(axis);
            let nominal = document.instrument.as_ref().and_then(|i| i.nominal_sensitivity_nt_per_v);
            basic.sensors[axis.index()] = SensorConstants {
                sensitivity: value(sensor.and_then(|sensor| sensitivity(sensor, unit)))
                    .or(nominal.filter(|_| unit == Unit::Volt))
                    .unwrap_or(1.0),
                offset_nt: value(sensor.and_then(|s| s.offset_nt.as_ref())).unwrap_or(0.0),
            };
        }
        if let Some(axes) = &calibration.axes {
            let given = |part: &Option<common::AxesDirections>| part.as_ref().and_then(|part| part.matrix);
            basic.eta = given(&axes.coils).map_or(basic.eta, |rows| frames::matrix(&rows));
            basic.mu = given(&axes.sensors).map_or(basic.mu, |rows| frames::matrix(&rows));
        }
        basic
    }

    /// Where the first constant stands that is undetermined (`null`).
    pub fn undetermined(&self) -> Option<String> {
        let coils = Axis::ALL.map(|axis| (format!("coils.{axis}"), self.coils[axis.index()]));
        let sensors = Axis::ALL.map(|axis| (format!("sensors.{axis}"), self.sensors[axis.index()]));
        let coils = coils.into_iter().map(|(path, k)| (path, k.constant_nt_per_a + k.offset_nt));
        let sensors = sensors.into_iter().map(|(path, k)| (path, k.sensitivity + k.offset_nt));
        coils.chain(sensors).find(|(_, sum)| !sum.is_finite()).map(|(path, _)| format!("calibration.{path}"))
    }

    /// As `of`, with `axes.offsets_nt` of axescal added to the sensors' offsets.
    pub fn found(document: &Document, unit: Unit) -> Self {
        let mut basic = Basic::of(document, unit);
        let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
        for (axis, offset) in axes.and_then(|axes| axes.offsets_nt.as_ref()).iter().flat_map(|all| all.iter())
        {
            basic.sensors[axis.index()].offset_nt += offset.value();
        }
        basic
    }

    /// The chain of a differential recording, T = R η + d: the reference's reading in place of the field, η
    /// in place of the sensors' directions, −d in place of the offsets. Not stated: η = 1, d = 0.
    pub fn differential(document: &Document) -> Self {
        let mut basic = Basic::of(&Document::default(), Unit::Nanotesla);
        let calibration =
            document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
        if let Some(rows) = calibration.and_then(|differential| differential.matrix) {
            basic.mu = frames::matrix(&rows);
        }
        for axis in Axis::ALL {
            let offset = calibration.and_then(|differential| differential.offset_nt.as_ref()?.get(axis));
            basic.sensors[axis.index()].offset_nt = -offset.map_or(0.0, Quantity::value);
        }
        basic
    }

    /// The same chain in another number type, all derivatives zero.
    pub fn lift<T: Real>(&self) -> Basic<T> {
        Basic {
            coils: self.coils.map(|coil| CoilConstants {
                constant_nt_per_a: T::from(coil.constant_nt_per_a),
                offset_nt: T::from(coil.offset_nt),
            }),
            eta: self.eta.map(T::from),
            mu: self.mu.map(T::from),
            sensors: self.sensors.map(|sensor| SensorConstants {
                sensitivity: T::from(sensor.sensitivity),
                offset_nt: T::from(sensor.offset_nt),
            }),
        }
    }
}

/// The sensitivity that goes with readings of a unit.
pub fn sensitivity(sensor: &SensorCalibration, unit: Unit) -> Option<&Quantity> {
    match unit {
        Unit::Volt => sensor.sensitivity_nt_per_v.as_ref(),
        Unit::Nanotesla => sensor.sensitivity_nt_per_nt.as_ref(),
    }
}

pub(crate) fn column<T: Real>(matrix: &Matrix3<T>, axis: Axis) -> Vector3<T> {
    matrix.column(axis.index()).into_owned()
}
