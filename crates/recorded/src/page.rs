//! What was found of one set, as markdown with its plots.

use serde_json::Value;

use crate::known::KnownFact;
use crate::markdown;
use crate::prediction::Prediction;

/// A part of the page.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// The finding in a sentence.
    pub headline: String,
    /// Markdown.
    pub text: String,
    /// Plots by file name.
    pub plots: Vec<(String, String)>,
    /// What the source says is in it, and whether it was found.
    pub known: Vec<KnownFact>,
    /// How well what was left out is predicted, by hand and by the programs.
    pub predictions: Vec<Prediction>,
}

impl Page {
    /// A paragraph.
    pub fn say(&mut self, words: impl AsRef<str>) {
        self.text += words.as_ref();
        self.text += "\n\n";
    }

    /// A sentence for the top of the page.
    pub fn head(&mut self, words: impl AsRef<str>) {
        let space = if self.headline.is_empty() { "" } else { " " };
        self.headline += &format!("{space}{}", words.as_ref());
    }

    /// A list.
    pub fn list<S: AsRef<str>>(&mut self, items: impl IntoIterator<Item = S>) {
        for item in items {
            self.text += &format!("- {}\n", item.as_ref());
        }
        self.text += "\n";
    }

    /// A table.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        self.text += &markdown::table(head, rows);
    }

    /// A plot, in a file of that name.
    pub fn plot(&mut self, file: &str, svg: String, words: &str) {
        self.say(format!("![{words}]({file})"));
        self.plots.push((file.into(), svg));
    }

    /// What the set cannot decide.
    pub fn undecided(&mut self, words: &str) {
        self.say(format!("**Not determined:** {words}"));
    }

    /// That a stage refused, in its own words.
    pub fn refused(&mut self, program: &str, words: &str) {
        let words = words.trim().trim_start_matches(&format!("{program}: "));
        self.say(format!("`{program}` refuses: “{words}”."));
    }

    /// What diagnose says: verdict, figures, effects, what is left, what is asked for next.
    pub fn diagnosis(&mut self, document: &Value) {
        let entry = &document["diagnosis"][0];
        let fit = |key: &str| entry["fit"][key].as_f64().map_or("unknown".into(), three);
        let verdict = entry["verdict"].as_str().unwrap_or("nothing");
        self.say(format!(
            "`diagnose`: **{}**. rms {} nT as it came, {} with the calibration fitted again, {} with the effects found; held-out \
             readings (six parts) {} before and {} after; noise {} nT ({}).",
            verdict.replace('_', " "),
            fit("rms_before_nt"),
            fit("rms_refitted_nt"),
            fit("rms_after_nt"),
            fit("held_out_before_nt"),
            fit("held_out_after_nt"),
            fit("noise_floor_nt"),
            entry["fit"]["noise_source"].as_str().unwrap_or("source unknown"),
        ));
        let mut items: Vec<String> = array(&entry["effects"]).map(effect).collect();
        let equals: Vec<String> = array(&entry["ambiguity"]).map(plain).collect();
        if !equals.is_empty() {
            items.push(format!("indistinguishable: {}", equals.join("; ")));
        }
        if let Some(left) = entry["remaining"]["structure"].as_str().filter(|left| !left.is_empty()) {
            items.push(format!("left: {left}"));
        }
        let reasons = array(&entry["reasons"]).filter_map(Value::as_str);
        items.extend(reasons.filter(|reason| reason.starts_with("rejected ")).take(4).map(String::from));
        if let Some(next) = entry["next_experiment"].as_str().filter(|_| verdict != "agrees") {
            items.push(format!("it proposes: {next}"));
        }
        if !items.is_empty() {
            self.list(items);
        }
    }
}

/// The verdict of diagnose with what it names, in a few words.
pub fn verdict(document: &Value) -> String {
    let entry = &document["diagnosis"][0];
    let names: Vec<&str> = array(&entry["effects"]).filter_map(|effect| effect["effect"].as_str()).collect();
    let verdict = entry["verdict"].as_str().unwrap_or("nothing");
    let verdict = verdict.replace('_', " ");
    if names.is_empty() { verdict } else { format!("{verdict} ({})", names.join(", ")) }
}

/// An effect that was named, in a line.
fn effect(effect: &Value) -> String {
    let name = effect["effect"].as_str().unwrap_or("?");
    let place = ["sensor", "coil", "column", "recording"].iter().filter_map(|key| effect[key].as_str());
    let parameters = effect["parameters"].as_object().into_iter().flatten();
    let parameters: Vec<String> =
        parameters.map(|(name, value)| format!("`{name}` {}", quantity(value))).collect();
    let target = place.collect::<Vec<_>>().join(", ");
    format!("named: `{name}` {target}: {}", parameters.join(", "))
}

/// The items of a list; none where it is no list.
pub fn array(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn plain(value: &Value) -> String {
    array(value).filter_map(Value::as_str).collect::<Vec<_>>().join(" with ")
}

/// A quantity of the document with its uncertainty, where it has one.
pub fn quantity(value: &Value) -> String {
    let number = value.as_f64().or_else(|| value["value"].as_f64());
    match (number, value["std"].as_f64()) {
        (Some(number), Some(std)) if std > 0.0 => plus_minus(number, std),
        (Some(number), _) => three(number),
        (None, _) => "unknown".into(),
    }
}

/// A number to three digits at least, and no more than three decimals below one.
pub fn three(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { (2 - value.abs().log10().floor() as i32).clamp(0, 3) };
    format!("{value:.*}", digits as usize)
}

/// A value with its standard uncertainty, both to the second digit of the latter.
pub fn plus_minus(value: f64, std: f64) -> String {
    let digits = (1 - std.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.digits$} ± {std:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn figures_have_the_digits_that_they_mean() {
        assert_eq!(plus_minus(0.990179, 0.001308), "0.9902 ± 0.0013");
        assert_eq!(plus_minus(-736.1, 173.4), "-736 ± 173");
        assert_eq!(
            (three(0.0978).as_str(), three(17.2254).as_str(), three(2926.9).as_str()),
            ("0.098", "17.2", "2927")
        );
        assert_eq!(quantity(&json!({"value": 2.0, "std": 0.25})), "2.00 ± 0.25");
        assert_eq!(quantity(&json!(1.5)), "1.50");
    }
}
