//! Other observatories: vector against scalar.

use serde_json::{Value, json};
use std::fs;

use super::scalar::{self, PLANE, Scalar};
use crate::Error;
use crate::known::KnownFact;
use crate::page::{Page, array, quantity, three};
use crate::series::{Series, mean, rms};
use crate::split::Split;
use crate::stages::Stages;

const DIDD: &str = include_str!("../../../../fixtures/ingest/real/didd.json");
const PROTON: &str = include_str!("../../../../fixtures/ingest/real/proton.json");
/// A difference farther from the day's middle is an outlier of the proton magnetometer.
const OUTLIER_NT: f64 = 20.0;
/// A reading farther from the day's middle is one: a storm stays within.
const FARTHEST_NT: f64 = 300.0;

/// Conrad: 2022-08-03 fitted, 2022-08-10 left out.
pub fn conrad(stages: &Stages) -> Result<Page, Error> {
    let read = |name: String| stages.ingest(&[stages.file(&format!("wic-conrad-2022-08/{name}"))?], None);
    let day = |date: &str| -> Result<Series, Error> {
        let vector = read(format!("fge_s0252_{date}_1s.csv"))?;
        let scalar = read(format!("gp20s3_scalar_{date}.csv"))?.renamed("sensor", "reference");
        let scalar = scalar.on_clock(vector.start_s);
        Ok(vector.means(60.0).joined(&scalar.means(60.0)).complete())
    };
    let mut page = Page::default();
    page.say(
        "FGE S0252 and the potassium magnetometer GP20S3 on another pier, means of a minute. The FGE's readings are variations: its compensation, −20.68 µT and −43.45 µT, \
         is added as an offset. One day is fitted; another, a week later, is held out.",
    );
    let scalar = Scalar {
        fitted: day("2022-08-03")?,
        left_out: day("2022-08-10")?,
        parts: ["2022-08-03", "2022-08-10"],
        offset_nt: [20_680.0, 0.0, 43_450.0],
        by_hand: PLANE,
        plot: Some("real-conrad-scalar.svg"),
        of: "",
    };
    scalar::study(stages, &mut page, &scalar)?;
    scalar::by_scalarcal(stages, &mut page, &scalar)?;
    page.undecided(
        "the orientation of the vector instrument; which constant is wrong (the compensation in x or z, a scale, or the difference of some \
        nT between the piers), since the direction of the field is constant; the temperature coefficient stated by the maker (0.25 nT/K), \
        because the temperature of the tunnel is not in the file and hardly changes.",
    );
    Ok(page)
}

/// Vernadsky: sixteen hours fitted, eight left out.
pub fn vernadsky(stages: &Stages) -> Result<Page, Error> {
    let file = stages.file("aia-vernadsky-2020-03-03/SXY20200303vsec.sec")?;
    let series = stages.ingest(&[file], None)?.complete();
    let split = Split::at(&series.means(60.0), 16.0 * 3600.0);
    let mut page = Page::default();
    page.say(
        "LEMI-025 and a scalar reading each ten seconds, 2020-03-03, means of a minute. The header states the compensation, −19777.5, −5570.0 and 31837.5 nT, which is \
         taken off the readings.",
    );
    let scalar = Scalar {
        fitted: split.fitted,
        left_out: split.left_out,
        parts: ["0 to 16 h", "16 to 24 h"],
        offset_nt: [19_777.5, 5_570.0, -31_837.5],
        by_hand: PLANE,
        plot: Some("real-vernadsky.svg"),
        of: "",
    };
    scalar::study(stages, &mut page, &scalar)?;
    scalar::by_scalarcal(stages, &mut page, &scalar)?;
    page.undecided(
        "anything but a level: the residual scatters by less than a tenth of a nT over the day, and a fit to so little would predict the \
        evening worse than its mean does. Neither the orientation nor the constant behind the level is determined.",
    );
    Ok(page)
}

