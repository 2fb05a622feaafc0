//! The baselines of a document as INTERMAGNET's file of a year.

use common::time::Start;
use common::{AbsoluteSet, Document, Error, Quantity, Recording};
use estimate::stats::mean;
use jiff::civil::date;
use jiff::tz::TimeZone;
use jiff::{Timestamp, Zoned};

use crate::formats::ibf::{Adopted, Baselines, text};
use crate::variometer::{DELTA_F, adopted};

const NOON_S: f64 = 43_200.0;

fn calendar(unix_s: f64) -> Zoned {
    Timestamp::from_second(unix_s as i64).unwrap_or_default().to_zoned(TimeZone::UTC)
}

/// IBFV2.00 of the year in which most measurements are: observed values, and those adopted at noon of every day.
///
/// # Errors
///
/// A document without adopted baselines; what the format cannot hold.
pub fn ibf(document: &Document, station: &str) -> Result<String, Error> {
    let found = adopted(document).zip(document.calibration.as_ref().and_then(|all| all.absolute.as_ref()));
    let Some(((components, baselines), absolute)) = found else {
        let expected = "baselines of a variometer, which absolute adopts";
        return Err(Error::document("calibration.absolute.adopted", "none", expected));
    };
    let moments: Vec<(&AbsoluteSet, Zoned)> = (absolute.sets.iter())
        .filter_map(|set| Some((set, calendar(Start::parse(&set.time)?.unix_s))))
        .collect();
    let count = |year: i16| moments.iter().filter(|(_, moment)| moment.year() == year).count();
    let year = moments.iter().map(|(_, moment)| moment.year()).max_by_key(|year| (count(*year), -year));
    let year = year.unwrap_or_default();
    let of_year = moments.iter().filter(|(_, moment)| moment.year() == year);
    let pillar = baselines.pillar_difference_nt;
    let observed = of_year.clone().map(|(set, moment)| {
        let mut values = [f64::NAN, f64::NAN, f64::NAN, pillar];
        set.baseline.values().zip(&mut values).for_each(|(value, place)| *place = value.value());
        (moment.day_of_year() as u16, values)
    });
    let origin_s = Start::parse(&baselines.start).map_or(0.0, |origin| origin.unix_s);
    let first =
        date(year, 1, 1).to_zoned(TimeZone::UTC).map_or(0.0, |day| day.timestamp().as_second() as f64);
    let days = date(year, 1, 1).days_in_year();
    let delta = delta_f(document, first, days as usize);
    let steps: Vec<f64> = (baselines.components.values())
        .flat_map(|one| &one.steps)
        .filter_map(|step| Some(Start::parse(&step.time)?.unix_s))
        .collect();
    let day = |day: usize| {
        let noon_s = first + day as f64 * 2.0 * NOON_S + NOON_S;
        let mut values = [f64::NAN; 4];
        if let Some(known) = baselines.at(noon_s - origin_s) {
            known.iter().zip(&mut values).for_each(|([value, _], place)| *place = *value);
            values[3] = pillar;
        }
        let is_step = steps.iter().any(|step| (noon_s - 2.0 * NOON_S..noon_s).contains(step));
        Adopted { baselines: values, delta_f_nt: delta[day], is_step }
    };
    let means = |of: fn(&AbsoluteSet) -> Option<&Quantity>| {
        let all: Vec<f64> = of_year.clone().filter_map(|(set, _)| Some(of(set)?.value())).collect();
        mean(&all)
    };
    let courses = baselines.components.iter().map(|(key, one)| {
        format!(
            "{key}: {}; scatter of the measurements {:.3} beyond their own uncertainty.",
            one.course, one.scatter_std
        )
    });
    let comments =
        std::iter::once("Baselines adopted by the evidence of courses, averaged.".to_string()).chain(courses);
    text(&Baselines {
        station,
        year,
        components: if components.name() == "hez" { "HDZF" } else { "XYZF" },
        annual_means_nt: [means(|set| set.h_nt.as_ref()), means(|set| set.f_nt.as_ref())],
        observed: observed.collect(),
        adopted: (0..days as usize).map(day).collect(),
        comments: comments.collect(),
    })
}

/// Mean ΔF of each day, of the recordings that were corrected.
fn delta_f(document: &Document, first_s: f64, days: usize) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; days];
    let of = |one: &Recording| {
        Some((one.start()?.unix_s, one.column("time_s")?.to_vec(), one.column(DELTA_F)?.to_vec()))
    };
    for (start, times, values) in document.recordings.iter().filter_map(of) {
        for (time, value) in times.iter().zip(values).filter(|(_, value)| value.is_finite()) {
            let day = ((start + time - first_s) / (2.0 * NOON_S)).floor();
            if let Some(sum) = sums.get_mut(day as usize).filter(|_| day >= 0.0) {
                *sum = [sum[0] + value, sum[1] + 1.0];
            }
        }
    }
    sums.into_iter().map(|[sum, count]| sum / count).collect()
}
