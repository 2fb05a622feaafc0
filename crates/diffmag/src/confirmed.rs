//! Events that the final fit does not confirm are none.

use common::{EventKind, Quantity};

use crate::Error;
use crate::regression::{AxisFit, step_sizes};
use joined::Pair;
use paired::apart;
use paired::events::{self, CONFIRMED, FoundEvent};
use paired::noise::Noise;
use paired::prepare::{Prepared, settled};
use paired::residual::{of_levels, scatter};

/// A step that is not confirmed is none if the final fit is so many of its uncertainties off the size that
/// was found; a fit that rests on long periods may not be able to tell.
const REFUTED: f64 = 3.0;

/// The same without the events that the fit does not confirm; None where it confirms all.
///
/// While events are looked for η is not the final one: noise of the reference, or filters, may pull it at
/// short periods, and a sudden change of the field then leaves a step.
pub fn confirmed(prepared: &Prepared, raw: &Pair, fits: &[AxisFit; 3]) -> Result<Option<Prepared>, Error> {
    let found = &prepared.events.found;
    if found.is_empty() {
        return Ok(None);
    }
    let stands = |(found, size): (&FoundEvent, Option<Quantity>)| {
        size.is_none_or(|size| apart(0.0, &size) >= CONFIRMED || apart(found.size, &size) < REFUTED)
    };
    let mut kept: Vec<bool> = found.iter().zip(step_sizes(&prepared.events, fits)).map(stands).collect();
    let (steps, disturbed): (Vec<usize>, Vec<usize>) =
        (0..found.len()).partition(|number| found[*number].kind == EventKind::Step);
    // With steps taken off no axis leaves more than it would without any fit.
    for (axis, fit) in fits.iter().enumerate() {
        if scatter(&fit.difference, &prepared.pair.whole) > of_levels(raw, axis) {
            let own = steps.iter().filter(|step| found[**step].axes(fits.len()).contains(&axis));
            own.for_each(|step| kept[*step] = false);
        }
    }
    let of = |numbers: &[usize]| numbers.iter().map(|number| &found[*number]).collect::<Vec<_>>();
    let pair = prepared.events.steps().aligned(raw, prepared.shift);
    let mut out: Vec<bool> = pair.whole.iter().map(|whole| !whole).collect();
    of(&disturbed).iter().for_each(|event| out[event.from..=event.to].fill(true));
    let left: Vec<Vec<f64>> = fits.iter().enumerate().map(|(axis, fit)| fit.left(&pair, axis)).collect();
    let eta: Vec<[f64; 3]> = fits.iter().map(|fit| std::array::from_fn(|i| fit.fit.weighted[i])).collect();
    let lasting = events::lasting(&left, &eta, &out, &of(&steps));
    steps.iter().zip(lasting).for_each(|(step, lasts)| kept[*step] &= lasts);
    if !disturbed.is_empty() {
        let noise: Vec<&Noise> = fits.iter().map(|fit| &fit.noise).collect();
        let off = events::off(&left, &out, pair.step_s, &noise, &of(&disturbed))?;
        disturbed.iter().zip(off).for_each(|(number, off)| kept[*number] = off);
    }
    if !kept.contains(&false) {
        return Ok(None);
    }
    let correct_clock = prepared.clock.as_ref().is_some_and(|clock| clock.corrected);
    let events = prepared.events.confirmed(&kept);
    settled(raw, events, prepared.clock.clone(), prepared.shift, correct_clock).map(Some)
}

#[cfg(test)]
mod tests {
    use common::EventInstrument;
    use noise::Stream;
    use paired::events::Events;
    use paired::look::Shift;

    use super::*;

    const ROWS: usize = 4000;

    /// Two instruments with white noise; the test instrument's x rises by 2 nT at row 1000.
    fn pair() -> Pair {
        let mut stream = Stream::new(11, "prepare");
        let wave = |row: usize, axis: usize| 30.0 * (row as f64 / (90.0 + 40.0 * axis as f64)).sin();
        let field: [Vec<f64>; 3] = std::array::from_fn(|axis| (0..ROWS).map(|row| wave(row, axis)).collect());
        let mut test = field.clone().map(|column| {
            column.into_iter().map(|value| value + 0.1 * stream.normal()).collect::<Vec<f64>>()
        });
        test[0][1000..].iter_mut().for_each(|value| *value += 2.0);
        Pair {
            step_s: 1.0,
            reference: field.map(Into::into),
            test: test.map(Into::into).into(),
            whole: vec![true; ROWS],
            steps: vec![Vec::new(); 3],
            segments: vec![joined::Segment { rows: 0..ROWS, late_s: 0.0 }],
            ..Pair::default()
        }
    }

    fn step(from: usize, size: f64) -> FoundEvent {
        let (kind, instrument) = (EventKind::Step, EventInstrument::Test);
        FoundEvent { kind, instrument, axis: 0, from, to: from, size, std: 0.05 }
    }

    #[test]
    fn a_step_that_the_fit_refutes_is_none() {
        let raw = pair();
        let events = Events { found: vec![step(1000, 2.0), step(2500, 1.5)], ..Events::default() };
        let prepared = settled(&raw, events, None, Shift::default(), false).expect("a pair without steps");
        let fits = crate::regression::fit(&prepared.pair, &[]).expect("a fit");
        let fewer = confirmed(&prepared, &raw, &fits).expect("a fit").expect("one step fewer");
        let rows: Vec<usize> = fewer.events.found.iter().map(|event| event.from).collect();
        assert_eq!((rows, fewer.events.unconfirmed), (vec![1000], [1, 0]));
        let fits = crate::regression::fit(&fewer.pair, &[]).expect("a fit");
        assert!(confirmed(&fewer, &raw, &fits).expect("a fit").is_none());
    }
}
