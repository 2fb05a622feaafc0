//! NASA's Common Data Format, version 3 (CDF Internal Format Description, NASA GSFC, version 3.9): one file, not
//! compressed, numbers with the most significant byte first; attributes of the file, and variables of one value a record.

use ingest::LAST_LEAP;

/// Bytes of the marks at the beginning, and of the descriptors of the file and of its contents.
const MARKS: usize = 8;
const CDR: usize = 312;
const GDR: usize = 84;
const NAME: usize = 256;
/// What stands for no offset, no number.
const NONE: u32 = u32::MAX;

/// What an attribute says, or the records of a variable.
pub enum Value {
    Text(String),
    Doubles(Vec<f64>),
    Tt2000(Vec<i64>),
}

pub struct Variable {
    pub name: String,
    pub records: Value,
    pub attributes: Vec<(&'static str, Value)>,
}

#[derive(Default)]
pub struct Cdf {
    /// One entry each.
    pub attributes: Vec<(&'static str, Value)>,
    pub variables: Vec<Variable>,
}

impl Value {
    fn stored(&self) -> (u32, usize, Vec<u8>) {
        match self {
            Value::Text(text) => (51, text.len(), text.as_bytes().to_vec()),
            Value::Doubles(all) => (45, all.len(), all.iter().flat_map(|one| one.to_be_bytes()).collect()),
            Value::Tt2000(all) => (33, all.len(), all.iter().flat_map(|one| one.to_be_bytes()).collect()),
        }
    }
}

/// A record without its size and type.
struct Body(Vec<u8>);

impl Body {
    /// Begins with places in the file.
    fn at(offsets: &[usize]) -> Self {
        Body(Vec::new()).offsets(offsets)
    }

    fn offsets(mut self, offsets: &[usize]) -> Self {
        offsets.iter().for_each(|offset| self.0.extend((*offset as u64).to_be_bytes()));
        self
    }

    fn numbers<const N: usize>(mut self, numbers: [u32; N]) -> Self {
        numbers.iter().for_each(|number| self.0.extend(number.to_be_bytes()));
        self
    }

    fn name(mut self, name: &str) -> Self {
        let end = self.0.len() + NAME;
        self.0.extend(name.bytes());
        self.0.resize(end, 0);
        self
    }
}

/// Appends a record; its place.
fn record(file: &mut Vec<u8>, kind: u32, body: &[u8]) -> usize {
    let at = file.len();
    file.extend((12 + body.len() as u64).to_be_bytes());
    file.extend(kind.to_be_bytes());
    file.extend(body);
    at
}

impl Cdf {
    /// The file. A list is written from its end, so that each record knows the place of the next.
    pub fn bytes(&self) -> Vec<u8> {
        let mut file = vec![0; MARKS + CDR + GDR];
        let mut variables = 0;
        for (number, variable) in self.variables.iter().enumerate().rev() {
            variables = variable.write(&mut file, number, variables);
        }
        let mut own: Vec<(&str, Vec<(usize, &Value)>)> = Vec::new();
        for (number, variable) in self.variables.iter().enumerate() {
            for (name, value) in &variable.attributes {
                match own.iter_mut().find(|(known, _)| known == name) {
                    Some((_, entries)) => entries.push((number, value)),
                    None => own.push((name, vec![(number, value)])),
                }
            }
        }
        let all = self.attributes.iter().map(|(name, value)| (*name, vec![(0, value)], true));
        let all: Vec<_> = all.chain(own.into_iter().map(|(name, entries)| (name, entries, false))).collect();
        let mut attributes = 0;
        for (number, (name, entries, is_global)) in all.iter().enumerate().rev() {
            attributes = attribute(&mut file, (number as u32, name), entries, *is_global, attributes);
        }
        let mut head = vec![0xCD, 0xF3, 0x00, 0x01, 0x00, 0x00, 0xFF, 0xFF];
        // Version 3.9, numbers as in networks, rows first and one file.
        let cdr = Body::at(&[MARKS + CDR]).numbers([3, 9, 1, 3, 0, 0, 0, 2, NONE]).name("");
        record(&mut head, 1, &cdr.0);
        let gdr = Body::at(&[0, variables, attributes, file.len()])
            .numbers([0, all.len() as u32, NONE, 0, self.variables.len() as u32])
            .offsets(&[0])
            .numbers([0, LAST_LEAP, NONE]);
        record(&mut head, 2, &gdr.0);
        file[..head.len()].copy_from_slice(&head);
        file
    }
}

impl Variable {
    /// Values (VVR), their index (VXR), and the descriptor (zVDR) with the place of the next one; its place.
    fn write(&self, file: &mut Vec<u8>, number: usize, next: usize) -> usize {
        let (kind, count, values) = self.records.stored();
        let last = count as u32 - 1;
        let values = record(file, 7, &values);
        let index = record(file, 6, &Body::at(&[0]).numbers([1, 1, 0, last]).offsets(&[values]).0);
        let descriptor = Body::at(&[next])
            .numbers([kind, last])
            .offsets(&[index, index])
            // A value for each record; nothing sparse, padded or compressed.
            .numbers([1, 0, 0, NONE, NONE, 1, number as u32])
            .offsets(&[usize::MAX])
            .numbers([0])
            .name(&self.name)
            .numbers([0]);
        record(file, 8, &descriptor.0)
    }
}

/// Entries (AgrEDR or AzEDR) by number, and their descriptor (ADR); its place.
fn attribute(
    file: &mut Vec<u8>,
    (number, name): (u32, &str),
    entries: &[(usize, &Value)],
    is_global: bool,
    next: usize,
) -> usize {
    let mut first = 0;
    for (of, value) in entries.iter().rev() {
        let (kind, elements, bytes) = value.stored();
        let texts = u32::from(matches!(value, Value::Text(_)));
        let numbers = [number, kind, *of as u32, elements as u32, texts, 0, 0, NONE, NONE];
        let mut entry = Body::at(&[first]).numbers(numbers);
        entry.0.extend(bytes);
        first = record(file, if is_global { 5 } else { 9 }, &entry.0);
    }
    let there = (first, entries.len() as u32, entries.last().map_or(NONE, |(of, _)| *of as u32));
    let none = (0, 0, NONE);
    let (global, own) = if is_global { (there, none) } else { (none, there) };
    let descriptor = Body::at(&[next, global.0])
        .numbers([if is_global { 1 } else { 2 }, number, global.1, global.2, 0])
        .offsets(&[own.0])
        .numbers([own.1, own.2, NONE])
        .name(name);
    record(file, 4, &descriptor.0)
}
