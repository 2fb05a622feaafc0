//! Further kinds, and further forms of the kinds in [`super::ALL`].

use super::{
    Single, age, block, channel, cores, craft, environment, facility, grids, ground, lagging, logger, loops,
    metal, pair, single, stepped, vehicles, warmth,
};
use crate::draw::Draw;
use crate::effect::Effect;
use crate::scene::{Campaign, Kind};

const fn form(
    name: &'static str,
    form: &'static str,
    scene: Kind,
    make: fn(&Campaign, &mut Draw) -> Effect,
) -> Single {
    Single { form, ..single(name, scene, make) }
}

/// All of them. Name and form together are unique; by them an entry has its group, see [`crate::groups`].
pub const FURTHER: [Single; 84] = [
    form("ageing", "logarithm of age", Kind::Coils, |campaign, draw| {
        age::offset(campaign, draw, "relaxation over barriers of all heights", age::logarithm)
    }),
    form("ageing", "stretched exponential", Kind::Coils, |campaign, draw| {
        age::offset(campaign, draw, "relaxation with a stretched exponential", age::stretched)
    }),
    form("sensitivity_ageing", "root of time", Kind::Coils, |campaign, draw| {
        age::sensitivity(campaign, draw, "voltage reference that ages with the root of time", age::root)
    }),
    form("sensitivity_ageing", "logarithm of age", Kind::Coils, |campaign, draw| {
        age::sensitivity(
            campaign,
            draw,
            "feedback coil that relaxes with the logarithm of time",
            age::logarithm,
        )
    }),
    form("axis_creep", "three relaxation times", Kind::Coils, block::creeping_glue),
    form("offset_temperature_inflection", "hyperbola", Kind::Coils, block::hyperbola),
    form("perming", "distributed thresholds", Kind::Coils, loops::perming),
    form("hysteresis", "pinned walls", Kind::Coils, loops::pinned_walls),
    form("hysteresis", "play operators", Kind::Coils, loops::plays),
    form("offset_temperature_lag", "one body in still air", Kind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::one_body)
    }),
    form("offset_temperature_lag", "three bodies", Kind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::three_bodies)
    }),
    form("offset_temperature_lag", "diffusion", Kind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::diffusion)
    }),
    form("offset_temperature_lag", "thermometer elsewhere", Kind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::thermometer_elsewhere)
    }),
    form("sensitivity_temperature_lag", "one body in still air", Kind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::one_body)
    }),
    form("sensitivity_temperature_lag", "three bodies", Kind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::three_bodies)
    }),
    form("sensitivity_temperature_lag", "diffusion", Kind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::diffusion)
    }),
    form("sensitivity_temperature_lag", "thermometer elsewhere", Kind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::thermometer_elsewhere)
    }),
    form("offset_electronics_temperature_lag", "two bodies", Kind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 1, lagging::two_bodies)
    }),
    form("offset_electronics_temperature_lag", "diffusion", Kind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 1, lagging::diffusion)
    }),
    form("sensitivity_electronics_temperature_lag", "two bodies", Kind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 1, lagging::two_bodies)
    }),
    form("sensitivity_electronics_temperature_lag", "three bodies", Kind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 1, lagging::three_bodies)
    }),
    form("sensitivity_electronics_temperature", "band gap", Kind::Coils, channel::bandgap_reference),
    form("sensitivity_electronics_temperature", "divider", Kind::Coils, channel::divider),
    form("warm_up", "board and box", Kind::Coils, channel::board_and_box),
    form("clipping", "rounded end", Kind::Coils, channel::clipping),
    form("delay", "jitter", Kind::Fast, channel::uneven_delay),
    form("delay", "mean over a while", Kind::Fast, channel::moving_average),
    form("loop_bandwidth", "three poles", Kind::Fast, channel::three_poles),
    form("dropout", "value that leaks away", Kind::Pair, channel::dropout),
    form("eddy_currents", "two rings", Kind::Coils, metal::two_rings),
    form("coil_heating", "ribs and plates", Kind::Coils, metal::ribs_and_plates),
    form("coil_gradient", "unequal turns", Kind::Coils, metal::unequal_turns),
    form("mains", "changing load", Kind::Held, grids::changing_load),
    form("traction_power", "changing load", Kind::Held, grids::railway),
    stepped(form("vehicle_pass", "two dipoles", Kind::Site, vehicles::two_dipoles), 2.0),
    stepped(form("vehicle_pass", "round a bend", Kind::Site, vehicles::round_a_bend), 2.0),
    form("measured_tilt", "tiltmeters askew", Kind::Site, ground::measured_tilt),
    form("pillar_tilt", "diffusion", Kind::Pair, ground::pillar_tilt),
    form("pillar_settling", "logarithm of age", Kind::Pair, ground::pillar_settling),
    form("hysteresis", "loading and unloading", Kind::Coils, cores::loaded_and_unloaded),
    form("hysteresis", "weak fields", Kind::Coils, cores::weak_fields),
    form("quadratic_nonlinearity", "unlike halves", Kind::Coils, cores::unlike_halves),
    form("cubic_nonlinearity", "arctangent", Kind::Coils, cores::arctangent),
    form("cross_field", "hard axis", Kind::Coils, cores::turned_core),
    form("cross_field_sensitivity", "tilted core", Kind::Coils, cores::tilted_core),
    form("offset_temperature", "remanence", Kind::Coils, warmth::remanence),
    form("sensitivity_temperature", "finite gain", Kind::Coils, warmth::finite_gain),
    form("offset_electronics_temperature", "thermistor", Kind::Coils, warmth::thermistor),
    form("offset_temperature_inflection", "two bars", Kind::Coils, warmth::two_bars),
    form("axis_temperature", "backlash", Kind::Coils, warmth::backlash),
    form("axis_creep", "spread of times", Kind::Coils, warmth::resin),
    form("offset_temperature_lag", "sphere", Kind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 0, lagging::sphere)
    }),
    form("sensitivity_temperature_lag", "round rod", Kind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 0, lagging::rod)
    }),
    form("offset_electronics_temperature_lag", "spread of times", Kind::Coils, |campaign, draw| {
        lagging::offset(campaign, draw, 1, lagging::spread)
    }),
    form("sensitivity_electronics_temperature_lag", "sphere", Kind::Coils, |campaign, draw| {
        lagging::sensitivity(campaign, draw, 1, lagging::sphere)
    }),
    form("warm_up", "still air", Kind::Coils, channel::box_in_still_air),
    form("ageing", "two exponentials", Kind::Coils, |campaign, draw| {
        age::offset(campaign, draw, "two relaxations, the quicker one nearly over", age::two)
    }),
    form("sensitivity_ageing", "faster when warm", Kind::Coils, age::warm_glue),
    form("loop_bandwidth", "digital integrator", Kind::Fast, logger::digital_integrator),
    form("delay", "filter with weights", Kind::Fast, logger::hann_filter),
    form("clock_offset", "set by a server", Kind::Coils, logger::disciplined),
    form("clock_rate", "cubic of temperature", Kind::Coils, logger::at_cut),
    form("reading_step", "creep after the step", Kind::Coils, logger::creeping_step),
    form("spike", "ringing", Kind::Coils, logger::ringing_spike),
    form("quantisation", "dither", Kind::Coils, logger::dither),
    form("saturation", "soft end", Kind::Coils, logger::soft_end),
    form("eddy_currents", "round rods", Kind::Coils, metal::rods),
    form("coil_heating", "still air", Kind::Coils, metal::winding_in_still_air),
    form("coil_gradient", "square windings", Kind::Coils, metal::square_windings),
    form("nulling_leakage", "proportional loop", Kind::Site, facility::proportional_nulling),
    form("mains", "two feeders", Kind::Held, grids::two_feeders),
    form("traction_power", "notches", Kind::Held, grids::notches),
    stepped(form("vehicle_pass", "wagons", Kind::Site, vehicles::wagons), 2.0),
    stepped(form("vehicle_pass", "crossing", Kind::Site, vehicles::at_a_crossing), 2.0),
    stepped(form("working_hours", "one after another", Kind::Site, environment::one_after_another), 200.0),
    form("measured_tilt", "bubbles", Kind::Site, ground::bubbles),
    form("pillar_tilt", "round pillar", Kind::Pair, ground::round_pillar),
    form("pillar_settling", "consolidation", Kind::Pair, ground::consolidation),
    form("induction_difference", "half space", Kind::Pair, pair::half_space),
    form("stray_current", "metal about the loop", Kind::Craft, craft::loop_in_metal),
    form("sun_thermoelectric", "skin and body", Kind::Craft, craft::skin_and_body),
    form("sun_thermoelectric_harmonics", "glossy plates", Kind::Craft, craft::glossy_plates),
    stepped(form("reaction_wheel", "magnet on the rim", Kind::Craft, craft::magnet_on_a_wheel), 0.5),
    stepped(form("reaction_wheel_harmonic", "two magnets", Kind::Craft, craft::two_magnets_on_a_wheel), 0.5),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base;
    use crate::case::{self, Concealed, Labels};
    use crate::scenes::{self, Length};
    use std::collections::BTreeSet;

    /// In its scene every entry adds numbers of which a fresh calibration leaves something, whether the thermometers go together or apart.
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
