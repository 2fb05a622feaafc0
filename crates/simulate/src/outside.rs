//! The world outside: Earth's field with its variations, and the noise of the site by hour and weekday.

use common::time::{day_of_week, hour_of_day};
use common::{Axis, Noise};
use nalgebra::Vector3;
use noise::NoiseError;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The natural field, GEO, nT. Main field, daily variation and storm are functions of time alone; the
/// background is drawn anew for each recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct OutsidePlan {
    /// Main field.
    pub main_field_nt: [f64; 3],
    /// Size of the daily variation (solar quiet) of each component.
    pub daily_nt: [f64; 3],
    /// Background of each component: white, power law, random walk.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub background: Option<Noise>,
    /// A storm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub storm: Option<Storm>,
    /// Noise of the station magnetometer that records `outside_*_nt`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<Noise>,
}

/// A magnetic storm: a sudden commencement, a main phase that deepens and recovers, and unrest while it
/// lasts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Storm {
    /// Beginning on the campaign's clock, s.
    pub time_s: f64,
    /// Step at the beginning, nT.
    pub sudden_nt: [f64; 3],
    /// Deepest depression, nT.
    pub depression_nt: [f64; 3],
    /// Time constant of the main phase, s.
    pub growth_s: f64,
    /// Time constant of the recovery, s.
    pub recovery_s: f64,
    /// Unrest of each component at the storm's height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unrest: Option<Noise>,
}

/// Noise of the site in each of the report's four conditions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct SitePlan {
    /// Monday to Friday, 7 h to 17 h.
    pub weekday_day: SiteNoise,
    /// The night to Tuesday to Saturday.
    pub weekday_night: SiteNoise,
    /// Saturday and Sunday, 7 h to 17 h.
    pub weekend_day: SiteNoise,
    /// The night to Sunday and Monday.
    pub weekend_night: SiteNoise,
}

/// Noise of the site, GEO.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SiteNoise {
    /// Of each component.
    pub noise: Noise,
    /// Amplitude of the mains field of each component, nT.
    pub mains_nt: [f64; 3],
    /// Its frequency, Hz; absent: 60.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mains_hz: Option<f64>,
}

/// A condition of the site.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Site {
    /// Midweek workday.
    WeekdayDay,
    /// Midweek night shift.
    WeekdayNight,
    /// Weekend midday.
    WeekendDay,
    /// Weekend night shift.
    WeekendNight,
}

impl Site {
    /// In the report's order.
    pub const ALL: [Site; 4] = [Site::WeekdayDay, Site::WeekdayNight, Site::WeekendDay, Site::WeekendNight];

    /// As `conditions.site` has it.
    pub fn name(self) -> &'static str {
        ["weekday-day", "weekday-night", "weekend-day", "weekend-night"][self as usize]
    }

    /// Day of the week (0 = Monday) and hour at which its series begin: nine hours fit in.
    pub fn when(self) -> (u8, f64) {
        [(2, 7.5), (2, 20.0), (5, 7.5), (5, 20.0)][self as usize]
    }

    /// The condition at a local time. A night belongs to the day on which it begins.
    pub fn at(local_s: f64) -> Self {
        let hour = hour_of_day(local_s);
        let day = (7.0..17.0).contains(&hour);
        let evening = if hour < 7.0 { local_s - 86_400.0 } else { local_s };
        match (day_of_week(evening) < 5, day) {
            (true, true) => Site::WeekdayDay,
            (true, false) => Site::WeekdayNight,
            (false, true) => Site::WeekendDay,
            (false, false) => Site::WeekendNight,
        }
    }
}

/// The times of a recording as the outside world sees them.
pub struct Moments<'a> {
    pub seed: u64,
    /// The recording's id, for its streams.
    pub id: &'a str,
    pub time_s: &'a [f64],
    /// Its zero on the campaign's clock, s.
    pub clock_s: f64,
    /// Its zero on the local clock, seconds since 1970, where a date is known.
    pub local_s: Option<f64>,
}

