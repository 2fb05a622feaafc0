//! IBFV2.00, INTERMAGNET's yearly baseline file (Technical Reference Manual, appendix on data formats;
//! <https://tech-man.intermagnet.org/stable/appendices/dataformats.html>): those observed, those adopted for each day,
//! comments. Lines of a fixed length that end with CrLf.

use common::Error;
use jiff::civil::Date;

use super::station_code;

/// What is missing, and what is never observed: a component, nT; Delta F.
const CODES: [[f64; 2]; 2] = [[99_999.0, 88_888.0], [999.0, 888.0]];
/// Components as the header names them.
const COMPONENTS: [&str; 4] = ["XYZF", "HDZF", "DIF", "UVZF"];
/// Characters of a line of comments at most.
const COMMENT: usize = 53;

/// Baselines of a year, absolute − recorded: nT, degrees for D and I. NaN is missing; a component without any value
/// counts as not observed.
pub(crate) struct Baselines<'a> {
    /// Three letters.
    pub station: &'a str,
    pub year: i16,
    /// One of XYZF, HDZF, DIF, UVZF.
    pub components: &'a str,
    /// Of H and F, nT.
    pub annual_means_nt: [f64; 2],
    /// Day of the year; the three components and the scalar magnetometer.
    pub observed: Vec<(u16, [f64; 4])>,
    /// For each day of the year.
    pub adopted: Vec<Adopted>,
    /// How the baselines were adopted, and other remarks.
    pub comments: Vec<String>,
}

/// What holds on a day.
#[derive(Clone, Copy)]
pub(crate) struct Adopted {
    /// As of [`Baselines::observed`].
    pub baselines: [f64; 4],
    /// |vector| − scalar at the absolute pier, nT.
    pub delta_f_nt: f64,
    /// Whether something was changed since the day before, so that baselines have a step.
    pub is_step: bool,
}

/// The file's text.
///
/// # Errors
///
/// A code or components that the format does not have, days that the year does not have or that are left out, values
/// as large as the codes, no comment.
pub(crate) fn text(baselines: &Baselines<'_>) -> Result<String, Error> {
    let Baselines { year, components, adopted, .. } = baselines;
    let station = station_code(baselines.station, 3)?;
    let known = COMPONENTS.iter().find(|known| *known == components);
    let components =
        known.ok_or_else(|| refused(&format!("the components {components}"), "XYZF, HDZF, DIF or UVZF"))?;
    // "DIF" has three letters in a field of four.
    let components = format!("{components:<4}");
    let first = Date::new(*year, 1, 1).ok().filter(|first| first.year() > 999);
    let days =
        first.ok_or_else(|| refused(&format!("the year {year}"), "one of four digits"))?.days_in_year();
    let mut observed = baselines.observed.clone();
    observed.sort_by_key(|(day, _)| *day);
    if let Some((day, _)) = observed.iter().find(|(day, _)| !(1..=days as u16).contains(day)) {
        return Err(refused(&format!("day {day}"), &format!("a day of {year}, 1 to {days}")));
    }
    if adopted.len() != days as usize {
        let found = format!("adopted baselines of {} days", adopted.len());
        return Err(refused(&found, &format!("one for each of the {days} days of {year}")));
    }
    let said: Vec<String> = baselines.comments.iter().flat_map(|comment| wrapped(comment)).collect();
    if said.is_empty() || !said.iter().all(|line| line.is_ascii()) {
        return Err(refused(
            "no comment, or one that is not ASCII",
            "a comment in ASCII on how the baselines were adopted, required by IBF",
        ));
    }
    let all = || observed.iter().map(|day| day.1).chain(adopted.iter().map(|day| day.baselines));
    let is_there = [0, 1, 2, 3].map(|column| all().any(|values| values[column].is_finite()));
    let has_delta = adopted.iter().any(|day| day.delta_f_nt.is_finite());
    let line = |day: u16, values: &[f64; 4]| -> Result<String, Error> {
        let mut text = format!("{day:03}");
        for ((value, letter), is_there) in values.iter().zip(components.chars()).zip(is_there) {
            let stored = if matches!(letter, 'D' | 'I') { 60.0 * value } else { *value };
            text += &format!(" {:9.2}", number(stored, is_there, CODES[0])?);
        }
        Ok(text)
    };
    let [h, f] = baselines.annual_means_nt.map(|mean| number(mean, true, CODES[0]));
    let mut lines = vec![format!("{components} {:5.0} {:5.0} {station} {year}", h?, f?)];
    for (day, values) in &observed {
        lines.push(line(*day, values)?);
    }
    lines.push("*".into());
    for (day, Adopted { baselines, delta_f_nt, is_step }) in (1..).zip(adopted) {
        let (delta, mark) = (number(*delta_f_nt, has_delta, CODES[1])?, if *is_step { 'd' } else { 'c' });
        lines.push(format!("{} {delta:7.2} {mark}", line(day, baselines)?));
    }
    lines.extend(["*".to_string(), "Comments:".into()].into_iter().chain(said));
    Ok(lines.iter().map(|line| format!("{line}\r\n")).collect())
}

fn refused(found: &str, expected: &str) -> Error {
    Error::Request(format!("found {found}; expected {expected}"))
}

