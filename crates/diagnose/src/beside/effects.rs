//! The causes that were found, as effects of the document.

use common::{ExplainedEffect, ListedEffect, Quantity};
use explain::{Amplitude, Cause, Form};
use indexmap::IndexMap;
use physics::Kind;

use super::{Compared, rms};

/// All that explains something, the largest first.
pub fn effects(compared: &Compared) -> Vec<ExplainedEffect> {
    let mut effects: Vec<ExplainedEffect> = compared
        .explained
        .causes
        .iter()
        .enumerate()
        .map(|(number, one)| cause(compared, number, one))
        .collect();
    effects.extend(clock(compared));
    effects.extend(steps(compared));
    effects.sort_by(|a, b| b.share.unwrap_or(0.0).total_cmp(&a.share.unwrap_or(0.0)));
    effects
}

/// Where an effect acts.
pub fn place(effect: &ExplainedEffect) -> &'static str {
    Kind::named(&effect.effect).map_or("sensor", |kind| kind.place().word())
}

fn cause(compared: &Compared, number: usize, one: &Amplitude) -> ExplainedEffect {
    let explained = &compared.explained;
    let contribution: f64 = explained.contributions[number].iter().map(|channel| rms(channel).powi(2)).sum();
    let before: f64 = explained.before.iter().map(|channel| rms(channel).powi(2)).sum();
    let column = match one.cause {
        Cause::Covariate(number) => Some(compared.covariates[number].clone()),
        _ => None,
    };
    let about = kind(compared, one.cause, one.form).about();
    let follows = match &column {
        Some(column) => format!("follows {column}"),
        None => about.title.to_string(),
    };
    let form = Form { late_s: one.late_s.as_ref().map_or(0.0, Quantity::value), ..one.form };
    ExplainedEffect {
        effect: about.name.into(),
        title: match &column {
            Some(_) => format!("{} {follows}{}", compared.what, paired::lateness(&form)),
            None => follows,
        },
        physics: about.physics.into(),
        equation: about.equation.into(),
        source: about.source.into(),
        parameters: parameters(compared, one, column.as_deref()),
        column,
        p_adjusted: (-explained.gains[number]).exp().min(1.0),
        probability: Some(explained.probabilities[number].min(1.0)),
        share: Some((contribution / before).min(1.0)),
        held_out_gain_nt: explained.held_out_gains[number],
        visible_fraction: 1.0,
        ..ExplainedEffect::default()
    }
}

/// The effect that a cause is in a form: of a current that acts at once the catalogue has the field.
pub fn kind(compared: &Compared, cause: Cause, form: Form) -> Kind {
    match cause {
        Cause::Covariate(number)
            if compared.covariates[number].ends_with("_a") && form == Form::default() =>
        {
            Kind::StrayCurrent
        }
        Cause::Covariate(_) => Kind::Dependence,
        Cause::Time if form.late_s > 0.0 => Kind::WarmUp,
        Cause::Time => Kind::Ageing,
        Cause::Clock => Kind::ClockOffset,
    }
}

fn parameters(compared: &Compared, one: &Amplitude, column: Option<&str>) -> IndexMap<String, Quantity> {
    let mut all = IndexMap::new();
    let of_axis = |channel: usize| match compared.channels[channel].1 {
        Some(axis) => axis.to_string(),
        None => "along_field".into(),
    };
    let names: Vec<String> = match (one.cause, column) {
        (Cause::Covariate(_), Some(column)) => {
            let unit = common::unit::of_change(column);
            let second =
                if one.form.fast { format!("fast_nt_per_{unit}") } else { format!("nt_per_{unit}_2") };
            vec![format!("nt_per_{unit}"), second]
        }
        (Cause::Time, _) if one.form.late_s > 0.0 => vec!["amplitude_nt".into()],
        (Cause::Time, _) => vec!["nt_per_day".into()],
        _ => ["from_x", "from_y", "from_z"].map(|from| format!("{from}_ppm")).to_vec(),
    };
    let by = |quantity: &Quantity| match one.cause {
        Cause::Time if one.form.late_s == 0.0 => {
            times(quantity, 86_400.0_f64.powf(one.form.power.unwrap_or(1.0)))
        }
        _ => quantity.clone(),
    };
    for (channel, quantities) in one.channels.iter().enumerate() {
        for (name, quantity) in names.iter().zip(quantities) {
            all.insert(format!("{}_{name}", of_axis(channel)), by(quantity));
        }
    }
    if let Some(late_s) = &one.late_s {
        let name = if one.cause == Cause::Time { "time_constant_s" } else { "lag_s" };
        all.insert(name.into(), late_s.clone());
    }
    if let Some(power) = one.form.power {
        all.insert("exponent".into(), Quantity::Bare(power));
    }
    if one.form.rows != 0 {
        all.insert("late_rows".into(), Quantity::Bare(f64::from(one.form.rows)));
    }
    all
}

