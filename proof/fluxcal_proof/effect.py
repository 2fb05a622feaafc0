"""What acts beyond the basic model, and how what acts in one sensor of a campaign is written down."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .campaign import AXES, Campaign, Parts, Run


@dataclass
class Effect:
    """What it adds to the readings at all instants, nT, by its size; (3, instants) for each recording."""

    act: Callable[[float], Parts]
    # What it acts on: a sensor, a coil, columns of which each is right, or nothing in particular.
    on: tuple[str, ...] = ("",)
    # A power p: what is left goes as size^p where the size is no factor.
    power: float = 1.0
    # Parameters that the catalogue's equation has too, at size one; sizes in nT are in proportion.
    truth: dict[str, float] = field(default_factory=dict)
    # Of the converter: acts after all others, on `Campaign.noisy`.
    last: bool = False

    def sized(self, basic: Any, target: float) -> tuple[Parts, float]:
        """What it adds at the size at which the constants of the basic model leave so many nT of it, and that size."""
        size, parts = 1.0, self.act(1.0)
        for _ in range(12):
            left = basic.left(parts)
            if abs(np.log(left / target)) < 0.02:
                break
            size *= float(np.clip((target / left) ** (1 / self.power), 1e-3, 1e3))
            parts = self.act(size)
        return parts, size


# A number that is drawn: evenly between two, or by a function.
Draw = tuple[float, float] | Callable[[Campaign], Any]
NORMAL: Draw = lambda c: c.rng.normal()


def drawn(c: Campaign, draws: Sequence[Draw]) -> list[Any]:
    return [draw(c) if callable(draw) else c.rng.uniform(*draw) for draw in draws]


class Sensor:
    """One sensor in one recording, with all that may act on it, at all instants."""

    def __init__(self, c: Campaign, run: Run, axis: int) -> None:
        self.c, self.run, self.axis, self.at, self.rng, self.warm = c, run, axis, run.at, c.rng, run.warm
        # The field along this sensor and the two others, nT; the same in 50 000 nT.
        self.nt, *self.across = np.roll(c.plain(run), -axis, 0)
        self.b, self.u, self.v = self.nt / 50_000, *(nt / 50_000 for nt in self.across)
        # Time since the campaign's beginning over the length of a recording.
        self.age = (run.at - c.runs[0].at[0]) / c.length

    @property
    def way(self) -> np.ndarray:
        """The field's way to each instant, 50 000 nT; (instants, finer)."""
        return self.run.path(lambda t: self.c.plain(self.run, t)[self.axis] / 50_000)

    def column(self, name: str) -> np.ndarray:
        return self.run.columns[name](self.at)


def linear(parts: Parts) -> Callable[[float], Parts]:
    """Parts in proportion to a size."""
    return lambda size: [size * part for part in parts]


def one_sensor(c: Campaign, axis: int, of: Callable[[Sensor], np.ndarray]) -> Parts:
    """What acts in one sensor and not in the others."""
    return [np.outer(np.eye(3)[axis], of(Sensor(c, run, axis))) for run in c.runs]


def sensor(of: Callable[..., np.ndarray], *draws: Draw, on: tuple[str, ...] = (), **truth: float) -> Callable[[Campaign, int], Effect]:
    """A function of a sensor and of numbers that are drawn once, in proportion to its size."""

    def make(c: Campaign, axis: int) -> Effect:
        numbers = drawn(c, draws)
        return Effect(linear(one_sensor(c, axis, lambda x: of(x, *numbers))), on or (AXES[axis],), truth=truth)

    return make


def in_geo(c: Campaign, of: Callable[[Run], np.ndarray], on: str = "") -> Effect:
    """A field in GEO, (3, instants), in proportion to its size."""
    return Effect(linear([c.geo_to_reading(run, of(run)) for run in c.runs]), (on,))
