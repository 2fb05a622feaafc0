//! Other methods on the same documents: their answers stand beside those of diagnose, under the same seals,
//! and are scored by the same code.

use std::path::Path;
use std::time::Duration;
use testkit::programs::Programs;

use crate::Error;
use crate::folder::{Asked, Folder};
use crate::score::{Score, Sort};
use crate::seal;
use crate::verdict::{Class, Outcome};
use crate::wilson::Share;

/// How the program is told a method, and the method in words.
const METHODS: [(&str, &str); 3] = [
    ("--method=stepwise", "stepwise BIC"),
    ("--method=lasso", "group lasso, stability selection"),
    ("--method=ensemble", "SINDy's ensemble"),
];

/// How long a method may take on a document, s.
const LIMIT_S: u64 = 60;

fn with<T>(
    programs: &Programs,
    method: &str,
    of: impl FnOnce(&Asked<'_>) -> Result<T, Error>,
) -> Result<T, Error> {
    let arguments = [method.to_string()];
    of(&Asked { name: "baselines", arguments: &arguments, programs, limit: Duration::from_secs(LIMIT_S) })
}

/// Has each of them answer the documents of some cases. One that fails, or takes too long, has given no
/// answer.
pub fn answer<'c>(
    folder: &Folder,
    programs: &Programs,
    cases: impl Iterator<Item = &'c String> + Clone,
) -> Result<(), Error> {
    METHODS.into_iter().try_for_each(|(method, _)| {
        with(programs, method, |asked| folder.answer_all(asked, cases.clone()).map(|_| ()))
    })
}

/// Opens the truths for the answers of each of them, and scores those.
pub fn scores(folder: &Folder, programs: &Programs, truths: &Path) -> Result<Vec<Score>, Error> {
    let one = |(method, _)| {
        with(programs, method, |asked| {
            let answers = folder.answers(asked.name, asked.arguments, asked.programs)?;
            Score::of(seal::open(folder, truths, &answers)?, &answers, seal::commitment(folder)?)
        })
    };
    METHODS.into_iter().map(one).collect()
}

/// The table of diagnose and the methods.
pub fn section(diagnose: &Score, others: &[Score]) -> String {
    let mut text = String::from("## Comparison with other methods\n\n| | diagnose |");
    METHODS.iter().for_each(|(_, words)| text += &format!(" {words} |"));
    text += &format!("\n| --- |{}\n", " --- |".repeat(1 + METHODS.len()));
    let all = || std::iter::once(diagnose).chain(others);
    for (what, sort, so) in LINES {
        let shares = all().map(|score| format!(" {} |", Share::of(score.of_sort(sort), |o| so(o)).words()));
        text += &format!("| {what} |{}\n", shares.collect::<String>());
    }
    let silent =
        all().map(|score| format!(" {} |", Share::of(&score.outcomes, |o| o.verdict == "none").words()));
    text += &format!("| no answer |{}\n", silent.collect::<String>());
    text + &format!(
        "\nAll documents; answers are sealed and scored like those of diagnose, and each method has {LIMIT_S} s per document. Each method \
        chooses from the whole dictionary of diagnose, whitened by the same noise, with the constants of the calibration projected out \
        (`crates/baselines`): every effect on every possible target, dependences and smooth structure, grids of lags and of other shapes at \
        every value; spectral lines, outliers, steps, passes and codes where diagnose's own search finds them in the residual of the \
        calibration. The ensemble has a threshold on single coefficients. It is given only the best value of each grid, and no smooth \
        structure, since with more, fewer of its names were correct. A wrong name: an effect is named that is not present. No answer: the \
        program failed or took too long, which counts as a claim if nothing was concealed.\n"
    )
}

/// A line of the table: in words, what was concealed, and what is counted.
type Line = (&'static str, Sort, fn(&Outcome) -> bool);

const LINES: [Line; 6] = [
    ("single: right, alone", Sort::Single, |o| o.class == Class::Right),
    ("single: a wrong name", Sort::Single, |o| o.class == Class::Wrong),
    ("several: all right", Sort::Several, |o| o.class == Class::Right),
    ("clean: anything claimed", Sort::Clean, |o| o.class != Class::Right),
    ("outside: a wrong name", Sort::Outside, |o| o.class == Class::Wrong),
    ("taken out of the catalogue: a neighbour named", Sort::Removed, |o| o.class == Class::Wrong),
];
