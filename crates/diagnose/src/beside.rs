//! Readings held against an instrument beside them: what explains the difference, by the engine `explain`.

mod answer;
mod effects;
mod families;
mod magnitude;
mod pair;
mod readings;
mod unrecorded;

use common::{
    AdoptedEffect, Axis, Diagnosis, Document, Quantity, Remaining, Residual, ResidualOf, ResidualSeries,
    Share, Verdict,
};
use estimate::stats::rms;
use explain::{Cause, Covariate, Form};
use indexmap::IndexSet;
use paired::{Asked, Explanation};
use physics::Kind;

use self::pair::Declared;
use self::readings::Frozen;
use crate::report::Drawn;
use crate::{Error, Options, against, plain};

/// A name has at least this probability.
const NAMED: f64 = 0.9;

/// What was compared, in the document's names, and what explains it.
struct Compared {
    recordings: Vec<String>,
    channels: Vec<(String, Option<Axis>)>,
    /// What the readings belong to, in words: "the test instrument".
    what: &'static str,
    of: Explanation,
    frozen: Vec<Frozen>,
    /// Sensors with coarse codes, and how wide these are, nT.
    coarse: Vec<(Axis, f64)>,
    /// Rms of each channel as the document has it, nT.
    as_it_came: Vec<f64>,
    notes: Vec<String>,
    declared: Option<Declared>,
    /// What makes variations the whole field: whether readings are in volts, a scale factor, offsets in nT.
    main_field: Option<(bool, f64, [Quantity; 3])>,
}

/// Of the instruments side by side: what the one reads beside the other, or beside a simulation.
pub fn pairs(document: &mut Document, options: &Options, told: &dyn Fn(&str)) -> Result<Diagnosis, Error> {
    let compared = match &options.against {
        Some(simulated) => pair::compared(&against::pairs(document, simulated)?, told)?,
        None => pair::compared(document, told)?,
    };
    compared.adopt(document);
    Ok(compared.diagnosis())
}

/// Of sensors whose field hardly turns beside a scalar magnetometer; None for other documents.
pub fn magnitude(
    document: &mut Document,
    options: &Options,
    told: &dyn Fn(&str),
) -> Result<Option<Diagnosis>, Error> {
    if options.against.is_some() {
        return Ok(None);
    }
    let Some(compared) = magnitude::compared(document, told)? else { return Ok(None) };
    if let Some((volts, scale, added)) = compared.main_field.as_ref().filter(|_| options.refit) {
        joined::state_main_field(document, *volts, *scale, added);
    }
    compared.adopt(document);
    Ok(Some(compared.diagnosis()))
}

/// All that the engine is asked of the recordings of a pair.
fn asked(document: &Document, recordings: &[String]) -> Asked {
    let given = unrecorded::working_hours(document, recordings).into_iter().collect();
    let covariates = joined::beside(document, recordings);
    Asked { covariates, correct_clock: false, unrecorded: true, given }
}

impl Compared {
    /// Writes causes to the document's model: currents, and clocks where none was stated.
    fn adopt(&self, document: &mut Document) {
        if self.main_field.is_some() {
            return;
        }
        let known = self.of.explained.probabilities.iter().all(|probability| *probability >= NAMED);
        let currents: Vec<AdoptedEffect> = effects::effects(self)
            .into_iter()
            .filter(|effect| known && effect.effect == Kind::StrayCurrent.name())
            .map(|effect| AdoptedEffect {
                effect: effect.effect,
                column: effect.column,
                parameters: effect.parameters,
                extra: [("found_by".to_string(), "diagnose".into())].into_iter().collect(),
                ..AdoptedEffect::default()
            })
            .collect();
        let clocks = [Kind::ClockOffset, Kind::ClockRate].map(Kind::name);
        let mut stated = document.model.iter().flat_map(|model| &model.effects);
        let timed = stated.any(|effect| clocks.contains(&effect.effect.as_str()));
        if !currents.is_empty() {
            document.model.get_or_insert_default().effects.extend(currents);
        }
        if let Some(clock) = self.of.clock.as_ref().filter(|_| !timed) {
            paired::adopt::clock(document, &self.of.frame, &clock.difference, "diagnose");
        }
    }

    fn diagnosis(self) -> Diagnosis {
        let effects = effects::effects(&self);
        let ambiguity = self.ambiguity();
        let fit = self.fit();
        let verdict = verdict(&fit, &ambiguity, effects.is_empty(), self.is_beyond());
        let mut diagnosis = Diagnosis {
            verdict,
            recordings: self.recordings.clone(),
            places: self.places(&effects),
            families: families::families(&self, &effects),
            effects,
            ambiguity,
            remaining: Some(self.remaining(verdict)),
            series: self.series(),
            reasons: self.reasons(&fit),
            fit: Some(fit),
            next_experiment: self.next(verdict),
            ..Diagnosis::default()
        };
        diagnosis.answer = answer::answer(&diagnosis, self.what);
        diagnosis
    }

