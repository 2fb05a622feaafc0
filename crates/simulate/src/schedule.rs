//! When each recording begins.

use common::Error;
use common::number::duration;
use common::time::{Start, day_of_week, hour_of_day};

use crate::plan::{Plan, Temperatures};
use crate::planned::{Begins, Planned};

/// A recording with its place in time.
pub struct Scheduled {
    pub planned: Planned,
    /// Its beginning on the campaign's clock, s.
    pub begins_s: f64,
    /// The recording's zero of time on the campaign's clock, s: its beginning where it has a `start`, else 0.
    pub clock_s: f64,
    /// The same on the local clock, seconds since 1970, where the campaign has a date.
    pub local_s: Option<f64>,
}

/// Without a date the campaign begins on a Monday at 0 h.
const MONDAY_S: f64 = 4.0 * 86_400.0;

/// Puts the recordings one after the other.
pub fn schedule(plan: &Plan, planned: Vec<Planned>) -> Result<Vec<Scheduled>, Error> {
    let start = match &plan.start {
        None => None,
        Some(text) => Some(Start::parse(text).ok_or_else(|| {
            let expected =
                "a moment with its offset from UTC, as in \"1977-05-26T09:00:00-05:00\" (RFC 3339)";
            Error::document("start", format!("\"{text}\""), expected)
        })?),
    };
    let mut free_s = 0.0;
    let mut first = (String::new(), 0.0);
    let mut scheduled = Vec::with_capacity(planned.len());
    for mut planned in planned {
        let begins_s = match planned.begins {
            Begins::Next => free_s,
            Begins::AsItSays => start.map_or(0.0, |_| free_s),
            Begins::After(wait) => {
                if first.0 != planned.path {
                    first = (planned.path.clone(), free_s);
                }
                first.1 + wait
            }
            Begins::At { day, hour } => {
                next(start.map_or(MONDAY_S, |start| start.local_s()) + free_s, day, hour) + free_s
            }
        };
        free_s = f64::max(free_s, begins_s + planned.length_s());
        let (mut clock_s, mut local_s) = (0.0, None);
        if let Some(start) = start {
            let moment = start.after(begins_s);
            planned.recording.start = Some(moment.text().ok_or_else(|| {
                let found = format!("a recording {} after the beginning", duration(begins_s));
                Error::document(planned.path.clone(), found, "dates before the year 10000")
            })?);
            (clock_s, local_s) = (begins_s, Some(moment.local_s()));
        } else if let Some(time) = planned.recording.columns.get_mut("time_s")
            && planned.begins != Begins::AsItSays
        {
            time.iter_mut().for_each(|t| *t += begins_s);
        }
        scheduled.push(Scheduled { planned, begins_s, clock_s, local_s });
    }
    // The campaign's clock, as every reader of the document sees it, begins with its first recording.
    let first_s = scheduled.iter().map(|scheduled| scheduled.clock_s).fold(f64::INFINITY, f64::min);
    for Scheduled { planned, clock_s, local_s, .. } in &mut scheduled {
        *clock_s -= first_s;
        if let Some(temperatures) = &plan.temperatures {
            add_temperatures(temperatures, planned, *clock_s, local_s.unwrap_or(MONDAY_S));
        }
    }
    Ok(scheduled)
}

/// Seconds from a local time to the next such day of the week and hour.
fn next(local_s: f64, day: u8, hour: f64) -> f64 {
    let days = (7 + day - day_of_week(local_s)) % 7;
    let wait = f64::from(days) * 86_400.0 + (hour - hour_of_day(local_s)) * 3600.0;
    if wait < 0.0 { wait + 7.0 * 86_400.0 } else { wait }
}

/// Temperature columns of the rooms, where the recording has none of its own.
fn add_temperatures(rooms: &Temperatures, planned: &mut Planned, clock_s: f64, local_s: f64) {
    let recording = &mut planned.recording;
    let time = match recording.column("time_s") {
        Some(time) => time.to_vec(),
        None => vec![0.0; recording.rows()],
    };
    let columns = [
        ("sensor_temperature_c", Some(rooms.sensor_temperature_c)),
        ("electronics_temperature_c", Some(rooms.electronics_temperature_c)),
        ("coil_temperature_c", rooms.coil_temperature_c),
    ];
    for (name, mean) in columns {
        let Some(mean) = mean.filter(|_| recording.column(name).is_none()) else { continue };
        let at = |t: &f64| {
            let wave = (std::f64::consts::TAU * (hour_of_day(local_s + t) - 15.0) / 24.0).cos();
            mean + rooms.daily_k * wave + rooms.trend_k_per_day * (clock_s + t) / 86_400.0
        };
        recording.columns.insert(name.into(), time.iter().map(at).collect());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_next_wednesday() {
        let local = |text: &str| Start::parse(text).expect("a moment").local_s();
        let thursday = local("1977-05-26T14:00:00Z");
        assert_eq!(next(thursday, 2, 7.5), local("1977-06-01T07:30:00Z") - thursday);
        assert_eq!(next(thursday, 3, 20.0), 6.0 * 3600.0);
        assert_eq!(next(thursday, 3, 14.0), 0.0);
        assert_eq!(next(thursday, 3, 13.0), 7.0 * 86_400.0 - 3600.0);
    }
}
