//! Effects of the catalogue that are fitted with the sensors, and those of the model, which are taken off.

use common::{Axis, Document};
use indexmap::IndexSet;
use nalgebra::Vector3;
use physics::{
    Acts, Basic, EffectInstance, Parameter as Derivative, References, Role, Setting, Stage, predict,
    predict_with_jacobian,
};

use crate::design::Scales;
use crate::directions::unmixed;
use crate::model::Parameter;
use crate::read::Series;
use crate::terms::ONE;
use crate::{Error, Options};

/// Columns are one where they differ by less than this share.
const SAME: f64 = 1e-9;

/// The effects that are fitted: one instance for each sensor or housekeeping column.
///
/// Errors: an effect with a time constant, a level or a moment, or one that does not act on the sensors; no
/// column for it to follow.
pub fn asked(document: &Document, options: &Options) -> Result<Vec<EffectInstance>, Error> {
    let mut all = Vec::new();
    for kind in &options.with {
        let about = kind.about();
        let linear = about.parameters.iter().all(|parameter| parameter.role == Role::Amplitude);
        if !linear || about.stage < Stage::Block || !kind.invertible() {
            return Err(Error::Request(format!(
                "--with {}: {} is not linear in its parameters at the sensors and cannot be fitted from the magnitude; run diagnose on the result, which searches for it",
                about.name, about.title
            )));
        }
        let of = |axis: Option<Axis>, column: Option<String>| EffectInstance {
            column,
            ..EffectInstance::new(*kind, axis, vec![0.0; about.parameters.len()])
        };
        match about.acts {
            Acts::OneSensor => all.extend(Axis::ALL.map(|axis| of(Some(axis), None))),
            Acts::WithColumn(_) => {
                let names = document.recordings.iter().flat_map(|recording| recording.columns.keys());
                let columns: IndexSet<&String> = names.filter(|name| kind.takes(name)).collect();
                if columns.is_empty() {
                    let (name, needs) = (about.name, about.needs.join(", "));
                    let words = format!("--with {name}: it needs {needs}, and no recording has it");
                    return Err(Error::Request(words));
                }
                all.extend(columns.into_iter().map(|column| of(None, Some(column.clone()))));
            }
            _ => all.push(of(None, None)),
        }
    }
    Ok(all)
}

/// The parameters of effects; the series get the columns that they follow, by how the chain's readings move
/// with the parameters where the field is what the sensors read by `basic`.
pub fn following(
    document: &Document,
    series: &mut [Series],
    scales: &Scales,
    basic: &Basic,
    effects: &[EffectInstance],
) -> Result<Vec<Parameter>, Error> {
    let numbers: Vec<[usize; 2]> = effects
        .iter()
        .enumerate()
        .flat_map(|(number, effect)| (0..effect.parameters.len()).map(move |parameter| [number, parameter]))
        .collect();
    let derivatives: Vec<Derivative> =
        numbers.iter().map(|[effect, parameter]| Derivative::Effect(*effect, *parameter)).collect();
    // contributions[recording][parameter][sensor][row], nT for one unit of the parameter.
    let mut contributions: Vec<Vec<[Vec<f64>; 3]>> = Vec::new();
    for one in series.iter() {
        let setting = setting(document, one, basic)?;
        let refused = |error: physics::Error| error.at(&one.path());
        let (_, moved) = predict_with_jacobian(&setting.basic, effects, &setting.context, &derivatives)
            .map_err(refused)?;
        // What is read too much by e makes the output larger by e/k.
        let of = |along: &[Vector3<f64>]| -> [Vec<f64>; 3] {
            std::array::from_fn(|axis| {
                one.rows.iter().map(|row| along[*row][axis] * basic.sensors[axis].sensitivity).collect()
            })
        };
        contributions.push(moved.iter().map(|prediction| of(&prediction.readings)).collect());
    }
    let mut parameters = Vec::new();
    let rows: f64 = series.iter().map(|one| one.len() as f64).sum();
    for (place, number) in numbers.iter().enumerate() {
        let rms: [f64; 3] = std::array::from_fn(|axis| {
            let squares = contributions.iter().flat_map(|one| &one[place][axis]).map(|value| value * value);
            (squares.sum::<f64>() / rows).sqrt()
        });
        let largest = rms.iter().copied().fold(0.0, f64::max);
        let one = &effects[number[0]];
        let name = format!("{}.{}", one.kind.name(), one.kind.parameters()[number[1]].name);
        if largest <= 0.0 {
            return Err(Error::Unanswerable(format!(
                "{name} changes no reading of these recordings: the quantity that it follows does not vary"
            )));
        }
        let unit = scales.magnitude_nt / largest;
        let follows = std::array::from_fn(|axis| {
            if rms[axis] <= SAME * largest {
                return None;
            }
            let to_rms = scales.magnitude_nt / rms[axis];
            let scaled =
                |one: &Vec<[Vec<f64>; 3]>| one[place][axis].iter().map(|value| value * to_rms).collect();
            let column = contributions.iter().map(scaled).collect();
            let (number, sign) = shared(series, column, scales.magnitude_nt);
            Some((ONE + 1 + number, sign * rms[axis] / largest))
        });
        let of = one.axis.map(|axis| format!(" of {axis}")).unwrap_or_default();
        let column = one.column.as_ref().map(|column| format!(" ({column})")).unwrap_or_default();
        parameters.push(Parameter::Effect { number: *number, unit, follows, name: name + &of + &column });
    }
    Ok(parameters)
}

