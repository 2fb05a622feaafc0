//! Sections that a template writes down: its functions add to the page, its filters write numbers and names.
//!
//! What a template is given is the document as JSON has it. What is missing there is missing in the cells:
//! the way to it need not be asked for.

use common::{Axis, ExplainedEffect, Quantity};
use minijinja::value::{Object, ObjectRepr, Rest, Value, ValueKind, from_args};
use minijinja::{AutoEscape, Environment, Error, ErrorKind, UndefinedBehavior};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use crate::page::plot::{Dimension, Mark, Plot, Series};
use crate::page::{Cell, Field, Header, Item, Section, Table, Target, number, words};

const FUNCTIONS: [&str; 15] = [
    "section",
    "words",
    "say",
    "heading",
    "table",
    "row",
    "plots",
    "plot",
    "note",
    "points",
    "line",
    "dashes",
    "field",
    "signature",
    "blank_without_results",
];

/// The sections of a template in their order, as yet with what turned out to be empty; plots are added by
/// their names. An error where the template is wrong.
pub fn sections(
    mut environment: Environment<'static>,
    template: &str,
    context: Value,
    plots: HashMap<String, Vec<Plot>>,
) -> Result<Vec<Section>, common::Error> {
    let builder = Arc::new(Mutex::new(Builder { sections: Vec::new(), plots }));
    for name in FUNCTIONS {
        let builder = Arc::clone(&builder);
        environment.add_function(name, move |arguments: Rest<Value>| {
            builder.lock().unwrap_or_else(PoisonError::into_inner).add(name, &arguments)
        });
    }
    rendered(&environment, template, context)?;
    let mut builder = builder.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(std::mem::take(&mut builder.sections))
}

/// What templates of HTML know: text is escaped, and lines that hold a block alone leave nothing behind.
pub fn html() -> Environment<'static> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.set_formatter(|out, _, value| {
        let text = value.to_string();
        Ok(out.write_str(&if value.is_safe() { text } else { words::escape(&text) })?)
    });
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.set_keep_trailing_newline(true);
    environment
}

/// The text of a template; an error where it is wrong.
pub fn rendered(
    environment: &Environment<'_>,
    template: &str,
    context: Value,
) -> Result<String, common::Error> {
    let wrong = |error| common::Error::Unanswerable(format!("a template of the page is wrong: {error:#}"));
    environment.render_str(template, context).map_err(wrong)
}

/// A part of a document for a template; what is absent is undefined there.
pub fn part<T: Serialize>(part: &Option<T>) -> Value {
    part.as_ref().map_or(Value::UNDEFINED, Value::from_serialize)
}

struct Builder {
    sections: Vec<Section>,
    plots: HashMap<String, Vec<Plot>>,
}

impl Builder {
    fn add(&mut self, name: &str, arguments: &[Value]) -> Result<(), Error> {
        if let ("section", [id, title]) = (name, arguments) {
            self.sections.push(Section::new(id.to_string(), title.to_string()));
            return Ok(());
        }
        let misplaced =
            || Error::new(ErrorKind::InvalidOperation, format!("`{name}` is misplaced or incomplete"));
        let section = self.sections.last_mut().ok_or_else(misplaced)?;
        let items = &mut section.items;
        match (name, arguments, items.last_mut()) {
            ("row", cells, Some(Item::Table(table))) => add_row(table, cells)?,
            ("note", [note], Some(Item::Plot(plot))) => plot.note = note.to_string(),
            ("points" | "line" | "dashes", _, Some(Item::Plot(plot))) => plot.push(series(name, arguments)?),
            ("plots", [name], _) => {
                let plots = self.plots.remove(&name.to_string()).unwrap_or_default();
                items.extend(plots.into_iter().map(Box::new).map(Item::Plot));
            }
            ("plot", [id, title, x, y, log @ ..], _) => {
                let log = log.first().map(Value::to_string).unwrap_or_default();
                let [x, y] = [(x, 'x'), (y, 'y')].map(|(label, axis)| Dimension {
                    log: log.contains(axis),
                    ..Dimension::from(label.to_string().as_str())
                });
                items.push(Item::Plot(Box::new(Plot::new(id.to_string(), title.to_string()).axes(x, y))));
            }
            ("table", [caption, headers @ ..], _) => {
                let headers = headers.first().map(Value::to_string).unwrap_or_default();
                items.push(Item::Table(Table::new(caption.to_string(), &headers)));
            }
            ("words", [words], _) => section.words.push(words.to_string()),
            ("say", [words], _) => items.push(Item::Words(words.to_string())),
            ("heading", [words], _) => items.push(Item::Heading(words.to_string())),
            ("field", [label, clause, text], _) => {
                let with = |text: &str| Field::new(label.to_string(), clause.to_string(), text);
                items.push(Item::Field(match text.kind() {
                    ValueKind::String => with(&text.to_string()),
                    ValueKind::Seq => {
                        let lines = text.try_iter()?.map(|line| line.to_string()).collect();
                        Field { lines, ..with("") }
                    }
                    _ => with(""),
                }));
            }
            ("signature", [], _) => items.push(Item::Signature),
            // Beside what is said first.
            ("blank_without_results", [], _) => {
                section.complete();
                if section.items.len() == 1 {
                    section.items.push(Item::Field(Field::new("Results".into(), "7.8.2.1 m".into(), "")));
                }
            }
            _ => return Err(misplaced()),
        }
        Ok(())
    }
}

