//! The baselines of a document as INTERMAGNET's yearly baseline file.

use common::time::Start;
use common::{AbsoluteSet, Document, Error, Quantity, Recording};
use estimate::stats::mean;
use jiff::Zoned;
use jiff::civil::date;
use jiff::tz::TimeZone;

use crate::Frame;
use crate::formats::calendar;
use crate::formats::ibf::{Adopted, Baselines, text};
use crate::noise::DAY_S;
use crate::variometer::{DELTA_F, adopted, is_by_baselines};

/// IBFV2.00 of the year in which most measurements are: observed values, and those adopted at noon of every day.
///
/// # Errors
///
/// A document without adopted baselines; what the format cannot hold.
pub fn ibf(document: Document, station: &str) -> Result<String, Error> {
    // Daily means of ΔF are those of the variometer's readings, where they are at hand.
    let is_there = |one: &Recording| crate::is_corrected(one) && is_by_baselines(&document, one);
    let is_there = document.recordings.iter().any(is_there);
    let document = &if is_there { crate::run(document, Frame::Geo)? } else { document };
    let found = adopted(document).zip(document.calibration.as_ref().and_then(|all| all.absolute.as_ref()));
    let Some(((components, baselines), absolute)) = found else {
        let expected = "baselines of a variometer, which absolute adopts";
        return Err(Error::document("calibration.absolute.adopted", "none", expected));
    };
    let moments: Vec<(&AbsoluteSet, Zoned)> = (absolute.sets.iter())
        .filter_map(|set| Some((set, calendar((Start::parse(&set.time)?.unix_s * 1e9) as i64))))
        .collect();
    let count = |year: i16| moments.iter().filter(|(_, moment)| moment.year() == year).count();
    let year = moments.iter().map(|(_, moment)| moment.year()).max_by_key(|year| (count(*year), -year));
    let year = year.unwrap_or_default();
    let of_year = moments.iter().filter(|(_, moment)| moment.year() == year);
    let (keys, pillar) = (components.keys(), baselines.pillar_difference_nt);
    let observed = of_year.clone().map(|(set, moment)| {
        let [x, y, z] = keys.map(|key| set.baseline.get(key).map_or(f64::NAN, Quantity::value));
        (moment.day_of_year() as u16, [x, y, z, pillar])
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
        let noon_s = first + (day as f64 + 0.5) * DAY_S;
        let [x, y, z] =
            keys.map(|key| baselines.at(key, noon_s - origin_s).map_or(f64::NAN, |[value, _]| value));
        let scalar = if x.is_nan() { f64::NAN } else { pillar };
        let is_step = steps.iter().any(|step| (noon_s - DAY_S..noon_s).contains(step));
        Adopted { baselines: [x, y, z, scalar], delta_f_nt: delta[day], is_step }
    };
    let means = |of: fn(&AbsoluteSet) -> Option<&Quantity>| {
        let all: Vec<f64> = of_year.clone().filter_map(|(set, _)| Some(of(set)?.value())).collect();
        mean(&all)
    };
    let courses = baselines.components.iter().map(|(key, one)| {
        let unit = if key.ends_with("_deg") { "deg" } else { "nT" };
        format!("{key}: {}; excess scatter {:.4} {unit}.", one.trend, one.scatter_std)
    });
    let comments =
        std::iter::once("Adopted baselines: model average weighted by Bayesian evidence. Annual means are those of the measurements.".to_string()).chain(courses);
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
            let day = ((start + time - first_s) / DAY_S).floor();
            if let Some(sum) = sums.get_mut(day as usize).filter(|_| day >= 0.0) {
                *sum = [sum[0] + value, sum[1] + 1.0];
            }
        }
    }
    sums.into_iter().map(|[sum, count]| sum / count).collect()
}
