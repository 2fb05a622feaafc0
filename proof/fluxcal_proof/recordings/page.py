"""What was found of one set, as markdown: words, figures, pictures, what a program answered, and predictions."""
import io
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import floor, log10

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from .programs import Refused

WITHIN = 1.05  # the programs predict as well as by hand if they leave no more than this factor
BINS = 120  # along a picture; each keeps its least and its greatest value
STYLE = {"svg.hashsalt": "fluxcal", "svg.fonttype": "none", "font.size": 8, "lines.linewidth": 0.6}


def table(head: list[str], rows: list[list[str]]) -> str:
    return "".join(f"| {' | '.join(line)} |\n" for line in [head, ["---"] * len(head), *rows])


def three(value: float) -> str:
    """To three digits at least, and no more than three decimals."""
    decimals = min(max(2 - floor(log10(abs(value))), 0), 3) if value else 0
    return f"{value:.{decimals}f}"


def figures(value: float) -> str:
    """To three figures."""
    decimals = 2 - int(f"{value:.2e}".split("e")[1])
    return f"{round(value, decimals):.{max(decimals, 0)}f}"


def each(values: Iterable[float], form: Callable[[float], str] = three) -> str:
    return "; ".join(map(form, values))


def plus_minus(value: float, std: float) -> str:
    """A value with its standard uncertainty, both to the second digit of the latter."""
    decimals = min(max(1 - floor(log10(std)), 0), 9)
    return f"{value:.{decimals}f} ± {std:.{decimals}f}"


def number(of: dict | float | None) -> float:
    """A number of a document, which may stand with its uncertainty; 0 where there is none."""
    return float((of.get("value") if isinstance(of, dict) else of) or 0.0)


def quantity(of: dict | float) -> str:
    """A number of a document with its uncertainty, where it has one."""
    std = of.get("std") if isinstance(of, dict) else None
    return plus_minus(number(of), std) if std else three(number(of))


def verdict(document: dict) -> str:
    """The verdict of diagnose with what it names, in a few words."""
    entry = document["diagnosis"][0]
    names = ", ".join(effect["effect"] for effect in entry.get("effects", []))
    return entry["verdict"].replace("_", " ") + (f" ({names})" if names else "")


@dataclass
class Prediction:
    """What is left of a part held out, about its own mean, nT: by hand and by the programs, each component."""

    ways: list[str]
    by_hand_nt: np.ndarray
    programs_nt: np.ndarray | None  # None where they refuse
    of: str = ""
    why: str = ""  # why the programs leave more; empty where nobody knows

    @property
    def holds(self) -> bool:
        return self.programs_nt is not None and bool((self.programs_nt <= WITHIN * self.by_hand_nt).all())

    def row(self, title: str) -> list[str]:
        nt = self.programs_nt
        told = ["refused", ""] if nt is None else [each(nt, figures), each(nt / self.by_hand_nt, "{:.2f}".format)]
        return [f"{title} – {self.of}" if self.of else title, "; ".join(dict.fromkeys(self.ways)), each(self.by_hand_nt, figures), *told,
                "yes" if self.holds else f"**no**: {self.why}" if self.why else "**no**; the reason is not known"]


@dataclass
class Page:
    """One section of the page; paragraphs and sentences by key are those of sets.toml."""

    words: dict
    about: dict[str, object] = field(default_factory=dict)  # figures of the first paragraph
    headline: list[str] = field(default_factory=list)  # sentences for the table at the top
    text: list[str] = field(default_factory=list)
    plots: dict[str, str] = field(default_factory=dict)  # SVG by file name
    known: list[tuple[str, bool]] = field(default_factory=list)  # what a program that was not told answered, and whether that is known
    predictions: list[Prediction] = field(default_factory=list)

    def say(self, words: str) -> None:
        self.text.append(f"{words}\n")

    def tell(self, key: str, **figures: object) -> None:
        self.say(self.words[key].format(**figures))

    def head(self, key: str, **figures: object) -> None:
        self.headline.append(self.words[key].format(**figures))

    def table(self, head: list[str], rows: list[list[str]]) -> None:
        self.text.append(table(head, rows))

    def items(self, items: list[str]) -> None:
        self.text += ["".join(f"- {item}\n" for item in items)] * bool(items)

    def refused(self, refusal: Refused) -> None:
        self.say(f"`{refusal.program}` refuses: “{refusal}”.")

    def plot(self, hours: list[np.ndarray], panels: dict[str, dict[str, np.ndarray]]) -> None:
        """What is left against time, if a picture is asked for: panels by the label of y, of lines by their label, over both parts; a
        dashed line is where the part held out begins. The same readings give the same bytes."""
        if "plot" not in self.words:
            return
        x = np.concatenate(hours)
        bins = [rows for rows in np.split(np.arange(len(x)), np.searchsorted(x, np.linspace(x[0], x[-1], BINS + 1)[1:-1])) if len(rows)]
        with rc_context(STYLE):
            figure, text = Figure((7.2, 0.8 + 1.1 * len(panels)), layout="constrained"), io.StringIO()
            axes = figure.subplots(len(panels), sharex=True, squeeze=False)[:, 0]
            for axis, (label, lines) in zip(axes, panels.items()):
                for colour, (name, y) in zip(("#c2410c", "#1d4ed8", "#15803d"), lines.items()):
                    peaks = sorted({rows[k] for rows in bins for k in (np.argmin(y[rows]), np.argmax(y[rows]))})
                    gaps = 1 + np.flatnonzero(np.diff(x[peaks]) > np.ptp(x) / 20)
                    axis.plot(*(np.insert(of[peaks], gaps, np.nan) for of in (x, y)), color=colour, label=name)
                axis.axvline(hours[1][0], color="#666", linestyle="--")
                axis.set_ylabel(label)
            axes[0].set_title(self.words["plot_title"].format(held_out=self.words["parts"][1]), fontsize=8, loc="left")
            axes[-1].set_xlabel("time, h")
            figure.legend(*axes[0].get_legend_handles_labels(), fontsize=6, ncols=3, loc="outside lower left", frameon=False)
            figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
        self.plots[self.words["plot"]] = text.getvalue()
        self.say(f"![what is left before and after]({self.words['plot']})")

    def diagnosis(self, document: dict) -> list[dict]:
        """What diagnose says: verdict, figures, effects, what is left, what it asks for next; the effects that it names."""
        entry, items = document["diagnosis"][0], []
        rms = {key: three(value) for key, value in entry["fit"].items() if key.endswith("_nt") and isinstance(value, float)}
        self.tell("diagnosis", verdict=entry["verdict"].replace("_", " "), source=entry["fit"]["noise_source"], **rms)
        for effect in entry.get("effects", []):
            target = ", ".join(effect[key] for key in ("sensor", "coil", "column", "recording") if key in effect)
            parameters = ", ".join(f"`{name}` {quantity(value)}" for name, value in effect.get("parameters", {}).items())
            items.append(f"named: `{effect['effect']}` {target}" + (f": {parameters}" if parameters else ""))
        if entry.get("ambiguity"):
            items.append("indistinguishable: " + "; ".join(" with ".join(one) for one in entry["ambiguity"]))
        if entry.get("remaining", {}).get("structure"):
            items.append(f"left: {entry['remaining']['structure']}")
        items += [reason for reason in entry.get("reasons", []) if reason.startswith("rejected ")][:4]
        if "next_experiment" in entry and entry["verdict"] != "agrees":
            items.append(f"it proposes: {entry['next_experiment']}")
        self.items(items)
        return entry.get("effects", [])