/// A series: its name, style, x and y, then standard uncertainties or two limits.
fn series(name: &str, arguments: &[Value]) -> Result<Series, Error> {
    type Numbers = Option<Vec<f64>>;
    let mark = match name {
        "points" => Mark::Points,
        "line" => Mark::Line,
        _ => Mark::Dashes,
    };
    let (title, style, x, y, bars): (String, usize, Numbers, Numbers, Rest<Numbers>) = from_args(arguments)?;
    let series = Series::new(title, mark, style, &x.unwrap_or_default(), &y.unwrap_or_default());
    Ok(match bars.as_slice() {
        [Some(low), Some(high)] => series.between(low, high),
        [Some(std)] => series.with_std(std),
        _ => series,
    })
}

/// Adds the cells of a row, alone or as a map from their headers.
fn add_row(table: &mut Table, cells: &[Value]) -> Result<(), Error> {
    match cells {
        [row] if row.kind() == ValueKind::Map => {
            let headers: Vec<Value> = row.try_iter()?.collect();
            let cells = headers.iter().map(|header| Ok(Cell::from(&row.get_item(header)?)));
            table.rows.push(cells.collect::<Result<_, Error>>()?);
            table.headers = headers.iter().map(|header| Header::from(header.to_string().as_str())).collect();
        }
        cells => table.rows.push(cells.iter().map(Cell::from).collect()),
    }
    debug_assert!(table.rows.iter().all(|row| row.len() == table.headers.len()), "{}", table.caption);
    Ok(())
}

impl From<&Value> for Cell {
    fn from(value: &Value) -> Self {
        let number = |value: &Value| f64::try_from(value.clone()).ok();
        if let Some(cell) = value.downcast_object_ref::<Cell>() {
            return cell.clone();
        }
        match value.kind() {
            ValueKind::String => value.to_string().into(),
            ValueKind::Bool => if value.is_true() { "yes" } else { "no" }.into(),
            ValueKind::Number if value.is_integer() => {
                usize::try_from(value.clone()).map_or(Cell::Empty, Cell::Count)
            }
            ValueKind::Number => number(value).map_or(Cell::Empty, Cell::Number),
            ValueKind::Map => {
                let of = |key: &str| value.get_attr(key).ok();
                let at_least = of("at_least").is_some_and(|at_least| at_least.is_true());
                let [value, std] = ["value", "std"].map(|key| of(key).as_ref().and_then(number));
                match (value, std) {
                    (Some(value), Some(std)) if at_least => {
                        Cell::Text(Quantity::new(value, std).at_least().to_string())
                    }
                    (Some(value), Some(std)) => Cell::Uncertain { value, std },
                    (value, _) => value.map_or(Cell::Empty, Cell::Number),
                }
            }
            _ => Cell::Empty,
        }
    }
}

impl Object for Cell {
    fn repr(self: &Arc<Self>) -> ObjectRepr {
        ObjectRepr::Plain
    }

