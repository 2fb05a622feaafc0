//! Further kinds, and further forms of the kinds in [`super::ALL`].

use super::single::{Single, single, stepped};
use super::{
    age, block, channel, cores, craft, environment, facility, grids, ground, lagging, logger, loops, metal,
    pair, vehicles, warmth,
};
use crate::draw::Draw;
use crate::effect::Effect;
use crate::scene::{Campaign, SceneKind};

const fn form(
    name: &'static str,
    form: &'static str,
    scene: SceneKind,
    make: fn(&Campaign, &mut Draw) -> Effect,
) -> Single {
    Single { form, ..single(name, scene, make) }
}

/// All of them. Name and form together are unique; by them an entry has its group, see [`crate::groups`].
pub const FURTHER: [Single; 84] = [
    form("ageing", "logarithm of age", SceneKind::Coils, |campaign, draw| {
        age::offset(campaign, draw, "relaxation over barriers of all heights", age::logarithm)
    }),
    form("ageing", "stretched exponential", SceneKind::Coils, |campaign, draw| {
        age::offset(campaign, draw, "relaxation with a stretched exponential", age::stretched)
    }),
    form("sensitivity_ageing", "root of time", SceneKind::Coils, |campaign, draw| {
        age::sensitivity(campaign, draw, "voltage reference that ages with the root of time", age::root)
    }),
    form("sensitivity_ageing", "logarithm of age", SceneKind::Coils, |campaign, draw| {
        age::sensitivity(
            campaign,
            draw,
            "feedback coil that relaxes with the logarithm of time",
            age::logarithm,
        )
    }),
    form("axis_creep", "three relaxation times", SceneKind::Coils, block::creeping_glue),
    form("offset_temperature_inflection", "hyperbola", SceneKind::Coils, block::hyperbola),
    form("perming", "distributed thresholds", SceneKind::Coils, loops::perming),
    form("hysteresis", "pinned walls", SceneKind::Coils, loops::pinned_walls),
    form("hysteresis", "play operators", SceneKind::Coils, loops::plays),
    form("offset_temperature_lag", "one body in still air", SceneKind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::one_body)
    }),
    form("offset_temperature_lag", "three bodies", SceneKind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::three_bodies)
    }),
    form("offset_temperature_lag", "diffusion", SceneKind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::diffusion)
    }),
    form("offset_temperature_lag", "thermometer elsewhere", SceneKind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::thermometer_elsewhere)
    }),
    form("sensitivity_temperature_lag", "one body in still air", SceneKind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::one_body)
    }),
    form("sensitivity_temperature_lag", "three bodies", SceneKind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::three_bodies)
    }),
    form("sensitivity_temperature_lag", "diffusion", SceneKind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::diffusion)
    }),
    form("sensitivity_temperature_lag", "thermometer elsewhere", SceneKind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::thermometer_elsewhere)
    }),
    form("offset_electronics_temperature_lag", "two bodies", SceneKind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 1, lagging::two_bodies)
    }),
    form("offset_electronics_temperature_lag", "diffusion", SceneKind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 1, lagging::diffusion)
    }),
    form("sensitivity_electronics_temperature_lag", "two bodies", SceneKind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 1, lagging::two_bodies)
    }),
    form("sensitivity_electronics_temperature_lag", "three bodies", SceneKind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 1, lagging::three_bodies)
    }),
    form("sensitivity_electronics_temperature", "band gap", SceneKind::Coils, channel::bandgap_reference),
    form("sensitivity_electronics_temperature", "divider", SceneKind::Coils, channel::divider),
    form("warm_up", "board and box", SceneKind::Coils, channel::board_and_box),
    form("clipping", "rounded end", SceneKind::Coils, channel::clipping),
    form("delay", "jitter", SceneKind::Fast, channel::uneven_delay),
    form("delay", "mean over a while", SceneKind::Fast, channel::moving_average),
    form("loop_bandwidth", "three poles", SceneKind::Fast, channel::three_poles),
    form("dropout", "value that leaks away", SceneKind::Pair, channel::dropout),
    form("eddy_currents", "two rings", SceneKind::Coils, metal::two_rings),
    form("coil_heating", "ribs and plates", SceneKind::Coils, metal::ribs_and_plates),
    form("coil_gradient", "unequal turns", SceneKind::Coils, metal::unequal_turns),
    form("mains", "changing load", SceneKind::Held, grids::changing_load),
    form("traction_power", "changing load", SceneKind::Held, grids::railway),
    stepped(form("vehicle_pass", "two dipoles", SceneKind::Site, vehicles::two_dipoles), 2.0),
    stepped(form("vehicle_pass", "round a bend", SceneKind::Site, vehicles::round_a_bend), 2.0),
    form("measured_tilt", "tiltmeters askew", SceneKind::Site, ground::measured_tilt),
    form("pillar_tilt", "diffusion", SceneKind::Pair, ground::pillar_tilt),
    form("pillar_settling", "logarithm of age", SceneKind::Pair, ground::pillar_settling),
    form("hysteresis", "loading and unloading", SceneKind::Coils, cores::loaded_and_unloaded),
    form("hysteresis", "weak fields", SceneKind::Coils, cores::weak_fields),
    form("quadratic_nonlinearity", "unlike halves", SceneKind::Coils, cores::unlike_halves),
    form("cubic_nonlinearity", "arctangent", SceneKind::Coils, cores::arctangent),
    form("cross_field", "hard axis", SceneKind::Coils, cores::turned_core),
    form("cross_field_sensitivity", "tilted core", SceneKind::Coils, cores::tilted_core),
    form("offset_temperature", "remanence", SceneKind::Coils, warmth::remanence),
    form("sensitivity_temperature", "finite gain", SceneKind::Coils, warmth::finite_gain),
    form("offset_electronics_temperature", "thermistor", SceneKind::Coils, warmth::thermistor),
    form("offset_temperature_inflection", "two bars", SceneKind::Coils, warmth::two_bars),
    form("axis_temperature", "backlash", SceneKind::Coils, warmth::backlash),
    form("axis_creep", "spread of times", SceneKind::Coils, warmth::resin),
    form("offset_temperature_lag", "sphere", SceneKind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::sphere)
    }),
    form("sensitivity_temperature_lag", "round rod", SceneKind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::rod)
    }),
    form("offset_electronics_temperature_lag", "spread of times", SceneKind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 1, lagging::spread)
    }),
    form("sensitivity_electronics_temperature_lag", "sphere", SceneKind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 1, lagging::sphere)
    }),
    form("warm_up", "still air", SceneKind::Coils, channel::box_in_still_air),
    form("ageing", "two exponentials", SceneKind::Coils, |campaign, draw| {
        age::offset(campaign, draw, "two relaxations, the quicker one nearly over", age::two)
    }),
    form("sensitivity_ageing", "faster when warm", SceneKind::Coils, age::warm_glue),
    form("loop_bandwidth", "digital integrator", SceneKind::Fast, logger::digital_integrator),
    form("delay", "filter with weights", SceneKind::Fast, logger::hann_filter),
    form("clock_offset", "set by a server", SceneKind::Coils, logger::disciplined),
    form("clock_rate", "cubic of temperature", SceneKind::Coils, logger::at_cut),
    form("reading_step", "creep after the step", SceneKind::Coils, logger::creeping_step),
    form("spike", "ringing", SceneKind::Coils, logger::ringing_spike),
    form("quantisation", "dither", SceneKind::Coils, logger::dither),
    form("saturation", "soft end", SceneKind::Coils, logger::soft_end),
    form("eddy_currents", "round rods", SceneKind::Coils, metal::rods),
    form("coil_heating", "still air", SceneKind::Coils, metal::winding_in_still_air),
    form("coil_gradient", "square windings", SceneKind::Coils, metal::square_windings),
    form("nulling_leakage", "proportional loop", SceneKind::Site, facility::proportional_nulling),
    form("mains", "two feeders", SceneKind::Held, grids::two_feeders),
    form("traction_power", "notches", SceneKind::Held, grids::notches),
    stepped(form("vehicle_pass", "wagons", SceneKind::Site, vehicles::wagons), 2.0),
    stepped(form("vehicle_pass", "crossing", SceneKind::Site, vehicles::at_a_crossing), 2.0),
    stepped(
        form("working_hours", "one after another", SceneKind::Site, environment::one_after_another),
        200.0,
    ),
    form("measured_tilt", "bubbles", SceneKind::Site, ground::bubbles),
    form("pillar_tilt", "round pillar", SceneKind::Pair, ground::round_pillar),
    form("pillar_settling", "consolidation", SceneKind::Pair, ground::consolidation),
    form("induction_difference", "half space", SceneKind::Pair, pair::half_space),
    form("stray_current", "metal about the loop", SceneKind::Craft, craft::loop_in_metal),
    form("sun_thermoelectric", "skin and body", SceneKind::Craft, craft::skin_and_body),
    form("sun_thermoelectric_harmonics", "glossy plates", SceneKind::Craft, craft::glossy_plates),
    stepped(form("reaction_wheel", "magnet on the rim", SceneKind::Craft, craft::magnet_on_a_wheel), 0.5),
    stepped(
        form("reaction_wheel_harmonic", "two magnets", SceneKind::Craft, craft::two_magnets_on_a_wheel),
        0.5,
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base;
    use crate::case::{self, Concealed, Labels};
    use crate::scenes::{self, Length};
    use std::collections::BTreeSet;

    /// In its scene every entry adds numbers of which a fresh calibration leaves something, whether the
    /// thermometers go together or apart.
    #[test]
    fn every_entry_shows_in_its_scene() {
        for which in FURTHER {
            for (seed, apart) in [(1, true), (2, false)] {
                let draw = &mut Draw::new(&format!("{}/{}", which.name, which.form), seed);
                let campaign = scenes::campaign(which.scene, Length::Short, apart, which.step_s, draw);
                let effect = (which.make)(&campaign, draw);
                let added = (effect.act)(&campaign, &campaign.plain(), 1.0);
                let left = base::size_left(&campaign, &added);
                let said = format!("{}, {}: {left} nT", which.name, which.form);
                assert!(added.iter().flatten().flatten().all(|value| value.is_finite()), "{said}");
                assert!(left.is_finite() && left > 1e-3, "{said}");
                assert!(
                    effect.accepted.iter().any(|name| name.split(' ').next() == Some(which.name)),
                    "{said}"
                );
            }
        }
    }

    /// The size at which a wanted strength is left can be found for every entry.
    #[test]
    fn every_entry_takes_the_strength_that_is_wanted() {
        for which in FURTHER {
            let (length, strength) = (Length::Short, 1.0);
            let draw = &mut Draw::new(&format!("{}/{}", which.name, which.form), 3);
            let campaign = scenes::campaign(which.scene, length, true, which.step_s, draw);
            let noise = case::noise_of(draw, campaign.runs[0].step_s());
            let effect = (which.make)(&campaign, draw);
            let concealed = Concealed { name: which.name.into(), effect, strength, form_error: 0.0 };
            let labels =
                Labels { case: String::new(), set: String::new(), seed: 3, number: 0, strength, length };
            let truth = case::make(&campaign, noise, vec![concealed], labels, draw).truth;
            let left = truth.effects[0].left_nt / truth.noise_nt;
            assert!((left - strength).abs() < 0.05, "{}, {}: {left}", which.name, which.form);
        }
    }

    #[test]
    fn names_with_forms_are_unique() {
        let all: BTreeSet<_> =
            super::super::ALL.iter().chain(&FURTHER).map(|one| (one.name, one.form)).collect();
        assert_eq!(all.len(), super::super::ALL.len() + FURTHER.len());
    }

    #[test]
    fn at_least_twelve_kinds_are_new() {
        let old: BTreeSet<_> = super::super::ALL.iter().map(|one| one.name).collect();
        let new: BTreeSet<_> =
            FURTHER.iter().map(|one| one.name).filter(|name| !old.contains(name)).collect();
        assert!(new.len() >= 12, "{new:?}");
    }
}
