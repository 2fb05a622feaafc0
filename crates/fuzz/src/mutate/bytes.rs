//! Changes to bytes, whatever they mean.

use crate::draw::Draw;

/// Makes one change, and says which.
pub fn edit(bytes: &mut Vec<u8>, draw: &mut Draw) -> &'static str {
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

#[cfg(test)]
mod tests {
    use super::edit;
    use crate::draw::Draw;

    #[test]
    fn any_length_will_do() {
        let mut draw = Draw::new(1, 1);
        for length in [0, 1, 5, 4000] {
            for _ in 0..200 {
                edit(&mut vec![7; length], &mut draw);
            }
        }
    }
}
