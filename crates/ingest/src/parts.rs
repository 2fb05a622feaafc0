//! Rows of a text, parsed in parts on all cores.

use memchr::{memchr, memchr_iter};
use rayon::prelude::*;

use crate::Error;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    pub times_ns: Vec<i64>,
    /// Values, column by column; NaN where one is missing.
    pub columns: Vec<Vec<f64>>,
    pub lines: Vec<u32>,
}

/// Room for the rows of a part: as many as it can have at most, in their places of the whole.
pub struct Room<'a> {
    times_ns: &'a mut [i64],
    columns: Vec<&'a mut [f64]>,
    lines: &'a mut [u32],
    rows: usize,
}

impl Room<'_> {
    #[inline]
    pub fn set(&mut self, column: usize, value: f64) {
        self.columns[column][self.rows] = value;
    }

    #[inline]
    pub fn end_row(&mut self, time_ns: i64, line: u32) {
        self.times_ns[self.rows] = time_ns;
        self.lines[self.rows] = line;
        self.rows += 1;
    }
}

const PART: usize = 1 << 20;

/// Parses lines on all cores, rows of so many columns and so many bytes at least; `parse` gets a part of the
/// text, the number of its first line, and room for its rows. The first fault by the order of lines counts,
/// whatever the threads do.
pub fn in_parts(
    bytes: &[u8],
    first_line: u32,
    columns: usize,
    least_bytes: usize,
    parse: impl Fn(&[u8], u32, &mut Room) -> Result<(), Error> + Sync,
) -> Result<Rows, Error> {
    let (mut parts, mut sizes) = (Vec::new(), Vec::new());
    let (mut start, mut line) = (0, first_line);
    while start < bytes.len() {
        let least = bytes.len().min(start + PART);
        let end = memchr(b'\n', &bytes[least..]).map_or(bytes.len(), |end| least + end + 1);
        let lines = memchr_iter(b'\n', &bytes[start..end]).count() + 1;
        parts.push((&bytes[start..end], line));
        // Empty lines need no room, however many there are.
        sizes.push(lines.min((end - start) / least_bytes.max(1) + 1));
        line += lines as u32 - 1;
        start = end;
    }
    let all: usize = sizes.iter().sum();
    let mut rows = Rows {
        times_ns: vec![0; all],
        columns: (0..columns).map(|_| vec![0.0; all]).collect(),
        lines: vec![0; all],
    };
    let parsed: Vec<Result<usize, Error>> = parts
        .into_par_iter()
        .zip(rooms(&mut rows, &sizes))
        .map(|((part, line), mut room)| parse(part, line, &mut room).map(|()| room.rows))
        .collect();
    let counts: Vec<usize> = parsed.into_iter().collect::<Result<_, _>>()?;
    close_up(&mut rows.times_ns, &sizes, &counts);
    close_up(&mut rows.lines, &sizes, &counts);
    rows.columns.par_iter_mut().for_each(|values| close_up(values, &sizes, &counts));
    Ok(rows)
}

/// Cuts the whole into rooms.
fn rooms<'a>(rows: &'a mut Rows, sizes: &[usize]) -> Vec<Room<'a>> {
    let (mut times_ns, mut lines) = (rows.times_ns.as_mut_slice(), rows.lines.as_mut_slice());
    let mut columns: Vec<&mut [f64]> = rows.columns.iter_mut().map(Vec::as_mut_slice).collect();
    sizes
        .iter()
        .map(|size| Room {
            times_ns: times_ns.split_off_mut(..*size).unwrap_or_default(),
            columns: columns.iter_mut().map(|rest| rest.split_off_mut(..*size).unwrap_or_default()).collect(),
            lines: lines.split_off_mut(..*size).unwrap_or_default(),
            rows: 0,
        })
        .collect()
}

fn close_up<T: Copy>(values: &mut Vec<T>, sizes: &[usize], counts: &[usize]) {
    let (mut from, mut to) = (0, 0);
    for (size, count) in sizes.iter().zip(counts) {
        if from != to {
            values.copy_within(from..from + count, to);
        }
        from += size;
        to += count;
    }
    values.truncate(to);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::{decoded, lines_from};

    #[test]
    fn the_first_fault_by_line() {
        let text = "1\n".repeat(3 * PART);
        let parse = |_: &[u8], line: u32, _: &mut Room| Err(Error::Request(line.to_string()));
        let first = in_parts(text.as_bytes(), 5, 1, 2, parse).expect_err("a fault");
        assert_eq!(first.to_string(), "5");
    }

    #[test]
    fn rows_close_up_where_lines_are_none() {
        let text: String =
            (0..PART).map(|row| if row % 3 == 0 { format!("{row}\n") } else { "\n".into() }).collect();
        let parse = |part: &[u8], first: u32, room: &mut Room| {
            for (number, line) in lines_from(part, first).filter(|(_, line)| !line.is_empty()) {
                room.set(0, decoded(line).parse().expect("a number"));
                room.end_row(0, number);
            }
            Ok(())
        };
        let rows = in_parts(text.as_bytes(), 1, 1, 2, parse).expect("no fault");
        let expected: Vec<f64> = (0..PART).step_by(3).map(|row| row as f64).collect();
        assert_eq!(rows.columns[0], expected);
        assert_eq!(rows.lines, expected.iter().map(|row| *row as u32 + 1).collect::<Vec<_>>());
    }
}
