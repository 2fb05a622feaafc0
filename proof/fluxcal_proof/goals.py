"""What is wanted, and whether it was reached."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .score import Round, count
from .verdict import FORM, Outcome

Test = Callable[[Outcome], bool]
# Half of intervals of these levels, in standard uncertainties.
LEVELS = ((50, 0.674490), (90, 1.644854), (95, 1.959964), (99, 2.575829))
PROBABILITIES = ((0.0, 0.5), (0.5, 0.9), (0.9, 0.99), (0.99, 1.0))


@dataclass(frozen=True)
class Goal:
    """A share of some outcomes that should be at least, or at most, so many per cent; `own` are those of the program alone."""

    title: str
    percent: float
    at_least: bool
    of: Test
    hit: Test
    own: bool = False

    def met(self, hits: int, trials: int) -> bool:
        """Whether the share reaches what is wanted."""
        return 100 * hits >= self.percent * trials if self.at_least else 100 * hits <= self.percent * trials

    def better(self, one: tuple[int, int], other: tuple[int, int]) -> bool:
        """Whether the first share is the better one."""
        a, b = one[0] * other[1], other[0] * one[1]
        return a > b if self.at_least else a < b


def strong(one: Outcome) -> bool:
    return all(effect["strength"] >= 1 for effect in one.truth["effects"])


def all_families(one: Outcome) -> bool:
    return all(one.families)


def members(one: Outcome) -> bool:
    return all(member in ("right", "set") for member in one.members)


def all_of() -> list[Goal]:
    """The goals for campaigns, for pairs and for real recordings."""
    out: list[Goal] = []
    for where, here in (("campaigns", lambda o: o.truth["sort"] not in ("pair", "injected", "recorded")), ("pairs", lambda o: o.truth["sort"] == "pair")):
        def some(sort: str, more: Test = lambda o: True, here: Test = here) -> Test:
            return lambda o: here(o) and o.sort == sort and more(o)

        weak: Test = lambda o: not strong(o)
        out += [
            Goal(f"{where}, one effect of at least the noise: family", 97, True, some("single", strong), all_families),
            Goal(f"{where}, one effect of at least the noise: member, or in the set", 92, True, some("single", strong), members),
            Goal(f"{where}, one effect of 0.3 times the noise: family", 85, True, some("single", weak), all_families),
            Goal(f"{where}, one effect of 0.3 times the noise: member, or in the set", 80, True, some("single", weak), members),
            Goal(f"{where}, two to four effects: all families", 88, True, some("several"), all_families),
            Goal(f"{where}, a wrong member where something acts that has a name", 2, False,
                 lambda o, here=here: here(o) and o.sort in ("single", "several"), lambda o: bool(o.wrong)),  # type: ignore[misc]
            Goal(f"{where}, clean: anything claimed", 1, False, some("clean"), lambda o: o.verdict != "agrees"),
            Goal(f"{where}, outside the catalogue: no wrong member", 95, True, some("unnamed"), lambda o: o.verdict != "failed" and not o.wrong),
        ]
    out += [
        Goal("campaigns, outside the catalogue: `--empirical` lowers the rms by 1 %", 80, True,
             lambda o: o.truth["sort"] == "unnamed", lambda o: (o.empirical or 9) < 0.99, True),
        Goal("explained: rms left out within 5 % of the floor", 95, True, lambda o: o.verdict == "explained" and o.form is not None, lambda o: (o.form or 9) <= FORM, True),
        Goal("indistinguishable: the whole set is told", 95, True, lambda o: o.sort == "undecidable", lambda o: o.members == ["right"] and not o.wrong),
        Goal("real recordings, injected at 1 to 10 times the scatter: member, or in the set", 92, True, lambda o: o.sort == "injected" and strong(o), members, True),
        Goal("real recordings, a wrong member", 2, False, lambda o: o.sort == "injected", lambda o: bool(o.wrong), True),
        Goal("real recordings as they came, anything claimed", 1, False, lambda o: o.sort == "recorded", lambda o: o.verdict != "agrees", True),
        Goal("answered within the time", 99, True, lambda o: True, lambda o: o.verdict != "failed", True),
    ]
    return out


def reached(of: Round) -> list[tuple[Goal, tuple[int, int], dict[str, tuple[int, int]]]]:
    """Each goal with the program's share and the others', missed ones first; goals without a case are left out."""
    rows = []
    for goal in all_of():
        own = count(filter(goal.of, of.diagnose), goal.hit)
        others = {} if goal.own else {name: count(filter(goal.of, outcomes), goal.hit) for name, outcomes in of.others.items()}
        if own[1]:
            rows.append((goal, own, others))
    return sorted(rows, key=lambda row: row[0].met(*row[1]))


def false_names(outcomes: list[Outcome]) -> int:
    """Names, alone or in a set, that are not right."""
    return sum(len(one.wrong) for one in outcomes)


def probabilities(outcomes: list[Outcome]) -> list[tuple[str, float, tuple[int, int]]]:
    """Names by the probability printed: the class, its mean, and how many were right."""
    rows = []
    for low, high in PROBABILITIES:
        own = [(p, right) for one in outcomes for p, right in one.printed if low < p <= high]
        if own:
            rows.append((f"{low:g} to {high:g}", sum(p for p, _ in own) / len(own), (sum(right for _, right in own), len(own))))
    return rows


def intervals(outcomes: list[Outcome]) -> list[tuple[int, tuple[int, int]]]:
    """Parameters whose truth is within their interval, level by level."""
    off = [abs(value) for one in outcomes for _, value in one.intervals]
    return [(level, (sum(value <= half for value in off), len(off))) for level, half in LEVELS]
