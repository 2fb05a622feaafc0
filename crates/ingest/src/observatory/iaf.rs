//! INTERMAGNET's archive format (IAF 1.00 to 2.11): a file a month, a day in 5888 little-endian words of 32 bits.
//! 16 words of header, then 1440 minute means of each of four elements in tenths of nT or of a minute of arc,
//! then hourly and daily means and K indices, which are not read. A minute mean is centred on its minute.

use common::number::counted;
use tables::Place;

use super::{Components, elements, header, scaled};
use crate::Error;
use crate::clock::{self, DAY_NS, SECOND_NS};
use crate::piece::Piece;
use crate::text::{Source, decoded, quoted};

const HEADER_WORDS: usize = 16;
const MINUTES: usize = 1440;
const DAY_BYTES: usize = 4 * 5888;
/// Six digits: the missing value is the largest.
const MOST: i32 = 999_999;
/// By the first byte of word 15.
const VERSIONS: [&str; 5] = ["1.00", "1.10", "2.00", "2.10", "2.11"];
/// A scalar that was missing when G = |vector| − scalar was computed leaves less than this, tenths of nT.
const LEAST_DIFFERENCE: i32 = -444_400;

struct Day<'a> {
    source: &'a Source,
    at: usize,
    words: &'a [[u8; 4]],
}

impl Day<'_> {
    fn number(&self, index: usize) -> i32 {
        i32::from_le_bytes(self.words[index])
    }

    fn text(&self, index: usize) -> String {
        let letters = self.words[index].map(|byte| if byte == 0 { b' ' } else { byte });
        decoded(letters.trim_ascii()).into_owned()
    }

    /// The fault of a word of the header, counted from 1 as the format does.
    fn fault(&self, word: usize, found: String, expected: &str) -> Error {
        let found = format!("{found} in word {word} of the day at byte {}", self.at);
        self.source.fault(Place::Whole, found, expected)
    }

    /// Days since 1970, from YYYYDDD.
    fn day(&self) -> Result<i64, Error> {
        let (year, of_year) = (i64::from(self.number(1) / 1000), i64::from(self.number(1) % 1000));
        let day = clock::day(year, 1, 1).zip(clock::day(year + 1, 1, 1));
        let day = day.filter(|(first, next)| (1..=next - first).contains(&of_year));
        day.map(|(first, _)| first + of_year - 1).ok_or_else(|| {
            let expected =
                "year and day of the year, as in 2024366; was the file damaged or joined with another?";
            self.fault(2, format!("{} as the day", self.number(1)), expected)
        })
    }

    /// The letters of the four elements. Where the header names three, the fourth is the scalar.
    fn letters(&self) -> Result<Vec<char>, Error> {
        let letters = elements(&self.text(5)).filter(|letters| (3..=4).contains(&letters.len()));
        let mut letters = letters.ok_or_else(|| {
            let found = format!("the orientation {}", quoted(self.text(5).as_bytes()));
            self.fault(6, found, "the elements, as in XYZG or HDZF")
        })?;
        if letters.len() == 3 {
            letters.push(if letters.contains(&'F') { 'S' } else { 'F' });
        }
        Ok(letters)
    }

    /// Latitude and longitude, degrees.
    fn place(&self) -> Result<[f64; 2], Error> {
        for (index, what, range) in [(2, "colatitude", 0..=180_000), (3, "longitude", -180_000..=360_000)] {
            if !range.contains(&self.number(index)) {
                let (low, high) = range.into_inner();
                let expected = format!("{low} to {high}, in thousandths of a degree; was the file damaged?");
                return Err(self.fault(index + 1, format!("the {what} {}", self.number(index)), &expected));
            }
        }
        Ok([90_000 - self.number(2), self.number(3)].map(|thousandths| f64::from(thousandths) / 1000.0))
    }

    fn version(&self) -> Option<&'static str> {
        VERSIONS.get(usize::from(self.words[14][0])).copied()
    }
}

