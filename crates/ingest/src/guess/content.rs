//! What columns hold, told from their values where names do not say it. Such a guess is a question in words,
//! never taken in silence.

use common::number::significant;

/// A unit in which readings of that size are the Earth's field. Not mG: a field of hundreds of µT is as
/// likely.
pub fn unit_of_earth(mut sizes: Vec<f64>) -> Option<&'static str> {
    let size = median(&mut sizes)?;
    let units = [("nT", 1.0), ("uT", 1e3), ("G", 1e5), ("T", 1e9)];
    let fits = |(_, nt): &(&str, f64)| (20_000.0..70_000.0).contains(&(size * nt));
    units.into_iter().find(fits).map(|(unit, _)| unit)
}

/// Norms of three columns, row by row.
pub fn norms(columns: &[Vec<f64>; 3]) -> Vec<f64> {
    let rows = columns[0].iter().zip(columns[1].iter().zip(&columns[2]));
    rows.map(|(x, (y, z))| (x * x + y * y + z * z).sqrt()).collect()
}

/// Three columns as one field by their norm: it is steady, and the Earth's in some unit, or the columns turn
/// while it stays. The unit (`counts` where none fits), and why in words.
pub fn field(columns: &[Vec<f64>; 3]) -> Option<(&'static str, String)> {
    const ROWS: usize = 8;
    const STEADY: f64 = 0.2;
    let norms = norms(columns);
    if norms.len() < ROWS || columns.iter().any(|values| values.len() != columns[0].len()) {
        return None;
    }
    let norm = median(&mut norms.clone()).filter(|norm| *norm > 0.0)?;
    let scatter = spread(&norms)? / norm;
    let turn = columns.iter().filter_map(|values| spread(values)).fold(0.0, f64::max) / norm;
    let [size, percent] = [significant(norm, 3), significant(100.0 * scatter, 2)];
    let size = format!("the norm of the three is {size} and stays so to {percent} %");
    match unit_of_earth(norms) {
        Some(unit) if scatter < STEADY => Some((unit, format!("{size}; in {unit} it is the Earth's field"))),
        None if scatter < STEADY && turn > 3.0 * scatter.max(0.1) => {
            Some(("counts", format!("{size} while the columns change by {} %", significant(100.0 * turn, 2))))
        }
        _ => None,
    }
}

/// Whether values are a temperature in °C or K: within the range of instruments, with decimals or small
/// steps, slowly changing.
pub fn temperature(values: &[f64]) -> Option<(&'static str, String)> {
    const ROWS: usize = 8;
    let least = values.iter().copied().min_by(f64::total_cmp).filter(|_| values.len() >= ROWS)?;
    let most = values.iter().copied().max_by(f64::total_cmp)?;
    let range = spread(values)?;
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let slow = spread(&steps)? <= 0.5 * range && range > 0.0;
    let unit = [("C", -40.0, 85.0), ("K", 233.0, 358.0)]
        .into_iter()
        .find(|(_, low, high)| least >= *low && most <= *high);
    let (unit, ..) = unit.filter(|_| slow && values.iter().any(|value| value.fract() != 0.0))?;
    let [least, most] = [least, most].map(|end| significant(end, 4));
    Some((unit, format!("values from {least} to {most} that change slowly are a temperature in {unit}")))
}

/// Whether values rise by steps that are alike: each within half of the usual one.
pub fn rises_evenly(values: &[f64]) -> bool {
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = median(&mut steps.clone()).filter(|_| steps.len() >= 8);
    usual.is_some_and(|usual| {
        let near = steps.iter().filter(|step| (**step - usual).abs() <= 0.5 * usual).count();
        usual > 0.0 && steps.iter().all(|step| *step > 0.0) && 10 * near >= 9 * steps.len()
    })
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// What eight of ten values lie within.
fn spread(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some(sorted[(0.9 * last as f64).round() as usize] - sorted[(0.1 * last as f64).round() as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_by_its_norm() {
        let unit = |columns: &[Vec<f64>; 3]| field(columns).map(|(unit, _)| unit);
        // A field that turns, with an offset of the sensor.
        for (size, offset, due) in [(48_000.0, 500.0, "nT"), (48.0, 0.5, "uT"), (3600.0, 40.0, "counts")] {
            let rows = (0..40).map(|row| (0.3 * f64::from(row)).sin_cos());
            let (y, x) = rows.map(|(sin, cos)| (size * 0.8 * sin, size * 0.8 * cos + offset)).unzip();
            assert_eq!(unit(&[x, y, vec![size * 0.6; 40]]), Some(due));
        }
        // What grows from nothing, what does not change, and what is no field of the Earth.
        let ramp: Vec<f64> = (0..40).map(f64::from).collect();
        assert_eq!(unit(&[ramp.clone(), ramp.clone(), ramp]), None);
        assert_eq!(unit(&[5.0, 0.1, -9.8].map(|value| vec![value; 40])), None);
        assert_eq!(unit(&[20_000.0, 1000.0, 44_000.0].map(|value| vec![value; 40])), Some("nT"));
    }

    #[test]
    fn temperatures_and_times() {
        let slow: Vec<f64> = (0..60).map(|row| 21.0 + 0.5 * (f64::from(row) / 15.0).sin()).collect();
        assert_eq!(temperature(&slow).map(|(unit, _)| unit), Some("C"));
        let kelvin: Vec<f64> = slow.iter().map(|value| value + 273.15).collect();
        assert_eq!(temperature(&kelvin).map(|(unit, _)| unit), Some("K"));
        let noise: Vec<f64> = (0..60).map(|row| f64::from(row * 7919 % 61) / 2.0).collect();
        assert_eq!(temperature(&noise), None);
        assert_eq!(temperature(&(0..60).map(f64::from).collect::<Vec<_>>()), None);
        assert!(rises_evenly(&(0..60).map(|row| 0.1 * f64::from(row)).collect::<Vec<_>>()));
        assert!(!rises_evenly(&slow) && !rises_evenly(&[1.0, 2.0]));
    }
}
