"""Nonlinear and history-dependent responses to the field along the sensor or across it."""
from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..campaign import AXES, Campaign, Parts, Run
from ..effect import Effect, in_sensor, kind, one_sensor

FAMILY = "own_field"


def own(c: Campaign, run: Run, axis: int) -> np.ndarray:
    return c.plain(run)[axis] / 50_000


@kind("quadratic_nonlinearity", "square", FAMILY, "NASA CR-156638, sensor sensitivity")
def square(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return in_sensor(c, axis, lambda run: own(c, run, axis) ** 2, "quadratic_nonlinearity", truth={"departure_nt": 1.0})


@kind("cubic_nonlinearity", "cube", FAMILY, "NASA CR-156638, sensor sensitivity")
def cube(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return in_sensor(c, axis, lambda run: own(c, run, axis) ** 3, "cubic_nonlinearity", truth={"departure_nt": 1.0})


@kind("quadratic_nonlinearity", "gains that go over into each other", FAMILY, "two halves of an output stage; x tanh(x/w)")
def two_gains(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    width = rng.uniform(0.5, 1.2)
    return in_sensor(c, axis, lambda run: own(c, run, axis) * np.tanh(own(c, run, axis) / width), "quadratic_nonlinearity")


@kind("cubic_nonlinearity", "hyperbolic sine", FAMILY, "input stage that conducts exponentially; Horowitz and Hill 2015")
def sinh(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    width = rng.uniform(0.5, 1.0)
    return in_sensor(c, axis, lambda run: np.sinh(own(c, run, axis) / width), "cubic_nonlinearity")


@kind("cross_field", "squares and products", FAMILY, "Brauer et al. 1997, Sens. Actuators A 59, 70")
def across(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    a, b, mixed = rng.normal(size=3)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    return in_sensor(c, axis, lambda run: a * own(c, run, u) ** 2 + b * own(c, run, v) ** 2 + mixed * own(c, run, u) * own(c, run, v), "cross_field")


@kind("cross_field", "core that turns its moment", FAMILY, "Brauer et al. 1997; energy of a moment in an anisotropy field")
def turned_moment(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    level = rng.uniform(0.7, 1.5)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    return in_sensor(c, axis, lambda run: np.sqrt(1 + (own(c, run, u) ** 2 + own(c, run, v) ** 2) / level**2), "cross_field")


@kind("cross_field_sensitivity", "product", FAMILY, "Brauer et al. 1997, Sens. Actuators A 59, 70")
def product(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    a, b = rng.normal(size=2)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    return in_sensor(c, axis, lambda run: own(c, run, axis) * (a * own(c, run, u) + b * own(c, run, v)), "cross_field_sensitivity")


@kind("saturation", "soft end", FAMILY, "feedback that runs out of current: M / (1 + |M/L|^p)^(1/p)")
def saturation(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    sharp = rng.uniform(4, 8)

    def act(size: float) -> Parts:
        level = 3.0 * size**-0.25
        return one_sensor(c, axis, lambda run: 5e4 * own(c, run, axis) * ((1 + np.abs(own(c, run, axis) / level) ** sharp) ** (-1 / sharp) - 1))

    return Effect(act, [("saturation", AXES[axis])], power=sharp / 4)


@kind("saturation", "hyperbolic tangent", FAMILY, "a differential pair that is steered fully; Gray and Meyer 2009")
def tanh(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    right = [(name, AXES[axis]) for name in ("saturation", "cubic_nonlinearity")]

    def act(size: float) -> Parts:
        level = 10 * size**-0.5
        return one_sensor(c, axis, lambda run: 5e4 * (level * np.tanh(own(c, run, axis) / level) - own(c, run, axis)))

    return Effect(act, right)


def history(c: Campaign, axis: int, of: Callable[[np.ndarray], np.ndarray], *right: str) -> Effect:
    """What depends on the way of the field: `of` goes through the field's way (instants, finer) in 50 000 nT."""
    return in_sensor(c, axis, lambda run: of(run.path(lambda t: c.plain(run, t)[axis] / 50_000)), *right)


@kind("hysteresis", "play", FAMILY, "Krasnosel'skii and Pokrovskii 1989, Systems with Hysteresis")
def play(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return history(c, axis, lambda way: plays(way, np.array([rng.uniform(0.06, 0.3)]), np.ones(1)), "hysteresis", "perming")


@kind("hysteresis", "Preisach", FAMILY, "Mayergoyz 1991, Mathematical Models of Hysteresis; plays weighted by a density of widths")
def preisach(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    widths = np.linspace(0.02, 0.5, 15)
    weights = np.exp(-((widths - rng.uniform(0.05, 0.25)) / 0.1) ** 2)
    return history(c, axis, lambda way: plays(way, widths, weights), "hysteresis", "perming")


def plays(way: np.ndarray, widths: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sum of plays, less the field: y stays within x - r and x + r."""
    y, out = np.full(len(widths), way[0, 0]), np.empty(len(way))
    for i, stretch in enumerate(way):
        for x in stretch:
            y = np.minimum(np.maximum(y, x - widths), x + widths)
        out[i] = weights @ (y - stretch[-1])
    return out


def by_steps(way: np.ndarray, z: float, change: Callable[[float, float], float]) -> np.ndarray:
    """Integrates dz = change(z, dx) along the way, in parts of 1 000 nT at most."""
    x, out = way[0, 0], np.empty(len(way))
    for i, stretch in enumerate(way):
        for end in stretch:
            parts = int(abs(end - x) / 0.02) + 1
            for _ in range(parts):
                z += change(z, (end - x) / parts)
            x = end
        out[i] = z
    return out


@kind("hysteresis", "Bouc and Wen", FAMILY, "Wen 1976, J. Eng. Mech. Div. 102, 249")
def bouc_wen(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    width, beta = rng.uniform(0.05, 0.3), rng.uniform(0.5, 0.9)
    change = lambda z, dx: (dx - beta * abs(dx) * z - (1 - beta) * dx * abs(z)) / width
    return history(c, axis, lambda way: -by_steps(way, 0.0, change), "hysteresis")


@kind("hysteresis", "Dahl", FAMILY, "Dahl 1976, AIAA J. 14, 1675: friction of walls, its exponent between 1 and 2")
def dahl(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    width, power = rng.uniform(0.05, 0.3), rng.uniform(1.2, 2.0)
    change = lambda z, dx: dx / width * np.sign(1 - z * np.sign(dx)) * abs(1 - z * np.sign(dx)) ** power
    return history(c, axis, lambda way: -by_steps(way, 0.0, change), "hysteresis")


@kind("perming", "one threshold", FAMILY, "Primdahl 1979, J. Phys. E 12, 241")
def perming(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    threshold = rng.uniform(0.4, 0.8)

    def remanence(way: np.ndarray) -> np.ndarray:
        p, out = 0.0, np.empty(len(way))
        for i, stretch in enumerate(way):
            for x in stretch:
                p = min(max(p, x - threshold), x + threshold)
            out[i] = p
        return out

    return history(c, axis, remanence, "perming", "hysteresis")
