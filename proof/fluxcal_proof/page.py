"""The page of a round."""
from __future__ import annotations

from pathlib import Path

import numpy as np

from . import goals
from .score import Round, count, share
from .verdict import Outcome

PICTURE = "proof/sealed.svg"


def table(head: list[str], rows: list[list[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def title(outcome: Outcome) -> str:
    """What is concealed in a case."""
    return " + ".join(f"{e['kind']}, {e['form']} ({e['strength']:g}x)" for e in outcome.truth["effects"]) or "nothing"


def write(of: Round, page: Path) -> None:
    """Writes the page and its picture beside it."""
    page.parent.mkdir(parents=True, exist_ok=True)
    (page.parent / PICTURE).parent.mkdir(parents=True, exist_ok=True)
    picture(of, page.parent / PICTURE)
    parts = [opening(of), wins(of), goal_table(of), verdicts(of), calibration(of), kinds(of), failures(of), how(of)]
    page.write_text("\n".join(part for part in parts if part))


def opening(of: Round) -> str:
    """A picture and three sentences."""
    single = [o for o in of.diagnose if o.sort == "single" and goals.strong(o)]
    clean = [o for o in of.diagnose if o.sort == "clean"]
    named, claimed = count(single, lambda o: goals.members(o) and not o.wrong), count(clean, lambda o: o.verdict != "agrees")
    wrong = count([o for o in of.diagnose if o.truth["effects"]], lambda o: bool(o.wrong))
    return (f"# Proof: what was concealed, and what was found\n\n![Single effects by strength, and what the rivals make of the same cases]({PICTURE})\n\n"
            f"Where one effect as large as the noise or larger was concealed, `diagnose` named it in {share(*named)} of the cases, alone or in a set. "
            f"It named something that was not there in {share(*wrong)} of the cases in which anything acted. "
            f"Where nothing was concealed, it claimed something in {share(*claimed)}.\n")


def wins(of: Round) -> str:
    """Goals in which a rival is better, first of all."""
    lines = []
    for goal, own, others in goals.reached(of):
        for name, theirs in others.items():
            if name in ("stepwise", "ensemble") and theirs[1] and goal.better(theirs, own):
                lines.append(f"- {name} is better in “{goal.title}”: {share(*theirs)} against {share(*own)}.")
    for name in ("stepwise", "ensemble"):
        theirs_all = of.others.get(name, [])
        common = {o.name for o in theirs_all}
        own_all = [o for o in of.diagnose if o.name in common]
        (mine, trials), (other, _) = count(own_all, lambda o: o.right), count(theirs_all, lambda o: o.right)
        if mine < other:
            lines.append(f"- {name} has more right verdicts: {other} against {mine} of {trials}.")
        false, theirs_false = goals.false_names(own_all), goals.false_names(theirs_all)
        if name == "stepwise" and false > 0.1 * theirs_false:
            lines.append(f"- False names are more than a tenth of those of {name}: {false} against {theirs_false}.")
    return "## Where a rival is better\n\n" + ("\n".join(lines) if lines else "In no goal.") + "\n"


def goal_table(of: Round) -> str:
    """Goals, missed first."""
    rows = []
    for goal, own, others in goals.reached(of):
        wanted = f"at {'least' if goal.at_least else 'most'} {goal.percent:g} %"
        theirs = [f"{100 * others[n][0] / others[n][1]:.0f} %" if n in others and others[n][1] else "" for n in ("stepwise", "ensemble", "nothing", "diffmag")]
        rows.append([goal.title, wanted, share(*own), *theirs, "met" if goal.met(*own) else "**missed**"])
    return "## Goals\n\n" + table(["goal", "wanted", "diagnose", "stepwise", "ensemble", "nothing", "diffmag", ""], rows) + (
        "\nIntervals are Wilson's, 95 %. `diffmag` answers pairs only; its shares are of those.\n")


def verdicts(of: Round) -> str:
    """Verdicts, false names and time, program by program."""
    rows = []
    for name, outcomes in {"diagnose": of.diagnose, **of.others}.items():
        false = goals.false_names(outcomes)
        seconds = [o.seconds for o in outcomes]
        rows.append([name, share(*count(outcomes, lambda o: o.right)), str(false), f"{false / len(outcomes):.2f}",
                     f"{np.median(seconds):.2g}", f"{np.percentile(seconds, 95):.2g}", f"{max(seconds):.2g}"])
    notes = "" if "ensemble" in of.others else "\nPySINDy is not installed where this was run: its ensemble was left out.\n"
    return "## The same cases, others\n\n" + table(["", "right", "false names", "a case", "s, median", "s, 95 %", "s, most"], rows) + notes


def calibration(of: Round) -> str:
    """Whether printed probabilities and intervals hold."""
    names = [[f"names printed with {words}", f"{100 * mean:.1f} %", share(*own)] for words, mean, own in goals.probabilities(of.diagnose)]
    levels = [[f"intervals of {level} %", f"{level} %", share(*own)] for level, own in goals.intervals(of.diagnose)]
    return "## Printed probabilities and intervals\n\n" + table(["", "printed", "right"], names + levels)


def kinds(of: Round) -> str:
    """A line a kind."""
    groups: dict[str, list[Outcome]] = {}
    for one in of.diagnose:
        effects = one.truth["effects"]
        name = f"{effects[0]['kind']}, {effects[0]['form']}" if len(effects) == 1 else one.sort if one.truth["sort"] != "pair" else f"pair, {one.sort}"
        groups.setdefault(name, []).append(one)
    rows = []
    for name, own in sorted(groups.items()):
        explained = [o for o in own if o.verdict == "explained" and o.form is not None]
        rows.append([name, own[0].truth["effects"][0].get("source", "") if len(own[0].truth["effects"]) == 1 else "", str(len(own)),
                     str(sum(goals.all_families(o) for o in own)), str(sum(goals.members(o) for o in own)), str(sum(bool(o.wrong) for o in own)),
                     f"{sum((o.form or 9) <= 1.05 for o in explained)} of {len(explained)}", str(sum(o.right for o in own)), f"{np.median([o.seconds for o in own]):.1f}"])
    return "## Kind by kind\n\n" + table(["concealed", "source", "cases", "family", "member or set", "wrong", "form within 5 %", "right", "s"], rows)


def failures(of: Round) -> str:
    """Every case that is not right."""
    rows = []
    for one in of.diagnose:
        if not one.right:
            told = "; ".join(" or ".join(names) for names in one.claims) or "–"
            rows.append([str(one.truth["number"]), title(one), ", ".join([f"{one.truth['rows']} rows", *one.truth["manners"]]), one.verdict.replace("_", " "), told])
    return (f"## Failures\n\n`python3 -m fluxcal_proof case --seed {of.seed} --set {of.of} --number N -o doc.json` makes one again (numbers from 1 000 000 on are real recordings, which `make --recordings` makes with the same seed).\n\n"
            + table(["number", "concealed", "recorded", "answer", "named"], rows))


def how(of: Round) -> str:
    """What a round is."""
    readings = sum(3 * o.truth["rows"] for o in of.diagnose)
    return f"""## How it was done

- **Sealed.** Cases are made, answered and scored in three runs. Before any answer the SHA-256 of each truth, with a random number in it, was written beside the documents; the commitment, the SHA-256 of all seals, is `{of.commitment}`. The truths were opened once; later answers are refused. Seed {of.seed}, set `{of.of}`, {len(of.diagnose)} cases, {readings} readings.
- **Foreign.** The package `proof/` imports nothing of fluxcal and takes its physics from the publications in the table. Fields, temperatures and currents are functions of continuous time, and linear responses act on them exactly. Each document has an earlier calibration, wrong by as much as its stated uncertainty.
- **Size of an effect.** What is left of it in the worst sensor after all constants of the basic model were fitted to it, rms, over the rms of the noise.
- **Right.** Family: the answer names it with nine tenths. Member: each claim has a name that is right, or a set with one. Wrong: a claim without. Form: rms of new readings about what the answer predicts, over that about the fitted truth; of pairs the printed rms of readings left out over the rms that the truth leaves.
- **Kinds.** Those looked at in development are in the set `develop`, by the rule in `proof/fluxcal_proof/groups.py`.
"""


def picture(of: Round, path: Path) -> None:
    """Members told by strength, of the program and its rivals."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "fluxcal", "svg.fonttype": "none", "font.size": 10})
    from matplotlib import pyplot

    from .score import wilson

    figure, axes = pyplot.subplots(figsize=(7.2, 3.6), layout="constrained")
    for name, outcomes, mark in [("diagnose", of.diagnose, "o-"), *((n, of.others[n], m) for n, m in (("stepwise", "s--"), ("ensemble", "^:")) if n in of.others)]:
        x, y, low, high = [], [], [], []
        for strength in (0.3, 1.0, 3.0, 10.0, 100.0):
            own = [o for o in outcomes if o.sort == "single" and o.truth["effects"][0]["strength"] == strength]
            if own:
                hits, trials = count(own, lambda o: goals.members(o) and not o.wrong)
                bounds = wilson(hits, trials)
                x, y = x + [strength], y + [100 * hits / trials]
                low, high = low + [max(y[-1] - 100 * bounds[0], 0)], high + [max(100 * bounds[1] - y[-1], 0)]
        axes.errorbar(x, y, [low, high], fmt=mark, capsize=3, label=name)
    axes.set(xscale="log", ylim=(-3, 103), xlabel="size of the effect over the noise", ylabel="named, and nothing wrong, %")
    axes.set_xticks([0.3, 1, 3, 10, 100], ["0.3", "1", "3", "10", "100"])
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    figure.savefig(path, metadata={"Date": None, "Creator": None})
    pyplot.close(figure)
