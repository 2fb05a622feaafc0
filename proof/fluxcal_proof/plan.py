"""What a round is made of: by the number of a case alone, so that one command makes any case again."""
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count as naturals
from itertools import islice
from typing import Any

import numpy as np

# Of thirty cases: p pairs of instruments, S single effects, V several at once, C clean, U without a name, D undecidable.
PATTERN = "SpVSpCSpUSpSVpSpCSUpSpSVpCSpUD"
SORTS = {"p": "pair", "S": "single", "V": "several", "C": "clean", "U": "unnamed", "D": "undecidable"}
# What acts in ten pairs: one thing, nothing, several, or something without a name.
TURNS = ("single", "single", "clean", "single", "several", "single", "single", "unnamed", "clean", "single")
STRENGTHS = (1.0, 3.0, 0.3, 10.0, 100.0)
# One of twelve pairs, twenty of a round, is a day of seconds; of the others so many have so many rows.
DAY_EVERY, DAY_ROWS = 12, 86_400
LENGTHS = ((0.86, 500, 1000), (0.11, 1000, 4000), (0.02, 4000, 12_000), (0.01, 12_000, 30_000))


@dataclass
class Case:
    """A document, its truth, and the readings without noise."""

    document: dict[str, Any]
    truth: dict[str, Any]
    expected: np.ndarray


def turn(pattern: Sequence[str], number: int) -> tuple[str, int]:
    """What a pattern that is repeated has at a number, and how many of the same came before."""
    rounds, place = divmod(number, len(pattern))
    return pattern[place], rounds * pattern.count(pattern[place]) + pattern[:place].count(pattern[place])


def sort(number: int) -> tuple[str, int]:
    """The sort of a case by its number, and how many of the same came before."""
    letter, index = turn(PATTERN, number)
    return SORTS[letter], index


def numbers(count: int, only: str) -> list[int]:
    """The first so many cases: all, campaigns or pairs."""
    wanted = {"all": lambda s: True, "campaigns": lambda s: s != "pair", "pairs": lambda s: s == "pair"}[only]
    return list(islice((number for number in naturals() if wanted(sort(number)[0])), count))


def rows(rng: np.random.Generator) -> int:
    weights = [share for share, _, _ in LENGTHS]
    _, least, most = LENGTHS[int(rng.choice(len(LENGTHS), p=weights))]
    return int(np.exp(rng.uniform(np.log(least), np.log(most))))
