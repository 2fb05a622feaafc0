"""A round on a terminal: a line a case, then kind by kind."""
from __future__ import annotations

import numpy as np

from . import goals, page
from .score import Round, count, share
from .verdict import Outcome


def line(one: Outcome) -> str:
    """A case in a line."""
    told = "; ".join(" or ".join(names) for names in one.claims) or "-"
    form = "" if one.form is None else f" form {one.form:.3f}"
    empirical = "" if one.empirical is None else f" empirical {one.empirical:.3f}"
    family = "".join("F" if one_of else "-" for one_of in one.families)
    state = "right" if one.right else "MISSED"
    return (f"{state:6s} {one.truth['number']:4d} {one.truth['sort']} {one.sort}: {page.title(one)} | {one.truth['rows']} rows, {', '.join(one.truth['manners'])} | "
            f"{one.verdict}: {told} [{family} {','.join(one.members)}]{form}{empirical} {one.seconds:.1f} s")


def of(scored: Round) -> str:
    """The table."""
    outcomes = scored.diagnose
    lines = [line(one) for one in outcomes]
    lines += ["", page.kinds(scored)]
    for goal, own, others in goals.reached(scored):
        theirs = ", ".join(f"{name} {hits} of {trials}" for name, (hits, trials) in others.items() if trials)
        wanted = f"at {'least' if goal.at_least else 'most'} {goal.percent:g} %"
        lines.append(f"{'met   ' if goal.met(*own) else 'MISSED'} {goal.title}, {wanted}: {share(*own)}; {theirs}")
    right = count(outcomes, lambda o: o.right)
    lines.append(f"right: {share(*right)}, {goals.false_names(outcomes)} false names; " + "; ".join(
        f"{name} {count(of_rival, lambda o: o.right)[0]} of {len(of_rival)}, {goals.false_names(of_rival)}" for name, of_rival in scored.others.items()))
    lines.append(f"seconds an answer: median {np.median([o.seconds for o in outcomes]):.1f}, most {max(o.seconds for o in outcomes):.1f}, in all {sum(o.seconds for o in outcomes):.0f}")
    return "\n".join(lines)
