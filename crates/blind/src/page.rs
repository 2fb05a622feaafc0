//! The page that the proof writes.

mod failures;
pub mod month;
pub mod orbit;
mod picture;
pub mod real;
mod tables;

use concealed::sets::Set;

use crate::reliability;
use crate::score::{Score, Sort};
use crate::verdict::Class;
use crate::wilson::Share;
use picture::Point;

/// What the page says besides the score.
pub struct Besides {
    /// What other methods make of the same documents.
    pub methods: String,
    /// The section of the orbit, where it was run.
    pub orbit: Option<String>,
    /// The section of the observatory, where it was run.
    pub month: Option<String>,
    /// The section of real recordings and its picture, where there are some.
    pub real: Option<(String, String)>,
}

/// The page with its pictures by file name.
pub fn of(score: &Score, besides: &Besides) -> (String, Vec<(&'static str, String)>) {
    let mut sections = vec![
        introduction(score),
        tables::goals(score),
        pictures_of(besides),
        tables::sets(score),
        tables::strengths(score),
        tables::kinds(score),
        tables::removed(score),
        tables::figures(score),
        reliability::section(score.outcomes.iter()),
        besides.methods.clone(),
        failures::section(score),
    ];
    sections.extend(besides.real.as_ref().map(|(section, _)| section.clone()));
    sections.extend(besides.orbit.clone());
    sections.extend(besides.month.clone());
    sections.push(concealed());
    let mut pictures = vec![(STRENGTHS, by_strength(score)), (RELIABILITY, by_probability(score))];
    pictures.extend(besides.real.as_ref().map(|(_, picture)| (real::PICTURE, picture.clone())));
    (sections.join("\n"), pictures)
}

const STRENGTHS: &str = "blind-strengths.svg";
const RELIABILITY: &str = "blind-reliability.svg";

/// Score against strength, reliability, and a real recording before and after.
fn pictures_of(besides: &Besides) -> String {
    let (words, file) = match besides.real {
        Some(_) => ("A real recording with an effect concealed in it, before and after", real::PICTURE),
        None => (
            "A day of an observatory's variometer, the readings left out of the fit behind the dashed line",
            "real-conrad.svg",
        ),
    };
    [
        ("Single effects named right by strength", STRENGTHS),
        ("Whether printed probabilities hold", RELIABILITY),
        (words, file),
    ]
    .map(|(words, file)| format!("![{words}](proof/{file})\n"))
    .join("\n")
}

/// Single effects by strength, with what was wanted.
fn by_strength(score: &Score) -> String {
    let point = |strength: f64| Point {
        label: format!("{strength} ×"),
        share: Share::of(score.of_sort(Sort::Single).filter(|o| o.truth.strength == strength), |o| {
            o.class == Class::Right
        }),
        wanted: match strength {
            0.3 => Some(0.8),
            strength if strength >= 1.0 => Some(0.95),
            _ => None,
        },
    };
    let points: Vec<Point> = tables::strengths_of(score).into_iter().rev().map(point).collect();
    picture::shares(
        "Single effects named right, with 95 % intervals; red: wanted",
        "size of the effect over the noise of a reading",
        &points,
    )
}

/// Names by the probability that was printed, and intervals by their level.
fn by_probability(score: &Score) -> String {
    let names = reliability::of_names(score.outcomes.iter()).into_iter().map(|class| Point {
        label: format!("{:.3}", class.mean),
        share: class.right,
        wanted: Some(class.mean),
    });
    let intervals = reliability::of_intervals(score.outcomes.iter()).into_iter();
    let intervals = intervals.filter(|(_, share)| share.trials > 0).map(|(level, share)| Point {
        label: format!("{:.0} %", 100.0 * level),
        share,
        wanted: Some(level),
    });
    let points: Vec<Point> = names.chain(intervals).collect();
    picture::shares(
        "Names that are right, and intervals that hold; red: what was printed",
        "names, by mean printed probability; intervals of parameters, by level",
        &points,
    )
}

fn introduction(score: &Score) -> String {
    let whole: usize = Set::SCORE.into_iter().map(Set::round).sum();
    let readings: usize = score.outcomes.iter().map(|outcome| outcome.truth.readings).sum();
    format!(
        "# Proof: what was concealed, and what was found\n\n\
        This page is made by `blind score` and not by hand; `just proof` makes one of a whole round, {whole} cases and those in real recordings, of which this one has {}. Recordings that somebody else made have their own: [real.md](proof/real.md). The scores of earlier builds are in [history.md](proof/history.md).\n\n\
        A tool that finds what its own simulator puts in has shown nothing: the two share their mistakes. The crate `concealed` shares no line of \
        physics, noise or estimation with `diagnose`, `simulate` and what they stand on (`crates/concealed/tests/it/independence.rs`). Its physics is finer than \
        the catalogue's ([below](#what-was-concealed)), fields and temperatures are known at every instant and not at samples alone, and its noise is \
        made by itself. Each document has an earlier calibration that is off by what it states, and a name that says nothing.\n\n\
        - **Sealed.** Made, answered and scored in three runs. For each case the truth, the names that would be right, and a random number were written to a \
        file apart and their SHA-256 stored beside the documents before `diagnose` ran; the truths were opened once, and answers that come later are refused. \
        Commitment, the digest of all {} seals: `{}`. {readings} readings in all.\n\
        - **Seed.** {}, a random number of the system where it was not given.\n\
        - **Physics that nobody looked at.** What was concealed while `diagnose` was developed is not scored here. Further kinds and forms are divided by a rule that was \
        written down before any was run (`crates/concealed/src/groups.rs`): some choose between versions, the others are scored. Documents are as instruments write them: \
        500 to 30 000 rows, readings each quarter of a minute to 500 a second, times to a millisecond or a microsecond, uneven or with gaps and lost rows, storms in the field, coarse converters, \
        housekeeping that follows the truth, columns that say nothing, noise declared rightly, a tenth wrong, or not at all. Forms are off their formulas by up to a fifth.\n\
        - **Size of an effect.** What is left of it when all constants of the basic model are fitted to it by least squares: rms in the sensor that \
        keeps most of it, over the rms of the noise that was drawn. The catalogue's own table ([diagnose.md](diagnose.md)) counts before that fit, \
        so that sizes here are the smaller for the same effect, and the harder for what is much like a turned axis.\n\
        - **Named right.** Every effect concealed has one of the names that were sealed for it, on the right sensor, coil or column, and nothing else \
        is named. One name too many is a wrong name. Names that are indistinguishable are right where each of them is (a second-order loop is a lag as well as a delay), and \
        *in the set* where one of them is.\n\
        - Intervals are Wilson's, 95 %.\n",
        score.cases(),
        score.cases(),
        score.seal,
        score.outcomes.first().map_or(0, |outcome| outcome.truth.seed)
    )
}

fn concealed() -> String {
    let mut text = String::from(
        "## What was concealed\n\n| piece | finer than the catalogue by | checked against |\n| --- | --- | --- |\n",
    );
    for (piece, finer, checked) in [
        (
            "hysteresis",
            "Preisach's model with a distribution of coercive fields, the past drive remembered",
            "return-point memory, congruency, wiping out",
        ),
        (
            "temperature with lag",
            "thermometer, former and core as bodies that warm each other",
            "two lags in closed form",
        ),
        ("coil heating", "winding and former warm each other, I² at every instant", "the steady state"),
        ("eddy currents, induction", "diffusion through metal in eight modes", "the analytic step response"),
        ("loop", "second order", "its transfer function"),
        (
            "clock",
            "the field taken again at the true moments; a quartz that feels its temperature",
            "closed forms",
        ),
        ("converter", "bits of wrong weight; uneven codes; both act on noisy readings", "period and rms"),
        ("mains", "a frequency that wanders as grids do, a third harmonic", "a pure line; the wander's rms"),
        (
            "nulling",
            "a loop with an integrator, fed with natural variation through the building's metal",
            "control theory's answer to a ramp",
        ),
        ("Sun", "twelve plates with Lambert's law that warm late", "a cube"),
        ("vehicle", "a dipole on a road", ""),
        (
            "noise",
            "sines eight times as dense as the record's Fourier series; of old: fractional integration over a past of eight records",
            "its density",
        ),
    ] {
        text += &format!("| {piece} | {finer} | {checked} |\n");
    }
    text
}
