//! What is to be explained, and what was recorded beside it.

use crate::form::Form;

/// A series that was recorded beside the channels, at times of its own.
#[derive(Clone, Debug)]
pub struct Covariate {
    /// Its name.
    pub name: String,
    /// Rising times of its samples on the rows' clock, s.
    pub time_s: Vec<f64>,
    /// Its samples; none is missing.
    pub values: Vec<f64>,
}

/// Readings of some channels at the same moments, and what is known to make them up.
#[derive(Clone, Debug, Default)]
pub struct Problem {
    /// Rising times of the rows, s.
    pub time_s: Vec<f64>,
    /// The readings of each channel; none is missing.
    pub channels: Vec<Vec<f64>>,
    /// What every channel is regressed on in any case, beside a level.
    pub base: Vec<Vec<f64>>,
    /// White noise over the standard deviation within which the coefficient of each column of the base is zero; 0
    /// where nothing is known of it. May be shorter than the base.
    pub known: Vec<f64>,
    /// How many of the base's columns, the first, are readings with noise of their own.
    pub noisy: usize,
    /// What was recorded beside.
    pub covariates: Vec<Covariate>,
    /// The rate of what is predicted of each channel, 1/s: it is what a late clock adds for each second.
    /// Empty where there is no second clock.
    pub rates: Vec<Vec<f64>>,
    /// Where a cause acts through a direction that turns: it is multiplied by each of these. Empty: it acts
    /// as it is.
    pub directions: Vec<Vec<f64>>,
    /// What else may act.
    pub courses: Vec<Course>,
}

/// What something does to each channel, in one of some shapes.
#[derive(Clone, Debug)]
pub struct Course {
    /// The columns of each shape.
    pub shapes: Vec<Vec<Term>>,
    /// Among how many alike it was found.
    pub looks: f64,
}

/// What may act on all channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Cause {
    /// The covariate with this number.
    Covariate(usize),
    /// Time itself: ageing and warming up.
    Time,
    /// Another clock than that of the base.
    Clock,
    /// The course with this number.
    Course(usize),
}

/// The columns of an explanation.
#[derive(Clone, Debug)]
pub enum Term {
    /// One column for all channels, with an amplitude in each.
    Alike(Vec<f64>),
    /// A column for each channel, with one amplitude for all.
    Tied(Vec<Vec<f64>>),
}

impl Term {
    fn at(&self, rows: &[usize]) -> Self {
        let of = |column: &Vec<f64>| rows.iter().map(|row| column[*row]).collect();
        match self {
            Term::Alike(column) => Term::Alike(of(column)),
            Term::Tied(own) => Term::Tied(own.iter().map(of).collect()),
        }
    }
}

impl Problem {
    /// Rows.
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// The usual step between rows, s.
    pub fn step_s(&self) -> f64 {
        let mut steps: Vec<f64> = self.time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.is_empty() { 1.0 } else { estimate::stats::median_of(&mut steps) }
    }

    /// From the first row to the last, s.
    pub fn length_s(&self) -> f64 {
        self.time_s.last().zip(self.time_s.first()).map_or(0.0, |(last, first)| last - first)
    }

    /// The same at some of its rows.
    pub fn at(&self, rows: &[usize]) -> Self {
        let of = |column: &Vec<f64>| rows.iter().map(|row| column[*row]).collect::<Vec<f64>>();
        let all = |columns: &[Vec<f64>]| columns.iter().map(of).collect();
        let course = |course: &Course| Course {
            shapes: course
                .shapes
                .iter()
                .map(|shape| shape.iter().map(|term| term.at(rows)).collect())
                .collect(),
            ..*course
        };
        Self {
            time_s: of(&self.time_s),
            channels: all(&self.channels),
            base: all(&self.base),
            known: self.known.clone(),
            noisy: self.noisy,
            covariates: self.covariates.clone(),
            rates: all(&self.rates),
            directions: all(&self.directions),
            courses: self.courses.iter().map(course).collect(),
        }
    }

    /// The same with a base of the noisy readings alone.
    pub fn plain(&self) -> Self {
        Self { base: self.base[..self.noisy].to_vec(), known: Vec::new(), ..self.clone() }
    }

    /// All that may explain something.
    pub fn causes(&self) -> Vec<Cause> {
        let clock = (!self.rates.is_empty()).then_some(Cause::Clock);
        let covariates = (0..self.covariates.len()).map(Cause::Covariate);
        let courses = (0..self.courses.len()).map(Cause::Course);
        covariates.chain([Cause::Time]).chain(clock).chain(courses).collect()
    }

    /// The columns of a cause in one of its forms.
    pub fn terms(&self, cause: Cause, form: &Form) -> Vec<Term> {
        let series: Vec<Vec<f64>> = match cause {
            Cause::Covariate(number) => form.of(&self.covariates[number], &self.time_s),
            Cause::Time => form.of_time(&self.time_s),
            Cause::Clock => {
                return form.of_clock(&self.time_s, &self.rates).into_iter().map(Term::Tied).collect();
            }
            Cause::Course(number) => return self.courses[number].shapes[form.shape].clone(),
        };
        let turned = |column: &Vec<f64>| -> Vec<Term> {
            let times = |direction: &Vec<f64>| column.iter().zip(direction).map(|(a, b)| a * b).collect();
            self.directions.iter().map(|direction| Term::Alike(times(direction))).collect()
        };
        if self.directions.is_empty() {
            series.into_iter().map(Term::Alike).collect()
        } else {
            series.iter().flat_map(turned).collect()
        }
    }

    /// The level and the base as columns.
    pub fn base_columns(&self) -> Vec<Vec<f64>> {
        let level = vec![1.0; self.rows()];
        let centred = |column: &Vec<f64>| {
            let mean = estimate::stats::mean(column);
            column.iter().map(|value| value - mean).collect::<Vec<f64>>()
        };
        self.base.iter().map(centred).chain([level]).collect()
    }
}
