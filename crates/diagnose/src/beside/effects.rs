//! The causes that were found, as effects of the document.

use common::{Axis, ExplainedEffect, ListedEffect, Quantity};
use explain::{Amplitude, Cause, Form};
use indexmap::IndexMap;
use paired::Acting;
use paired::events::FoundEvent;
use physics::Kind;

use super::readings::Frozen;
use super::{Compared, rms, unrecorded};
use crate::report::described;

/// All that explains something, the largest first.
pub fn effects(compared: &Compared) -> Vec<ExplainedEffect> {
    let causes = compared.of.explained.causes.iter().enumerate();
    let mut effects: Vec<ExplainedEffect> =
        causes.map(|(number, one)| cause(compared, number, one)).collect();
    effects.extend(clock(compared));
    effects.extend(spikes(compared));
    effects.extend(frozen(compared));
    let known = |axis: Option<Axis>| {
        effects.iter().any(|one| one.effect == Kind::Quantisation.name() && one.sensor == axis)
    };
    let coarse: Vec<ExplainedEffect> =
        coarse(compared).into_iter().filter(|one| !known(one.sensor)).collect();
    effects.extend(coarse);
    effects.sort_by(|a, b| b.share.unwrap_or(0.0).total_cmp(&a.share.unwrap_or(0.0)));
    effects
}

pub fn place(effect: &ExplainedEffect) -> &'static str {
    Kind::named(&effect.effect).map_or("sensor", |kind| kind.place().word())
}

pub fn cause(compared: &Compared, number: usize, one: &Amplitude) -> ExplainedEffect {
    let explained = &compared.of.explained;
    let contribution: f64 = explained.contributions[number].iter().map(|channel| rms(channel).powi(2)).sum();
    let before: f64 = explained.before.iter().map(|channel| rms(channel).powi(2)).sum();
    let column = match one.cause {
        Cause::Covariate(number) => Some(compared.covariate(number).name.clone()),
        _ => None,
    };
    let sensor = match one.cause {
        Cause::Course(number) if !matches!(compared.of.acting[number], Acting::Step(_)) => {
            unrecorded::sensor(compared, one.cause)
        }
        Cause::Course(_) | Cause::Time => {
            alone(compared, one.channels.iter().filter_map(|sizes| sizes.first()))
        }
        _ => None,
    };
    let kind = kind(compared, one.cause, one.form);
    let form = Form { late_s: one.late_s.as_ref().map_or(0.0, Quantity::value), ..one.form };
    ExplainedEffect {
        title: match &column {
            Some(column) => format!("{} follows {column}{}", compared.what, paired::lateness(&form)),
            None => in_sensor(kind, sensor).unwrap_or_else(|| kind.about().title.into()),
        },
        sensor,
        parameters: parameters(compared, one, column.as_deref()),
        column: column.or_else(|| unrecorded::column(compared, one.cause).map(str::to_string)),
        p_adjusted: (-explained.gains[number]).exp().min(1.0),
        // A delay and a loop are as probable.
        probability: Some(
            explained.probabilities[number].min(1.0)
                * unrecorded::loop_name(compared, one.cause).map_or(1.0, |_| 0.5),
        ),
        share: Some((contribution / before).min(1.0)),
        held_out_gain_nt: explained.held_out_gains[number],
        visible_fraction: 1.0,
        ..described(kind)
    }
}

/// What an effect does in one sensor.
fn in_sensor(kind: Kind, sensor: Option<Axis>) -> Option<String> {
    sensor.map(|axis| format!("{} (sensor {axis})", kind.about().title))
}

/// The effect that a cause is in a form: of a current that acts at once the catalogue has the field.
pub fn kind(compared: &Compared, cause: Cause, form: Form) -> Kind {
    match cause {
        Cause::Covariate(number)
            if compared.covariate(number).name.ends_with("_a") && form == Form::default() =>
        {
            Kind::StrayCurrent
        }
        Cause::Covariate(_) => Kind::Dependence,
        Cause::Course(_) => unrecorded::kind(compared, cause).unwrap_or(Kind::Empirical),
        Cause::Time if form.late_s > 0.0 => Kind::WarmUp,
        Cause::Time => Kind::Ageing,
        Cause::Clock => Kind::ClockOffset,
    }
}

