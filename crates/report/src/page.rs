use crate::plot::Plot;
use crate::table::{Cell, Table};

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

/// What one stage found, or one part of it.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// For links: lower case letters, digits and hyphens, unique within the page.
    pub id: String,
    /// Its title.
    pub title: String,
    /// Sentences at its head.
    pub words: Vec<String>,
    /// What looks wrong; those of the largest size come first on the page.
    pub warnings: Vec<Finding>,
    /// Tables, plots and words in their order; neighbouring plots stand side by side.
    pub items: Vec<Item>,
}

/// What looks wrong, with the size of what it is about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// A sentence.
    pub words: String,
    /// How large it is; None where the document does not say.
    pub size: Option<Size>,
}

/// How large a thing is in the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// A field, nT.
    Nt(f64),
    /// A direction, arcsec.
    Arcsec(f64),
}

impl Size {
    /// A field of 50 000 nT across a turned direction, nT.
    const NT_PER_ARCSEC: f64 = 50_000.0 / 206_264.806;

    /// As a field, nT: what a turn does in one of 50 000 nT.
    pub fn as_nt(self) -> f64 {
        match self {
            Size::Nt(size) => size.abs(),
            Size::Arcsec(angle) => angle.abs() * Self::NT_PER_ARCSEC,
        }
    }
}

impl Finding {
    /// A finding of a size; one that is not finite is none.
    pub fn of(words: impl Into<String>, size: Option<Size>) -> Self {
        Self { words: words.into(), size: size.filter(|size| size.as_nt().is_finite()) }
    }
}

impl From<String> for Finding {
    fn from(words: String) -> Self {
        Self { words, size: None }
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
    Plot(Plot),
}

impl Section {
    /// A section without content as yet.
    pub fn new(id: impl Into<String>, title: impl Into<String>) -> Self {
        Self { id: id.into(), title: title.into(), ..Self::default() }
    }

    /// Adds a table without the columns that are empty throughout, unless it has no rows.
    pub fn table(&mut self, mut table: Table) {
        let filled = |column: usize| table.rows.iter().any(|row| !matches!(row[column], Cell::Empty));
        let kept: Vec<bool> = (0..table.headers.len()).map(filled).collect();
        retain(&mut table.headers, &kept);
        table.rows.iter_mut().for_each(|row| retain(row, &kept));
        if !table.rows.is_empty() {
            self.items.push(Item::Table(table));
        }
    }

    /// Adds a plot, unless there is nothing to draw.
    pub fn plot(&mut self, plot: Plot) {
        if !plot.series.is_empty() {
            self.items.push(Item::Plot(plot));
        }
    }

    /// Adds the plots of several sensors, the first of each, then the second of each, and so on.
    pub fn plots_side_by_side(&mut self, of_each: Vec<Vec<Plot>>) {
        let mut of_each: Vec<_> = of_each.into_iter().map(Vec::into_iter).collect();
        loop {
            let row: Vec<Plot> = of_each.iter_mut().filter_map(Iterator::next).collect();
            if row.is_empty() {
                return;
            }
            row.into_iter().for_each(|plot| self.plot(plot));
        }
    }

    /// Adds a paragraph.
    pub fn say(&mut self, words: impl Into<String>) {
        self.items.push(Item::Words(words.into()));
    }

    /// Whether it has nothing to show.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty() && self.words.is_empty() && self.warnings.is_empty()
    }
}

fn retain<T>(all: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    all.retain(|_| kept.next().copied().unwrap_or(true));
}
