"""What a round is made of: by the number of a case alone, so that one command makes any case again."""
from __future__ import annotations

from dataclasses import dataclass
from itertools import count as naturals
from itertools import islice

import numpy as np

# Of thirty cases: p pairs of instruments, S single effects, V several at once, C clean, U without a name, D undecidable.
PATTERN = "SpVSpCSpUSpSVpSpCSUpSpSVpCSpUD"
SORTS = {"p": "pair", "S": "single", "V": "several", "C": "clean", "U": "unnamed", "D": "undecidable"}
STRENGTHS = (1.0, 3.0, 0.3, 10.0, 100.0)
# One of sixteen pairs, twenty of a thousand cases, is a day of seconds; of the others so many have so many rows.
DAY_EVERY, DAY_ROWS = 16, 86_400
LENGTHS = ((0.86, 500, 1000), (0.11, 1000, 4000), (0.02, 4000, 12_000), (0.01, 12_000, 30_000))


@dataclass(frozen=True)
class Spec:
    """A case before it is made. `index` counts the cases of its sort; `day` is a day of seconds."""

    number: int
    sort: str
    index: int
    day: bool


def spec(number: int) -> Spec:
    """The sort of a case by its number."""
    letter = PATTERN[number % len(PATTERN)]
    whole = number // len(PATTERN) * PATTERN.count(letter)
    index = whole + PATTERN[: number % len(PATTERN)].count(letter)
    day = letter == "p" and index % DAY_EVERY == 10
    return Spec(number, SORTS[letter], index, day)


def numbers(count: int, only: str) -> list[int]:
    """The first so many cases: all, campaigns or pairs."""
    wanted = {"all": lambda s: True, "campaigns": lambda s: s != "pair", "pairs": lambda s: s == "pair"}[only]
    return list(islice((number for number in naturals() if wanted(spec(number).sort)), count))


def of_kinds(index: int, count: int) -> tuple[int, float]:
    """Which of so many kinds, and how strong: each kind comes in each strength before any comes again in one."""
    return index % count, STRENGTHS[(index + index // count) % len(STRENGTHS)]


def rows(rng: np.random.Generator) -> int:
    """How many rows a case has."""
    weights = [share for share, _, _ in LENGTHS]
    _, least, most = LENGTHS[int(rng.choice(len(LENGTHS), p=weights))]
    return int(np.exp(rng.uniform(np.log(least), np.log(most))))