fn parameters(compared: &Compared, one: &Amplitude, column: Option<&str>) -> IndexMap<String, Quantity> {
    if let Cause::Course(_) = one.cause {
        return unrecorded::parameters(compared, one);
    }
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
    let mut all = compared.by_axis(one, &names);
    all.values_mut().for_each(|quantity| *quantity = by(quantity));
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

impl Compared {
    /// The amplitudes of a cause by the axis of the channel, those of each under these names.
    pub fn by_axis<N: std::fmt::Display>(&self, one: &Amplitude, names: &[N]) -> IndexMap<String, Quantity> {
        let mut all = IndexMap::new();
        for (quantities, (_, axis)) in one.channels.iter().zip(&self.channels) {
            let axis = axis.map_or("along_field", Axis::letter);
            for (name, quantity) in names.iter().zip(quantities) {
                all.insert(format!("{axis}_{name}"), quantity.clone());
            }
        }
        all
    }
}

/// Readings that freeze, as one effect for each sensor.
fn frozen(compared: &Compared) -> Vec<ExplainedEffect> {
    let of = |axis: Axis| {
        let listed = |frozen: &Frozen| {
            let moments = [("time_s", frozen.time_s), ("duration_s", frozen.duration_s)];
            let parameters = moments.map(|(name, value)| (name.to_string(), Quantity::Bare(value)));
            ListedEffect { parameters: IndexMap::from(parameters), ..ListedEffect::default() }
        };
        let own = compared.frozen.iter().filter(|frozen| frozen.axis == axis);
        found_apart(compared, Kind::Dropout, own.map(listed).collect(), Some(axis))
    };
    Axis::ALL.into_iter().filter_map(of).collect()
}

/// Rounding that is at least this share of what is left explains it.
const ROUNDING: f64 = 0.3;

/// Coarse codes whose rounding is a good part of what is left, as one effect for each sensor.
fn coarse(compared: &Compared) -> Vec<ExplainedEffect> {
    let explained = &compared.of.explained;
    let of = |&(axis, width): &(Axis, f64)| {
        let channel = compared.channels.iter().position(|(_, own)| own.is_none_or(|own| own == axis))?;
        // Beside a magnitude by what the sensor shows in it.
        let shows = compared.channels[channel].1.map_or(explained.base[channel][axis.index()].0, |_| 1.0);
        let share = (width * shows / rms(&explained.residual[channel])).powi(2) / 12.0;
        let parameters = IndexMap::from([("width_nt".to_string(), Quantity::Bare(width))]);
        let listed = ListedEffect { parameters, ..ListedEffect::default() };
        let found = found_apart(compared, Kind::Quantisation, vec![listed], Some(axis))?;
        (share >= ROUNDING).then(|| ExplainedEffect { share: Some(share.min(1.0)), ..found })
    };
    compared.coarse.iter().filter_map(of).collect()
}

/// A reading stands alone where it is off by so many times the largest of what else is left.
const ALONE: f64 = 2.0;

/// Single readings that stand alone, as one effect for each sensor; beside a magnitude they may be of any.
fn spikes(compared: &Compared) -> Vec<ExplainedEffect> {
    let left = |channel: usize| {
        compared.of.explained.residual[channel].iter().fold(0.0_f64, |most, left| most.max(left.abs()))
    };
    let of_channel = |channel: usize| {
        let own = |event: &&FoundEvent| {
            (compared.channels.len() == 1 || event.axis == channel)
                && event.size.abs() > ALONE * left(channel)
        };
        let own = compared.of.spikes.iter().filter(own);
        let listed = |event: &FoundEvent| {
            let height = ("height_nt".to_string(), Quantity::new(event.size, event.std));
            let time = ("time_s".to_string(), Quantity::Bare(compared.of.frame.time_s(event.from)));
            ListedEffect { parameters: IndexMap::from([height, time]), ..ListedEffect::default() }
        };
        found_apart(compared, Kind::Spike, own.map(listed).collect(), compared.channels[channel].1)
    };
    (0..compared.channels.len()).filter_map(of_channel).collect()
}

/// What was found at moments, as one effect; None where there is nothing.
fn found_apart(
    compared: &Compared,
    kind: Kind,
    mut list: Vec<ListedEffect>,
    sensor: Option<Axis>,
) -> Option<ExplainedEffect> {
    let parameters = match list.len() {
        0 => return None,
        1 => list.remove(0).parameters,
        _ => IndexMap::new(),
    };
    Some(ExplainedEffect {
        title: in_sensor(kind, sensor)
            .unwrap_or_else(|| format!("{}: {}", compared.what, kind.about().title)),
        sensor,
        parameters,
        list,
        probability: Some(1.0),
        visible_fraction: 1.0,
        ..described(kind)
    })
}

/// Uncertainties from which on something shows in a sensor, and from which on it may.
const SHOWS: f64 = 4.0;
const MAY_SHOW: f64 = 2.6;

/// The one sensor in which something shows; None where it does in more, or may.
fn alone<'q>(compared: &Compared, sizes: impl Iterator<Item = &'q Quantity>) -> Option<Axis> {
    let over = |size: &Quantity| size.std().map_or(0.0, |std| (size.value() / std).abs());
    let over: Vec<f64> = sizes.map(over).collect();
    let shows: Vec<usize> = (0..over.len()).filter(|channel| over[*channel] > MAY_SHOW).collect();
    let [channel] = shows[..] else { return None };
    compared.channels[channel].1.filter(|_| over[channel] > SHOWS)
}

pub fn times(quantity: &Quantity, by: f64) -> Quantity {
    match quantity.std() {
        Some(std) => Quantity::new(quantity.value() * by, std * by),
        None => Quantity::Bare(quantity.value() * by),
    }
}

/// Uncertainties within which a clock was right at the beginning.
const WITHIN: f64 = 2.0;

/// The clock's offset, and its rate: a rate alone where it was right at the beginning.
pub fn clock(compared: &Compared) -> Option<ExplainedEffect> {
    let clock = compared.of.clock.as_ref()?;
    let half_s = 0.5 * compared.of.problem.length_s();
    let offset = &clock.difference.offset_s;
    let [offset_s, offset_std] = [offset.value(), offset.std().unwrap_or(0.0)];
    let began_right = |rate: &&Quantity| {
        let std = offset_std.hypot(half_s * rate.std().unwrap_or(0.0));
        (offset_s - half_s * rate.value()).abs() < WITHIN * std
    };
    let only_rate = clock.rate.as_ref().filter(began_right).is_some();
    let kind = if only_rate { Kind::ClockRate } else { Kind::ClockOffset };
    let mut parameters = IndexMap::from([("offset_s".to_string(), offset.clone())]);
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
        title: format!("the clock of {} {is}", compared.what),
        parameters,
        p_adjusted: (-clock.gain).exp().min(1.0),
        probability: Some(1.0),
        visible_fraction: 1.0,
        ..described(kind)
    })
}
