//! The instrument that an event belongs to.

use common::{EventInstrument, EventKind};
use estimate::stats;

use super::found::{FoundEvent, parts};

/// An instrument is ruled out when what it does not explain is so improbable …
const RULED_OUT: f64 = 1e-3;
/// … beyond this share of the whole, which an error of η explains.
const OF_ETA: f64 = 1e-6;

/// Size and uncertainty of what the differences share in the proportions `parts`.
fn shared(sizes: &[(f64, f64)], parts: &[f64]) -> (f64, f64) {
    let (mut above, mut below) = (0.0, 0.0);
    for ((size, std), part) in sizes.iter().zip(parts) {
        above += part * size / (std * std);
        below += (part / std).powi(2);
    }
    if below > 0.0 { (above / below, below.sqrt().recip()) } else { (0.0, f64::INFINITY) }
}

/// The largest event in sizes and uncertainties of the three differences: the reference's where the other
/// differences have it in the proportions of η and one axis of the test instrument does not explain it, the
/// test instrument's where it is the other way about or neither does.
fn largest(sizes: &[(f64, f64)], eta: &[[f64; 3]], (kind, row): (EventKind, usize)) -> FoundEvent {
    let event =
        |instrument, axis, (size, std)| FoundEvent { kind, instrument, axis, from: row, to: row, size, std };
    let z: Vec<f64> = sizes.iter().map(|(size, std)| size / std).collect();
    let axis = (0..z.len()).fold(0, |a, b| if z[b].abs() > z[a].abs() { b } else { a });
    let all: f64 = z.iter().map(|z| z * z).sum();
    let limit = stats::chi_squared_quantile(1.0 - RULED_OUT, 2.0) + OF_ETA * all;
    let test = event(EventInstrument::Test, axis, sizes[axis]);
    let of_reference = |own: usize| {
        let parts = parts(EventInstrument::Reference, own, eta);
        event(EventInstrument::Reference, own, shared(sizes, &parts))
    };
    let reference = (0..3).map(of_reference).max_by(|a, b| a.z().abs().total_cmp(&b.z().abs()));
    let explains = |event: &FoundEvent| all - event.z().powi(2) < limit;
    match reference.filter(explains) {
        Some(_) if explains(&test) => FoundEvent { instrument: EventInstrument::Either, ..test },
        Some(reference) => reference,
        None => test,
    }
}

/// The events of a kind at a row that sizes and uncertainties of the three differences speak of, each of at least
/// `least` uncertainties beside the ones before it.
pub fn sources(
    mut sizes: Vec<(f64, f64)>,
    least: f64,
    eta: &[[f64; 3]],
    at: (EventKind, usize),
) -> Vec<FoundEvent> {
    let mut found: Vec<FoundEvent> = Vec::new();
    while found.len() < sizes.len() && sizes.iter().any(|(size, std)| (size / std).abs() >= least) {
        let event = largest(&sizes, eta, at);
        if found.iter().any(|known| known.source() == event.source()) {
            break;
        }
        sizes.iter_mut().zip(event.parts(eta)).for_each(|((size, _), part)| *size -= part * event.size);
        found.push(event);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const ETA: [[f64; 3]; 3] = [[0.9, 0.4, 0.0], [-0.4, 0.9, 0.4], [0.0, -0.4, 0.9]];

    #[test]
    fn each_instrument_is_recognised() {
        let named = |sizes: [f64; 3]| -> Vec<(EventInstrument, usize, f64)> {
            let found = sources(sizes.map(|size| (size, 0.1)).to_vec(), 5.0, &ETA, (EventKind::Spike, 0));
            found.iter().map(|event| (event.instrument, event.axis, event.size.round())).collect()
        };
        assert_eq!(named([-9.0, 4.0, 0.0]), [(EventInstrument::Reference, 0, 10.0)]);
        let both = [(EventInstrument::Test, 1, 4.0), (EventInstrument::Test, 2, -3.0)];
        assert_eq!(named([0.05, 4.0, -3.0]), both);
        assert!(named([0.3, -0.2, 0.0]).is_empty());
    }
}
