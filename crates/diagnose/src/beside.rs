//! Readings held against an instrument beside them: what explains the difference, by the engine `explain`.

mod answer;
mod coarse;
mod declared;
mod effects;
mod families;
mod frozen;
mod magnitude;
mod pair;
mod stated;
mod unrecorded;

use common::{
    AdoptedEffect, Axis, Diagnosis, Document, Quantity, Remaining, Residual, ResidualOf, ResidualSeries,
    Share, Verdict,
};
use estimate::stats::rms;
use explain::{Cause, Covariate, Explained};
use indexmap::IndexSet;
use joined::Pair;
use paired::events::FoundEvent;
use paired::{Acting, Asked, Clock, Explanation};
use physics::Kind;

use self::declared::Declared;
use self::frozen::Frozen;
use crate::drawn::Drawn;
use crate::{Error, Options, against, plain};

/// A name has at least this probability.
const NAMED: f64 = 0.9;
/// What was compared, in the document's names, and what explains it.
struct Compared {
    /// Ids of the recordings.
    recordings: Vec<String>,
    /// Column and axis of each channel.
    channels: Vec<(String, Option<Axis>)>,
    /// What the readings belong to, in words: "the test instrument".
    what: &'static str,
    /// Names of the covariates.
    covariates: Vec<String>,
    /// Times of the rows that were explained, s, and the covariates there.
    time_s: Vec<f64>,
    /// What the engine's courses are.
    acting: Vec<Acting>,
    /// Single disturbed readings, and readings that freeze.
    spikes: Vec<FoundEvent>,
    frozen: Vec<Frozen>,
    /// Sensors with coarse codes, and how wide these are, nT.
    coarse: Vec<(Axis, f64)>,
    /// Rows that are disturbed.
    off: usize,
    along: Vec<Vec<f64>>,
    /// The readings of each channel, nT.
    recorded: Vec<Vec<f64>>,
    /// Rms of each channel as the document has it, nT.
    as_it_came: Vec<f64>,
    clock: Option<Clock>,
    /// What a clock that is late by a second adds to each channel, nT.
    late_nt: Vec<Vec<f64>>,
    /// The rows of the pair, without readings.
    frame: Pair,
    /// Rms of what the fit leaves of each channel with the clocks as they were recorded, nT.
    unmoved: Vec<f64>,
    explained: Explained,
    /// What is to be said besides.
    notes: Vec<String>,
    /// What the instruments' declared noise leaves.
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
fn asked(document: &Document, recordings: &[String], covariates: &[Covariate]) -> Asked {
    let given = unrecorded::working_hours(document, recordings).into_iter().collect();
    Asked { covariates: covariates.to_vec(), correct_clock: false, unrecorded: true, given }
}

impl Compared {
    /// What the engine says of some covariates; what the document has to say is still missing.
    fn of(covariates: &[Covariate], of: Explanation) -> Self {
        let time_s = of.problem.time_s;
        let along = |one: &Covariate| explain::sampled(&one.time_s, &one.values, &time_s, one.holds());
        Self {
            recordings: Vec::new(),
            channels: Vec::new(),
            what: "",
            covariates: covariates.iter().map(|one| one.name.clone()).collect(),
            along: covariates.iter().map(along).collect(),
            recorded: of.problem.channels,
            time_s,
            acting: of.acting,
            spikes: of.spikes,
            frozen: Vec::new(),
            coarse: Vec::new(),
            off: of.off,
            as_it_came: Vec::new(),
            clock: of.clock,
            late_nt: of.problem.rates,
            frame: of.frame,
            unmoved: of.unmoved,
            explained: of.explained,
            notes: Vec::new(),
            declared: None,
            main_field: None,
        }
    }

