//! From what is set to what is read: the chain, the world around, noise and codes.

use common::{Axis, Column, Document, Error, Noise, PerAxis, Recording, procedure};
use nalgebra::Vector3;
use noise::NoiseError;
use physics::{Basic, Context, EffectInstance, Kind, Prediction, References, Unit};
use rayon::prelude::*;
use std::collections::HashMap;

use crate::aboard;
use crate::outside::{Moments, by_axis};
use crate::plan::Plan;
use crate::planned::{Planned, Reads, Surroundings};
use crate::schedule::Scheduled;
use crate::truth::{Electrical, Wander};

/// What is true for all recordings.
pub struct World<'a> {
    pub plan: &'a Plan,
    /// What is true of facility and calibration, exact; its recordings without columns.
    pub document: Document,
    pub basic: Basic,
    pub effects: Vec<EffectInstance>,
    /// Unit of the readings.
    pub unit: Unit,
    pub references: References,
    pub electrical: Option<Electrical>,
    /// What is added to the offset, nT, by recording.
    pub wander: HashMap<String, f64>,
}

type Read = Vec<(String, Vec<f64>)>;

impl World<'_> {
    /// All recordings, with their readings. The first fault in the plan's order is the one that is told.
    pub fn recordings(&self, set: Vec<Recording>, written: &[Scheduled]) -> Result<Vec<Recording>, Error> {
        let made: Vec<Result<Recording, Error>> =
            set.into_par_iter().zip(written).map(|(set, written)| self.recording(set, written)).collect();
        made.into_iter().collect()
    }

    /// One recording: what is set is made true, the chain predicts, and what is written is put in its place.
    fn recording(&self, mut set: Recording, written: &Scheduled) -> Result<Recording, Error> {
        let Planned { path, outside, reads, .. } = &written.planned;
        let failed = |error: NoiseError| disorder(error, path);
        let natural = self.natural(&set, written).map_err(failed)?;
        if *outside && natural.is_none() {
            let expected = "the natural field (truth.outside) and times, for the station outside";
            return Err(Error::document(format!("{path}.outside"), "true", expected));
        }
        let given_outside = set.columns.keys().any(|name| name.starts_with("outside_"));
        if let Some(natural) = natural.as_ref().filter(|_| !given_outside) {
            insert(&mut set, outside_columns(by_axis(natural)));
        }
        let currents = self.follow_profile(&mut set);
        let read = self.read(&set, written, natural.as_deref())?;
        set.conditions = written.planned.recording.conditions.clone();
        if let Some((name, currents)) = currents {
            set.columns.insert(name, currents);
        }
        if !given_outside {
            Axis::ALL.iter().for_each(|axis| {
                set.columns.shift_remove(&format!("outside_{axis}_nt"));
            });
            if let (Some(of), Some(field), true) = (&self.plan.truth.outside, &natural, *outside) {
                let moments = self.moments(&set, written);
                let station =
                    moments.map(|moments| of.station(&moments, field)).transpose().map_err(failed)?;
                insert(&mut set, station.map(outside_columns).unwrap_or_default());
            }
        }
        if let Reads::Aboard { known, .. } = reads {
            let context = Context::new(&self.document, &set, self.references);
            let attitude = context.map_err(|error| advise(error, path))?.attitude;
            aboard::write(&mut set, known.as_deref(), &attitude, self.plan.seed).map_err(failed)?;
        }
        insert(&mut set, read);
        self.write_voltages(&mut set)?;
        Ok(set)
    }

    fn moments<'r>(&self, set: &'r Recording, written: &Scheduled) -> Option<Moments<'r>> {
        Some(Moments {
            seed: self.plan.seed,
            id: &set.id,
            time_s: set.column("time_s")?,
            clock_s: written.clock_s,
            local_s: written.local_s,
        })
    }

    /// The natural field, where the recording or an effect on it takes notice of it.
    fn natural(&self, set: &Recording, written: &Scheduled) -> Result<Option<Vec<Vector3<f64>>>, NoiseError> {
        let leaks = self.effects.iter().any(|effect| effect.kind.follows_outside());
        let wanted = written.planned.outside || leaks || written.planned.surroundings == Surroundings::Open;
        let outside = self.plan.truth.outside.as_ref().filter(|_| wanted);
        outside.zip(self.moments(set, written)).map(|(outside, moments)| outside.field(&moments)).transpose()
    }

    fn read(
        &self,
        set: &Recording,
        written: &Scheduled,
        natural: Option<&[Vector3<f64>]>,
    ) -> Result<Read, Error> {
        let Planned { path, surroundings, reads, .. } = &written.planned;
        let mut context =
            Context::new(&self.document, set, self.references).map_err(|error| advise(error, path))?;
        context.unit = self.unit;
        match surroundings {
            // In the natural field, without coils, there is only what the recording says.
            Surroundings::Coils if !context.in_coils => {}
            Surroundings::Coils => {
                let residual_nt = vector(self.plan.truth.residual_field_nt.as_ref());
                context.ambient_nt.iter_mut().for_each(|field| *field += residual_nt);
                if let (Some(site), Some(moments)) = (&self.plan.truth.site, self.moments(set, written)) {
                    let noise = site.field(&moments).map_err(|error| disorder(error, path))?;
                    context.ambient_nt =
                        noise.iter().enumerate().map(|(row, noise)| context.ambient(row) + noise).collect();
                }
            }
            Surroundings::Shield => {
                let position = set.column("position");
                let field_nt = vector(self.plan.truth.shield_field_nt.as_ref());
                let of = |row: usize| field_nt * position.map_or(1.0, |position| position[row]);
                context.ambient_nt = (0..context.rows).map(of).collect();
            }
            Surroundings::Open => context.ambient_nt = natural.unwrap_or_default().to_vec(),
        }
        match reads {
            Reads::Sensors(sensors) => self.read_sensors(sensors, context, &written.planned),
            Reads::Scalar => self.read_scalar(&context, path),
            Reads::Differential => self.read_differential(context, path),
            Reads::Aboard { sensors, scalar, .. } => {
                let mut read = if *scalar { self.read_scalar(&context, path)? } else { Read::new() };
                read.extend(self.read_sensors(sensors, context, &written.planned)?);
                Ok(read)
            }
        }
    }

    fn predict(&self, basic: &Basic, context: &Context<'_>, path: &str) -> Result<Prediction, Error> {
        let effects = self.effects_in(context.recording);
        physics::predict(basic, &effects, context).map_err(|error| advise(error, path))
    }

    fn noise(
        &self,
        noise: &Noise,
        context: &Context<'_>,
        channel: &str,
        time: Option<&[f64]>,
    ) -> Result<Vec<f64>, NoiseError> {
        let channel = format!("{}/{channel}", context.recording.id);
        noise::series(noise, self.plan.seed, &channel, context.rows, time)
    }

    /// The effects that act in a recording: those of a spacecraft only on board, where their housekeeping is.
    fn effects_in(&self, recording: &Recording) -> Vec<EffectInstance> {
        let aboard = |effect: &&EffectInstance| {
            let column = match effect.kind {
                Kind::SunThermoelectric | Kind::SunThermoelectricHarmonics => Some("sun_azimuth_rad"),
                _ => effect.column.as_deref(),
            };
            column.is_none_or(|column| holds(recording, column))
        };
        self.effects.iter().filter(aboard).cloned().collect()
    }

    fn read_sensors(
        &self,
        sensors: &[Axis],
        mut context: Context<'_>,
        planned: &Planned,
    ) -> Result<Read, Error> {
        let instrument = self.plan.instrument.clone().unwrap_or_default();
        let width = self.unit.code_width(Some(&instrument));
        let wandered = self.wander.get(&context.recording.id).copied().unwrap_or(0.0);
        let errors = |sensor: &Axis| {
            let name = format!("sensor_{sensor}_{}", self.unit.suffix());
            let declared = instrument.noise_of(*sensor).cloned().unwrap_or_default();
            let errors = self.noise(&declared, &context, &name, context.recording.column("time_s"))?;
            Ok((name, errors))
        };
        let errors: Vec<Result<_, NoiseError>> = sensors.par_iter().map(errors).collect();
        let read = errors.into_iter().collect::<Result<Read, _>>();
        let mut read = read.map_err(|error| disorder(error, &planned.path))?;
        context.noise_nt = vec![Vector3::zeros(); context.rows];
        for ((_, errors), sensor) in read.iter().zip(sensors) {
            for (noise, error) in context.noise_nt.iter_mut().zip(errors) {
                noise[sensor.index()] = error - wandered;
            }
        }
        let readings = self.predict(&self.basic, &context, &planned.path)?.readings;
        read.par_iter_mut().zip(sensors).for_each(|((_, column), sensor)| {
            column.iter_mut().zip(&readings).for_each(|(value, reading)| *value = reading[sensor.index()]);
            noise::quantise(column, width.unwrap_or(0.0) / planned.amplification);
        });
        Ok(read)
    }

    fn read_scalar(&self, context: &Context<'_>, path: &str) -> Result<Read, Error> {
        let field = self.predict(&self.basic, context, path)?.field_geo;
        let std = self.plan.facility.as_ref().and_then(|facility| facility.reference_std_nt);
        let declared = Noise { white_rms_nt: std, ..Noise::default() };
        let column = self.noise(&declared, context, "reference_nt", None);
        let mut column = column.map_err(|error| disorder(error, path))?;
        column.iter_mut().zip(&field).for_each(|(value, field)| *value += field.norm());
        Ok(vec![("reference_nt".into(), column)])
    }

    fn read_differential(&self, mut context: Context<'_>, path: &str) -> Result<Read, Error> {
        let Some(truth) = &self.plan.truth.differential else { return Ok(Read::new()) };
        let instrument = self.plan.instrument.clone().unwrap_or_default();
        let noise = |context: &Context<'_>, prefix: &str| -> Result<Vec<Vector3<f64>>, Error> {
            let mut errors = vec![Vector3::zeros(); context.rows];
            for axis in Axis::ALL {
                let declared = match prefix {
                    "test" => instrument.noise_of(axis).cloned(),
                    "third" => truth.third.as_ref().and_then(|third| third.noise.clone()),
                    _ => truth.reference_noise.clone(),
                };
                let (declared, channel) = (declared.unwrap_or_default(), format!("{prefix}_{axis}_nt"));
                let series = self.noise(&declared, context, &channel, context.recording.column("time_s"));
                let series = series.map_err(|error| disorder(error, path))?;
                errors.iter_mut().zip(series).for_each(|(all, error)| all[axis.index()] = error);
            }
            Ok(errors)
        };
        let noisy = |context: &Context<'_>, prefix: &str, mut readings: Vec<Vector3<f64>>| {
            let errors = noise(context, prefix)?;
            readings.iter_mut().zip(errors).for_each(|(reading, error)| *reading += error);
            Ok::<_, Error>((prefix.to_string(), readings))
        };
        let matrix = truth.reference_matrix();
        let reference: Vec<Vector3<f64>> = context.ambient_nt.iter().map(|field| matrix * field).collect();
        context.reference_nt = Some(reference.clone());
        context.noise_nt = noise(&context, "test")?;
        let mut all = vec![noisy(&context, "reference", reference)?];
        let test = self.predict(&Basic::differential(&self.document), &context, path)?.readings;
        all.push(("test".into(), test));
        if let Some(third) = &truth.third {
            let (matrix, offset) = (third.axes.matrix(), Vector3::from(third.offset_nt));
            let readings = context.ambient_nt.iter().map(|field| matrix * field + offset).collect();
            all.push(noisy(&context, "third", readings)?);
        }
        let mut read = Read::new();
        for (prefix, readings) in all {
            for (axis, mut column) in Axis::ALL.iter().zip(by_axis(&readings)) {
                noise::quantise(&mut column, instrument.quantisation_nt.unwrap_or(0.0));
                read.push((format!("{prefix}_{axis}_nt"), column));
            }
        }
        Ok(read)
    }

    /// In a survey along the axis the coil's field is that of the place. Gives the currents that were set.
    fn follow_profile(&self, set: &mut Recording) -> Option<(String, Column)> {
        let coil = set.conditions.coil.filter(|_| set.procedure == procedure::COIL_GRADIENT)?;
        let profile = self.plan.truth.coil_profile.as_ref()?.get(coil)?;
        let position = set.column("position_m")?.to_vec();
        let name = format!("coil_{coil}_a");
        let column = set.columns.get_mut(&name)?;
        let currents = column.clone();
        column.iter_mut().zip(position).for_each(|(current, x)| *current *= profile.at(x));
        Some((name, currents))
    }

    /// Currents as the voltmeter reads them.
    fn write_voltages(&self, read: &mut Recording) -> Result<(), Error> {
        let Some(electrical) = self.electrical.as_ref().filter(|_| read.procedure != procedure::FREE_RUN)
        else {
            return Ok(());
        };
        let columns = std::mem::take(&mut read.columns);
        for (name, column) in columns {
            let coil = Axis::ALL.into_iter().find(|axis| name == format!("coil_{axis}_a"));
            let Some(coil) = coil else {
                read.columns.insert(name, column);
                continue;
            };
            let reads = |current: &f64| electrical.reads(coil, *current);
            let volts: Option<Vec<f64>> = column.iter().map(reads).collect();
            let volts = volts.ok_or_else(|| {
                let expected = "its resistance, which \"drive\": \"voltage\" needs";
                Error::document(format!("facility.coils.{coil}.resistor_ohm"), "no such key", expected)
            })?;
            read.columns.insert(format!("coil_{coil}_v"), Column::from(volts));
        }
        Ok(())
    }
}

