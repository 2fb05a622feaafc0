"""Late responses to the field: loops, filters, clocks, eddy currents."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .. import response
from ..campaign import AXES, Campaign, Parts, Run
from ..effect import Effect, kind, linear, one_sensor
from ..response import Response

FAMILY = "late_response"
LOOP = ("loop_bandwidth", "delay")


def loop(c: Campaign, axis: int, of: Callable[[float], Response], right: tuple[str, ...]) -> Effect:
    """The reading follows its field through a response whose time is the size, in hundredths of a step."""

    def act(size: float) -> Parts:
        what = of(0.01 * c.step * size)
        return one_sensor(c, axis, lambda run: c.reading_through(run, axis, what) - c.plain(run)[axis])

    return Effect(act, [(name, AXES[axis]) for name in right])


@kind("loop_bandwidth", "one pole", FAMILY, "Primdahl 1979, J. Phys. E 12, 241")
def one_pole(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return loop(c, axis, response.relaxation, LOOP)


@kind("delay", "filter of a converter", FAMILY, "Oppenheim and Schafer 1989, Discrete-Time Signal Processing")
def delay(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return loop(c, axis, response.late, LOOP)


@kind("loop_bandwidth", "two unlike poles", FAMILY, "Auster et al. 2008, Space Sci. Rev. 141, 235")
def two_poles(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    ratio = rng.uniform(0.2, 0.7)
    return loop(c, axis, lambda tau: response.poles([tau, ratio * tau]), LOOP)


@kind("loop_bandwidth", "three poles", FAMILY, "Oppenheim and Schafer 1989, Discrete-Time Signal Processing: a cascade of RC filters")
def three_poles(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return loop(c, axis, lambda tau: response.poles([tau, 0.8 * tau, 0.6 * tau]), LOOP)


@kind("loop_bandwidth", "damped second order", FAMILY, "Franklin, Powell and Emami-Naeini, Feedback Control of Dynamic Systems")
def second_order(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    damping = rng.uniform(0.6, 0.95)
    return loop(c, axis, lambda tau: response.damped(tau, damping), LOOP)


def shifted(c: Campaign, seconds: Callable[[Run], np.ndarray | float]) -> Callable[[float], Parts]:
    """Readings taken at another time than is written; a held drive is set after a reading, so that a late one misses it."""

    def act(size: float) -> Parts:
        return [c.plain(run, run.at - seconds(run) * size) - c.plain(run) for run in c.runs]

    return act


@kind("clock_offset", "one recording", FAMILY, "INTERMAGNET Technical Reference Manual")
def clock(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    number, sign = int(rng.choice([run.number for run in c.runs if not run.held])), rng.choice([-1, 1])
    return Effect(shifted(c, lambda run: sign * 0.01 * c.step * (run.number == number)), [("clock_offset", "")])


@kind("clock_rate", "quartz with a temperature coefficient", FAMILY, "Vig 1992, Introduction to Quartz Frequency Standards")
def quartz(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    bend = rng.uniform(0, 0.2)

    def seconds(run: Run) -> np.ndarray:
        t = run.at - c.runs[0].at[0]
        return 1e-6 * (t + bend * c.length * (t / (2 * c.length)) ** 2)

    return Effect(shifted(c, seconds), [("clock_rate", ""), ("clock_offset", "")])


def eddy(c: Campaign, axis: int, what: Response) -> Effect:
    """Metal about one coil keeps back a share of its changes: dB_c = -s (B_c - what B_c)."""
    parts, less = [], replace(what, direct=what.direct - 1)
    for run in c.runs:
        change = lambda k, x: x.through(less).times(1e-3 if k == axis else 0.0)
        along = c.along(run, through=change) - c.bias[:, None]
        parts.append(c.geo_to_reading(run, c.eta @ along))
    return Effect(linear(parts), [("eddy_currents", AXES[axis])])


@kind("eddy_currents", "plate", FAMILY, "Carslaw and Jaeger 1959, Conduction of Heat in Solids, 3.4")
def eddy_plate(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return eddy(c, axis, response.plate(c.step * rng.uniform(2, 25)))


@kind("eddy_currents", "sphere", FAMILY, "Wait 1951, Geophysics 16, 666: a conducting sphere in a field that changes")
def eddy_sphere(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return eddy(c, axis, response.sphere(c.step * rng.uniform(2, 25)))


@kind("eddy_currents", "many bodies", FAMILY, "Leliak 1961, IRE Trans. ANE-8, 95; a log-normal spread of their times")
def eddy_many(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return eddy(c, axis, response.spread(c.step * rng.uniform(1, 8), 0.35))
