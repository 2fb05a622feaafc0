//! Changes to bytes, and to lines of text: tables, an observatory's days, the text of JSON.

use crate::draw::Draw;
use crate::kind::FileKind;

/// What somebody's program writes into a cell, with bars between.
const CELLS: &str = "| |nan|NaN|inf|-inf|1e308|-1e31|1e400|99999.00|88888.88|99999|-99999|0|-0|1e-400|null|\
    x|\"|\"a|1,5|1.5.5|+1|0x1F|1e|--1|2024-02-30|24:00:00|Infinity|123456789012345678901234567890|1_000|µ";

/// Numbers as JSON texts have them and JSON values do not, with bars between them.
const LITERALS: &str = "1e400|-1e400|NaN|Infinity|-Infinity|01|1.|.5|+1|1e|-|0x1F|1e-400|\
    123456789012345678901234567890";

/// Makes one change, and says which.
pub fn edit(bytes: &mut Vec<u8>, kind: FileKind, draw: &mut Draw) -> &'static str {
    let mut lines: Vec<Vec<u8>> = bytes.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
    let (one, other) = (draw.below(lines.len()), draw.below(lines.len()));
    let done = match draw.below(16) {
        0 => {
            lines.remove(one);
            "a line left out"
        }
        1 => {
            lines.insert(one, lines[other].clone());
            "a line twice"
        }
        2 => {
            lines.swap(one, other);
            "lines exchanged"
        }
        3 => {
            lines.truncate(one + 1);
            "lines cut"
        }
        4 => {
            *bytes = bytes.repeat(2);
            return "all twice";
        }
        5 => {
            lines.insert(one, vec![b'1'; *draw.of(&[300, 70_000, 2_000_000])]);
            "a very long line"
        }
        6 => {
            let ends: [&[u8]; 4] = [b"\r\n", b"\r", b"\n\n", b"\0"];
            let ends = ends[draw.below(ends.len())];
            *bytes = lines.join(ends);
            return "other line ends";
        }
        7 => {
            let (from, to) = (*draw.of(b",;\t |"), *draw.of(b",;\t |."));
            bytes.iter_mut().filter(|byte| **byte == from).for_each(|byte| *byte = to);
            return "another separator";
        }
        8 if !kind.is_json() && kind != FileKind::Iaga => {
            exchange(&mut lines, separator(bytes), draw);
            "columns exchanged"
        }
        _ => {
            let rows = lines.len();
            let line = if draw.chance(25) { draw.below(rows.min(20)) } else { one };
            cell(&mut lines[line], kind, separator(bytes), draw);
            "a cell replaced"
        }
    };
    *bytes = lines.join(&b'\n');
    done
}

/// The separator that there is most of.
fn separator(bytes: &[u8]) -> u8 {
    let count = |mark: u8| bytes.iter().filter(|byte| **byte == mark).count();
    *b",;\t ".iter().max_by_key(|mark| count(**mark)).unwrap_or(&b',')
}

/// Two cells of every line in one another's place.
fn exchange(lines: &mut [Vec<u8>], separator: u8, draw: &mut Draw) {
    let (one, other) = (draw.below(6), draw.below(6));
    for line in lines {
        let mut cells: Vec<&[u8]> = line.split(|byte| *byte == separator).collect();
        if cells.len() > one.max(other) {
            cells.swap(one, other);
            *line = cells.join(&separator);
        }
    }
}

/// A cell, a number of JSON text, or as many columns of a fixed width.
fn cell(line: &mut Vec<u8>, kind: FileKind, separator: u8, draw: &mut Draw) {
    if kind.is_json() || kind == FileKind::Ndjson {
        let is_number = |byte: &u8| byte.is_ascii_digit() || b"+-.eE".contains(byte);
        let starts: Vec<usize> = (0..line.len())
            .filter(|at| line[*at].is_ascii_digit() && (*at == 0 || !is_number(&line[at - 1])))
            .collect();
        if let Some(start) = starts.get(draw.below(starts.len())) {
            let end = start + line[*start..].iter().take_while(|byte| is_number(byte)).count();
            line.splice(*start..end, draw.part(LITERALS).bytes());
        }
        return;
    }
    if kind == FileKind::Iaga {
        let text = if draw.chance(50) { draw.part(CELLS) } else { "99999.00" };
        let start = draw.below(line.len() + 1);
        let end = (start + text.len()).min(line.len());
        line.splice(start..end, text.bytes());
        return;
    }
    let mut cells: Vec<Vec<u8>> = line.split(|byte| *byte == separator).map(<[u8]>::to_vec).collect();
    let at = draw.below(cells.len());
    match draw.below(8) {
        0 => {
            cells.remove(at);
        }
        1 => cells.insert(at, b"1".to_vec()),
        _ => cells[at] = draw.part(CELLS).into(),
    }
    *line = cells.join(&separator);
}

/// Makes one change to bytes, and says which.
pub fn edit_bytes(bytes: &mut Vec<u8>, draw: &mut Draw) -> &'static str {
    let place = place(bytes.len(), draw);
    match draw.below(10) {
        0..=2 => {
            if let Some(byte) = bytes.get_mut(place) {
                *byte ^= 1 << draw.below(8);
            }
            "a bit flipped"
        }
        3 | 4 => {
            if let Some(byte) = bytes.get_mut(place) {
                *byte = *draw.of(&[0, 1, 0x7f, 0x80, 0xff, 0xc3, b'"', b'\n', b'9', b'-']);
            }
            "a byte replaced"
        }
        5 => {
            bytes.truncate(place);
            "cut short"
        }
        6 => {
            let more: Vec<u8> = (0..draw.between(1, 40)).map(|_| draw.below(256) as u8).collect();
            bytes.splice(place..place, more);
            "bytes inserted"
        }
        7 => {
            let end = (place + draw.between(1, 40)).min(bytes.len());
            bytes.drain(place..end);
            "bytes left out"
        }
        8 => {
            let end = (place + draw.between(1, 16)).min(bytes.len());
            let with = *draw.of(&[0, 0xff]);
            bytes[place..end].fill(with);
            "bytes filled"
        }
        _ => {
            let marks: [&[u8]; 4] = [b"\xef\xbb\xbf", b"\xff\xfe", b"\x1f\x8b", b"\0"];
            bytes.splice(0..0, draw.of(&marks).iter().copied());
            "a mark before all"
        }
    }
}

/// Anywhere, or near the end, where binary formats keep what they are.
fn place(length: usize, draw: &mut Draw) -> usize {
    let tail = *draw.of(&[8, 200, 1000, length]);
    length.saturating_sub(1).saturating_sub(draw.below(tail.min(length)))
}
