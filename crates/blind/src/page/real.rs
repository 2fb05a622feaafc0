//! Effects in real recordings: a table of all of them, counts, and one before and after.

use serde_json::Value;
use std::path::Path;

use super::picture;
use crate::Error;
use crate::folder;
use crate::hosted::{self, CLOSE, Hosted};
use crate::hosts::Tried;
use crate::score::Score;
use crate::verdict::Class;
use crate::wilson::Share;

/// File name of the picture.
pub const PICTURE: &str = "blind-real.svg";

/// Time, h, and residual, nT.
type Course = Vec<[f64; 2]>;

/// The section and its picture; None where nothing was concealed in real recordings.
pub fn of(score: &Score, tried: &[Tried], answers: &Path) -> Result<Option<(String, String)>, Error> {
    if tried.is_empty() {
        return Ok(None);
    }
    let all = Hosted::all(score);
    let (words, picture) = before_and_after(&all, answers)?;
    let sections = [introduction(), hosts(score, tried), strengths(score, &all), words, table(&all)];
    Ok(Some((sections.join("\n"), picture)))
}

fn introduction() -> String {
    format!(
        "## Concealed in real recordings\n\n\
        Recordings made by others ([real.md](proof/real.md) has their sources), of instruments at rest on quiet days. Nothing else \
        is simulated: an effect of `concealed` acts in the recorded field and temperatures and is added to the readings; noise, rounding and \
        disturbances are those of the host. A recording is a host if `diagnose` answers `agrees` before anything is injected \
        (`crates/injected/src/hosts.rs`). A rule on the recorded columns decides which effects a host can carry \
        (`crates/injected/src/suits.rs`). Sizes are defined as above, over the residual of the host under the basic model. Real scatter has \
        memory, so that slow effects are harder to detect.\n\n\
        *Left out*: rms of held-out readings with the effects found, over that of the unmodified host; within {:.0} % of 1 the effect is \
        *removed, as if it had not been injected*. *Sized*: the parameters known in the truth lie within their 95 % intervals. Beside a scalar \
        magnetometer the field has one direction, and its magnitude does not show which sensor is affected: there the name counts and not the \
        sensor.\n",
        100.0 * CLOSE
    )
}

fn hosts(score: &Score, tried: &[Tried]) -> String {
    let mut text = String::from(
        "| recording | rows | scatter, nT | as it came | effects injected |\n| --- | --- | --- | --- | --- |\n",
    );
    for one in tried {
        let own = score.real.iter().filter(|o| o.truth.scene == one.name && !o.truth.effects.is_empty());
        let count = if one.host { own.count().to_string() } else { "no host".into() };
        text += &format!(
            "| `{}`: {} ({}) | {} | {:.4} | {} | {count} |\n",
            one.name, one.words, one.source, one.rows, one.scatter_nt, one.said
        );
    }
    text
}

fn strengths(score: &Score, all: &[Hosted]) -> String {
    let mut text = String::from(
        "| | cases | named right | right, or in the set | wrong name or set | unexplained | not seen | sized | removed |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    let mut line = |what: String, those: Vec<&Hosted>| {
        if those.is_empty() {
            return;
        }
        let share = |so: fn(Class) -> bool| Share::of(&those, |one| so(one.outcome.class)).words();
        let told: Vec<bool> = those.iter().filter_map(|one| one.sized()).collect();
        let cells = [
            share(|class| class == Class::Right),
            share(|class| matches!(class, Class::Right | Class::InSet)),
            share(|class| matches!(class, Class::Wrong | Class::WrongSet)),
            share(|class| class == Class::Unexplained),
            share(|class| class == Class::Missed),
            Share::of(told, |held| *held).words(),
            Share::of(those.iter().filter(|one| one.named()), |one| one.removed()).words(),
        ];
        text += &format!("| {what} | {} | {} |\n", those.len(), cells.join(" | "));
    };
    let mut strengths: Vec<f64> = all.iter().map(|one| one.outcome.truth.strength).collect();
    strengths.sort_by(|a, b| b.total_cmp(a));
    strengths.dedup();
    for strength in strengths {
        let those = all.iter().filter(|one| one.outcome.truth.strength == strength);
        line(format!("{strength} × scatter"), those.collect());
    }
    for host in hosted::untouched(score) {
        let those = all.iter().filter(|one| one.outcome.truth.scene == host.truth.scene);
        line(format!("`{}`", host.truth.scene), those.collect());
    }
    text + "\nSized: of those named right whose truth has parameters. Removed: of those named right.\n"
}