pub fn read(source: &Source, piece: &mut Piece) -> Result<Components, Error> {
    let size = source.bytes.len();
    if !size.is_multiple_of(DAY_BYTES) {
        let (days, bytes) = (counted(size / DAY_BYTES, "day"), counted(size % DAY_BYTES, "byte"));
        let found = format!("{days} and {bytes} of another");
        let expected = format!("whole days of {DAY_BYTES} bytes (IAF); was the file cut, or copied as text?");
        return Err(source.fault(Place::Whole, found, expected));
    }
    let (words, _) = source.bytes.as_chunks::<4>();
    let days = words.chunks_exact(DAY_BYTES / 4).enumerate();
    let days: Vec<Day> = days.map(|(index, words)| Day { source, at: index * DAY_BYTES, words }).collect();
    let Some(first) = days.first() else { return Err(source.no_row()) };
    let letters = first.letters()?;
    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(days.len() * MINUTES); letters.len()];
    let (mut not_observed, mut without_scalar) = (vec![0; letters.len()], 0);
    for day in &days {
        let (start_ns, _) = (day.day()? * DAY_NS, day.place()?);
        for (index, what) in [(0, "station"), (5, "orientation")] {
            if day.text(index) != first.text(index) {
                let found = format!("the {what} {}", quoted(day.text(index).as_bytes()));
                let expected =
                    format!("{} as on the first day; give such files one by one", first.text(index));
                return Err(day.fault(index + 1, found, &expected));
            }
        }
        piece.times_ns.extend((0..MINUTES as i64).map(|minute| start_ns + minute * 60 * SECOND_NS));
        for (element, (name, column)) in letters.iter().zip(&mut columns).enumerate() {
            for minute in 0..MINUTES {
                let word = HEADER_WORDS + element * MINUTES + minute;
                let stored = day.number(word);
                if stored.unsigned_abs() > MOST.unsigned_abs() {
                    let found = format!("{stored} for {name} at minute {minute}");
                    return Err(day.fault(word + 1, found, "six digits at most; was the file damaged?"));
                }
                let is_no_difference = *name == 'G' && stored < LEAST_DIFFERENCE;
                without_scalar += usize::from(is_no_difference);
                not_observed[element] += usize::from(stored == 888_888);
                column.push(if is_no_difference { f64::NAN } else { scaled(stored.into(), 10.0) });
            }
        }
    }
    piece.lines = (1..=piece.times_ns.len() as u32).collect();
    for (name, _) in letters.iter().zip(&not_observed).filter(|(_, count)| **count == piece.lines.len()) {
        piece.notes.push(format!("{name} was not observed (888888 throughout)"));
    }
    if without_scalar > 0 {
        let values = counted(without_scalar, "value");
        let note = format!("{values} of G below −44440 nT, a scalar that was missing, taken as missing");
        piece.notes.push(note);
    }
    let scalar = letters.iter().zip(&columns).find(|(name, _)| **name == 'F');
    if first.version() == Some("1.00") && scalar.is_some_and(|(_, f)| f.iter().any(|value| !value.is_nan())) {
        piece.notes.push("IAF 1.00 does not say whether F was measured or computed from the vector".into());
    }
    about(first, piece)?;
    Ok((letters, columns))
}

/// Keeps what the first day's header says.
fn about(day: &Day, piece: &mut Piece) -> Result<(), Error> {
    let version = day.version();
    if version.is_none() {
        piece.notes.push(format!("version code {} of IAF is not known; read as 2.11", day.words[14][0]));
    }
    let [latitude, longitude] = day.place()?;
    let quasi = version == Some("2.11") && day.words[14][1] == 1;
    piece.station = Some(day.text(0)).filter(|code| !code.is_empty());
    let records = header([
        ("Format", format!("IAF {}", version.unwrap_or_default()).trim().into()),
        ("Source of Data", day.text(6)),
        ("IAGA Code", day.text(0)),
        ("Geodetic Latitude", format!("{latitude:.3}")),
        ("Geodetic Longitude", format!("{longitude:.3}")),
        ("Elevation", day.number(4).to_string()),
        ("Reported", day.text(5)),
        ("Sensor Orientation", day.text(12)),
        ("Digital Sampling", format!("{} ms", day.number(11))),
        ("Data Interval Type", "1-minute".into()),
        ("Data Type", if quasi { "Quasi-definitive" } else { "Definitive" }.into()),
        ("Publication Date", day.text(13)),
    ]);
    piece.header.insert("header".into(), records);
    Ok(())
}