    /// Whether more is left than the noise that is declared.
    fn is_beyond(&self) -> bool {
        self.declared.as_ref().is_some_and(|declared| declared.rest.is_beyond())
    }

    fn covariate(&self, number: usize) -> &Covariate {
        &self.of.problem.covariates[number]
    }

    fn name(&self, cause: Cause) -> String {
        match cause {
            Cause::Course(_) => unrecorded::name(self, cause),
            Cause::Covariate(number) => self.covariate(number).name.clone(),
            _ => paired::named(cause, &[]),
        }
    }

    /// The effect that a cause is, in the form in which it was found.
    fn kind(&self, cause: Cause) -> Kind {
        let named = self.of.explained.causes.iter().find(|one| one.cause == cause);
        effects::kind(self, cause, named.map_or(Form::default(), |one| one.form))
    }

    /// The same with what it acts on or follows.
    fn label(&self, cause: Cause) -> String {
        let kind = self.kind(cause).name();
        match cause {
            Cause::Course(_) => self.name(cause),
            Cause::Covariate(_) => format!("{kind} {}", self.name(cause)),
            Cause::Time | Cause::Clock => kind.into(),
        }
    }

    /// Sets of names that explain as well, where no single one is sure.
    fn ambiguity(&self) -> Vec<Vec<String>> {
        let uncertain = self.of.explained.probabilities.iter().any(|own| *own < NAMED);
        let mut sum = 0.0;
        let rivals = self.of.explained.rivals.iter().take_while(|rival| {
            let told = sum < NAMED;
            sum += rival.probability;
            told
        });
        let sets: Vec<Vec<Cause>> = if uncertain {
            rivals.map(|rival| rival.causes.clone()).collect()
        } else {
            vec![self.of.explained.causes.iter().map(|one| one.cause).collect()]
        };
        // How many steps or lines there are is not a matter of names.
        let named = |set: &Vec<Cause>, lag: &dyn Fn(Cause) -> Option<String>| -> Vec<String> {
            let names = set.iter().map(|cause| lag(*cause).unwrap_or_else(|| self.label(*cause)));
            names.collect::<IndexSet<String>>().into_iter().collect()
        };
        // A lag of which the first order is seen may be a loop's.
        let either = sets.iter().flat_map(|set| {
            if set.is_empty() {
                return [vec!["no effect".to_string()]].into_iter().chain(None);
            }
            let delayed = named(set, &|_| None);
            let looped = named(set, &|cause| unrecorded::loop_name(self, cause));
            let twin = (looped != delayed).then_some(looped);
            [delayed].into_iter().chain(twin)
        });
        let sets: IndexSet<Vec<String>> = either.collect();
        if sets.len() > 1 { sets.into_iter().collect() } else { Vec::new() }
    }

    fn fit(&self) -> Residual {
        let explained = &self.of.explained;
        let whole = |of: &[Vec<f64>]| rms(&of.iter().map(|channel| rms(channel)).collect::<Vec<_>>());
        let held = &explained.held_out;
        let of = |(channel, (column, _)): (usize, &(String, Option<Axis>))| ResidualOf {
            recording: self.recordings.join(", "),
            column: column.clone(),
            rms_before_nt: self.as_it_came[channel],
            rms_after_nt: rms(&explained.residual[channel]),
            held_out_before_nt: held.base[channel],
            held_out_after_nt: held.named[channel],
            noise_floor_nt: match &self.declared {
                Some(declared) => declared.rms_nt[channel],
                None => rms(&explained.residual[channel]),
            },
        };
        Residual {
            rms_before_nt: rms(&self.as_it_came),
            rms_refitted_nt: match &self.of.clock {
                Some(_) => rms(&self.of.unmoved),
                None => whole(&explained.before),
            },
            rms_after_nt: whole(&explained.residual),
            held_out_before_nt: rms(&held.base),
            held_out_after_nt: rms(&held.named),
            noise_floor_nt: match &self.declared {
                Some(declared) => rms(&declared.rms_nt),
                None => whole(&explained.residual),
            },
            noise_source: if self.declared.is_some() { "declared" } else { "residuals" }.into(),
            by_recording: self.channels.iter().enumerate().map(of).collect(),
            plain: paired::regressions(explained, &|cause| self.name(cause)),
            ..Residual::default()
        }
    }

    fn places(&self, effects: &[common::ExplainedEffect]) -> Vec<Share> {
        let before: f64 = self.of.explained.before.iter().map(|channel| rms(channel).powi(2)).sum();
        let after: f64 = self.of.explained.residual.iter().map(|channel| rms(channel).powi(2)).sum();
        let of = |effect: &common::ExplainedEffect| Share {
            place: Some(effects::place(effect).into()),
            covariates: effect.column.iter().cloned().collect(),
            energy_share: effect.share,
            recordings: self.recordings.clone(),
            description: effect.title.clone(),
            ..Share::default()
        };
        if before > after { effects.iter().map(of).collect() } else { Vec::new() }
    }

