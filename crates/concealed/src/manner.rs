//! How a campaign is recorded: how long, how fast, how evenly, with what converter, in what weather.

use crate::case::Concealed;
use crate::draw::Draw;
use crate::noise::Noise;
use crate::scene::{Campaign, SceneKind};
use crate::scenes;
use crate::storm;

/// Share of campaigns whose readings come at uneven times, in whose field there is a storm, and which have a
/// coarse converter.
const UNEVEN: f64 = 0.35;
const STORM: f64 = 0.4;
const COARSE: f64 = 0.3;
/// By how much a moment is off its even place, at least and at most, over the step.
const OFF: [f64; 2] = [0.03, 0.25];
/// Width of a coarse converter's codes over the rms of the white noise.
const CODES: [f64; 2] = [0.3, 3.0];

/// 500 to 30 000 rows: three of four campaigns have up to 5 000, and one of twenty-five more than 12 000.
pub fn rows(draw: &mut Draw) -> usize {
    let [least, most] = match draw.between(0.0, 1.0) {
        x if x < 0.76 => [500.0, 5_000.0],
        x if x < 0.96 => [5_000.0, 12_000.0],
        _ => [12_000.0, 30_000.0],
    };
    draw.octaves(least, most).round() as usize
}

/// Time from one row to the next, s, where a kind does not say it: 0.07 to 44 Hz.
///
/// No campaign is shorter than its physics: an hour in coils, whose chamber has to warm, two at a site, an
/// orbit on board, six hours of a pair. Drives, lags and variations are made in steps and spans, so that they
/// are resolved at each rate. Coils that are held show the mains and are read as fast as that takes.
fn step_s(kind: SceneKind, rows: usize, draw: &mut Draw) -> Option<f64> {
    let least = |span: f64, step: f64| (span / rows as f64).max(step);
    let step = match kind {
        SceneKind::Coils => draw.octaves(least(3600.0, 0.25), 15.0),
        SceneKind::Fast => draw.octaves(1.0 / 44.0, 0.2),
        SceneKind::Held => return None,
        SceneKind::Site => draw.octaves(least(7200.0, 1.0), 60.0),
        SceneKind::Craft => draw.octaves(least(5640.0, 1.0), 20.0),
        SceneKind::Pair => draw.octaves(least(21_600.0, 1.0), 120.0),
    };
    // Slow loggers count milliseconds, quick ones divide a second into readings.
    let rate = (100.0 / step).round() / 100.0;
    Some(if step < 1.0 { 1.0 / rate } else { (step * 1000.0).round() / 1000.0 })
}

/// A campaign at random, and in words how it is recorded.
pub fn campaign(kind: SceneKind, step: Option<f64>, apart: bool, draw: &mut Draw) -> (Campaign, Vec<String>) {
    let rows = rows(draw);
    let step = step.or_else(|| step_s(kind, rows, draw));
    let mut campaign = scenes::of_rows(kind, rows, apart, step, draw);
    let mut said = vec![format!("{} Hz", two_digits(1.0 / campaign.runs[0].step_s()))];
    if draw.between(0.0, 1.0) < UNEVEN {
        uneven(&mut campaign, draw);
        said.push("uneven times".into());
    }
    if matches!(kind, SceneKind::Site | SceneKind::Craft | SceneKind::Pair) && draw.between(0.0, 1.0) < STORM
    {
        storm::over(&mut campaign, draw);
        said.push("a storm".into());
    }
    (campaign, said)
}

fn two_digits(rate: f64) -> String {
    let digits = (1.0 - rate.log10().floor()).clamp(0.0, 3.0) as usize;
    format!("{rate:.digits$}")
}

/// Moves each moment from its even place, but for the first two of a run, between which its step is read.
/// What is recorded is what was at these moments, all columns of a row at one. A logger of some seconds takes
/// its readings at whole milliseconds, another at whole microseconds.
pub fn uneven(campaign: &mut Campaign, draw: &mut Draw) {
    let off = draw.octaves(OFF[0], OFF[1]);
    let tick = if campaign.runs[0].step_s() >= 1.0 && draw.sign() > 0.0 { 1e3 } else { 1e6 };
    for run in &mut campaign.runs {
        let step = run.step_s();
        for time in run.times.iter_mut().skip(2) {
            *time = ((*time + off * step * draw.between(-1.0, 1.0)) * tick).round() / tick;
        }
    }
}

/// Gives a campaign a converter with codes of a third to three times the white noise, which its document
/// declares; not where the effect is one of the converter's own.
pub fn converter(
    campaign: &mut Campaign,
    noise: &Noise,
    concealed: &[Concealed],
    draw: &mut Draw,
) -> Option<String> {
    let coarse = draw.between(0.0, 1.0) < COARSE;
    let wanted = noise.white_nt * draw.octaves(CODES[0], CODES[1]);
    if !coarse || concealed.iter().any(|one| one.effect.on_codes || one.name == "quantisation") {
        return None;
    }
    // One over a whole number, as documents are rounded.
    campaign.code_nt = 1.0 / (1.0 / wanted).round().max(1.0);
    Some(format!("codes of {:.2} nT", campaign.code_nt))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_campaigns_are_short_and_few_are_longest() {
        let mut draw = Draw::new("rows", 1);
        let all: Vec<usize> = (0..2000).map(|_| rows(&mut draw)).collect();
        assert!(all.iter().all(|rows| (500..=30_000).contains(rows)));
        let share = |least: usize| all.iter().filter(|rows| **rows > least).count() as f64 / 2000.0;
        assert!((share(5_000) - 0.24).abs() < 0.04 && (share(12_000) - 0.04).abs() < 0.02);
    }

    /// Each kind at rates of its own, from less than 0.2 Hz to 44 Hz, and none in a shorter time than its
    /// physics takes.
    #[test]
    fn rates_go_from_a_fifth_of_a_hertz_to_forty_four() {
        let mut draw = Draw::new("rates", 1);
        let (mut least, mut most) = (f64::MAX, 0.0_f64);
        for kind in [SceneKind::Coils, SceneKind::Fast, SceneKind::Site, SceneKind::Craft, SceneKind::Pair] {
            for _ in 0..300 {
                let rows = rows(&mut draw);
                let step = step_s(kind, rows, &mut draw).expect("a step");
                (least, most) = (least.min(1.0 / step), most.max(1.0 / step));
                let span = step * rows as f64;
                assert!(kind != SceneKind::Coils || span > 3550.0, "{span}");
                assert!(kind != SceneKind::Craft || span > 5600.0, "{span}");
            }
        }
        assert!(least < 0.2 && (40.0..=44.001).contains(&most), "{least} {most}");
    }

    /// Times go forward, on whole microseconds, and the step stays what it was.
    #[test]
    fn uneven_times_go_forward() {
        for seed in 0..20 {
            let mut draw = Draw::new("uneven", seed);
            let mut campaign = scenes::of_rows(SceneKind::Coils, 600, true, Some(7.25), &mut draw);
            uneven(&mut campaign, &mut draw);
            for run in &campaign.runs {
                assert_eq!(run.step_s(), 7.25);
                assert!(run.times.windows(2).all(|pair| pair[1] - pair[0] > 0.4 * 7.25));
                assert!(run.times.windows(2).any(|pair| (pair[1] - pair[0] - 7.25).abs() > 0.01));
                assert!(run.times.iter().all(|t| (t * 1e6 - (t * 1e6).round()).abs() < 1e-2));
            }
        }
    }
}
