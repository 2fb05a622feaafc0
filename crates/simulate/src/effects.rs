//! The catalogue of effects, for people and for programs.

use clap::ValueEnum;
use common::{Error, to_text};
use physics::{Acts, Family, Kind, ParameterInfo, Role};
use serde::Serialize;

/// How the catalogue is laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Layout {
    /// For people.
    #[default]
    Table,
    /// For programs.
    Json,
    /// The page in docs/.
    Markdown,
}

#[derive(Serialize)]
struct Entry {
    effect: &'static str,
    title: &'static str,
    physics: &'static str,
    equation: &'static str,
    source: &'static str,
    family: &'static str,
    place: &'static str,
    acts_on: &'static str,
    parameters: Vec<Parameter>,
    needs: &'static [&'static str],
    invertible: bool,
}

#[derive(Serialize)]
struct Parameter {
    name: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    plausible: Option<[f64; 2]>,
    role: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    absent: Option<f64>,
}

/// The effects of that name, or all, in a layout.
pub fn catalogue(name: Option<&str>, layout: Layout) -> Result<String, Error> {
    let kinds: Vec<Kind> = match name {
        None => Kind::ALL.to_vec(),
        Some(name) => vec![Kind::known(name).map_err(Error::Request)?],
    };
    Ok(match layout {
        Layout::Table => table(&kinds),
        Layout::Json => to_text(&kinds.iter().map(|kind| entry(*kind)).collect::<Vec<_>>()),
        Layout::Markdown => markdown(&kinds),
    })
}

fn entry(kind: Kind) -> Entry {
    let about = kind.about();
    let parameter = |info: &ParameterInfo| Parameter {
        name: info.name,
        plausible: (!info.is_moment()).then_some([info.low, info.high]),
        role: role(info.role),
        absent: info.absent,
    };
    Entry {
        effect: about.name,
        title: about.title,
        physics: about.physics,
        equation: about.equation,
        source: about.source,
        family: about.family.word(),
        place: about.place.word(),
        acts_on: acts_on(about.acts),
        parameters: about.parameters.iter().map(parameter).collect(),
        needs: about.needs,
        invertible: kind.invertible(),
    }
}

fn acts_on(acts: Acts) -> &'static str {
    match acts {
        Acts::OneSensor => "sensor",
        Acts::OneCoil => "coil",
        Acts::Everything => "all",
        Acts::WithColumn(_) => "column",
    }
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Amplitude => "amplitude",
        Role::Shape => "shape",
        Role::Epoch => "epoch",
    }
}

fn of(kinds: &[Kind], family: Family) -> impl Iterator<Item = Entry> {
    family.members().filter(|kind| kinds.contains(kind)).map(entry)
}

fn plausible(parameter: &Parameter) -> String {
    let sizes = match parameter.plausible {
        Some([low, high]) => format!("{low} to {high}"),
        None => "(of the recording)".into(),
    };
    match parameter.absent {
        Some(value) => format!("{sizes} ({value} where it is not given)"),
        None => sizes,
    }
}

fn table(kinds: &[Kind]) -> String {
    let mut text = String::new();
    for family in Family::ALL {
        for (number, entry) in of(kinds, family).enumerate() {
            if number == 0 {
                text += &format!("{}\n", family.word());
            }
            let parameter = |parameter: &Parameter| format!("{} {}", parameter.name, plausible(parameter));
            let parameters: Vec<String> = entry.parameters.iter().map(parameter).collect();
            text += &format!("  {}: {}\n", entry.effect, entry.title);
            text += &format!("      {}\n", entry.equation);
            text += &format!("      {}\n", parameters.join("; "));
            text += &format!("      {}\n", entry.source);
        }
    }
    text
}

fn markdown(kinds: &[Kind]) -> String {
    let mut text = String::from(HEAD);
    for family in Family::ALL {
        let heading = capital(&family.word().replace('_', " "));
        text += &format!(
            "\n## {heading}\n\n{} (`{}`). {}\n",
            capital(family.title()),
            family.word(),
            family.told_apart_by()
        );
        for entry in of(kinds, family) {
            text += &format!("\n### `{}`\n\n{}. {}\n\n", entry.effect, capital(entry.title), entry.physics);
            text += &format!("```text\n{}\n```\n\n", entry.equation);
            let key = match entry.acts_on {
                "all" => "nothing".to_string(),
                key => format!("`{key}`"),
            };
            let parameter = |parameter: &Parameter| format!("`{}` {}", parameter.name, plausible(parameter));
            let parameters: Vec<String> = entry.parameters.iter().map(parameter).collect();
            text +=
                &format!("- Of the {}. Takes {key}; parameters {}.\n", entry.place, parameters.join(", "));
            if !entry.needs.is_empty() {
                let needs: Vec<String> = entry.needs.iter().map(|need| code(need)).collect();
                text += &format!("- Needs {}.\n", needs.join(", "));
            }
            if !entry.invertible {
                text += "- Has no inverse: many fields give one reading.\n";
            }
            text += &format!("- Source: {}.\n", entry.source);
        }
    }
    text
}

/// A column's name as code, words as words.
fn code(need: &str) -> String {
    if need.contains(' ') { need.into() } else { format!("`{need}`") }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

const HEAD: &str = "# The effects\n\n\
    Effects that a first model of a magnetometer leaves out. Each effect is one definition in `crates/physics/src/effects`, used for\n\
    simulation, fit and correction alike. This page is made by `simulate effects --layout markdown`.\n\n\
    A document adopts an effect under `model.effects`; a plan includes it under `truth.model.effects`:\n\n\
    ```json\n\
    {\"effect\": \"offset_temperature_lag\", \"sensor\": \"x\", \"parameters\": {\"coefficient_nt_per_k\": 1.3, \"lag_s\": 900}}\n\
    ```\n\n\
    **Target.** An effect takes `sensor` or `coil` if it acts on one, `column` if it follows a housekeeping column, and nothing if it acts\n\
    on all. With `recording` it acts in that recording only.\n\n\
    **Families.** Effects are ordered by kind of physics. Where recordings do not determine which member acts, or in which form,\n\
    `diagnose` names the family, with the probability of each member. Each family begins with the recording that tells its members\n\
    apart.\n\n\
    **Order.** Effects act in the order of the signal: coil, field in GEO, sensor block, sensor, electronics, logger; at one place in\n\
    the order in which they are listed.\n\n\
    **Symbols.** B is the field along the sensor at that place, dB what is added to it, in nT. T_S, T_E and T_C are\n\
    `sensor_temperature_c`, `electronics_temperature_c` and `coil_temperature_c`, T_ref the reference conditions. t counts on the\n\
    campaign's clock: from the earliest `start` of the document, or as `time_s` where recordings have none. Moments (`time_s`) count from\n\
    the zero of the recording. The letters of an equation are in the order of its parameters, matrices row by row; the ranges are\n\
    plausible sizes, not limits.\n\n\
    **Memory** begins anew with each recording: a temperature in equilibrium with its first row, a field as it moves there. Between samples\n\
    a signal is the cubic whose slopes are the central differences. A step more than four times as long as a neighbour is a gap, and\n\
    the signal is straight there. Where a drive is held before or after a jump, the slope is zero.\n";