impl Moments<'_> {
    fn noise(&self, noise: &Noise, name: &str) -> Result<Vec<f64>, NoiseError> {
        let channel = format!("{}/{name}", self.id);
        noise::series(noise, self.seed, &channel, self.time_s.len(), Some(self.time_s))
    }

    /// Local time of a row; without a date the campaign begins on a Monday at 0 h.
    fn local(&self, row: usize) -> f64 {
        const MONDAY: f64 = 4.0 * 86_400.0;
        self.local_s.unwrap_or(MONDAY + self.clock_s) + self.time_s[row]
    }
}

impl OutsidePlan {
    /// The field at each moment, GEO, nT.
    pub fn field(&self, moments: &Moments<'_>) -> Result<Vec<Vector3<f64>>, NoiseError> {
        let mut field: Vec<Vector3<f64>> = (0..moments.time_s.len())
            .map(|row| {
                let daily = daily(hour_of_day(moments.local(row)));
                Vector3::from(self.main_field_nt) + Vector3::from(self.daily_nt).component_mul(&daily)
            })
            .collect();
        for axis in Axis::ALL {
            let mut add = |series: Vec<f64>| {
                field.iter_mut().zip(series).for_each(|(field, value)| field[axis.index()] += value);
            };
            if let Some(background) = &self.background {
                add(moments.noise(background, &format!("outside_{axis}"))?);
            }
            if let Some(storm) = &self.storm {
                let unrest = match &storm.unrest {
                    Some(noise) => moments.noise(noise, &format!("storm_{axis}"))?,
                    None => vec![0.0; moments.time_s.len()],
                };
                let since = moments.time_s.iter().map(|t| t + moments.clock_s - storm.time_s);
                add(since.zip(unrest).map(|(t, unrest)| storm.at(axis, t, unrest)).collect());
            }
        }
        Ok(field)
    }

    /// What the station magnetometer records of it.
    pub fn station(
        &self,
        moments: &Moments<'_>,
        field: &[Vector3<f64>],
    ) -> Result<[Vec<f64>; 3], NoiseError> {
        let mut columns = by_axis(field);
        if let Some(noise) = &self.station {
            for (axis, column) in Axis::ALL.iter().zip(&mut columns) {
                let errors = moments.noise(noise, &format!("station_{axis}"))?;
                column.iter_mut().zip(errors).for_each(|(value, error)| *value += error);
            }
        }
        Ok(columns)
    }
}

pub fn by_axis(field: &[Vector3<f64>]) -> [Vec<f64>; 3] {
    Axis::ALL.map(|axis| field.iter().map(|field| field[axis.index()]).collect())
}

impl Storm {
    /// Its field along one axis, t seconds after its beginning: s e^(−t/r) + d w(t), w = (1 − e^(−t/g))
    /// e^(−t/r) over its largest value; unrest grows and fades with w.
    fn at(&self, axis: Axis, t: f64, unrest: f64) -> f64 {
        if t < 0.0 {
            return 0.0;
        }
        let shape = |t: f64| (1.0 - (-t / self.growth_s).exp()) * (-t / self.recovery_s).exp();
        let deepest = self.growth_s * (1.0 + self.recovery_s / self.growth_s).ln();
        let weight = shape(t) / shape(deepest);
        let fading = (-t / self.recovery_s).exp();
        self.sudden_nt[axis.index()] * fading + weight * (self.depression_nt[axis.index()] + unrest)
    }
}

/// The daily variation of x, y, z at an hour of local time, each between about −1 and 1: the first three
/// harmonics of the quiet day at middle latitudes (Chapman and Bartels 1940): x and z lowest about noon, y
/// high in the morning and low in the afternoon.
fn daily(hour: f64) -> Vector3<f64> {
    let wave = |period: f64, peak: f64| (TAU * (hour - peak) / period).cos();
    let dip = -(0.6 * wave(24.0, 12.0) + 0.3 * wave(12.0, 12.0) + 0.1 * wave(8.0, 12.0));
    let swing = 0.6 * wave(24.0, 6.0) + 0.5 * wave(12.0, 8.5) + 0.2 * wave(8.0, 9.0);
    Vector3::new(dip, swing, dip)
}

impl SitePlan {
    /// All conditions.
    pub fn all(&self) -> [(Site, &SiteNoise); 4] {
        let Self { weekday_day, weekday_night, weekend_day, weekend_night } = self;
        let all = [weekday_day, weekday_night, weekend_day, weekend_night];
        Site::ALL.map(|site| (site, all[site as usize]))
    }