/// Cobenzl: the proton magnetometer against the DIDD's own total field, by shifts of its clock, then by
/// diagnose on two days.
pub fn cobenzl(stages: &Stages) -> Result<Page, Error> {
    let folder = "wik-cobenzl-2011-09a";
    let didd = stages.ingest(&stages.files(&format!("{folder}/didd"), ".WIK")?, Some(DIDD))?;
    let mut days = Vec::new();
    for file in stages.files(&format!("{folder}/pmag"), ".txt")? {
        let text = fs::read_to_string(&file).map_err(|source| Error::file(&file, "read", source))?;
        let apart = text.lines().next().and_then(clocks_apart_s);
        let series = match stages.ingest(&[file], Some(PROTON)) {
            Ok(series) => Ok(series.on_clock(didd.start_s)),
            Err(Error::Program { words, .. }) => Err(words),
            Err(error) => return Err(error),
        };
        days.push((apart, series));
    }
    let mut page = Page::default();
    page.say(
        "A proton magnetometer, every ten seconds, beside the DIDD. Two clocks stand in its file, the log's and the instrument's, and differ by 32 s on the first day and more later; \
         nothing says which is right. The field says: by how much must the log's times be moved for the two to agree?",
    );
    let shifts: Vec<f64> = (-12..=12).map(|k| 5.0 * f64::from(k)).collect();
    let (mut rows, mut log_fits) = (Vec::new(), 0);
    for (number, (apart, day)) in days.iter().enumerate() {
        let name = format!("{} September", number + 1);
        let Ok(proton) = day else { continue };
        let left: Vec<f64> = shifts.iter().map(|shift| scatter(&didd, proton, *shift)).collect();
        let best = left.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let Some((best, least)) = best else { continue };
        let by_instrument = apart.map(|apart| scatter(&didd, proton, -apart));
        log_fits += usize::from(by_instrument.is_some_and(|nt| nt > left[shifts.len() / 2]));
        let apart = apart.map_or("unknown".into(), |s| format!("{s:+.0}"));
        let moved = format!("{:+.0}", shifts[best]);
        let instrument = by_instrument.map_or("unknown".into(), three);
        rows.push(vec![
            name,
            apart,
            three(left[shifts.len() / 2]),
            instrument,
            format!("{} at {moved} s", three(least)),
        ]);
    }
    page.say(format!(
        "Standard deviation of the difference, nT, by steps of 5 s (readings farther than {OUTLIER_NT} nT from the day's middle are left out):"
    ));
    page.table(
        &["day", "log less instrument, s", "by the log, nT", "by the instrument, nT", "least of all shifts"],
        &rows,
    );
    page.head(format!(
        "The field agrees with the log's clock, and not with the instrument's, on {log_fits} of {} days.",
        rows.len()
    ));
    page.say(format!(
        "The log's clock fits better than the instrument's on {log_fits} of {} days.",
        rows.len()
    ));
    for (number, (_, day)) in days.iter().enumerate() {
        if let Err(words) = day {
            let words = words.rsplit_once('/').map_or(words.as_str(), |(_, name)| name);
            page.say(format!("{} September:", number + 1));
            page.refused("ingest", words);
        }
    }
    let vector = didd.clone().only(|name| name != "reference_nt");
    let joined = |day: &Series| {
        let readings = day.column("reference_nt");
        let level = median(readings);
        vector.joined(&centred(&day.filter(|row| (readings[row] - level).abs() < FARTHEST_NT))).complete()
    };
    if let (Some((_, Ok(fitted))), Some((_, Ok(left_out)))) = (days.get(8), days.get(9)) {
        let scalar = Scalar {
            fitted: joined(fitted),
            left_out: joined(left_out),
            parts: ["9 September, storm", "10 September"],
            offset_nt: [0.0; 3],
            by_hand: PLANE,
            plot: None,
            of: "",
        };
        let recording =
            joined(&late(fitted, days[8].0.unwrap_or(0.0))).recording("vector-scalar", "free_run");
        scalar::study(stages, &mut page, &scalar)?;
        scalar::by_scalarcal(stages, &mut page, &scalar)?;
        if let Ok(document) = stages.stage("diagnose", &[], vec![recording], &json!({}))? {
            let clock = |effect: &&Value| effect["effect"] == "clock_offset";
            let found = array(&document["diagnosis"][0]["effects"]).find(clock);
            let offset = found.map(|effect| quantity(&effect["parameters"]["offset_s"]));
            page.known.push(KnownFact {
                from: "the field at Cobenzl, by shifts of the clock",
                what: "the proton magnetometer's own clock is off by half a minute and more; 9 September by that clock",
                stage: "diagnose",
                answer: offset.map_or("no clock named".into(), |s| format!("`clock_offset` {s} s")),
                found: found.is_some(),
            });
        }
    }
    page.undecided(
        "the clock to better than about 5 s; which instrument the scatter of the disturbed days belongs to (trams, at two places); whether \
        the DIDD's F is correct, since it is computed from its own X, Y and Z; the orientation of either.",
    );
    Ok(page)
}

