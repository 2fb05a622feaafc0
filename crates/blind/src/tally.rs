//! A quick count for development: cases made, diagnosed within a time and scored, a line each.

use clap::Args;
use concealed::case::{Case, Truth};
use concealed::sets::Set;
use program::pipe;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;
use testkit::programs::Programs;

use crate::Error;
use crate::folder::{self, Asked, Folder};
use crate::reliability;
use crate::seal;
use crate::verdict::Outcome;
use crate::wilson::Share;

/// What is asked of a count.
#[derive(Args, Clone, Debug)]
pub struct Arguments {
    /// What is concealed; several may be given
    #[arg(long, value_enum, required = true)]
    pub set: Vec<Set>,
    /// The seed of the sets
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How many of each set; absent: a whole round
    #[arg(long, value_name = "N")]
    pub cases: Option<usize>,
    /// The number to begin with
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    pub first: usize,
    /// Take what is concealed out of diagnose's catalogue: right is then no name, and structure in the right place
    #[arg(long)]
    pub removed: bool,
    /// Where documents and answers are kept; what this very program has answered is not diagnosed again
    #[arg(long, value_name = "FOLDER", default_value = "target/tally")]
    pub folder: PathBuf,
    /// Where the stages' programs are; absent: beside this one
    #[arg(long, value_name = "FOLDER")]
    pub programs: Option<PathBuf>,
    /// Cases side by side
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub jobs: usize,
    /// Seconds that a case may take; what takes longer has failed
    #[arg(long, value_name = "SECONDS", default_value_t = 300)]
    pub limit: u64,
}

/// What came of a case.
struct Counted {
    truth: Truth,
    outcome: Result<Outcome, String>,
    seconds: f64,
}

/// Makes and diagnoses case after case, and writes a line of each and the counts to standard output.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let programs = Programs::find(arguments.programs.as_deref())?;
    programs.program("diagnose")?;
    let folder = Folder::at(&arguments.folder)?;
    let wanted = arguments.set.iter().flat_map(|set| {
        let count = arguments.cases.unwrap_or(set.round());
        (arguments.first..arguments.first + count).map(|number| (*set, number))
    });
    let one = |(set, number): (Set, usize)| -> Result<Counted, Error> {
        let Case { document, mut truth } = set.case(arguments.seed, number);
        folder.write(&truth.case, &document)?;
        if arguments.removed {
            truth.take_names();
        }
        let without = seal::arguments(&truth);
        let limit = Duration::from_secs(arguments.limit);
        let asked = Asked { arguments: &without, limit, ..Asked::diagnose(&programs) };
        let answers = folder.answers(asked.name, asked.arguments, asked.programs)?;
        let (seconds, outcome) = match folder.answer(&asked, &truth.case, &answers) {
            Ok(seconds) => {
                let answer = folder::value(&answers.join(format!("{}.json", truth.case)))?;
                (seconds, Ok(Outcome::of(truth.clone(), &answer)))
            }
            Err(Error::Program { words, .. }) => (f64::NAN, Err(words)),
            Err(error) => return Err(error),
        };
        let counted = Counted { truth, outcome, seconds };
        pipe::write(None, &counted.line())?;
        Ok(counted)
    };
    let threads = rayon::ThreadPoolBuilder::new().num_threads(arguments.jobs.max(1)).build();
    let threads = threads.map_err(|e| Error::Common(common::Error::Request(e.to_string())))?;
    let all: Vec<Counted> = threads
        .install(|| wanted.collect::<Vec<_>>().into_iter().par_bridge().map(one).collect::<Result<_, _>>())?;
    Ok(pipe::write(None, &counts(&all))?)
}

impl Counted {
    fn class(&self) -> &'static str {
        self.outcome.as_ref().map_or("failed", |outcome| outcome.class.words())
    }

    /// Set, number, length, what was concealed and its form error, class, readings left out over the noise, seconds, answer.
    fn line(&self) -> String {
        let Truth { set, number, length, .. } = &self.truth;
        let (left, said) = match &self.outcome {
            Ok(outcome) => (outcome.over_floor(), outcome.said()),
            Err(words) => (f64::NAN, words.clone()),
        };
        format!(
            "{set} {number:>3}  {length:<8}  {:<46}  {:<20}  left {left:.2}  {:.1} s  {said}\n",
            self.concealed(),
            self.class(),
            self.seconds
        )
    }

    fn concealed(&self) -> String {
        let effects: Vec<String> = self
            .truth
            .effects
            .iter()
            .map(|effect| {
                let name = effect.accepted.first().unwrap_or(&effect.name);
                let times = effect.left_nt / self.truth.noise_nt;
                let times = if times < 9.95 { format!("{times:.1}") } else { format!("{times:.0}") };
                format!("{name} x{times} e{:.2}", effect.form_error)
            })
            .collect();
        if effects.is_empty() { "nothing".into() } else { effects.join(" + ") }
    }

    /// Where it is counted: the set, and by strength, or where there are several by their number.
    fn groups(&self) -> [(String, i64, String); 2] {
        let set = self.truth.set.clone();
        let group = match self.truth.effects.len() {
            0 => (set.clone(), 1, "nothing".into()),
            1 => (set.clone(), -(10.0 * self.truth.strength) as i64, format!("{} x", self.truth.strength)),
            count => (set.clone(), count as i64, format!("{count} effects")),
        };
        [(set, i64::MIN, "all".into()), group]
    }
}

/// How many of each class by set and strength, and the seconds.
fn counts(all: &[Counted]) -> String {
    let mut groups: BTreeMap<(String, i64, String), BTreeMap<&str, usize>> = BTreeMap::new();
    for counted in all {
        for group in counted.groups() {
            *groups.entry(group).or_default().entry(counted.class()).or_default() += 1;
        }
    }
    let mut text = String::from("\n");
    for ((set, _, group), classes) in groups {
        let parts: Vec<String> = classes.iter().map(|(class, count)| format!("{class} {count}")).collect();
        text += &format!("{set}, {group}: {} cases: {}\n", classes.values().sum::<usize>(), parts.join(", "));
    }
    let placed: Vec<bool> =
        all.iter().filter_map(|one| one.outcome.as_ref().ok().and_then(|outcome| outcome.located)).collect();
    text += &format!("located right, of all that is told: {}\n", Share::of(placed, |right| *right).words());
    let outcomes = || all.iter().filter_map(|one| one.outcome.as_ref().ok());
    for (level, share) in reliability::of_intervals(outcomes()) {
        text +=
            &format!("parameters whose {:.0} % interval holds the truth: {}\n", 100.0 * level, share.words());
    }
    for ((at_least, name), (share, farthest)) in reliability::by_parameter(outcomes()) {
        let bound = if at_least { ", at least" } else { "" };
        text += &format!("  {name}{bound}: {}; the farthest is off by {farthest:.1}\n", share.words());
    }
    for class in reliability::of_names(outcomes()) {
        text += &format!(
            "names with probability {} to {}: right {}\n",
            class.from,
            class.to,
            class.right.words()
        );
    }
    let mut seconds: Vec<f64> = all.iter().map(|one| one.seconds).filter(|s| s.is_finite()).collect();
    seconds.sort_by(f64::total_cmp);
    if let Some(most) = seconds.last() {
        let median = seconds[seconds.len() / 2];
        text += &format!("seconds of {} answered: median {median:.1}, most {most:.1}\n", seconds.len());
    }
    text
}