    /// The noise at each moment, GEO, nT, by the condition of that moment.
    pub fn field(&self, moments: &Moments<'_>) -> Result<Vec<Vector3<f64>>, NoiseError> {
        let conditions: Vec<Site> =
            (0..moments.time_s.len()).map(|row| Site::at(moments.local(row))).collect();
        let mut field = vec![Vector3::zeros(); conditions.len()];
        for (site, plan) in self.all().into_iter().filter(|(site, _)| conditions.contains(site)) {
            let hz = plan.mains_hz.unwrap_or(60.0);
            for axis in Axis::ALL {
                let noise = moments.noise(&plan.noise, &format!("{}_{axis}", site.name()))?;
                let amplitude = plan.mains_nt[axis.index()];
                for (row, noise) in noise.into_iter().enumerate() {
                    if conditions[row] == site {
                        let t = moments.time_s[row] + moments.clock_s;
                        field[row][axis.index()] += noise + amplitude * (TAU * hz * t).sin();
                    }
                }
            }
        }
        Ok(field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use common::time::Start;

    fn local(text: &str) -> f64 {
        Start::parse(text).expect("a moment").local_s()
    }

    #[test]
    fn conditions_of_the_site() {
        // 1977-05-26 was a Thursday.
        for (moment, site) in [
            ("1977-05-26T10:00:00-05:00", "weekday-day"),
            ("1977-05-26T22:00:00-05:00", "weekday-night"),
            ("1977-05-28T05:00:00-05:00", "weekday-night"),
            ("1977-05-28T12:00:00-05:00", "weekend-day"),
            ("1977-05-28T23:00:00-05:00", "weekend-night"),
            ("1977-05-30T05:00:00-05:00", "weekend-night"),
            ("1977-05-30T07:30:00-05:00", "weekday-day"),
        ] {
            assert_eq!(Site::at(local(moment)).name(), site, "{moment}");
        }
        for site in Site::ALL {
            // Nine hours and a little from its beginning.
            let (day, hour) = site.when();
            let monday = local("1977-05-23T00:00:00Z");
            for minute in 0..560 {
                let t = monday + f64::from(day) * 86_400.0 + hour * 3600.0 + f64::from(minute) * 60.0;
                assert_eq!(Site::at(t), site, "{} after {minute} min", site.name());
            }
        }
    }

    #[test]
    fn a_storm_begins_deepens_and_recovers() {
        let storm = Storm {
            time_s: 1000.0,
            sudden_nt: [30.0, 0.0, 0.0],
            depression_nt: [-150.0, 10.0, 40.0],
            growth_s: 7200.0,
            recovery_s: 40_000.0,
            unrest: None,
        };
        let outside = OutsidePlan { storm: Some(storm), ..OutsidePlan::default() };
        let time: Vec<f64> = (0..4000).map(|row| f64::from(row) * 100.0).collect();
        let moments = Moments { seed: 1, id: "run", time_s: &time, clock_s: 0.0, local_s: None };
        let x: Vec<f64> = outside.field(&moments).expect("a field").iter().map(|field| field.x).collect();
        assert_eq!((x[9], x[10]), (0.0, 30.0));
        let deepest = x.iter().copied().fold(0.0, f64::min);
        // At the depression's height some of the sudden commencement is left.
        assert!((-150.0..-120.0).contains(&deepest), "{deepest}");
        assert!(x[3999].abs() < 0.1, "{}", x[3999]);
    }

    #[test]
    fn the_quiet_day_has_its_size_and_its_hours() {
        let hours: Vec<f64> = (0..240).map(|tenth| f64::from(tenth) / 10.0).collect();
        for axis in 0..3 {
            let largest = hours.iter().map(|hour| daily(*hour)[axis].abs()).fold(0.0, f64::max);
            assert!((0.85..1.25).contains(&largest), "axis {axis}: {largest}");
        }
        let lowest = hours.iter().min_by(|a, b| daily(**a).x.total_cmp(&daily(**b).x));
        assert_eq!(lowest, Some(&12.0));
        assert!(daily(8.0).y > 0.5 && daily(14.0).y < -0.3, "{} {}", daily(8.0).y, daily(14.0).y);
    }
}
