"""Nonlinear and history-dependent responses to the field along the sensor or across it."""
from collections.abc import Callable
from functools import partial

import numpy as np

from ..campaign import AXES, Campaign, Parts
from ..effect import NORMAL, Effect, Sensor, one_sensor, sensor
from ..groups import Kind

FAMILY = "own_field"
REMANENT = ("hysteresis", "perming")


def saturation(c: Campaign, axis: int) -> Effect:
    sharp = c.rng.uniform(4, 8)

    def act(size: float) -> Parts:
        level = 3.0 * size**-0.25
        return one_sensor(c, axis, lambda x: 5e4 * x.b * ((1 + np.abs(x.b / level) ** sharp) ** (-1 / sharp) - 1))

    return Effect(act, (AXES[axis],), power=sharp / 4)


def bent(c: Campaign, axis: int, of: Callable[[np.ndarray], np.ndarray] = np.tanh) -> Effect:
    """A curve of slope one at zero."""

    def act(size: float) -> Parts:
        level = 10 * size**-0.5
        return one_sensor(c, axis, lambda x: 5e4 * (level * of(x.b / level) - x.b))

    return Effect(act, (AXES[axis],))


def plays(way: np.ndarray, widths: np.ndarray, start: float) -> np.ndarray:
    """Plays of some widths, (instants, widths): each stays within x - r and x + r."""
    y, out = np.full(len(widths), start), np.empty((len(way), len(widths)))
    for i, stretch in enumerate(way):
        for x in stretch:
            y = np.minimum(np.maximum(y, x - widths), x + widths)
        out[i] = y
    return out


def behind(x: Sensor, widths: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """A weighted sum of plays, less the field."""
    way = x.way
    return np.array([weights @ row for row in plays(way, widths, way[0, 0]) - way[:, -1:]])


def preisach(x: Sensor, middle: float) -> np.ndarray:
    widths = np.linspace(0.02, 0.5, 15)
    return behind(x, widths, np.exp(-((widths - middle) / 0.1) ** 2))


def by_steps(way: np.ndarray, change: Callable[[float, float], float]) -> np.ndarray:
    """Integrates dz = change(z, dx) along the way, in parts of 1 000 nT at most."""
    x, z, out = way[0, 0], 0.0, np.empty(len(way))
    for i, stretch in enumerate(way):
        for end in stretch:
            parts = int(abs(end - x) / 0.02) + 1
            for _ in range(parts):
                z += change(z, (end - x) / parts)
            x = end
        out[i] = z
    return out


def bouc_wen(x: Sensor, width: float, beta: float) -> np.ndarray:
    return -by_steps(x.way, lambda z, dx: (dx - beta * abs(dx) * z - (1 - beta) * dx * abs(z)) / width)


def dahl(x: Sensor, width: float, power: float) -> np.ndarray:
    return -by_steps(x.way, lambda z, dx: dx / width * np.sign(1 - z * np.sign(dx)) * abs(1 - z * np.sign(dx)) ** power)


KINDS = [Kind(*row) for row in [
    ("quadratic_nonlinearity", "square", FAMILY, sensor(lambda x: x.b**2, departure_nt=1.0), "NASA CR-156638, sensor sensitivity", True),
    ("cubic_nonlinearity", "cube", FAMILY, sensor(lambda x: x.b**3, departure_nt=1.0), "NASA CR-156638, sensor sensitivity", True),
    ("quadratic_nonlinearity", "gains that go over into each other", FAMILY, sensor(lambda x, width: x.b * np.tanh(x.b / width), (0.5, 1.2)),
     "two halves of an output stage; x tanh(x/w)", False),
    ("cubic_nonlinearity", "hyperbolic sine", FAMILY, sensor(lambda x, width: np.sinh(x.b / width), (0.5, 1.0)),
     "input stage that conducts exponentially; Horowitz and Hill 2015", True),
    ("cross_field", "squares and products", FAMILY,
     sensor(lambda x, a, b, mixed: a * x.u**2 + b * x.v**2 + mixed * x.u * x.v, NORMAL, NORMAL, NORMAL), "Brauer et al. 1997, Sens. Actuators A 59, 70", True),
    ("cross_field", "core that turns its moment", FAMILY, sensor(lambda x, level: np.sqrt(1 + (x.u**2 + x.v**2) / level**2), (0.7, 1.5)),
     "Brauer et al. 1997; energy of a moment in an anisotropy field", False),
    ("cross_field_sensitivity", "product", FAMILY, sensor(lambda x, a, b: x.b * (a * x.u + b * x.v), NORMAL, NORMAL),
     "Brauer et al. 1997, Sens. Actuators A 59, 70", True),
    ("saturation", "soft end", FAMILY, saturation, "feedback that runs out of current: M / (1 + |M/L|^p)^(1/p)", True),
    ("saturation", "hyperbolic tangent", FAMILY, bent, "a differential pair that is steered fully; Gray and Meyer 2009", False,
     ("saturation", "cubic_nonlinearity")),
    ("saturation", "arctangent", FAMILY, partial(bent, of=lambda x: np.arctan(np.pi / 2 * x) / (np.pi / 2)),
     "magnetisation of a soft core: Bozorth 1951, Ferromagnetism", False, ("saturation", "cubic_nonlinearity")),
    ("cross_field", "fourth power", FAMILY, sensor(lambda x: (x.u**2 + x.v**2) ** 2), "next order of a core that is magnetised across", False),
    ("hysteresis", "play", FAMILY, sensor(lambda x: behind(x, np.array([x.rng.uniform(0.06, 0.3)]), np.ones(1))),
     "Krasnosel'skii and Pokrovskii 1989, Systems with Hysteresis", True, REMANENT),
    ("hysteresis", "Preisach", FAMILY, sensor(preisach, (0.05, 0.25)),
     "Mayergoyz 1991, Mathematical Models of Hysteresis; plays weighted by a density of widths", True, REMANENT),
    ("hysteresis", "Prandtl and Ishlinskii", FAMILY,
     sensor(lambda x, scale: behind(x, np.linspace(0.02, 0.5, 15), np.exp(-np.linspace(0.02, 0.5, 15) / scale)), (0.05, 0.2)),
     "Visintin 1994, Differential Models of Hysteresis: plays whose weights fall with their width", False, REMANENT),
    ("hysteresis", "Bouc and Wen", FAMILY, sensor(bouc_wen, (0.05, 0.3), (0.5, 0.9)), "Wen 1976, J. Eng. Mech. Div. 102, 249", True),
    ("hysteresis", "Dahl", FAMILY, sensor(dahl, (0.05, 0.3), (1.2, 2.0)),
     "Dahl 1976, AIAA J. 14, 1675: friction of walls, its exponent between 1 and 2", False),
    ("perming", "one threshold", FAMILY, sensor(lambda x, threshold: plays(x.way, np.array([threshold]), 0.0)[:, 0], (0.4, 0.8)),
     "Primdahl 1979, J. Phys. E 12, 241", True, REMANENT[::-1]),
]]
