//! What a MagPy sheet leaves to be told from its numbers: with which readings of the mark the magnetometer was above
//! the telescope, and which position a line is of. Observers write marks and positions in different orders.
//!
//! Sheets begin with the view to the east. The circle of the mark is with the magnetometer above what makes the
//! declination one within ±90°; with the other face it is half a circle from that.

use common::number::fixed;

use super::row::{Row, turn};

/// Vertical circles that differ from 90 and 270 by no more are those of the declination.
const LEVEL: f64 = 0.5;
/// Vertical circles of the inclination lie at most so far from those that the first one predicts.
const NEAR: f64 = 5.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    pub number: u32,
    pub time_ns: i64,
    pub horizontal: f64,
    pub vertical: f64,
    pub residual_nt: f64,
}

impl Line {
    /// Whether it is one of the declination.
    pub fn is_level(&self) -> bool {
        turn(2.0 * self.vertical, 180.0).abs() <= 2.0 * LEVEL
    }

    /// Where the circle would have to stand for the same view with the magnetometer above.
    fn circle_up(&self) -> f64 {
        if self.vertical < 180.0 { self.horizontal } else { self.horizontal + 180.0 }
    }
}

/// Whether the magnetometer was above the telescope with the first readings of the mark; `east` is the first line.
pub fn first_is_up(mark_deg: f64, azimuth_deg: f64, east: &Line) -> bool {
    let declination = turn(east.circle_up() + azimuth_deg - mark_deg, 90.0);
    declination.abs() <= 90.0
}

/// The lines as rows. Errors: the first line whose vertical circle is that of no position, and what is
/// expected there.
pub fn rows(lines: &[Line]) -> Result<Vec<Row>, (Line, String)> {
    let Some(east) = lines.first() else { return Ok(Vec::new()) };
    // The view to the north, with the magnetometer above, of the plane in which the field lies.
    let north_up = lines.iter().find(|line| !line.is_level() && line.vertical < 180.0).map(|line| {
        if is_north(line.horizontal, east.circle_up() - 90.0) { line.vertical } else { 180.0 - line.vertical }
    });
    let row = |line: &Line| {
        let (up, residual_nt) = (line.vertical < 180.0, line.residual_nt);
        let mut row = if line.is_level() {
            let is_east = turn(line.circle_up(), east.circle_up()).abs() < 90.0;
            Row::at(if is_east { "East" } else { "West" }, up, line.horizontal, residual_nt)
        } else {
            let north_up = north_up.unwrap_or(line.vertical - 180.0);
            let positions = [
                ("North", north_up),
                ("South", 180.0 - north_up),
                ("North", 360.0 - north_up),
                ("South", north_up + 180.0),
            ];
            let Some((view, _)) = positions.iter().find(|(_, of)| turn(line.vertical, *of).abs() <= NEAR)
            else {
                return Err((*line, positions.map(|(_, of)| fixed(of, 1)).join(", ")));
            };
            Row::at(view, up, line.vertical, residual_nt)
        };
        (row.time_ns, row.values[1]) = (Some(line.time_ns), line.vertical);
        Ok(row)
    };
    lines.iter().map(row).collect()
}

/// Whether a circle is that of the view to the north with the magnetometer above. Sheets have a nominal 0 or 180
/// there, or what the circle reads.
fn is_north(horizontal: f64, circle_north: f64) -> bool {
    let is_nominal = turn(2.0 * horizontal, 0.0).abs() < 1e-6;
    turn(horizontal, if is_nominal { 0.0 } else { circle_north }).abs() < 90.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(horizontal: f64, vertical: f64) -> Line {
        Line { number: 1, time_ns: 0, horizontal: horizontal.rem_euclid(360.0), vertical, residual_nt: 0.0 }
    }

    /// D = 4.25, the mark at 200.5; the circle reads 77 less than the azimuth.
    #[test]
    fn marks_in_either_order() {
        let (zero, declination, azimuth) = (77.0, 4.25, 200.5);
        let mark_up: f64 = azimuth - zero;
        for east in [line(declination + 90.0 - zero, 90.0), line(declination + 270.0 - zero, 270.0)] {
            assert!(first_is_up(mark_up, azimuth, &east));
            assert!(!first_is_up(mark_up + 180.0, azimuth, &east));
            assert!(first_is_up(mark_up + 360.0, azimuth, &east));
        }
    }

    #[test]
    fn positions_in_any_order_and_south_of_the_equator() {
        let level = [line(93.0, 90.0), line(273.1, 90.0), line(273.2, 270.0), line(93.2, 270.0)];
        // The nominal circle, the nominal view, and what the circle reads.
        for circle in [[0.0, 0.0, 180.0, 180.0], [0.0, 180.0, 0.0, 180.0], [3.4, 3.4, 183.4, 183.4]] {
            for (dip, order) in [(64.4, [0, 1, 2, 3]), (12.0, [0, 3, 2, 1]), (-57.2, [1, 3, 0, 2])] {
                let up = f64::rem_euclid(dip, 180.0);
                let vertical = [up, up + 180.0, 360.0 - up, 180.0 - up];
                let steep = order.map(|place| line(circle[place], vertical[place] + 0.1));
                let rows = rows(&[level, steep].concat()).expect("positions");
                let views: Vec<&str> = rows.iter().map(|row| row.view).collect();
                assert_eq!(views[..4], ["East", "West", "East", "West"]);
                assert_eq!(views[4..], order.map(|place| ["North", "South", "North", "South"][place]));
            }
        }
        let (wrong, near) =
            rows(&[line(93.0, 90.0), line(0.0, 64.4), line(0.0, 74.4)]).expect_err("near none");
        assert_eq!((wrong.vertical, near.as_str()), (74.4, "64.4, 115.6, 295.6, 244.4"));
    }
}