/// What the log's clock is ahead of the instrument's in a line of the proton magnetometer, `00:00:04  48520,3
/// 0831235932`, s.
fn clocks_apart_s(line: &str) -> Option<f64> {
    let mut fields = line.split_whitespace();
    let (log, instrument) = (fields.next()?.replace(':', ""), fields.nth(1)?);
    let second_of_day = |digits: &str| -> Option<f64> {
        let part = |at: usize| digits.get(at..at + 2)?.parse::<f64>().ok();
        Some(3600.0 * part(0)? + 60.0 * part(2)? + part(4)?)
    };
    let apart = second_of_day(&log)? - second_of_day(instrument.get(4..)?)?;
    Some((apart + 43_200.0).rem_euclid(86_400.0) - 43_200.0)
}

/// The same readings at the times of the instrument's own clock, which the log's is ahead of.
fn late(proton: &Series, apart_s: f64) -> Series {
    let times = proton.column("time_s").iter().map(|t| t - apart_s).collect();
    proton.clone().with("time_s", times)
}

/// Means of a minute about the whole minute, as the DIDD gives them.
fn centred(proton: &Series) -> Series {
    let half = proton.column("time_s").iter().map(|t| t + 30.0).collect();
    let means = proton.clone().with("time_s", half).means(60.0);
    let back = means.column("time_s").iter().map(|t| t - 30.0).collect();
    means.with("time_s", back)
}

/// Standard deviation of the DIDD's total field less the proton magnetometer's, whose times are moved by
/// `shift` s, nT.
fn scatter(didd: &Series, proton: &Series, shift: f64) -> f64 {
    let moved = proton.column("time_s").iter().map(|t| t + shift).collect();
    let proton = centred(&proton.clone().with("time_s", moved));
    let values = proton.column("reference_nt").to_vec();
    let joined = didd.joined(&proton.only(|name| name == "time_s").with("proton_nt", values));
    let pairs = joined.column("reference_nt").iter().zip(joined.column("proton_nt"));
    let difference: Vec<f64> = pairs.map(|(didd, proton)| didd - proton).collect();
    let middle = median(&difference);
    let near: Vec<f64> = difference.into_iter().filter(|d| (d - middle).abs() < OUTLIER_NT).collect();
    let level = mean(near.iter().copied());
    rms(near.iter().map(|d| d - level))
}

fn median(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_clocks_in_one_line_over_midnight() {
        assert_eq!(clocks_apart_s("00:00:04\t48520,3\t0831235932"), Some(32.0));
        assert_eq!(clocks_apart_s("23:59:40\t48521,9\t0908235902"), Some(38.0));
        assert_eq!(clocks_apart_s("23:59:40\t48521,9"), None);
    }

    #[test]
    fn a_minute_is_about_its_whole_minute() {
        let readings = Series::default()
            .with("time_s", (0..18).map(|k| 10.0 * f64::from(k)).collect())
            .with("reference_nt", (0..18).map(f64::from).collect());
        let means = centred(&readings);
        assert_eq!(means.column("time_s"), [60.0, 120.0]);
        assert_eq!(means.column("reference_nt"), [5.5, 11.5]);
    }
}