    /// Writes what the catalogue has of the causes to the document's model: currents, and clocks where none was
    /// stated.
    fn adopt(&self, document: &mut Document) {
        if self.main_field.is_some() {
            return;
        }
        let known = self.explained.probabilities.iter().all(|probability| *probability >= NAMED);
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
        if let Some(clock) = self.clock.as_ref().filter(|_| !timed) {
            paired::adopt::clock(document, &self.frame, &clock.difference, "diagnose");
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

    /// The name of a cause.
    fn name(&self, cause: Cause) -> String {
        match cause {
            Cause::Course(_) => unrecorded::name(self, cause),
            _ => paired::named(cause, &self.covariates),
        }
    }

    /// Sets of names that explain as well, where no single one is sure.
    fn ambiguity(&self) -> Vec<Vec<String>> {
        let uncertain = self.explained.probabilities.iter().any(|own| *own < NAMED);
        let mut sum = 0.0;
        let rivals = self.explained.rivals.iter().take_while(|rival| {
            let told = sum < NAMED;
            sum += rival.probability;
            told
        });
        let rivals: Vec<Vec<Cause>> = rivals.map(|rival| rival.causes.clone()).collect();
        let chosen = || self.explained.causes.iter().map(|one| one.cause).collect();
        let sets = if uncertain { rivals } else { vec![chosen()] };
        // How many steps or lines there are is not a matter of names.
        let named = |set: &Vec<Cause>, lag: &dyn Fn(Cause) -> Option<String>| -> Vec<String> {
            let names = set.iter().map(|cause| lag(*cause).unwrap_or_else(|| self.name(*cause)));
            names.collect::<IndexSet<String>>().into_iter().collect()
        };
        // A lag of which the first order is seen may be a loop's.
        let either = sets.iter().filter(|set| !set.is_empty()).flat_map(|set| {
            let delayed = named(set, &|_| None);
            let looped = named(set, &|cause| unrecorded::loop_name(self, cause));
            let twin = (looped != delayed).then_some(looped);
            [delayed].into_iter().chain(twin)
        });
        let sets: IndexSet<Vec<String>> = either.collect();
        if sets.len() > 1 { sets.into_iter().collect() } else { Vec::new() }
    }

    fn fit(&self) -> Residual {
        let explained = &self.explained;
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
            rms_refitted_nt: match &self.clock {
                Some(_) => rms(&self.unmoved),
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
        let before: f64 = self.explained.before.iter().map(|channel| rms(channel).powi(2)).sum();
        let after: f64 = self.explained.residual.iter().map(|channel| rms(channel).powi(2)).sum();
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
        if self.off > 0 {
            parts.push(format!("{} disturbed", common::number::counted(self.off, "row")));
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
        let (effect, clock) = effects::clock(self).zip(self.clock.as_ref())?;
        let (from, to) = (self.time_s.first(), self.time_s.last());
        let middle_s = from.zip(to).map_or(0.0, |(from, to)| (from + to) / 2.0);
        let rate = clock.rate.as_ref().map_or(0.0, Quantity::value);
        let late_s = |at_s: &f64| clock.offset_s.value() + rate * (at_s - middle_s);
        let of = |late_nt: &Vec<f64>| {
            late_nt.iter().zip(&self.time_s).map(|(nt, at_s)| nt * late_s(at_s)).collect()
        };
        Some((effect.label(), self.late_nt.iter().map(of).collect()))
    }

    /// Before and after along time, the field's rate where a clock is late, and what is followed.
    fn series(&self) -> Vec<ResidualSeries> {
        let explained = &self.explained;
        let followed: Vec<(&str, &[f64])> = explained
            .causes
            .iter()
            .filter_map(|one| match one.cause {
                Cause::Covariate(number) => {
                    Some((self.covariates[number].as_str(), self.along[number].as_slice()))
                }
                _ => None,
            })
            .collect();
        let clock = self.clock_contribution();
        let causes = explained.causes.iter().enumerate().zip(&explained.contributions);
        let causes =
            causes.map(|((at, one), channels)| (effects::cause(self, at, one).label(), channels.clone()));
        let contributions: Vec<(String, Vec<Vec<f64>>)> = clock.iter().cloned().chain(causes).collect();
        let mut all = Vec::new();
        for (channel, (column, _)) in self.channels.iter().enumerate() {
            let mut before = explained.before[channel].clone();
            let rate: Option<Vec<f64>> = clock.as_ref().map(|(_, of_clock)| {
                before.iter_mut().zip(&of_clock[channel]).for_each(|(before, nt)| *before += nt);
                self.late_nt[channel].iter().map(|nt| -nt).collect()
            });
            let rate = rate.as_ref().map(|rate| ("field_rate_nt_per_s", rate.as_slice()));
            let time = ("time_s", self.time_s.as_slice());
            for (along, x) in [time].into_iter().chain(rate).chain(followed.iter().copied()) {
                let timed = along == "time_s";
                let of = |(label, of): &(String, Vec<Vec<f64>>)| (label.clone(), of[channel].clone());
                let drawn = Drawn {
                    x: x.to_vec(),
                    before: before.clone(),
                    after: explained.residual[channel].clone(),
                    recorded: if timed { self.recorded[channel].clone() } else { Vec::new() },
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
        let named: Vec<Cause> = self.explained.causes.iter().map(|one| one.cause).collect();
        for rival in
            self.explained.rivals.iter().filter(|rival| rival.causes.len() == named.len() + 1).take(3)
        {
            let more: Vec<String> = rival
                .causes
                .iter()
                .filter(|cause| !named.contains(cause))
                .map(|cause| self.name(*cause))
                .collect();
            reasons.push(format!(
                "rejected {} besides: probability {}",
                more.join(" and "),
                common::number::probability(rival.probability)
            ));
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
