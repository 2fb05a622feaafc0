"""A round on a terminal, and its page, whose words are in page.toml."""
import tomllib
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from . import goals
from .recordings.page import STYLE, table
from .score import Round, count, share, wilson
from .verdict import FORM, Outcome

WORDS = tomllib.loads(Path(__file__).with_name("page.toml").read_text())
PICTURE = "proof/sealed.svg"
REGRESSIONS = ("stepwise", "ensemble")
PROBABILITIES = ((0.0, 0.5), (0.5, 0.9), (0.9, 0.99), (0.99, 1.0))
# Half of intervals of these levels, in standard uncertainties.
LEVELS = ((50, 0.674490), (90, 1.644854), (95, 1.959964), (99, 2.575829))


def title(outcome: Outcome) -> str:
    """What is concealed in a case."""
    return " + ".join(f"{e['kind']}, {e['form']} ({e['strength']:g}x)" for e in outcome.truth["effects"]) or "nothing"


def told(outcome: Outcome) -> str:
    return "; ".join(" or ".join(names) for names in outcome.claims)


def recorded(outcome: Outcome) -> str:
    return ", ".join([f"{outcome.truth['rows']} rows", *outcome.truth["manners"]])


def line(one: Outcome) -> str:
    """A case in a line of the terminal."""
    form = "" if one.form is None else f" form {one.form:.3f}"
    empirical = "" if one.empirical is None else f" empirical {one.empirical:.3f}"
    family = "".join("F" if one_of else "-" for one_of in one.families)
    return (f"{'right' if one.right else 'MISSED':6s} {one.truth['number']:4d} {one.truth['sort']} {one.sort}: {title(one)} | {recorded(one)} | "
            f"{one.verdict}: {told(one) or '-'} [{family} {','.join(one.members)}]{form}{empirical} {one.seconds:.1f} s")


def terminal(of: Round) -> str:
    """A line a case, then kind by kind, then goals."""
    outcomes, seconds = of.diagnose, [o.seconds for o in of.diagnose]
    lines = [*map(line, outcomes), "", kinds(of)]
    for goal, own, others in goals.reached(of):
        theirs = ", ".join(f"{name} {hits} of {trials}" for name, (hits, trials) in others.items() if trials)
        lines.append(f"{'met   ' if goal.met(*own) else 'MISSED'} {goal.title}, {goal.wanted}: {share(*own)}; {theirs}")
    lines.append(f"right: {share(*count(outcomes, lambda o: o.right))}, {goals.false_names(outcomes)} false names; " + "; ".join(
        f"{name} {sum(o.right for o in theirs)} of {len(theirs)}, {goals.false_names(theirs)}" for name, theirs in of.others.items()))
    lines.append(f"seconds an answer: median {np.median(seconds):.1f}, most {max(seconds):.1f}, in all {sum(seconds):.0f}")
    return "\n".join(lines)


def write(of: Round, page: Path) -> None:
    """Writes the page and its picture beside it."""
    (page.parent / PICTURE).parent.mkdir(parents=True, exist_ok=True)
    picture(of, page.parent / PICTURE)
    page.write_text("\n".join(part(of) for part in (opening, wins, goal_table, verdicts, calibration, kinds, failures, how)))


def opening(of: Round) -> str:
    """A picture and three sentences."""
    single = [o for o in of.diagnose if o.sort == "single" and goals.strong(o)]
    clean = [o for o in of.diagnose if o.sort == "clean"]
    named, claimed = count(single, goals.named), count(clean, goals.claimed)
    wrong = count([o for o in of.diagnose if o.truth["effects"]], goals.wrong)
    return WORDS["opening"].format(picture=PICTURE, named=share(*named), wrong=share(*wrong), claimed=share(*claimed))


def wins(of: Round) -> str:
    """Goals in which a rival is better, first of all."""
    lines = [f"- {name} is better in “{goal.title}”: {share(*theirs)} against {share(*own)}."
             for goal, own, others in goals.reached(of) for name, theirs in others.items()
             if name in REGRESSIONS and theirs[1] and goal.better(theirs, own)]
    for name in REGRESSIONS:
        theirs_all = of.others.get(name, [])
        common = {o.name for o in theirs_all}
        own_all = [o for o in of.diagnose if o.name in common]
        mine, other = (sum(o.right for o in outcomes) for outcomes in (own_all, theirs_all))
        if mine < other:
            lines.append(f"- {name} has more right verdicts: {other} against {mine} of {len(own_all)}.")
        false, theirs_false = goals.false_names(own_all), goals.false_names(theirs_all)
        if name == "stepwise" and false > 0.1 * theirs_false:
            lines.append(f"- False names are more than a tenth of those of {name}: {false} against {theirs_false}.")
    return "## Where a rival is better\n\n" + ("\n".join(lines) or "In no goal.") + "\n"