    fn remaining(&self, verdict: Verdict) -> Remaining {
        let mut parts = Vec::new();
        if self.is_beyond() {
            parts.push("more than the noise that is declared".to_string());
        } else if verdict == Verdict::PartlyExplained {
            parts.push("a plain regression predicts held-out readings better".to_string());
        }
        if self.of.off > 0 {
            parts.push(format!("{} disturbed", common::number::counted(self.of.off, "row")));
        }
        Remaining {
            white: parts.is_empty(),
            p_adjusted: 1.0,
            structure: parts.join("; "),
            ..Remaining::default()
        }
    }

    /// The label and the contribution to each channel, nT, of the clock.
    fn clock_contribution(&self) -> Option<(String, Vec<Vec<f64>>)> {
        let (effect, clock) = effects::clock(self).zip(self.of.clock.as_ref())?;
        let problem = &self.of.problem;
        let (from, to) = (problem.time_s.first(), problem.time_s.last());
        let middle_s = from.zip(to).map_or(0.0, |(from, to)| (from + to) / 2.0);
        let rate = clock.rate.as_ref().map_or(0.0, Quantity::value);
        let late_s = |at_s: &f64| clock.difference.offset_s.value() + rate * (at_s - middle_s);
        let of = |late_nt: &Vec<f64>| {
            late_nt.iter().zip(&problem.time_s).map(|(nt, at_s)| nt * late_s(at_s)).collect()
        };
        Some((effect.label(), problem.rates.iter().map(of).collect()))
    }

    /// Before and after along time, the field's rate where a clock is late, and what is followed.
    fn series(&self) -> Vec<ResidualSeries> {
        let explained = &self.of.explained;
        let problem = &self.of.problem;
        let followed = explained.causes.iter().filter_map(|one| match one.cause {
            Cause::Covariate(number) => {
                let of = self.covariate(number);
                let values = explain::sampled(&of.time_s, &of.values, &problem.time_s, of.holds());
                Some((of.name.as_str(), values))
            }
            _ => None,
        });
        let followed: Vec<(&str, Vec<f64>)> = followed.collect();
        let clock = self.clock_contribution();
        let causes = explained.causes.iter().enumerate().zip(&explained.contributions);
        let causes =
            causes.map(|((at, one), channels)| (effects::cause(self, at, one).label(), channels.clone()));
        let contributions: Vec<(String, Vec<Vec<f64>>)> = clock.iter().cloned().chain(causes).collect();
        let mut all = Vec::new();
        for (channel, (column, _)) in self.channels.iter().enumerate() {
            let mut before = explained.before[channel].clone();
            let rate = clock.as_ref().map(|(_, of_clock)| {
                before.iter_mut().zip(&of_clock[channel]).for_each(|(before, nt)| *before += nt);
                ("field_rate_nt_per_s", problem.rates[channel].iter().map(|nt| -nt).collect())
            });
            let time = ("time_s", problem.time_s.clone());
            for (along, x) in [time].into_iter().chain(rate).chain(followed.iter().cloned()) {
                let timed = along == "time_s";
                let of = |(label, of): &(String, Vec<Vec<f64>>)| (label.clone(), of[channel].clone());
                let drawn = Drawn {
                    x,
                    before: before.clone(),
                    after: explained.residual[channel].clone(),
                    recorded: if timed { problem.channels[channel].clone() } else { Vec::new() },
                    contributions: contributions.iter().map(of).collect(),
                };
                let recording = timed.then(|| self.recordings.join(", "));
                all.extend(drawn.series(recording, column, along));
            }
        }
        all
    }

    fn reasons(&self, fit: &Residual) -> Vec<String> {
        let mut reasons = plain::reasons(fit);
        let named: Vec<Cause> = self.of.explained.causes.iter().map(|one| one.cause).collect();
        let rivals = self.of.explained.rivals.iter();
        for rival in rivals.filter(|rival| rival.causes.len() == named.len() + 1).take(3) {
            let more = rival.causes.iter().filter(|cause| !named.contains(cause));
            let more: Vec<String> = more.map(|cause| self.name(*cause)).collect();
            let probability = common::number::probability(rival.probability);
            reasons.push(format!("rejected {} besides: probability {probability}", more.join(" and ")));
        }
        reasons.extend(self.notes.iter().map(|note| format!("note: {note}")));
        reasons
    }

    fn next(&self, verdict: Verdict) -> Option<String> {
        let text = match verdict {
            Verdict::Ambiguous => "change one of the columns alone, everything else constant",
            _ if self.is_beyond() => {
                "record what is switched, moved and heated beside the instruments, and repeat"
            }
            Verdict::PartlyExplained => "record what the plain regression follows in more states",
            _ => return None,
        };
        Some(text.into())
    }
}

fn verdict(fit: &Residual, ambiguity: &[Vec<String>], nothing: bool, beyond: bool) -> Verdict {
    if !ambiguity.is_empty() {
        Verdict::Ambiguous
    } else if nothing {
        if beyond { Verdict::Unexplained } else { Verdict::Agrees }
    } else if beyond || plain::better(fit).is_some() {
        Verdict::PartlyExplained
    } else {
        Verdict::Explained
    }
}
