use crate::page::plot::Plot;
use serde::Serialize;

use crate::page::table::Table;

/// A page before it is written as HTML or text.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Its title.
    pub title: String,
    /// What it is about and what stands out, a sentence each.
    pub summary: Vec<String>,
    /// The sections in their order.
    pub sections: Vec<Section>,
}

/// What one stage found, or one part of it; a part of a certificate.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// For links: lower case letters, digits and hyphens, unique within the page. Of a certificate, clauses.
    pub id: String,
    pub title: String,
    pub words: Vec<String>,
    /// What looks wrong; what moves the result most comes first on the page.
    pub warnings: Vec<Finding>,
    /// Tables, plots and words in their order; neighbouring plots stand side by side.
    pub items: Vec<Item>,
}

/// What looks wrong, with what it does to the result.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    pub words: String,
    pub effect: Effect,
    pub place: Option<Place>,
}

/// What words speak of: where the page shows it, they lead there.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    pub of: Target,
    /// The way there; None where nothing shows it.
    pub link: Option<Link>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Target {
    /// An interval between two `time_s`: of the recording, of the earliest of several.
    Interval(Vec<String>, [f64; 2]),
    /// An effect that can be switched off in a plot, by the number of its diagnosis and its name.
    Effect(usize, String),
    Section(String),
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Link {
    /// Id of the words, by which plots lead back to them.
    pub id: Option<String>,
    pub to: String,
    /// The plots that show an interval, and its ends as moments.
    pub shown: Option<(String, [f64; 2])>,
}

/// What a finding does to the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effect {
    /// It moves a field by so much, nT.
    Nt(f64),
    /// It turns a direction by so much, arcsec.
    Arcsec(f64),
    /// It moves a parameter by so many of its standard uncertainties.
    Std(f64),
    /// There is no number, for this reason.
    Unstated(&'static str),
}

impl Place {
    pub fn new(recording: impl Into<String>, time_s: [f64; 2]) -> Self {
        Target::Interval(vec![recording.into()], time_s).into()
    }
}

impl From<Target> for Place {
    fn from(of: Target) -> Self {
        Self { of, link: None }
    }
}

impl Effect {
    /// A field of 50 000 nT across a turned direction, nT.
    const NT_PER_ARCSEC: f64 = 50_000.0 / 206_264.806;
    /// What is said where the document holds no number that would tell.
    pub const NOT_HELD: Self = Self::Unstated("not in the document");

    /// A field, unless the number is absent or not finite.
    pub fn nt(size: impl Into<Option<f64>>) -> Self {
        Self::held(size, Self::Nt)
    }

    /// A turn, likewise.
    pub fn arcsec(size: impl Into<Option<f64>>) -> Self {
        Self::held(size, Self::Arcsec)
    }

    /// Standard uncertainties, likewise.
    pub fn std(size: impl Into<Option<f64>>) -> Self {
        Self::held(size, Self::Std)
    }

    fn held(size: impl Into<Option<f64>>, kind: fn(f64) -> Self) -> Self {
        size.into().filter(|size| size.is_finite()).map_or(Self::NOT_HELD, |size| kind(size.abs()))
    }

    /// Its place: fields, and turns by what they do in 50 000 nT, by their size; then standard uncertainties;
    /// then what has no number.
    fn rank(self) -> (u8, f64) {
        match self {
            Self::Nt(size) => (2, size),
            Self::Arcsec(angle) => (2, angle * Self::NT_PER_ARCSEC),
            Self::Std(size) => (1, size),
            Self::Unstated(_) => (0, 0.0),
        }
    }
}

impl Finding {
    pub fn of(words: impl Into<String>, effect: Effect) -> Self {
        Self { words: words.into(), effect, place: None }
    }

    /// The same, in an interval of a recording.
    pub fn within(self, recording: impl Into<String>, time_s: [f64; 2]) -> Self {
        Self { place: Some(Place::new(recording, time_s)), ..self }
    }

    /// Sorts findings: what moves most comes first, and what is equal keeps its order.
    pub fn sort<T>(all: &mut [T], finding: impl Fn(&T) -> &Finding) {
        let rank = |one: &T| finding(one).effect.rank();
        all.sort_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
        });
    }
}

/// One part of a section.
#[derive(Clone, Debug)]
pub enum Item {
    /// A heading with what follows it.
    Heading(String),
    /// A paragraph.
    Words(String),
    /// A table.
    Table(Table),
    /// A plot.
    Plot(Box<Plot>),
    /// A field of a certificate.
    Field(Field),
    /// A line for a signature on a certificate.
    Signature,
}

/// A field with the clause of the standard that asks for it.
#[derive(Clone, Debug, Serialize)]
pub struct Field {
    pub label: String,
    pub clause: String,
    /// What stands in it, a line each; none: a blank line with the clause.
    pub lines: Vec<String>,
}

impl Field {
    /// With a text whose line breaks part its lines.
    pub fn new(label: String, clause: String, text: &str) -> Self {
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
        Self { label, clause, lines: lines.map(String::from).collect() }
    }
}

impl Section {
    pub fn new(id: impl Into<String>, title: impl Into<String>) -> Self {
        Self { id: id.into(), title: title.into(), ..Self::default() }
    }

    /// Takes out plots without series, tables without rows and columns that are empty throughout. Whether there is an item left.
    pub fn complete(&mut self) -> bool {
        self.items.retain_mut(|item| match item {
            Item::Table(table) => {
                table.leave_out_empty_columns();
                !table.rows.is_empty()
            }
            Item::Plot(plot) => !plot.series.is_empty(),
            _ => true,
        });
        !self.items.is_empty()
    }
}
