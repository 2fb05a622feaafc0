//! The instrument that an event belongs to.

use common::EventInstrument;
use estimate::stats;

/// An instrument is ruled out when what it does not explain is so improbable …
const RULED_OUT: f64 = 1e-3;
/// … beyond this share of the whole, which an error of η explains.
const OF_ETA: f64 = 1e-6;

/// An event of one instrument's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    pub instrument: EventInstrument,
    pub axis: usize,
    /// nT.
    pub size: f64,
    /// nT.
    pub std: f64,
}

impl Source {
    /// Its size in each of the differences: of the reference −η times its own.
    pub fn parts(&self, eta: &[[f64; 3]]) -> Vec<f64> {
        parts(self.instrument, self.axis, eta)
    }

    /// Its size over the uncertainty.
    pub fn z(&self) -> f64 {
        self.size / self.std
    }
}

fn parts(instrument: EventInstrument, own: usize, eta: &[[f64; 3]]) -> Vec<f64> {
    let part = |(axis, eta): (usize, &[f64; 3])| match instrument {
        EventInstrument::Reference => -eta[own],
        _ if axis == own => 1.0,
        _ => 0.0,
    };
    eta.iter().enumerate().map(part).collect()
}

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
fn largest(sizes: &[(f64, f64)], eta: &[[f64; 3]]) -> Source {
    let z: Vec<f64> = sizes.iter().map(|(size, std)| size / std).collect();
    let axis = (0..z.len()).fold(0, |a, b| if z[b].abs() > z[a].abs() { b } else { a });
    let all: f64 = z.iter().map(|z| z * z).sum();
    let limit = stats::chi_squared_quantile(1.0 - RULED_OUT, 2.0) + OF_ETA * all;
    let (size, std) = sizes[axis];
    let test = Source { instrument: EventInstrument::Test, axis, size, std };
    let reference = (0..3)
        .map(|own| {
            let (size, std) = shared(sizes, &parts(EventInstrument::Reference, own, eta));
            Source { instrument: EventInstrument::Reference, axis: own, size, std }
        })
        .max_by(|a, b| a.z().abs().total_cmp(&b.z().abs()));
    let explains = |source: &Source| all - source.z().powi(2) < limit;
    match reference.filter(explains) {
        Some(_) if explains(&test) => Source { instrument: EventInstrument::Either, ..test },
        Some(reference) => reference,
        None => test,
    }
}

/// The events that sizes and uncertainties of the three differences speak of, each of at least `least`
/// uncertainties beside the ones before it.
pub fn sources(mut sizes: Vec<(f64, f64)>, least: f64, eta: &[[f64; 3]]) -> Vec<Source> {
    let mut found: Vec<Source> = Vec::new();
    while found.len() < sizes.len() && sizes.iter().any(|(size, std)| (size / std).abs() >= least) {
        let source = largest(&sizes, eta);
        if found.iter().any(|known| (known.instrument, known.axis) == (source.instrument, source.axis)) {
            break;
        }
        sizes.iter_mut().zip(source.parts(eta)).for_each(|((size, _), part)| *size -= part * source.size);
        found.push(source);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const ETA: [[f64; 3]; 3] = [[0.9, 0.4, 0.0], [-0.4, 0.9, 0.4], [0.0, -0.4, 0.9]];

    #[test]
    fn each_instrument_is_recognised() {
        let of_reference = sources(vec![(-9.0, 0.1), (4.0, 0.1), (0.0, 0.1)], 5.0, &ETA);
        assert_eq!(of_reference.len(), 1);
        assert_eq!((of_reference[0].instrument, of_reference[0].axis), (EventInstrument::Reference, 0));
        assert!((of_reference[0].size - 10.0).abs() < 1e-9, "{of_reference:?}");
        let of_test = sources(vec![(0.05, 0.1), (4.0, 0.1), (-3.0, 0.1)], 5.0, &ETA);
        let named: Vec<_> = of_test.iter().map(|source| (source.instrument, source.axis)).collect();
        assert_eq!(named, [(EventInstrument::Test, 1), (EventInstrument::Test, 2)]);
        assert!(sources(vec![(0.3, 0.1), (-0.2, 0.1), (0.0, 0.1)], 5.0, &ETA).is_empty());
    }
}
