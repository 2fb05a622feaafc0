"""Physics for which no single name is right: the catalogue has none, or the recordings cannot tell two apart, whoever looks."""
from collections.abc import Callable
from functools import partial

import numpy as np

from .. import signal
from ..campaign import ELECTRONICS, REFERENCE_C, SENSOR, Campaign, Run
from ..effect import Effect, Sensor, linear, sensor
from ..groups import Kind
from ..response import relaxation
from ..signal import Signal

FOLLOWS = "follows_column"


def gain_step(x: Sensor, share: float) -> np.ndarray:
    first, last = x.c.runs[0].at[0], x.c.runs[-1].at[-1]
    return x.b * (x.at > first + share * (last - first))


def anisotropy(x: Sensor) -> np.ndarray:
    size = np.hypot(x.b, x.u)
    return np.sin(4 * np.arctan2(x.u, x.b)) * size / (0.2 + size)


def tank(x: Sensor) -> np.ndarray:
    start, end = x.run.span
    at = np.concatenate([[start], signal.moments(x.rng, start, end, 20 * x.c.step, 70 * x.c.step), [end]])
    last = np.clip(np.searchsorted(at, x.at, side="right") - 1, 0, len(at) - 2)
    return (x.at - at[last]) / (at[last + 1] - at[last])


def lorenz(of: Sensor) -> np.ndarray:
    x, out = of.rng.normal(size=3) + [0, 0, 25], np.empty(len(of.at))
    for i in range(len(out)):
        for _ in range(4):
            x = x + 0.01 * np.array([10 * (x[1] - x[0]), x[0] * (28 - x[2]) - x[1], x[0] * x[1] - 8 / 3 * x[2]])
        out[i] = x[0] / 8
    return out


def charge(x: Sensor) -> np.ndarray:
    net = x.column("panel_current_a")
    return np.cumsum((net - net.mean()) * np.gradient(x.at)) / (x.at[-1] - x.at[0])


def thermostat(x: Sensor, band: float) -> np.ndarray:
    warm = x.warm(SENSOR)
    warm = (warm - warm.mean()) / np.ptp(warm)
    state, out = 0.0, np.empty(len(warm))
    for i, value in enumerate(warm):
        state = 1.0 if value < -band else 0.0 if value > band else state
        out[i] = state
    return out


def converter(x: Sensor, gain: float) -> np.ndarray:
    rate = 0.11 / x.c.step + gain / x.c.step * x.column("heater_current_a")
    return np.sin(2 * np.pi * np.cumsum(rate * np.gradient(x.at)))


def swell(x: Sensor) -> np.ndarray:
    centre = x.rng.uniform(0.03, 0.08) / x.c.step
    f = centre * (1 + 0.15 * x.rng.normal(size=40))
    return np.sin(2 * np.pi * np.outer(x.at, f) + x.rng.uniform(0, 2 * np.pi, 40)).sum(1) / 6


def together(c: Campaign, axis: int) -> Effect:
    for run in c.runs:
        run.temperature[ELECTRONICS] = run.temperature[SENSOR].plus(Signal(level=REFERENCE_C[ELECTRONICS] - REFERENCE_C[SENSOR]))
    return sensor(lambda x: x.warm(SENSOR))(c, axis)


def currents(c: Campaign, axis: int) -> Effect:
    v, share = c.rng.normal(size=3), c.rng.uniform(0.4, 0.8)
    for run in c.runs:
        run.columns["battery_current_a"] = lambda t, panel=run.columns["panel_current_a"]: 0.5 - share * panel(t)
    return Effect(linear([np.outer(v, run.columns["panel_current_a"](run.at)) for run in c.runs]), ("panel_current_a", "battery_current_a"))