/// The number of a column among those that are there already, and its sign; a new one is added.
fn shared(series: &mut [Series], column: Vec<Vec<f64>>, size: f64) -> (usize, f64) {
    let count = series[0].follows.len();
    for number in 0..count {
        for sign in [1.0, -1.0] {
            let same = series.iter().zip(&column).all(|(have, new)| {
                have.follows[number].iter().zip(new).all(|(a, b)| (a - sign * b).abs() <= SAME * size)
            });
            if same {
                return (number, sign);
            }
        }
    }
    series.iter_mut().zip(column).for_each(|(one, new)| one.follows.push(new));
    (count, 1.0)
}

/// A recording in the field that its sensors read by a chain, which holds in SEN.
fn setting<'a>(document: &'a Document, series: &Series, basic: &Basic) -> Result<Setting<'a>, Error> {
    let recording = &document.recordings[series.index];
    let refused = |error: physics::Error| error.at(&series.path());
    let mut setting = Setting::of(document, recording, References::of(document)).map_err(refused)?;
    let unmix = unmixed(&basic.mu);
    let rows = setting.context.rows;
    let mut field = vec![Vector3::repeat(f64::NAN); rows];
    for (place, row) in series.rows.iter().enumerate() {
        let along = Vector3::from_fn(|axis, _| {
            basic.sensors[axis].sensitivity * series.readings[axis][place] + basic.sensors[axis].offset_nt
        });
        field[*row] = setting.context.rotation(*row).transpose() * (unmix * along);
    }
    // Rows without readings have the field of the row before: what remembers goes on.
    let mut before = field.iter().find(|field| field.x.is_finite()).copied().unwrap_or_else(Vector3::zeros);
    for field in &mut field {
        if !field.x.is_finite() {
            *field = before;
        }
        before = *field;
    }
    setting.context.ambient_nt = field;
    setting.context.in_coils = false;
    setting.basic = basic.clone();
    Ok(setting)
}

/// The readings without what the effects of the model add, at the field that they mean by a chain.
pub fn taken_off(
    document: &Document,
    series: &[Series],
    basic: &Basic,
    effects: &[EffectInstance],
) -> Result<Vec<Series>, Error> {
    let mut all = series.to_vec();
    for (one, with) in all.iter_mut().zip(series) {
        let setting = setting(document, with, basic)?;
        let acts = |effect: &&EffectInstance| {
            effect.acts(setting.context.recording) && effect.kind.about().stage >= Stage::Block
        };
        let acting: Vec<EffectInstance> = effects.iter().filter(acts).cloned().collect();
        if acting.is_empty() {
            continue;
        }
        let refused = |error: physics::Error| error.at(&with.path());
        let plain = predict(&setting.basic, &[], &setting.context).map_err(refused)?;
        let full = predict(&setting.basic, &acting, &setting.context).map_err(refused)?;
        for axis in 0..3 {
            for (place, row) in with.rows.iter().enumerate() {
                one.readings[axis][place] -= full.readings[*row][axis] - plain.readings[*row][axis];
            }
        }
    }
    Ok(all)
}
