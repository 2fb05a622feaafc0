"""A round on a terminal: a line a case, then kind by kind."""
from __future__ import annotations

import numpy as np

from .score import count, share
from .verdict import Outcome


def title(outcome: Outcome) -> str:
    """What is concealed in a case."""
    return " + ".join(f"{e['kind']}, {e['form']} ({e['strength']:g}x)" for e in outcome.truth["effects"]) or "nothing"


def line(one: Outcome) -> str:
    """A case in a line."""
    told = "; ".join(" or ".join(names) for names in one.claims) or "-"
    form = "" if one.form is None else f" form {one.form:.3f}"
    empirical = "" if one.empirical is None else f" empirical {one.empirical:.3f}"
    family = "".join("F" if one_of else "-" for one_of in one.families)
    state = "right" if one.right else "MISSED"
    return (f"{state:6s} {one.truth['number']:4d} {one.truth['sort']} {one.sort}: {title(one)} | {one.truth['rows']} rows, {', '.join(one.truth['manners'])} | "
            f"{one.verdict}: {told} [{family} {','.join(one.members)}]{form}{empirical} {one.seconds:.1f} s")


def of(outcomes: list[Outcome]) -> str:
    """The table."""
    lines = [line(one) for one in outcomes]
    groups: dict[str, list[Outcome]] = {}
    for one in outcomes:
        effects = one.truth["effects"]
        groups.setdefault(f"{effects[0]['kind']}, {effects[0]['form']}" if len(effects) == 1 else one.sort, []).append(one)
    lines.append(f"\n{'kind':60s} cases family right in-set wrong form<=1.05  s")
    for name, own in sorted(groups.items()):
        lines.append(f"{name:60s} {len(own):5d} {sum(all(o.families) for o in own):6d} {sum(all(m == 'right' for m in o.members) for o in own):5d} "
                     f"{sum(all(m != 'none' for m in o.members) for o in own):6d} {sum(bool(o.wrong) for o in own):5d} "
                     f"{sum((o.form or 9) <= 1.05 for o in own):10d} {np.median([o.seconds for o in own]):6.1f}")
    lines.append("")
    for sort in ("single", "several", "clean", "unnamed", "undecidable", "injected", "recorded"):
        own = [o for o in outcomes if o.sort == sort]
        if not own:
            continue
        lines.append(f"{sort}: right or in the set, nothing wrong {share(*count(own, lambda o: o.right))}; a wrong name {share(*count(own, lambda o: bool(o.wrong)))}")
        if sort in ("single", "several"):
            for name, strengths in (("0.3x", [0.3]), (">= 1x", [1, 3, 10, 100])):
                some = [o for o in own if all(e["strength"] in strengths for e in o.truth["effects"])]
                if some:
                    lines.append(f"  {name}: all families {share(*count(some, lambda o: all(o.families)))}; members right or in the set "
                                 f"{share(*count(some, lambda o: all(m != 'none' for m in o.members)))}; right {share(*count(some, lambda o: all(m == 'right' for m in o.members)))}")
    explained = [o for o in outcomes if o.verdict == "explained" and o.form is not None]
    lines.append(f"explained, rms within 5 % of the floor: {share(*count(explained, lambda o: (o.form or 9) <= 1.05))}")
    adopted = [o for o in outcomes if o.truth["sort"] == "unnamed" and o.verdict != "failed"]
    if adopted:
        lines.append(f"without a name, --empirical lowers the rms by 1 %: {share(*count(adopted, lambda o: (o.empirical or 9) < 0.99))}")
    lines.append(f"seconds an answer: median {np.median([o.seconds for o in outcomes]):.1f}, most {max(o.seconds for o in outcomes):.1f}, in all {sum(o.seconds for o in outcomes):.0f}")
    return "\n".join(lines)
