//! The command lines that read each kind of file.
//!
//! `IN` stands for the changed file, `-` for the same on standard input, `OUT.csv` for a file to write; what
//! begins with `fixtures/` is read as it is. `AROUND` is a document whose readings are the changed file
//! beside it.

use crate::kind::FileKind;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Writes {
    Document,
    /// A document a line.
    Documents,
    Mapping,
    Piece,
    Json,
    /// Words, a page or a table.
    Text,
}

#[derive(Clone, Copy, Debug)]
pub struct Line {
    pub kind: FileKind,
    /// How often, among the lines of its kind.
    pub weight: usize,
    pub words: &'static str,
    pub writes: Writes,
}

impl Line {
    pub fn program(&self) -> &'static str {
        program(self.words)
    }
}

pub fn program(words: &'static str) -> &'static str {
    words.split(' ').next().unwrap_or_default()
}

/// How often each kind is read.
pub const KINDS: [(usize, FileKind); 12] = [
    (56, FileKind::Document),
    (8, FileKind::Plan),
    (2, FileKind::Observatory),
    (6, FileKind::Mapping),
    (4, FileKind::Spec),
    (3, FileKind::Piece),
    (1, FileKind::Orientations),
    (6, FileKind::Iaga),
    (8, FileKind::Csv),
    (3, FileKind::Ndjson),
    (5, FileKind::Parquet),
    (5, FileKind::Cdf),
];

const fn line(kind: FileKind, weight: usize, words: &'static str, writes: Writes) -> Line {
    Line { kind, weight, words, writes }
}

pub const LINES: [Line; 91] = {
    use FileKind::{Cdf, Csv, Iaga, Mapping, Ndjson, Observatory, Orientations, Parquet, Piece, Plan, Spec};
    use Writes::{Documents, Json, Text};
    const DOC: FileKind = FileKind::Document;
    const TO_DOC: Writes = Writes::Document;
    const GEO_OF_A_TABLE: &str = "correct --frame geo --calibration IN --recording flight fixtures/correct/flight/readings.csv -o OUT.ndjson";
    const DAY_OF_AN_OBSERVATORY: &str = "correct --calibration IN --iaga FLX --start 2026-05-26T00:00:00Z fixtures/correct/flight/readings.csv -o OUT.min";
    const MINUTES_OF_A_DAY: &str = "correct --calibration IN --imf FLX --place 47.93,15.87,1087 fixtures/ingest/flx20240310a.min -o OUT.imf";
    const VALUES_OF_AN_OBSERVATORY: &str =
        "correct --calibration IN --imagcdf FLX fixtures/ingest/flx20240310a.min -o OUT.cdf";
    [
        line(DOC, 10, "coilcal IN", TO_DOC),
        line(DOC, 1, "coilcal -", TO_DOC),
        line(DOC, 10, "sensorcal IN", TO_DOC),
        line(DOC, 1, "sensorcal -", TO_DOC),
        line(DOC, 8, "axescal IN", TO_DOC),
        line(DOC, 3, "axescal --known-coils IN", TO_DOC),
        line(DOC, 2, "axescal --start document IN", TO_DOC),
        line(DOC, 2, "axescal --free-scales IN", TO_DOC),
        line(DOC, 2, "axescal --robust IN", TO_DOC),
        line(DOC, 1, "axescal --sensor x --coil y IN", TO_DOC),
        line(DOC, 5, "diffmag IN", TO_DOC),
        line(DOC, 1, "diffmag --correct-clock IN", TO_DOC),
        line(DOC, 4, "scalarcal IN", TO_DOC),
        line(DOC, 1, "scalarcal --robust IN", TO_DOC),
        line(DOC, 1, "scalarcal --constant-magnitude --windows 60 IN", TO_DOC),
        line(DOC, 1, "scalarcal --known --reference-offset --with offset_temperature IN", TO_DOC),
        line(DOC, 1, "scalarcal stream --document IN fixtures/scalarcal/pieces/morning.csv", TO_DOC),
        line(DOC, 5, "absolute IN", TO_DOC),
        line(DOC, 4, "starcal IN", TO_DOC),
        line(DOC, 1, "starcal --attitude-frame icrf --field-model wmm2025 IN", TO_DOC),
        line(DOC, 4, "diagnose IN", TO_DOC),
        line(DOC, 1, "diagnose --refit IN", TO_DOC),
        line(DOC, 1, "diagnose --against fixtures/diagnose/warm/input.json IN", TO_DOC),
        line(DOC, 1, "diagnose --against IN fixtures/diagnose/warm/input.json", TO_DOC),
        line(DOC, 8, "correct IN", TO_DOC),
        line(DOC, 2, "correct --frame geo IN", TO_DOC),
        line(DOC, 4, "correct --calibration IN fixtures/correct/flight/readings.csv -o OUT.csv", Text),
        line(DOC, 1, GEO_OF_A_TABLE, Text),
        line(DOC, 2, DAY_OF_AN_OBSERVATORY, Text),
        line(DOC, 1, "correct --ibf FLX IN -o OUT.blv", Text),
        line(DOC, 1, MINUTES_OF_A_DAY, Text),
        line(DOC, 1, VALUES_OF_AN_OBSERVATORY, Text),
        line(DOC, 5, "report IN", Text),
        line(DOC, 7, "report --text IN", Text),
        line(DOC, 3, "report --text --spec fixtures/specs/magsat.json IN", Text),
        line(DOC, 5, "simulate replay IN", TO_DOC),
        line(DOC, 3, "simulate replay --noise IN", TO_DOC),
        line(DOC, 3, "ingest --add IN fixtures/ingest/field.csv", TO_DOC),
        line(DOC, 2, "series average --window 300 IN", TO_DOC),
        line(DOC, 1, "series average --window 7.5 --share 0.9 IN", TO_DOC),
        line(DOC, 2, "series resample --step 30 IN", TO_DOC),
        line(DOC, 2, "series cut --from 10 --to 2000 IN", TO_DOC),
        line(DOC, 1, "series rename sensor=test --document IN", TO_DOC),
        line(DOC, 2, "series join reference test --procedure differential --document IN", TO_DOC),
        line(Plan, 6, "simulate campaign IN", TO_DOC),
        line(Plan, 2, "simulate campaign --truth OUT-truth.json IN", TO_DOC),
        line(Plan, 2, "simulate campaign --run-sheet IN", Text),
        line(Plan, 2, "simulate sweep --seeds 1..2 IN", Documents),
        line(Observatory, 1, "simulate observatory IN", TO_DOC),
        line(Observatory, 1, "simulate flight IN", TO_DOC),
        line(Mapping, 4, "ingest --map IN fixtures/ingest/logger.csv", TO_DOC),
        line(Mapping, 3, "ingest --map IN fixtures/bad/ingest/word.csv", TO_DOC),
        line(Mapping, 3, "ingest --map IN fixtures/ingest/counts.txt", TO_DOC),
        line(Mapping, 2, "ingest --map IN fixtures/ingest/field.csv", TO_DOC),
        line(Mapping, 1, "ingest --map IN fixtures/ingest/field.ndjson", TO_DOC),
        line(Mapping, 1, "ingest --map IN fixtures/ingest/field.parquet", TO_DOC),
        line(Spec, 3, "report --text --spec IN fixtures/specs/calibrated/input.json", Text),
        line(Spec, 1, "report --spec IN fixtures/specs/calibrated/input.json", Text),
        line(Piece, 2, "diffmag merge IN", TO_DOC),
        line(Piece, 1, "diffmag merge --partial IN", Writes::Piece),
        line(Piece, 2, "scalarcal merge IN", TO_DOC),
        line(Piece, 1, "scalarcal merge --partial IN", Writes::Piece),
        line(Piece, 1, "starcal merge IN", TO_DOC),
        line(Orientations, 1, "axescal design --candidates IN", Json),
        line(Iaga, 4, "ingest IN", TO_DOC),
        line(Iaga, 1, "ingest -", TO_DOC),
        line(Iaga, 2, "ingest --trust-rows --sort --keep first IN", TO_DOC),
        line(Iaga, 2, "ingest --keep last IN fixtures/ingest/flx20240310b.min", TO_DOC),
        line(Iaga, 1, "ingest --beside IN -o OUT.json", Text),
        line(Csv, 4, "ingest IN", TO_DOC),
        line(Csv, 2, "ingest guess IN", Writes::Mapping),
        line(Csv, 3, "ingest --map fixtures/ingest/counts-map.json IN", TO_DOC),
        line(Csv, 3, "correct --calibration fixtures/correct/flight/input.json IN -o OUT.csv", Text),
        line(Csv, 3, "diffmag stream IN", TO_DOC),
        line(Csv, 1, "diffmag stream --partial IN", Writes::Piece),
        line(Csv, 2, "scalarcal stream IN", TO_DOC),
        line(Csv, 1, "scalarcal stream --partial IN", Writes::Piece),
        line(Csv, 1, "starcal stream IN", TO_DOC),
        line(Csv, 2, "correct AROUND", TO_DOC),
        line(Ndjson, 2, "ingest IN", TO_DOC),
        line(Ndjson, 1, "ingest guess IN", Writes::Mapping),
        line(Ndjson, 1, "correct --calibration fixtures/correct/flight/input.json IN -o OUT.ndjson", Text),
        line(Cdf, 4, "ingest IN", TO_DOC),
        line(Cdf, 1, "ingest -", TO_DOC),
        line(Cdf, 1, "ingest --trust-rows --sort --keep first IN", TO_DOC),
        line(Cdf, 1, "ingest guess IN", Writes::Mapping),
        line(Parquet, 3, "ingest IN", TO_DOC),
        line(Parquet, 1, "ingest guess IN", Writes::Mapping),
        line(Parquet, 1, "diffmag stream IN", TO_DOC),
        line(Parquet, 1, "scalarcal stream IN", TO_DOC),
        line(Parquet, 1, "correct --calibration fixtures/correct/flight/input.json IN -o OUT.parquet", Text),
    ]
};

/// Options with a number that is at times absurd (`#`) or a word that is (`@`), bars between them, by the
/// beginning of the command line.
pub const OPTIONS: [(&str, &str); 16] = [
    ("coilcal", "--off-centre-m #|--nyquist-hz #"),
    ("sensorcal", "--turn-deg #|--axes-std-deg #|--budget-field-nt #|--budget-warmer-k #"),
    (
        "axescal design",
        "--number #|--noise-nt #|--quantisation-nt #|--drive-nt #|--theodolite-arcsec #|--table-to #",
    ),
    ("diffmag stream", "--step-s #"),
    ("scalarcal", "--windows #"),
    ("diagnose", "--level #|--seed #"),
    ("correct", "--recording @|--start @|--iaga @|--imf @|--imagcdf @"),
    ("series average", "--window #|--share #|--recording @"),
    ("series resample", "--step #|--recording @"),
    ("series cut", "--from #|--to #|--from @"),
    ("series join", "--id @|--procedure @"),
    ("simulate campaign", "--seed #"),
    ("simulate observatory", "--seed #"),
    ("simulate replay", "--seed #"),
    ("simulate sweep", "--set noise=#|--set seed=#,#|--set @=#|--seeds #..#"),
    ("ingest", "--declination-base-arcmin #|--id @|--procedure @|--as reference|--as test"),
];

/// The programs that read what a program wrote, with bars between.
pub fn next(program: &str) -> &'static str {
    NEXT.iter().find(|(before, _)| *before == program).map_or("", |(_, next)| next)
}

const NEXT: [(&str, &str); 12] = [
    ("simulate", "coilcal|sensorcal|axescal|diffmag|absolute|correct|report --text"),
    ("ingest", "report --text|diagnose|diffmag|absolute|correct|sensorcal|series average --window 60"),
    ("series", "report --text"),
    ("coilcal", "sensorcal|axescal|diagnose|correct|report --text|coilcal"),
    ("sensorcal", "axescal|diagnose|correct|report|sensorcal"),
    ("axescal", "correct|diagnose|report --text|axescal|sensorcal|simulate replay"),
    ("diffmag", "report --text|diffmag|correct"),
    ("scalarcal", "report --text|correct|diagnose|scalarcal"),
    ("absolute", "report --text|correct|absolute"),
    ("starcal", "report --text|correct|diagnose|starcal"),
    ("diagnose", "correct|report --text|diagnose|simulate replay"),
    ("correct", "report --text|diagnose|correct"),
];
