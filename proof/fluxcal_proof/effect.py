"""What acts beyond the basic model, and the table of kinds that the modules of `effects` fill."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .campaign import AXES, Campaign, Parts, Run


@dataclass
class Effect:
    """What it adds to the readings at all instants, nT, by its size; (3, instants) for each recording."""

    act: Callable[[float], Parts]
    # Names that are right, as (effect, what it acts on): each alone, or a set of them.
    right: list[tuple[str, str]]
    # A power p: what is left goes as size^p where the size is no factor.
    power: float = 1.0
    # Parameters that the catalogue's equation has too, at size one; sizes in nT multiply `scaled`.
    truth: dict[str, float] = field(default_factory=dict)
    # Of the converter: acts on readings with their noise, which are put here before.
    codes: bool = False
    noisy: Parts = field(default_factory=list)
    # Of a set where nobody can tell the members apart, the right answer is the set.
    undecidable: bool = False


# Of a campaign, an axis and random numbers.
Make = Callable[[Campaign, int, np.random.Generator], Effect]


@dataclass(frozen=True)
class Kind:
    """A kind of physics in one of its forms; the family is the catalogue's, or "" where no name is right."""

    name: str
    form: str
    family: str
    make: Make
    source: str


KINDS: list[Kind] = []


def kind(name: str, form: str, family: str, source: str) -> Callable[[Make], Make]:
    """Enters what follows in the table."""

    def enter(make: Make) -> Make:
        KINDS.append(Kind(name, form, family, make, source))
        return make

    return enter


def linear(parts: Parts) -> Callable[[float], Parts]:
    """Parts in proportion to a size."""
    return lambda size: [size * part for part in parts]


def one_sensor(c: Campaign, axis: int, of: Callable[[Run], np.ndarray]) -> Parts:
    """In one sensor, a function of the recording."""
    parts = [np.zeros((3, len(run.at))) for run in c.runs]
    for run, part in zip(c.runs, parts):
        part[axis] = of(run)
    return parts


def in_sensor(c: Campaign, axis: int, of: Callable[[Run], np.ndarray], *right: str, **more: dict[str, float]) -> Effect:
    """An effect in one sensor, in proportion to its size; `right` are effects that have its name, on that sensor."""
    return Effect(linear(one_sensor(c, axis, of)), [(name, AXES[axis]) for name in right], **more)  # type: ignore[arg-type]


def in_geo(c: Campaign, of: Callable[[Run], np.ndarray], right: list[tuple[str, str]], truth: dict[str, float] | None = None) -> Effect:
    """A field in GEO, (3, instants), in proportion to its size."""
    return Effect(linear([c.geo_to_reading(run, of(run)) for run in c.runs]), right, truth=truth or {})