    fn render(self: &Arc<Self>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

pub fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Chainable);
    environment.add_test("given", |value: &Value| !value.is_undefined() && !value.is_none());
    let cell = |cell: Option<Cell>| cell.map_or(Value::UNDEFINED, Value::from_object);
    environment.add_filter("cell", |value: &Value| Value::from_object(Cell::from(value)));
    environment.add_filter("figures", move |number: Option<f64>, digits: usize| {
        cell(number.map(|number| Cell::Figures(number, digits)))
    });
    environment.add_filter("p", move |p: Option<f64>| cell(p.map(Cell::Probability)));
    environment
        .add_filter("rounded", move |number: Option<f64>| cell(number.map(words::rounded).map(Cell::Number)));
    environment.add_filter("fixed", |number: Option<f64>, decimals: i32| {
        number.map(|number| number::fixed(number, decimals))
    });
    environment.add_filter("significant", number::significant);
    environment.add_filter("p_value", number::p_value);
    environment.add_filter("counted", |count: usize, of: String| number::counted(count, &of));
    environment.add_filter("sentence", |text: String| words::sentence(&text));
    environment.add_filter("spaced", |name: String| name.replace('_', " "));
    environment.add_filter("key", |name: String| words::key(&name).0);
    environment.add_filter("unit", |name: String| words::key(&name).1);
    environment.add_filter("std_of", std_of);
    environment.add_filter("at", at);
    environment.add_filter("explained", |name: String, diagnosis: usize| {
        Value::from_object(Cell::Placed(name.clone(), Target::Effect(diagnosis, name).into()))
    });
    environment.add_filter("label", |effect: Value| {
        ExplainedEffect::deserialize(effect).map(|effect| effect.label())
    });
    environment.add_filter("minus", minus);
    environment.add_filter("times", |all: Vec<f64>, factor: f64| -> Vec<f64> {
        all.iter().map(|one| one * factor).collect()
    });
    environment.add_filter("over", |all: Vec<f64>, divisor: f64| -> Vec<f64> {
        all.iter().map(|one| one / divisor).collect()
    });
    environment.add_filter("where", rows_where);
    environment.add_filter("ends", |all: Vec<f64>| number::ends(all.into_iter()));
    environment.add_filter("most", |all: Vec<f64>| all.into_iter().reduce(f64::max));
    environment.add_filter("worst_ppm", worst_ppm);
    environment.add_filter("joined", |lists: Vec<Vec<Value>>| lists.concat());
    environment.add_filter("pairs", |map: Value| pairs(&map, &keys(&map)));
    environment
        .add_filter("axes", |map: Value| pairs(&map, &Axis::ALL.map(|axis| Value::from(axis.letter()))));
    environment
}

fn keys(map: &Value) -> Vec<Value> {
    if map.kind() == ValueKind::Map { map.try_iter().into_iter().flatten().collect() } else { Vec::new() }
}

/// Those of some keys that a map has, with what stands there.
fn pairs(map: &Value, keys: &[Value]) -> Vec<Vec<Value>> {
    let there = |key: &Value| Some(map.get_item(key).ok()?).filter(|item| !item.is_undefined());
    keys.iter().filter_map(|key| Some(vec![key.clone(), there(key)?])).collect()
}

/// The standard uncertainty of a parameter, from the covariance matrix that stands beside it.
fn std_of(of: &Value, parameter: &str) -> Option<f64> {
    let mut order = of.get_attr("covariance_order").ok()?.try_iter().ok()?;
    let place = order.position(|name| name.as_str() == Some(parameter))?;
    let row = of.get_attr("covariance").ok()?.get_item_by_index(place).ok()?;
    f64::try_from(row.get_item_by_index(place).ok()?).ok().map(f64::sqrt)
}

/// Words about an interval or a moment of recordings; words alone where one of these is not known.
fn at(words: String, recordings: Value, time_s: Value) -> Value {
    let time_s = Some(time_s).filter(|time_s| !time_s.is_undefined() && !time_s.is_none());
    let time_s = time_s.and_then(|time_s| match Quantity::deserialize(time_s.clone()) {
        Ok(moment) => Some([moment.value(); 2]),
        Err(_) => <[f64; 2]>::deserialize(time_s).ok(),
    });
    let cell = match (Vec::<String>::deserialize(recordings), time_s) {
        (Ok(recordings), Some(time_s)) if !recordings.is_empty() => {
            Cell::Placed(words, Target::Interval(recordings, time_s).into())
        }
        _ => words.into(),
    };
    Value::from_object(cell)
}

/// A list less another, or less a number.
fn minus(all: Vec<f64>, other: Value) -> Result<Vec<f64>, Error> {
    if let Ok(other) = f64::try_from(other.clone()) {
        return Ok(all.iter().map(|one| one - other).collect());
    }
    let other = Vec::<f64>::deserialize(other)?;
    Ok(all.iter().zip(other).map(|(one, other)| one - other).collect())
}

/// Those of a list at whose place another has a value.
fn rows_where(all: &Value, other: &Value, value: &Value) -> Result<Vec<Value>, Error> {
    let rows = all.try_iter()?.zip(other.try_iter()?).filter(|(_, other)| other == value);
    Ok(rows.map(|(one, _)| one).collect())
}

/// The largest relative standard uncertainty of some quantities, ppm.
fn worst_ppm(all: Vec<Value>) -> Option<String> {
    let known = all.into_iter().filter_map(|one| Quantity::deserialize(one).ok()?.relative_std());
    known.reduce(f64::max).map(|relative| number::significant(1e6 * relative, 2))
}