fn table(all: &[Hosted]) -> String {
    let mut text = String::from(
        "| host | effect | × scatter | answer | | sized | left out |\n| --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for one in all {
        let truth = &one.outcome.truth;
        for effect in &truth.effects {
            let sensors = effect.sensors.join(", ");
            let space = if sensors.is_empty() { "" } else { " " };
            let sized = one.sized().map_or("", |held| if held { "yes" } else { "no" });
            text += &format!(
                "| {} (`{}`) | `{}`{space}{sensors}: {} | {} | {} | {} | {sized} | {:.3} |\n",
                truth.scene,
                truth.case,
                effect.name,
                effect.physics,
                truth.strength,
                one.outcome.said(),
                one.outcome.class.words(),
                one.held_out
            );
        }
    }
    text
}

/// The case named right in which the residual falls most: before, and with what was found taken out.
fn before_and_after(all: &[Hosted], answers: &Path) -> Result<(String, String), Error> {
    let mut best: Option<(f64, &Hosted, [Course; 2])> = None;
    for one in all.iter().filter(|one| one.named() && one.removed()) {
        let answer: Value = folder::value(&answers.join(format!("{}.json", one.outcome.truth.case)))?;
        let Some(courses) = courses(&answer) else { continue };
        let [before, after] = courses.each_ref().map(|course| rms(course));
        if after > 0.0 && best.as_ref().is_none_or(|(most, ..)| before / after > *most) {
            best = Some((before / after, one, courses));
        }
    }
    let Some((_, one, [before, after])) = best else {
        return Ok((String::new(), picture::courses("nothing was removed", ["time, h", "nT"], &[])));
    };
    let truth = &one.outcome.truth;
    let words = format!("{} with {} at {} × its scatter", truth.scene, truth.effects[0].name, truth.strength);
    let lines = [("as injected".to_string(), before), ("with what diagnose found".to_string(), after)];
    let svg = picture::courses(&words, ["time, h", "residual, nT"], &lines);
    Ok((format!("![{words}, before and after](proof/{PICTURE})\n"), svg))
}

/// The residual along time before and after, means of neighbours, levels off; of the column that changes
/// most.
fn courses(answer: &Value) -> Option<[Course; 2]> {
    let all = answer["diagnosis"][0]["series"].as_array()?.iter();
    let in_time = all.filter(|series| series["along"] == "time_s");
    let both = in_time.filter_map(|series| {
        let numbers = |key: &str| -> Option<Vec<f64>> {
            Some(series[key].as_array()?.iter().filter_map(Value::as_f64).collect())
        };
        let x = numbers("x")?;
        let course = |key: &str| -> Option<Course> {
            let values = numbers(key)?;
            let level = values.iter().sum::<f64>() / values.len() as f64;
            Some(x.iter().zip(values).map(|(x, value)| [x / 3600.0, value - level]).collect())
        };
        Some([course("before_nt")?, course("after_nt")?])
    });
    both.max_by(|a, b| rms(&a[0]).total_cmp(&rms(&b[0])))
}

fn rms(course: &[[f64; 2]]) -> f64 {
    (course.iter().map(|point| point[1] * point[1]).sum::<f64>() / course.len().max(1) as f64).sqrt()
}