def goal_table(of: Round) -> str:
    """Goals, missed first."""
    rows, names = [], (*REGRESSIONS, "nothing", "diffmag")
    for goal, own, others in goals.reached(of):
        theirs = [f"{100 * others[name][0] / others[name][1]:.0f} %" if name in others and others[name][1] else "" for name in names]
        rows.append([goal.title, goal.wanted, share(*own), *theirs, "met" if goal.met(*own) else "**missed**"])
    return "## Goals\n\n" + table(["goal", "wanted", "diagnose", *names, ""], rows) + WORDS["goals"]


def verdicts(of: Round) -> str:
    """Verdicts, false names and time, program by program."""
    rows = []
    for name, outcomes in {"diagnose": of.diagnose, **of.others}.items():
        false, seconds = goals.false_names(outcomes), [o.seconds for o in outcomes]
        rows.append([name, share(*count(outcomes, lambda o: o.right)), str(false), f"{false / len(outcomes):.2f}",
                     f"{np.median(seconds):.2g}", f"{np.percentile(seconds, 95):.2g}", f"{max(seconds):.2g}"])
    notes = "" if "ensemble" in of.others else WORDS["no_ensemble"]
    return "## The same cases, others\n\n" + table(["", "right", "false names", "a case", "s, median", "s, 95 %", "s, most"], rows) + notes


def calibration(of: Round) -> str:
    """Whether printed probabilities and intervals hold."""
    rows, off = [], [abs(value) for one in of.diagnose for _, value in one.intervals]
    for low, high in PROBABILITIES:
        own = [(p, right) for one in of.diagnose for p, right in one.printed if low < p <= high]
        if own:
            p, right = map(sum, zip(*own))
            rows.append([f"names printed with {low:g} to {high:g}", f"{100 * (p / len(own)):.1f} %", share(right, len(own))])
    rows += [[f"intervals of {level} %", f"{level} %", share(sum(value <= half for value in off), len(off))] for level, half in LEVELS]
    return "## Printed probabilities and intervals\n\n" + table(["", "printed", "right"], rows)


def kinds(of: Round) -> str:
    groups: dict[str, list[Outcome]] = {}
    for one in of.diagnose:
        effects = one.truth["effects"]
        name = f"pair, {one.sort}" if one.truth["sort"] == "pair" else one.sort
        groups.setdefault(f"{effects[0]['kind']}, {effects[0]['form']}" if len(effects) == 1 else name, []).append(one)
    rows = []
    for name, own in sorted(groups.items()):
        effects, explained = own[0].truth["effects"], [o for o in own if o.verdict == "explained" and o.form is not None]
        counts = [len(own), *(sum(map(hit, own)) for hit in (goals.all_families, goals.members, goals.wrong))]
        rows.append([name, effects[0].get("source", "") if len(effects) == 1 else "", *map(str, counts),
                     f"{sum((o.form or 9) <= FORM for o in explained)} of {len(explained)}", str(sum(o.right for o in own)),
                     f"{np.median([o.seconds for o in own]):.1f}"])
    return "## Kind by kind\n\n" + table(["concealed", "source", "cases", "family", "member or set", "wrong", "form within 5 %", "right", "s"], rows)


def failures(of: Round) -> str:
    rows = [[str(one.truth["number"]), title(one), recorded(one), one.verdict.replace("_", " "), told(one) or "–"] for one in of.diagnose if not one.right]
    return WORDS["failures"].format(seed=of.seed, set=of.of) + table(["number", "concealed", "recorded", "answer", "named"], rows)


def how(of: Round) -> str:
    readings = sum(3 * o.truth["rows"] for o in of.diagnose)
    return WORDS["how"].format(commitment=of.commitment, seed=of.seed, set=of.of, cases=len(of.diagnose), readings=readings)


def picture(of: Round, path: Path) -> None:
    """Members told by strength, of the program and its rivals."""
    sizes, programs = {0.3: "0.3", 1: "1", 3: "3", 10: "10", 100: "100"}, {"diagnose": of.diagnose, **of.others}
    with rc_context(STYLE | {"font.size": 10, "lines.linewidth": 1.5}):
        figure = Figure((7.2, 3.6), layout="constrained")
        axes = figure.subplots()
        for name, mark in zip(("diagnose", *REGRESSIONS), ("o-", "s--", "^:")):
            if name not in programs:
                continue
            single, points = [o for o in programs[name] if o.sort == "single"], []
            for strength in sizes:
                hits, trials = count([o for o in single if o.truth["effects"][0]["strength"] == strength], goals.named)
                if trials:
                    y, (low, high) = 100 * hits / trials, wilson(hits, trials)
                    points.append((strength, y, max(y - 100 * low, 0), max(100 * high - y, 0)))
            x, y, *bars = np.reshape(points, (-1, 4)).T
            axes.errorbar(x, y, bars, fmt=mark, capsize=3, label=name)
        axes.set(xscale="log", ylim=(-3, 103), xlabel="size of the effect over the noise", ylabel="named, and nothing wrong, %")
        axes.set_xticks(list(sizes), list(sizes.values()))
        axes.legend(frameon=False)
        axes.grid(alpha=0.3)
        figure.savefig(path, metadata={"Date": None, "Creator": None})
