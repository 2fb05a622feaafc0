//! Repeats: readings with the same drive, and visits, those of them that were taken one after the other.

use crate::readings::Reading;

/// Currents within this share of the largest are one level.
const SAME: f64 = 1e-4;

/// Readings at one drive.
#[derive(Clone, Debug)]
pub struct Level {
    pub members: Vec<usize>,
}

/// Groups the readings into levels, by rising current.
pub fn levels(readings: &[Reading]) -> Vec<Level> {
    let largest = readings.iter().map(|reading| reading.current_a.abs()).fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..readings.len()).collect();
    order.sort_by(|a, b| readings[*a].current_a.total_cmp(&readings[*b].current_a));
    let mut levels: Vec<Level> = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for index in order {
        let current = readings[index].current_a;
        match levels.last_mut() {
            Some(level) if current - last <= SAME * largest => level.members.push(index),
            _ => levels.push(Level { members: vec![index] }),
        }
        last = current;
    }
    levels
}

/// Splits levels into visits: readings of one drive that follow each other directly. What wanders slowly, the
/// site's field for one, is common to a visit.
pub fn visits(levels: &[Level]) -> Vec<Level> {
    let of = |level: &Level| {
        let mut members = level.members.clone();
        members.sort_unstable();
        let runs = members.chunk_by(|before, after| before + 1 == *after);
        runs.map(|run| Level { members: run.to_vec() }).collect::<Vec<_>>()
    };
    levels.iter().flat_map(of).collect()
}

/// Sum of squares of values about the means of their levels, and its degrees of freedom.
pub fn within(levels: &[Level], value: impl Fn(usize) -> f64) -> (f64, f64) {
    let mut sum = 0.0;
    let mut freedom = 0.0;
    for level in levels {
        let mean = mean(level, &value);
        sum += level.members.iter().map(|member| (value(*member) - mean).powi(2)).sum::<f64>();
        freedom += level.members.len() as f64 - 1.0;
    }
    (sum, freedom)
}

/// Mean of values over a level.
pub fn mean(level: &Level, value: impl Fn(usize) -> f64) -> f64 {
    level.members.iter().map(|member| value(*member)).sum::<f64>() / level.members.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_that_is_set_again_is_two_visits() {
        let reading = |current_a: f64| Reading { current_a, field_nt: 0.0, time_s: 0.0 };
        let readings: Vec<Reading> = [1.0, 1.0, -1.0, -1.0, 1.0].map(reading).to_vec();
        let levels = levels(&readings);
        let of = |groups: &[Level]| groups.iter().map(|group| group.members.clone()).collect::<Vec<_>>();
        assert_eq!(of(&levels), [vec![2, 3], vec![0, 1, 4]]);
        assert_eq!(of(&visits(&levels)), [vec![2, 3], vec![0, 1], vec![4]]);
    }
}
