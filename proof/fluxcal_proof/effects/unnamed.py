"""Physics for which no single name is right: the catalogue has none, or the recordings cannot tell two apart, whoever looks."""
from collections.abc import Callable
from functools import partial

import numpy as np

from ..campaign import ELECTRONICS, REFERENCE_C, SENSOR, Campaign
from ..effect import Effect, Sensor, linear, sensor
from ..groups import Kind
from ..response import relaxation
from ..signal import Signal

FOLLOWS = "follows_column"


def overload(x: Sensor, limit: float, steps: float) -> np.ndarray:
    beyond, out = 0.0, np.empty(len(x.at))
    for i, dt in enumerate(np.diff(x.at, prepend=x.at[0])):
        beyond = max(beyond * np.exp(-dt / (steps * x.c.step)), float(abs(x.b[i]) > limit))
        out[i] = beyond
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
    ("unnamed", "heater that nobody recorded", "",
     sensor(lambda x: x.run.switched(30, 100, [0.0, 1.0]).through(relaxation(20 * x.c.step), x.run.span[0])(x.at)),
     "Joule's heat into a block that no thermometer touches", True),
    ("unnamed", "charge of a battery", "", sensor(charge),
     "a loop current in proportion to the charge: the integral of the panel's current less a load", True),
    ("unnamed", "thermostat", "", sensor(thermostat, (0.1, 0.3)),
     "a heater that nobody recorded: on below a temperature, off above another; Franklin, Powell and Emami-Naeini", True),
    ("unnamed", "dead band", "", sensor(lambda x, band: np.sign(x.b) * np.maximum(np.abs(x.b) - band, 0.0), (0.2, 0.5)),
     "a comparator that does not see small fields: nothing within a band, the excess beyond it; Slotine and Li 1991", True),
    ("unnamed", "thermoelectric current", "", sensor(lambda x: np.gradient(x.warm(SENSOR), x.at) * x.c.length),
     "two metals between which heat flows while the temperature changes: Pollock 1985, Thermoelectricity", False),
    ("unnamed", "recovery from overload", "", sensor(overload, (0.5, 0.7), (10, 30)),
     "an amplifier that is driven beyond its range and recovers: Horowitz and Hill 2015", False),
    ("unnamed", "ripple of a supply", "", sensor(lambda x, hertz: x.b * np.real(x.run.wave(hertz / x.c.step)), (0.05, 0.45)),
     "a line as strong as the current of the coils", False),
    ("unnamed", "comparator across", "", sensor(lambda x, level: (x.u > level) * 1.0, (-0.3, 0.3)),
     "a field across that trips a comparator: a step where it passes a level", False),
    ("unnamed", "two loads on one wire", "", sensor(lambda x: x.column("panel_current_a") * x.column("heater_current_a")),
     "a field that goes with the product of two currents", False),
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