fn times(quantity: &Quantity, by: f64) -> Quantity {
    match quantity.std() {
        Some(std) => Quantity::new(quantity.value() * by, std * by),
        None => Quantity::Bare(quantity.value() * by),
    }
}

/// Uncertainties within which a clock was right at the beginning.
const WITHIN: f64 = 2.0;

/// The clock's offset, and its rate: a rate alone where it was right at the beginning.
fn clock(compared: &Compared) -> Option<ExplainedEffect> {
    let clock = compared.clock.as_ref()?;
    let half_s =
        0.5 * compared.time_s.last().zip(compared.time_s.first()).map_or(0.0, |(last, first)| last - first);
    let [offset_s, offset_std] = [clock.offset_s.value(), clock.offset_s.std().unwrap_or(0.0)];
    let began_right = |rate: &&Quantity| {
        let std = offset_std.hypot(half_s * rate.std().unwrap_or(0.0));
        (offset_s - half_s * rate.value()).abs() < WITHIN * std
    };
    let only_rate = clock.rate.as_ref().filter(began_right).is_some();
    let kind = if only_rate { Kind::ClockRate } else { Kind::ClockOffset };
    let mut parameters = IndexMap::from([("offset_s".to_string(), clock.offset_s.clone())]);
    if let Some(rate) = &clock.rate {
        parameters.insert("rate_ppm".into(), times(rate, 1e6));
    }
    let is = match (only_rate, offset_s >= 0.0) {
        (false, true) => "is late",
        (false, false) => "is early",
        (true, true) => "gains",
        (true, false) => "loses",
    };
    Some(ExplainedEffect {
        effect: kind.name().into(),
        title: format!("the clock of {} {is}", compared.what),
        physics: kind.about().physics.into(),
        equation: kind.about().equation.into(),
        source: kind.about().source.into(),
        parameters,
        p_adjusted: (-clock.gain).exp().min(1.0),
        probability: Some(1.0),
        visible_fraction: 1.0,
        ..ExplainedEffect::default()
    })
}

/// All changes of level as one effect.
fn steps(compared: &Compared) -> Option<ExplainedEffect> {
    let steps = &compared.explained.steps;
    if steps.is_empty() {
        return None;
    }
    let kind = Kind::ReadingStep;
    let listed = |step: &explain::Step| {
        let mut parameters = IndexMap::new();
        for (channel, (size, std)) in step.sizes.iter().enumerate() {
            let name = match compared.channels[channel].1 {
                Some(axis) => format!("{axis}_height_nt"),
                None => "height_nt".into(),
            };
            parameters.insert(name, Quantity::new(*size, *std));
        }
        parameters.insert("time_s".into(), Quantity::Bare(compared.time_s[step.row]));
        ListedEffect { parameters, ..ListedEffect::default() }
    };
    let mut list: Vec<ListedEffect> = steps.iter().map(listed).collect();
    let parameters = if list.len() == 1 { list.remove(0).parameters } else { IndexMap::new() };
    Some(ExplainedEffect {
        effect: kind.name().into(),
        title: format!("{} steps", compared.what),
        physics: kind.about().physics.into(),
        equation: kind.about().equation.into(),
        source: kind.about().source.into(),
        parameters,
        list,
        p_adjusted: 0.0,
        probability: Some(1.0),
        visible_fraction: 1.0,
        ..ExplainedEffect::default()
    })
}