def twins(c: Campaign, axis: int, columns: tuple[str, str], line: Callable[[np.ndarray], np.ndarray], acting: int, level: float) -> Effect:
    """A second column that is a line of the first; one of the two acts, about a level."""
    for run in c.runs:
        run.columns[columns[1]] = lambda t, one=run.columns[columns[0]]: line(one(t))
    return sensor(lambda x: x.column(columns[acting]) - level, on=columns)(c, axis)


KINDS = [Kind(*row) for row in [
    ("unnamed", "contact that opens and closes", "", sensor(lambda x: x.run.switched(8, 80, [0.0, 1.0])(x.at)),
     "random telegraph signal; Machlup 1954, J. Appl. Phys. 25, 341", True),
    ("unnamed", "product of the three fields", "", sensor(lambda x: np.prod(x.c.plain(x.run) / 50_000, 0)), "third-order cross term of a core", True),
    ("unnamed", "product of panel current and temperature", "", sensor(lambda x: x.column("panel_current_a") * x.warm(SENSOR)),
     "a loop whose resistance goes with temperature", True),
    ("unnamed", "gain that changes at a moment", "", sensor(gain_step, (0.3, 0.7)), "a feedback resistor that is switched", True),
    ("unnamed", "crystal axes", "", sensor(anisotropy), "cubic anisotropy K1: sin 4 phi of the field's direction; Cullity and Graham 2009, 7.2", True),
    ("unnamed", "tank that fills and empties", "", sensor(tank),
     "relaxation oscillator, its period unlike each time; van der Pol 1926, Phil. Mag. 2, 978", True),
    ("unnamed", "chaotic convection", "", sensor(lorenz), "Lorenz 1963, J. Atmos. Sci. 20, 130", True),
    ("unnamed", "heater that nobody recorded", "",
     sensor(lambda x: x.run.switched(30, 100, [0.0, 1.0]).through(relaxation(20 * x.c.step), x.run.span[0])(x.at)),
     "Joule's heat into a block that no thermometer touches", True),
    ("unnamed", "supply that sags", "", sensor(lambda x, limit: np.maximum(sum(np.abs(i(x.at)) for i in x.run.current) - limit, 0.0), (1.0, 1.6)),
     "a regulator that falls out of range where all coils draw current: sum of |I| beyond a limit", True),
    ("unnamed", "charge of a battery", "", sensor(charge),
     "a loop current in proportion to the charge: the integral of the panel's current less a load", False),
    ("unnamed", "thermostat", "", sensor(thermostat, (0.1, 0.3)),
     "a heater that nobody recorded: on below a temperature, off above another; Franklin, Powell and Emami-Naeini", False),
    ("unnamed", "dead band", "", sensor(lambda x, band: np.sign(x.b) * np.maximum(np.abs(x.b) - band, 0.0), (0.2, 0.5)),
     "a comparator that does not see small fields: nothing within a band, the excess beyond it; Slotine and Li 1991", False),
    ("unnamed", "switching converter", "", sensor(converter, (0.02, 0.08)),
     "its ripple beats with the sampling where the load changes its frequency: sin of a phase that the load drives", False),
    ("unnamed", "swell", "", sensor(swell), "a narrow band of waves from the sea: a resonance driven by noise; Longuet-Higgins 1957", False),
    ("undecidable", "two equal temperatures", FOLLOWS, together, "sensor and electronics in one oven", True,
     ("offset_temperature", "offset_electronics_temperature")),
    ("undecidable", "two currents in proportion", FOLLOWS, currents, "a panel and its battery share a bus", True, ("stray_current",)),
    ("undecidable", "two loggers of one humidity", FOLLOWS,
     partial(twins, columns=("humidity_percent", "second_humidity_percent"), line=lambda x: 1.02 * x - 1.5, acting=0, level=45),
     "one column written by two loggers", True, ("dependence",)),
    ("undecidable", "a gauge and its voltage", FOLLOWS,
     partial(twins, columns=("room_pressure_pa", "gauge_v"), line=lambda x: 2.5 + 1e-4 * x, acting=1, level=2.5),
     "one column in two units", False, ("dependence",)),
]]
