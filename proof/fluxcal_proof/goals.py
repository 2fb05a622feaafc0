"""What is wanted, and whether it was reached."""
from collections.abc import Callable
from dataclasses import dataclass, replace

from .score import Round, count
from .verdict import FORM, Outcome

Test = Callable[[Outcome], bool]


@dataclass(frozen=True)
class Goal:
    """A share of some outcomes that should be at least, or at most, so many per cent; `own` are those of the program alone."""

    title: str
    percent: float
    at_least: bool
    of: Test
    hit: Test
    own: bool = False

    @property
    def wanted(self) -> str:
        return f"at {'least' if self.at_least else 'most'} {self.percent:g} %"

    def met(self, hits: int, trials: int) -> bool:
        """Whether the share reaches what is wanted."""
        return 100 * hits >= self.percent * trials if self.at_least else 100 * hits <= self.percent * trials

    def better(self, one: tuple[int, int], other: tuple[int, int]) -> bool:
        """Whether the first share is the better one."""
        a, b = one[0] * other[1], other[0] * one[1]
        return a > b if self.at_least else a < b


# What may be asked of an outcome.
strong: Test = lambda o: all(effect["strength"] >= 1 for effect in o.truth["effects"])
all_families: Test = lambda o: all(o.families)
members: Test = lambda o: all(member in ("right", "set") for member in o.members)
named: Test = lambda o: members(o) and not o.wrong
wrong: Test = lambda o: bool(o.wrong)
claimed: Test = lambda o: o.verdict != "agrees"
answered: Test = lambda o: o.verdict != "failed"

# Wanted of campaigns and of pairs alike.
BOTH = [
    Goal("one effect of at least the noise: family", 97, True, lambda o: o.sort == "single" and strong(o), all_families),
    Goal("one effect of at least the noise: member, or in the set", 92, True, lambda o: o.sort == "single" and strong(o), members),
    Goal("one effect of 0.3 times the noise: family", 85, True, lambda o: o.sort == "single" and not strong(o), all_families),
    Goal("one effect of 0.3 times the noise: member, or in the set", 80, True, lambda o: o.sort == "single" and not strong(o), members),
    Goal("two to four effects: all families", 88, True, lambda o: o.sort == "several", all_families),
    Goal("a wrong member where something acts that has a name", 2, False, lambda o: o.sort in ("single", "several"), wrong),
    Goal("clean: anything claimed", 1, False, lambda o: o.sort == "clean", claimed),
    Goal("outside the catalogue: no wrong member", 95, True, lambda o: o.sort == "unnamed", lambda o: answered(o) and not o.wrong),
]
GOALS = [
    *(replace(goal, title=f"campaigns, {goal.title}", of=lambda o, of=goal.of: o.truth["sort"] != "pair" and of(o)) for goal in BOTH),
    *(replace(goal, title=f"pairs, {goal.title}", of=lambda o, of=goal.of: o.truth["sort"] == "pair" and of(o)) for goal in BOTH),
    Goal("campaigns, outside the catalogue: `--empirical` lowers the rms by 1 %", 80, True,
         lambda o: o.truth["sort"] == "unnamed", lambda o: (o.empirical or 9) < 0.99, True),
    Goal("explained: rms left out within 5 % of the floor", 95, True,
         lambda o: o.verdict == "explained" and o.form is not None, lambda o: (o.form or 9) <= FORM, True),
    Goal("indistinguishable: the whole set is told", 95, True, lambda o: o.sort == "undecidable", lambda o: o.members == ["right"] and not o.wrong),
    Goal("real recordings, injected at 1 to 10 times the scatter: member, or in the set", 92, True,
         lambda o: o.sort == "injected" and strong(o), members, True),
    Goal("real recordings, a wrong member", 2, False, lambda o: o.sort == "injected", wrong, True),
    Goal("real recordings as they came, anything claimed", 1, False, lambda o: o.sort == "recorded", claimed, True),
    Goal("answered within the time", 99, True, lambda o: True, answered, True),
]


def reached(of: Round) -> list[tuple[Goal, tuple[int, int], dict[str, tuple[int, int]]]]:
    """Each goal with the program's share and the others', missed ones first; goals without a case are left out."""
    rows = []
    for goal in GOALS:
        own = count(filter(goal.of, of.diagnose), goal.hit)
        others = {} if goal.own else {name: count(filter(goal.of, outcomes), goal.hit) for name, outcomes in of.others.items()}
        if own[1]:
            rows.append((goal, own, others))
    return sorted(rows, key=lambda row: row[0].met(*row[1]))


def false_names(outcomes: list[Outcome]) -> int:
    """Names, alone or in a set, that are not right."""
    return sum(len(one.wrong) for one in outcomes)
