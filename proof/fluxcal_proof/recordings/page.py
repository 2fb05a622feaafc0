"""What was found of one set, as markdown: words, figures, what a program answered, and predictions."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import floor, log10

import numpy as np

from .series import scatter

WITHIN = 1.05  # the programs predict as well as by hand if they leave no more than this factor


def three(value: float) -> str:
    """To three digits at least, and no more than three decimals."""
    decimals = min(max(2 - floor(log10(abs(value))), 0), 3) if value else 0
    return f"{value:.{decimals}f}"


def figures(value: float, digits: int = 3) -> str:
    """To so many figures."""
    decimals = digits - 1 - int(f"{value:.{digits - 1}e}".split("e")[1])
    return f"{round(value, decimals):.{max(decimals, 0)}f}"


def plus_minus(value: float, std: float) -> str:
    """A value with its standard uncertainty, both to the second digit of the latter."""
    decimals = min(max(1 - floor(log10(std)), 0), 9)
    return f"{value:.{decimals}f} ± {std:.{decimals}f}"


def each(values: np.ndarray) -> str:
    return "; ".join(three(value) for value in values)


def number(quantity: object) -> float:
    """A number of a document, which may stand with its uncertainty; 0 where there is none."""
    if isinstance(quantity, dict):
        quantity = quantity.get("value")
    return float(quantity) if quantity is not None else 0.0


def quantity(of: object) -> str:
    """A number of a document with its uncertainty, where it has one."""
    if of is None:
        return "unknown"
    std = of.get("std") if isinstance(of, dict) else None
    return plus_minus(number(of), std) if std else three(number(of))


def table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, *rows]
    text = [f"| {' | '.join(line)} |" for line in lines]
    return "\n".join([text[0], "|" + " --- |" * len(head), *text[1:]]) + "\n"


def verdict(document: dict) -> str:
    """The verdict of diagnose with what it names, in a few words."""
    entry = document["diagnosis"][0]
    names = [effect["effect"] for effect in entry.get("effects", [])]
    return entry["verdict"].replace("_", " ") + (f" ({', '.join(names)})" if names else "")


@dataclass
class Prediction:
    """What is left of a part held out, about its own mean, nT: by hand and by the programs, each component."""

    ways: list[str]
    by_hand_nt: list[float]
    programs_nt: list[float] | None  # None where they refuse
    of: str = ""
    why: str = ""  # why the programs leave more; empty where nobody knows

    @property
    def ratios(self) -> list[float]:
        return [] if self.programs_nt is None else [p / h for p, h in zip(self.programs_nt, self.by_hand_nt)]

    @property
    def holds(self) -> bool:
        return self.programs_nt is not None and max(self.ratios) <= WITHIN

    def row(self, title: str) -> list[str]:
        def all_figures(values: list[float]) -> str:
            return "; ".join(map(figures, values))
        reason = f": {self.why}" if self.why else "; the reason is not known"
        return [f"{title} – {self.of}" if self.of else title, "; ".join(dict.fromkeys(self.ways)),
                all_figures(self.by_hand_nt),
                "refused" if self.programs_nt is None else all_figures(self.programs_nt),
                "; ".join(f"{ratio:.2f}" for ratio in self.ratios), "yes" if self.holds else f"**no**{reason}"]


@dataclass
class Page:
    """One section of the page."""

    words: dict[str, str]  # of sets.toml
    headline: list[str] = field(default_factory=list)
    text: list[str] = field(default_factory=list)
    plots: dict[str, str] = field(default_factory=dict)
    known: list[tuple[str, str, str, str, bool]] = field(default_factory=list)
    predictions: list[Prediction] = field(default_factory=list)

    def say(self, words: str) -> None:
        self.text.append(f"{words}\n")

    def about(self, **values: object) -> None:
        """What was recorded and how it is cut."""
        self.say(self.words["about"].format(**values))

    def head(self, words: str) -> None:
        """A sentence for the table at the top."""
        self.headline.append(words)

    def list(self, items: list[str]) -> None:
        if items:
            self.say("\n".join(f"- {item}" for item in items))

    def table(self, head: list[str], rows: list[list[str]]) -> None:
        self.text.append(table(head, rows))

    def plot(self, name: str, svg: str, words: str) -> None:
        self.say(f"![{words}]({name})")
        self.plots[name] = svg

    def refused(self, program: str, words: Exception) -> None:
        self.say(f"`{program}` refuses: “{words}”.")

    def knows(self, source: str, what: str, program: str, answer: str, found: bool) -> None:
        """Something that the source says is in a recording, and whether a program that was not told found it."""
        self.known.append((source, what, program, answer, found))

    def predicts(self, ways: list[str], by_hand: list[np.ndarray], programs_nt: list[float] | None,
                 **further: str) -> None:
        self.predictions.append(Prediction(ways, [scatter(left) for left in by_hand], programs_nt, **further))

    def diagnosis(self, document: dict) -> None:
        """What diagnose says: verdict, figures, effects, what is left, what it asks for next."""
        entry = document["diagnosis"][0]
        fit = entry["fit"]

        def rms(name: str) -> str:
            return three(fit[name]) if fit.get(name) is not None else "unknown"
        self.say(
            f"`diagnose`: **{entry['verdict'].replace('_', ' ')}**. rms {rms('rms_before_nt')} nT as it came, "
            f"{rms('rms_refitted_nt')} with the calibration fitted again, {rms('rms_after_nt')} with the effects "
            f"found; held-out readings (six parts) {rms('held_out_before_nt')} before and "
            f"{rms('held_out_after_nt')} after; noise {rms('noise_floor_nt')} nT "
            f"({fit.get('noise_source', 'source unknown')}).")
        items = []
        for effect in entry.get("effects", []):
            target = ", ".join(effect[key] for key in ("sensor", "coil", "column", "recording") if key in effect)
            parameters = [f"`{name}` {quantity(value)}" for name, value in effect.get("parameters", {}).items()]
            items.append(f"named: `{effect['effect']}` {target}: {', '.join(parameters)}".rstrip(": "))
        if entry.get("ambiguity"):
            items.append("indistinguishable: " + "; ".join(" with ".join(one) for one in entry["ambiguity"]))
        if left := entry.get("remaining", {}).get("structure"):
            items.append(f"left: {left}")
        items += [reason for reason in entry.get("reasons", []) if reason.startswith("rejected ")][:4]
        if entry.get("next_experiment") and entry["verdict"] != "agrees":
            items.append(f"it proposes: {entry['next_experiment']}")
        self.list(items)
