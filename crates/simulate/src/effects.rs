//! The catalogue of effects, for people and for programs.

use clap::ValueEnum;
use common::{Error, to_text};
use physics::{About, Acts, Family, Kind, ParameterInfo, Role};
use serde_json::{Value, json};

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

fn entry(kind: Kind) -> Value {
    let about = kind.about();
    json!({
        "effect": about.name,
        "title": about.title,
        "physics": about.physics,
        "equation": about.equation,
        "source": about.source,
        "family": about.family.word(),
        "place": about.place.word(),
        "acts_on": acts_on(about.acts),
        "parameters": about.parameters.iter().map(parameter).collect::<Vec<Value>>(),
        "needs": about.needs,
        "invertible": kind.invertible(),
    })
}

fn parameter(info: &ParameterInfo) -> Value {
    let mut all = json!({"name": info.name});
    if !info.is_moment() {
        all["plausible"] = json!([info.low, info.high]);
    }
    all["role"] = match info.role {
        Role::Amplitude => "amplitude",
        Role::Shape => "shape",
        Role::Epoch => "epoch",
    }
    .into();
    if let Some(absent) = info.absent {
        all["absent"] = absent.into();
    }
    all
}

fn acts_on(acts: Acts) -> &'static str {
    match acts {
        Acts::OneSensor => "sensor",
        Acts::OneCoil => "coil",
        Acts::Everything => "all",
        Acts::WithColumn(_) => "column",
    }
}

fn of(kinds: &[Kind], family: Family) -> impl Iterator<Item = Kind> {
    family.members().filter(|kind| kinds.contains(kind))
}

/// The parameters with their plausible sizes, each name between two marks.
fn parameters(about: &About, mark: &str, between: &str) -> String {
    let one = |info: &ParameterInfo| {
        let sizes = (!info.is_moment()).then(|| format!("{} to {}", info.low, info.high));
        let sizes = sizes.unwrap_or("(of the recording)".into());
        let absent = info.absent.map(|value| format!(" ({value} where it is not given)")).unwrap_or_default();
        format!("{mark}{}{mark} {sizes}{absent}", info.name)
    };
    about.parameters.iter().map(one).collect::<Vec<String>>().join(between)
}

fn table(kinds: &[Kind]) -> String {
    let mut text = String::new();
    for family in Family::ALL {
        for (number, kind) in of(kinds, family).enumerate() {
            if number == 0 {
                text += &format!("{}\n", family.word());
            }
            let about = kind.about();
            text += &format!("  {}: {}\n", about.name, about.title);
            for line in [about.equation, &parameters(about, "", "; "), about.source] {
                text += &format!("      {line}\n");
            }
        }
    }
    text
}

fn markdown(kinds: &[Kind]) -> String {
    let mut text = String::from(HEAD);
    for family in Family::ALL {
        let heading = capital(&family.word().replace('_', " "));
        let (title, apart) = (capital(family.title()), family.told_apart_by());
        text += &format!("\n## {heading}\n\n{title} (`{}`). {apart}\n", family.word());
        for kind in of(kinds, family) {
            let About { name, title, physics, equation, source, place, acts, needs, .. } = kind.about();
            text += &format!("\n### `{name}`\n\n{}. {physics}\n\n", capital(title));
            text += &format!("```text\n{equation}\n```\n\n");
            let key = match acts_on(*acts) {
                "all" => "nothing".to_string(),
                key => format!("`{key}`"),
            };
            let parameters = parameters(kind.about(), "`", ", ");
            text += &format!("- Of the {}. Takes {key}; parameters {parameters}.\n", place.word());
            if !needs.is_empty() {
                // A column's name as code, words as words.
                let code =
                    |need: &&str| if need.contains(' ') { need.to_string() } else { format!("`{need}`") };
                let needs: Vec<String> = needs.iter().map(code).collect();
                text += &format!("- Needs {}.\n", needs.join(", "));
            }
            if !kind.invertible() {
                text += "- Has no inverse: many fields give one reading.\n";
            }
            text += &format!("- Source: {source}.\n");
        }
    }
    text
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
