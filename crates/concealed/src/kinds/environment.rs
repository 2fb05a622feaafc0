//! Around the facility.

use nalgebra::Vector3;

use crate::draw::Draw;
use crate::effect::{Effect, in_geo};
use crate::finer::mains;
use crate::scene::Campaign;

pub(super) fn direction(draw: &mut Draw) -> Vector3<f64> {
    Vector3::from_fn(|_, _| draw.normal()).normalize()
}

/// A cable's field under a wandering frequency, with a third harmonic, the three components not in phase.
pub fn mains(_: &Campaign, draw: &mut Draw) -> Effect {
    let (along, across) = (direction(draw), 0.4 * direction(draw));
    let (departure, seed) = (draw.between(-0.05, 0.05), draw.below(1 << 20) as u64);
    let act = in_geo(move |_, run, size| {
        let phase = mains::phase(&run.times, departure, 0.02, 200.0, &mut Draw::new("grid", seed));
        let field = |p: &f64| along * (p.sin() + 0.05 * (3.0 * p).sin()) + across * p.cos();
        phase.iter().map(|p| size * field(p)).collect()
    });
    Effect::new("mains of a wandering frequency, with a third harmonic", vec!["mains".into()], act)
}

/// A magnetised car on a straight road: the field of a dipole at each moment.
pub fn vehicle(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let run = &campaign.runs[0];
    let at = run.times[(run.times.len() as f64 * draw.between(0.3, 0.7)) as usize];
    let (distance, speed) = (draw.between(40.0, 90.0), draw.between(1.5, 3.0));
    let (moment, height) = (direction(draw), draw.between(-2.0, 2.0));
    let act = in_geo(move |_, run, size| {
        let field = |t: &f64| {
            let place = Vector3::new(speed * (t - at), distance, height);
            let (r, n) = (place.norm(), place.normalize());
            // A moment whose field at the nearest point is of the order of 1 nT.
            (3.0 * n * n.dot(&moment) - moment) * size * (distance / r).powi(3)
        };
        run.times.iter().map(field).collect()
    });
    Effect::new("dipole on a straight road", vec!["vehicle_pass".into()], act)
}

/// Machines that are switched on from seven and off before five, by hand, and draw an uneven load.
pub fn working_hours(_: &Campaign, draw: &mut Draw) -> Effect {
    let (field, seed) = (direction(draw), draw.below(1 << 20) as u64);
    let act = in_geo(move |_, run, size| {
        let mut load = Draw::new("load", seed);
        let late: Vec<[f64; 2]> =
            (0..8).map(|_| [load.between(0.0, 300.0), load.between(0.0, 300.0)]).collect();
        run.times
            .iter()
            .map(|t| {
                // The campaign begins on a Thursday at midnight; there is no work on the third and fourth day
                // of its weeks.
                let (day, hour) = ((t / 86_400.0) as usize, t % 86_400.0);
                let [on, off] = late[day % 8];
                let works =
                    !(2..4).contains(&(day % 7)) && hour >= 7.0 * 3600.0 + on && hour < 17.0 * 3600.0 - off;
                field * if works { size * (1.0 + 0.03 * load.normal()) } else { 0.0 }
            })
            .collect()
    });
    Effect::new("machines switched by hand, their load uneven", vec!["working_hours".into()], act)
}

/// Machines that are started one after another in the first half hour of work, and stopped so in the last.
const MACHINES: usize = 6;

/// Share of the machines that run at a time of day, s, by when each is started after seven and stopped before
/// five.
fn running(second: f64, after: &[f64; MACHINES], before: &[f64; MACHINES]) -> f64 {
    let runs = |k: &usize| second >= 7.0 * 3600.0 + after[*k] && second < 17.0 * 3600.0 - before[*k];
    (0..MACHINES).filter(runs).count() as f64 / MACHINES as f64
}

/// A hall of machines, one started after another.
pub fn one_after_another(_: &Campaign, draw: &mut Draw) -> Effect {
    let field = direction(draw);
    let moments = |draw: &mut Draw| std::array::from_fn(|_| draw.between(0.0, 1800.0));
    let (after, before) = (moments(draw), moments(draw));
    let act = in_geo(move |_, run, size| {
        let works = |t: &f64| {
            // As above, the third and fourth day of the campaign's weeks are Saturday and Sunday.
            let (day, second) = ((t / 86_400.0) as usize % 7, t % 86_400.0);
            if (2..4).contains(&day) { 0.0 } else { running(second, &after, &before) }
        };
        run.times.iter().map(|t| field * (size * works(t))).collect()
    });
    Effect::new("machines started one after another", vec!["working_hours".into()], act)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// None at night, all at noon, and on the average so many hours as their moments leave.
    #[test]
    fn machines_run_by_day() {
        let (after, before) = ([0.0, 300.0, 600.0, 900.0, 1200.0, 1500.0], [900.0; MACHINES]);
        let of = |second: f64| running(second, &after, &before);
        assert_eq!([of(0.0), of(43_200.0), of(70_000.0)], [0.0, 1.0, 0.0]);
        let worked: f64 = (0..86_400).map(|second| of(f64::from(second))).sum();
        assert!((worked - (36_000.0 - 750.0 - 900.0)).abs() < 2.0, "{worked}");
    }
}