/// Whether a recording has a column, or a condition of that name.
pub fn holds(recording: &Recording, name: &str) -> bool {
    recording.column(name).is_some() || recording.conditions.extra.contains_key(name)
}

fn disorder(error: NoiseError, path: &str) -> Error {
    Error::document(path, error.to_string(), "exponents from 0 to 2, and times without such gaps")
}

/// What an effect lacks, with the key of the plan that gives it.
fn advise(error: physics::Error, path: &str) -> Error {
    match error {
        physics::Error::Missing { who, what, .. } => {
            let key = if what.contains("temperature") {
                "; state `temperatures` in the plan"
            } else if what.contains("outside") {
                "; state `truth.outside` in the plan"
            } else {
                ""
            };
            Error::document(path, format!("nothing that {who} could use"), format!("{what}{key}"))
        }
        other => other.at(path),
    }
}

/// The wander of each sensor's offset over the dates of `offset_drift`, on an even grid of dates.
pub fn wander(plan: &Plan, set: &[Recording], written: &[Scheduled]) -> Result<Vec<Wander>, Error> {
    let Some(noise) = &plan.truth.offset_wander else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    for sensor in Axis::ALL {
        let mine = |(set, _): &(&Recording, &Scheduled)| {
            set.procedure == procedure::OFFSET_DRIFT && set.conditions.sensor == Some(sensor)
        };
        let dates: Vec<(&Recording, &Scheduled)> = set.iter().zip(written).filter(mine).collect();
        let times: Vec<f64> = dates.iter().map(|(_, written)| written.clock_s).collect();
        let name = format!("offset_wander_{sensor}");
        let series = noise::series(noise, plan.seed, &name, times.len(), Some(&times)).map_err(|error| {
            let expected = "an exponent from 0 to 2, and even dates";
            Error::document("truth.offset_wander", error.to_string(), expected)
        })?;
        let one =
            |((set, _), offset_nt): (&(&Recording, _), f64)| Wander { recording: set.id.clone(), offset_nt };
        all.extend(dates.iter().zip(series).map(one));
    }
    Ok(all)
}

fn insert(recording: &mut Recording, columns: Read) {
    recording.columns.extend(columns.into_iter().map(|(name, column)| (name, Column::from(column))));
}

fn outside_columns(columns: [Vec<f64>; 3]) -> Read {
    Axis::ALL.into_iter().zip(columns).map(|(axis, column)| (format!("outside_{axis}_nt"), column)).collect()
}

/// A field along x, y and z; zero where it is not stated.
pub fn vector(field: Option<&PerAxis<f64>>) -> Vector3<f64> {
    Vector3::from(Axis::ALL.map(|axis| field.and_then(|field| field.get(axis)).copied().unwrap_or(0.0)))
}
