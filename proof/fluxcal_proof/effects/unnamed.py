"""Physics for which the catalogue has no name: no member is right."""
from __future__ import annotations

import numpy as np

from .. import signal
from ..campaign import Campaign, Run
from ..effect import Effect, in_sensor, kind
from ..response import relaxation
from .follows import SENSOR, warmth


def own(c: Campaign, run: Run, axis: int) -> np.ndarray:
    return c.plain(run)[axis] / 50_000


@kind("unnamed", "contact that opens and closes", "", "random telegraph signal; Machlup 1954, J. Appl. Phys. 25, 341")
def telegraph(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    states = [run.switched(rng, 8, 80, [0.0, 1.0]) for run in c.runs]
    return in_sensor(c, axis, lambda run: states[run.number](run.at))


@kind("unnamed", "product of the three fields", "", "third-order cross term of a core")
def triple(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return in_sensor(c, axis, lambda run: np.prod(c.plain(run) / 50_000, 0))


@kind("unnamed", "product of panel current and temperature", "", "a loop whose resistance goes with temperature")
def warm_loop(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return in_sensor(c, axis, lambda run: run.columns["panel_current_a"](run.at) * warmth(run, SENSOR))


@kind("unnamed", "gain that changes at a moment", "", "a feedback resistor that is switched")
def gain_step(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    at = c.runs[0].at[0] + rng.uniform(0.3, 0.7) * (c.runs[-1].at[-1] - c.runs[0].at[0])
    return in_sensor(c, axis, lambda run: own(c, run, axis) * (run.at > at))


@kind("unnamed", "crystal axes", "", "cubic anisotropy K1: sin 4 phi of the field's direction; Cullity and Graham 2009, 7.2")
def anisotropy(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    u = (axis + 1) % 3

    def four_fold(run: Run) -> np.ndarray:
        x, y = own(c, run, axis), own(c, run, u)
        size = np.hypot(x, y)
        return np.sin(4 * np.arctan2(y, x)) * size / (0.2 + size)

    return in_sensor(c, axis, four_fold)


@kind("unnamed", "tank that fills and empties", "", "relaxation oscillator, its period unlike each time; van der Pol 1926, Phil. Mag. 2, 978")
def tank(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    def saw(run: Run) -> np.ndarray:
        at = np.concatenate([[run.span[0]], signal.moments(rng, *run.span, 20 * c.step, 70 * c.step), [run.span[1]]])
        last = np.clip(np.searchsorted(at, run.at, side="right") - 1, 0, len(at) - 2)
        return (run.at - at[last]) / (at[last + 1] - at[last])

    return in_sensor(c, axis, saw)


@kind("unnamed", "chaotic convection", "", "Lorenz 1963, J. Atmos. Sci. 20, 130")
def lorenz(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    def convection(run: Run) -> np.ndarray:
        x, out = rng.normal(size=3) + [0, 0, 25], np.empty(len(run.at))
        for i in range(len(out)):
            for _ in range(4):
                x = x + 0.01 * np.array([10 * (x[1] - x[0]), x[0] * (28 - x[2]) - x[1], x[0] * x[1] - 8 / 3 * x[2]])
            out[i] = x[0] / 8
        return out

    return in_sensor(c, axis, convection)


@kind("unnamed", "heater that nobody recorded", "", "Joule's heat into a block that no thermometer touches")
def hidden_heater(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    loads = [run.switched(rng, 30, 100, [0.0, 1.0]).through(relaxation(20 * c.step), run.span[0]) for run in c.runs]
    return in_sensor(c, axis, lambda run: loads[run.number](run.at))


@kind("unnamed", "supply that sags", "", "a regulator that falls out of range where all coils draw current: sum of |I| beyond a limit")
def sagging(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    limit = rng.uniform(1.0, 1.6)

    def drop(run: Run) -> np.ndarray:
        total = sum(np.abs(i(run.at)) for i in run.current)
        return np.maximum(total - limit, 0.0)

    return in_sensor(c, axis, drop)


@kind("unnamed", "charge of a battery", "", "a loop current in proportion to the charge: the integral of the panel's current less a load")
def charge(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    def state(run: Run) -> np.ndarray:
        net = run.columns["panel_current_a"](run.at)
        return np.cumsum((net - net.mean()) * np.gradient(run.at)) / (run.at[-1] - run.at[0])

    return in_sensor(c, axis, state)


@kind("unnamed", "thermostat", "", "a heater that nobody recorded: on below a temperature, off above another; Franklin, Powell and Emami-Naeini")
def thermostat(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    band = float(rng.uniform(0.1, 0.3))

    def on(run: Run) -> np.ndarray:
        warm = warmth(run, SENSOR)
        warm = (warm - warm.mean()) / np.ptp(warm)
        state, out = 0.0, np.empty(len(warm))
        for i, value in enumerate(warm):
            state = 1.0 if value < -band else 0.0 if value > band else state
            out[i] = state
        return out

    return in_sensor(c, axis, on)


@kind("unnamed", "dead band", "", "a comparator that does not see small fields: nothing within a band, the excess beyond it; Slotine and Li 1991")
def dead_band(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    band = float(rng.uniform(0.2, 0.5))
    return in_sensor(c, axis, lambda run: np.sign(own(c, run, axis)) * np.maximum(np.abs(own(c, run, axis)) - band, 0.0))


@kind("unnamed", "switching converter", "", "its ripple beats with the sampling where the load changes its frequency: sin of a phase that the load drives")
def converter(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    step, gain = 0.11 / c.step, float(rng.uniform(0.02, 0.08)) / c.step
    return in_sensor(c, axis, lambda run: np.sin(2 * np.pi * np.cumsum((step + gain * run.columns["heater_current_a"](run.at)) * np.gradient(run.at))))


@kind("unnamed", "swell", "", "a narrow band of waves from the sea: a resonance driven by noise; Longuet-Higgins 1957")
def swell(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    def waves(run: Run) -> np.ndarray:
        centre = rng.uniform(0.03, 0.08) / c.step
        f = centre * (1 + 0.15 * rng.normal(size=40))
        return np.sin(2 * np.pi * np.outer(run.at, f) + rng.uniform(0, 2 * np.pi, 40)).sum(1) / 6

    return in_sensor(c, axis, waves)
