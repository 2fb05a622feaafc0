//! What a fixture is, and so which programs read it.

use serde_json::Value;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FileKind {
    Document,
    /// What `simulate` carries out.
    Plan,
    /// What `simulate observatory` and `simulate flight` carry out.
    Observatory,
    /// How `ingest` reads columns.
    Mapping,
    /// What `report` holds a document against.
    Spec,
    /// Statistics of one piece of a long series.
    Piece,
    /// Orientations that a fixture can take.
    Orientations,
    /// An observatory's day, or its baselines, as text.
    Iaga,
    Csv,
    Ndjson,
    Parquet,
    /// Records of variables, or days of IAF, in binary.
    Cdf,
}

impl FileKind {
    /// Of a file by its name and, where that is JSON, by its keys. Absent: no program reads it.
    pub fn of(name: &str, bytes: &[u8]) -> Option<Self> {
        match name.rsplit_once('.')?.1 {
            "min" | "sec" | "imf" | "blv" => Some(FileKind::Iaga),
            "csv" => Some(FileKind::Csv),
            "ndjson" => Some(FileKind::Ndjson),
            "parquet" => Some(FileKind::Parquet),
            "cdf" | "bin" => Some(FileKind::Cdf),
            "txt" if name.ends_with("counts.txt") => Some(FileKind::Csv),
            "json"
                if !["tolerances.json", "certificate/magsat.json"].iter().any(|end| name.ends_with(end))
                    && !name.contains("reference/") =>
            {
                Some(Self::of_json(name, bytes))
            }
            "json" if name.ends_with("campaign_plan.json") => Some(FileKind::Plan),
            _ => None,
        }
    }

    fn of_json(name: &str, bytes: &[u8]) -> Self {
        let value: Value = serde_json::from_slice(bytes).unwrap_or_default();
        let has = |key: &str| value.get(key).is_some();
        if has("fluxcal-mapping") {
            FileKind::Mapping
        } else if has("fluxcal-partial") || name.contains("not-a-piece") {
            FileKind::Piece
        } else if has("requirements") || name.contains("specs/bad/") {
            FileKind::Spec
        } else if has("procedures") {
            FileKind::Plan
        } else if has("weeks") || has("cameras") {
            FileKind::Observatory
        } else {
            FileKind::Document
        }
    }

    /// The name that a changed file of this kind is given.
    pub fn file(self) -> &'static str {
        match self {
            FileKind::Iaga => "in.min",
            FileKind::Csv => "in.csv",
            FileKind::Ndjson => "in.ndjson",
            FileKind::Parquet => "in.parquet",
            FileKind::Cdf => "in.cdf",
            _ => "in.json",
        }
    }

    /// Whether it is one JSON value.
    pub fn is_json(self) -> bool {
        !matches!(self, FileKind::Iaga | FileKind::Csv | FileKind::Ndjson | FileKind::Parquet | FileKind::Cdf)
    }
}
