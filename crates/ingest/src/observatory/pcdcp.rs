//! PCDCP: a line of station, day and unit; a row for each minute or second of that day, in whole hundredths
//! or thousandths of a nanotesla.
//!
//! `BOU  2014  305  01-Nov-14  HEZF  0.01nT  File Version 2.00`, then `0000  2086514    -2094  4745454
//! 5237425`.

use super::{Components, whole_numbers};
use crate::Error;
use crate::clock::{self, DAY_NS, SECOND_NS};
use crate::piece::Piece;
use crate::text::{Source, decoded, lines, quoted};

const MISSING: [i64; 2] = [9_999_999, 99_999_990];

fn header(bytes: &[u8]) -> Vec<String> {
    let first = lines(bytes).next().map_or(&[][..], |(_, line)| line);
    decoded(&first[..first.len().min(200)]).split_whitespace().map(str::to_string).collect()
}

pub fn is_meant(bytes: &[u8]) -> bool {
    let words = header(bytes);
    words.len() > 6 && words[4] == "HEZF" && unit_nt(&words[5]).is_some() && words[6] == "File"
}

fn unit_nt(word: &str) -> Option<f64> {
    word.strip_suffix("nT")?.parse().ok().filter(|unit: &f64| *unit > 0.0)
}

pub fn read(source: &Source, piece: &mut Piece) -> Result<Components, Error> {
    let words = header(&source.bytes);
    let number = |word: &str| word.parse::<i64>().ok();
    let of_year = number(&words[2]).filter(|day| (1..=366).contains(day));
    let first = number(&words[1]).and_then(|year| clock::day(year, 1, 1));
    let Some((first, of_year)) = first.zip(of_year) else {
        let found = format!("the day {} {}", words[1], words[2]);
        return Err(source.in_line(1, found, "a year and its day, as in BOU  2014  305"));
    };
    let start_ns = (first + of_year - 1) * DAY_NS;
    // Units are 1/100 and 1/1000: dividing by the whole number rounds once.
    let per_nt = unit_nt(&words[5]).map_or(100.0, |unit| (1.0 / unit).round());
    piece.station = Some(words[0].clone());
    piece.header.insert("unit".into(), words[5].clone().into());
    let mut columns = vec![Vec::new(); 4];
    for (number, line) in lines(&source.bytes).skip(1).filter(|(_, line)| !line.trim_ascii().is_empty()) {
        let text = decoded(line);
        let row = whole_numbers(&text, i64::MAX).filter(|numbers| numbers.len() == 5).and_then(|numbers| {
            // Four digits are minutes of the day, five its seconds.
            let digits = text.split_whitespace().next().map_or(0, str::len);
            let ns = numbers[0].checked_mul(if digits > 4 { 1 } else { 60 } * SECOND_NS)?;
            (0..DAY_NS).contains(&ns).then_some((ns, numbers))
        });
        let Some((ns, numbers)) = row else {
            let expected = "a minute (or second) of the day and four whole numbers; was the file cut?";
            return Err(source.in_line(number, quoted(line), expected));
        };
        piece.times_ns.push(start_ns + ns);
        piece.lines.push(number);
        for (column, value) in columns.iter_mut().zip(&numbers[1..]) {
            column.push(if MISSING.contains(value) { f64::NAN } else { *value as f64 / per_nt });
        }
    }
    Ok((words[4].chars().collect(), columns))
}
