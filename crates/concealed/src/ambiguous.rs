//! Campaigns that cannot decide between two effects, whoever looks: the same readings follow from either.

use std::sync::Arc;

use crate::draw::Draw;
use crate::effect::{Effect, in_block, named, on_sensor};
use crate::kinds;
use crate::scene::{Campaign, SceneKind};
use crate::scenes::{self, Length};
use crate::signal::{held, over};

/// A design: its name in scores, and what makes campaign and effect.
pub type Design = (&'static str, fn(Length, &mut Draw) -> (Campaign, Effect));

/// All designs. What an effect accepts is every name that the campaign cannot tell from the others.
pub const ALL: [Design; 6] = [
    ("sensor and electronics warm together", together),
    ("a temperature that only rises, or time", rising),
    ("a delay or a loop, slow drives", slow_loop),
    ("two currents in proportion", proportional),
    ("a clock's offset or its rate, a day later", clock_late),
    ("a coil or its sensor warms", coil_or_sensor),
];

fn together(length: Length, draw: &mut Draw) -> (Campaign, Effect) {
    let mut campaign = scenes::campaign(SceneKind::Coils, length, true, None, draw);
    for run in &mut campaign.runs {
        let sensor = run.temperatures[0].clone();
        run.temperatures[1] = over(3.0, sensor);
    }
    let sensor = draw.below(3);
    let which = draw.below(2);
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        run.times.iter().map(|t| size * (run.temperatures[which](*t) - campaign.reference_c[which])).collect()
    });
    let accepted = vec![named("offset_temperature", sensor), named("offset_electronics_temperature", sensor)];
    (campaign, Effect::new("offset with one of two equal temperatures", accepted, act).in_sensor(sensor))
}

fn rising(length: Length, draw: &mut Draw) -> (Campaign, Effect) {
    let mut campaign = scenes::campaign(SceneKind::Coils, length, true, None, draw);
    campaign.runs.truncate(1);
    let run = &mut campaign.runs[0];
    run.id = "run".into();
    let span = run.step_s() * run.times.len() as f64;
    run.temperatures = [Arc::new(move |t| 17.0 + 12.0 * t / span), held(26.0), held(21.0)];
    let sensor = draw.below(3);
    let by_time = draw.below(2) == 0;
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let moved = |t: &f64| {
            if by_time { *t / span } else { (run.temperatures[0](*t) - campaign.reference_c[0]) / 12.0 }
        };
        run.times.iter().map(|t| size * moved(t)).collect()
    });
    let accepted = vec![named("offset_temperature", sensor), named("ageing", sensor)];
    (
        campaign,
        Effect::new("offset with time or a temperature in proportion", accepted, act).in_sensor(sensor),
    )
}

fn slow_loop(length: Length, draw: &mut Draw) -> (Campaign, Effect) {
    let campaign = scenes::campaign(SceneKind::Coils, length, true, None, draw);
    let effect = kinds::second_order_loop(&campaign, draw);
    (campaign, effect)
}

fn proportional(length: Length, draw: &mut Draw) -> (Campaign, Effect) {
    let mut campaign = scenes::campaign(SceneKind::Craft, length, true, None, draw);
    let run = &mut campaign.runs[0];
    if let Some(panel) = run.column("panel_current_a").cloned() {
        run.columns.push(("battery_current_a".into(), Arc::new(move |t| 0.4 - 0.8 * panel(t))));
    }
    let field = nalgebra::Vector3::new(draw.normal(), draw.normal(), draw.normal());
    let act = in_block(move |_, run, size| {
        let current = |t: &f64| run.column("panel_current_a").map_or(0.0, |signal| signal(*t));
        run.times.iter().map(|t| field * size * current(t)).collect()
    });
    let accepted = vec!["stray_current panel_current_a".into(), "stray_current battery_current_a".into()];
    (campaign, Effect::new("loop of one of two currents in proportion", accepted, act))
}

fn clock_late(length: Length, draw: &mut Draw) -> (Campaign, Effect) {
    let mut campaign = scenes::campaign(SceneKind::Coils, length, true, None, draw);
    campaign.runs.truncate(1);
    let run = &mut campaign.runs[0];
    run.id = "run".into();
    // Thirty days after the clock was set a run of an hour sees no growth.
    let later = 30.0 * 86_400.0;
    run.times.iter_mut().for_each(|t| *t += later);
    let name = if draw.below(2) == 0 { "clock_offset" } else { "clock_rate" };
    let offset = 0.01 * draw.sign();
    let late = move |t: f64, size: f64| {
        if name == "clock_offset" { size * offset } else { size * offset * t / later }
    };
    let act: crate::effect::Act = Arc::new(move |campaign, _, size| {
        let one = |run: &crate::scene::Run| {
            std::array::from_fn(|sensor| {
                let at = |t: f64| run.along(&campaign.bench, sensor, t);
                run.times.iter().map(|t| at(t - late(*t, size)) - at(*t)).collect()
            })
        };
        campaign.runs.iter().map(one).collect()
    });
    let accepted = vec!["clock_offset".into(), "clock_rate".into()];
    (campaign, Effect::new("resampling long after the clock was set", accepted, act))
}

fn coil_or_sensor(length: Length, draw: &mut Draw) -> (Campaign, Effect) {
    let mut campaign = scenes::campaign(SceneKind::Coils, length, true, None, draw);
    campaign.runs.truncate(1);
    let run = &mut campaign.runs[0];
    run.id = "run".into();
    run.attitude = Arc::new(|_| nalgebra::Matrix3::identity());
    let sensor = run.temperatures[0].clone();
    run.temperatures[2] = over(-2.0, sensor);
    let axis = draw.below(3);
    let ppm = 15.0 * draw.sign();
    let act = on_sensor(axis, move |campaign, run, plain, size| {
        let warm = |t: &f64| run.temperatures[0](*t) - campaign.reference_c[0];
        run.times.iter().zip(plain).map(|(t, reading)| 1e-6 * ppm * size * warm(t) * reading).collect()
    });
    let accepted = vec![named("sensitivity_temperature", axis), named("coil_temperature", axis)];
    (
        campaign,
        Effect::new("sensitivity that warms with its coil, one orientation", accepted, act).in_sensor(axis),
    )
}
