//! What no instrument reads: fill values and faults that would otherwise be taken for readings.

/// The unit at the end of a column's name, with the lowest and the highest value that a reading in it may have. The strongest
/// steady magnets make 45 T; a magnetometer of 1 T has little to do with the field of the Earth.
const BOUNDS: [(&str, [f64; 2]); 4] =
    [("_nt", [-1e9, 1e9]), ("_v", [-1e6, 1e6]), ("_a", [-1e6, 1e6]), ("_c", [-273.15, 1e4])];

/// The lowest and the highest value that a column of this name may have, by the unit at its end.
pub fn bounds(column: &str) -> Option<[f64; 2]> {
    BOUNDS.iter().find(|(unit, _)| column.ends_with(unit)).map(|(_, bounds)| *bounds)
}

/// The first row whose value no instrument reads. A missing reading is none.
pub fn first_beyond(column: &str, values: &[f64]) -> Option<usize> {
    let [low, high] = bounds(column)?;
    values.iter().position(|value| *value < low || *value > high)
}

#[cfg(test)]
mod tests {
    use super::first_beyond;

    #[test]
    fn by_the_unit() {
        assert_eq!(first_beyond("sensor_x_nt", &[6e4, f64::NAN, -1e31]), Some(2));
        assert_eq!(first_beyond("sensor_temperature_c", &[20.0, -300.0]), Some(1));
        assert_eq!(first_beyond("coil_x_a", &[1e200]), Some(0));
        assert_eq!(first_beyond("time_s", &[1.7e18]), None);
    }
}