/// A number as the file has it, or the code of a missing or unobserved one.
fn number(value: f64, is_there: bool, [missing, not_observed]: [f64; 2]) -> Result<f64, Error> {
    match value.is_finite() {
        true if value.abs() < not_observed - 0.5 => Ok(value),
        true => Err(refused(&value.to_string(), &format!("less than {not_observed}, a code of IBF"))),
        false => Ok(if is_there { missing } else { not_observed }),
    }
}

/// Lines of words.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let letters: Vec<Vec<char>> = text.split_whitespace().map(|word| word.chars().collect()).collect();
    for word in letters.iter().flat_map(|word| word.chunks(COMMENT)).map(String::from_iter) {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= COMMENT => *line += &format!(" {word}"),
            _ => lines.push(word),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: f64 = f64::NAN;

    /// Three lines of Dourbes' file of 2020 (INTERMAGNET, dou2020.blv), the first as the adopted baseline of all days.
    fn dourbes() -> Baselines<'static> {
        let first = [112.08 / 60.0, 3933.77 / 60.0, 48_779.32, NONE];
        let day = |is_step| Adopted { baselines: first, delta_f_nt: NONE, is_step };
        Baselines {
            station: "dou",
            year: 2020,
            components: "DIF",
            annual_means_nt: [20_173.0, 48_762.0],
            observed: vec![(21, [112.0 / 60.0, 3933.73 / 60.0, NONE, NONE]), (6, first)],
            adopted: (1..=366).map(|number| day(number == 100)).collect(),
            comments: vec!["Adopted by eye ".repeat(8), "x".repeat(60)],
        }
    }

    #[test]
    fn lines_have_the_layout_of_a_published_file() {
        let text = text(&dourbes()).expect("a file");
        let lines: Vec<&str> = text.split_terminator("\r\n").collect();
        assert!(
            text.is_ascii() && text.ends_with("\r\n") && !text.replace("\r\n", "").contains(['\r', '\n'])
        );
        assert_eq!(lines[0], "DIF  20173 48762 DOU 2020");
        assert_eq!(lines[1], "006    112.08   3933.77  48779.32  88888.00");
        assert_eq!(lines[2], "021    112.00   3933.73  99999.00  88888.00");
        assert_eq!((lines[3], lines[370], lines[371]), ("*", "*", "Comments:"));
        for (day, line) in (1..=366).zip(&lines[4..370]) {
            let mark = if day == 100 { 'd' } else { 'c' };
            assert_eq!(*line, format!("{day:03}{}  888.00 {mark}", &lines[1][3..]));
            assert_eq!(line.len(), 53);
        }
        assert!(lines[372..].iter().all(|line| line.len() <= 53) && lines.len() == 372 + 3 + 2);
    }

    #[test]
    fn what_is_missing_now_and_then_has_another_code() {
        let mut year = Baselines { components: "HDZF", year: 2023, ..dourbes() };
        year.adopted.truncate(365);
        year.adopted[0] =
            Adopted { baselines: [-5.004, -0.5, NONE, 0.25], delta_f_nt: -0.126, is_step: true };
        let text = text(&year).expect("a file");
        assert!(text.starts_with("HDZF 20173 48762 DOU 2023\r\n"));
        assert!(text.contains("\r\n001     -5.00    -30.00  99999.00      0.25   -0.13 d\r\n"), "{text}");
        assert!(text.contains("\r\n002      1.87   3933.77  48779.32  99999.00  999.00 c\r\n"), "{text}");
    }

    #[test]
    fn what_the_format_cannot_hold_is_refused() {
        let refusal = |change: fn(&mut Baselines<'static>)| {
            let mut year = dourbes();
            change(&mut year);
            text(&year).expect_err("refused").to_string()
        };
        assert!(refusal(|year| year.station = "DOUR").contains("expected three letters"));
        assert!(refusal(|year| year.components = "DHZ").contains("XYZF, HDZF, DIF or UVZF"));
        assert!(refusal(|year| year.year = 2021).contains("each of the 365 days of 2021"));
        assert!(refusal(|year| year.year = 209).contains("four digits"));
        assert!(refusal(|year| year.observed[0].0 = 367).contains("1 to 366"));
        assert!(refusal(|year| year.adopted[7].baselines[2] = 99_999.0).contains("less than 88888"));
        assert!(refusal(|year| year.adopted[7].delta_f_nt = 900.0).contains("less than 888"));
        assert!(refusal(|year| year.comments.clear()).contains("on how the baselines were adopted"));
    }

    #[test]
    fn ingest_reads_what_was_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("dou2020.blv");
        std::fs::write(&path, text(&dourbes()).expect("a file")).expect("written");
        let read = ingest::run(Default::default(), &[path], &Default::default()).expect("read");
        let recording = &read.document.recordings[0];
        let column = |name: &str| recording.column(name).expect(name);
        assert_eq!(column("adopted_baseline_d_deg").len(), 366);
        assert!((column("observed_baseline_i_deg")[5] - 3933.77 / 60.0).abs() < 0.005 / 60.0);
        assert!((column("adopted_baseline_f_nt")[365] - 48_779.32).abs() < 0.005);
        assert_eq!(recording.start.as_deref(), Some("2020-01-01T12:00:00Z"));
    }
}
