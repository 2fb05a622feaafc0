"""What follows a recorded temperature, current or another column."""
from __future__ import annotations

import numpy as np

from .. import response
from ..campaign import AXES, REFERENCE_C, Campaign, Run
from ..effect import Effect, in_geo, in_sensor, kind, linear
from ..response import Response

FAMILY = "follows_column"
SENSOR, ELECTRONICS, COIL = range(3)


def warmth(run: Run, which: int, late: Response | None = None) -> np.ndarray:
    """A temperature over its reference, K, at all instants; late: at rest when the recording begins."""
    t = run.temperature[which]
    return (t.through(late, run.span[0]) if late else t)(run.at) - REFERENCE_C[which]


def own(c: Campaign, run: Run, axis: int) -> np.ndarray:
    return c.plain(run)[axis]


@kind("offset_temperature", "bent", FAMILY, "NASA CR-156638, eq. 29")
def offset(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    b = rng.normal() * 0.02
    return in_sensor(c, axis, lambda run: warmth(run, SENSOR) * (1 + b * warmth(run, SENSOR)), "offset_temperature")


@kind("offset_temperature_lag", "one body", FAMILY, "Primdahl 1979, J. Phys. E 12, 241")
def offset_late(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    late = response.relaxation(c.length * rng.uniform(0.03, 0.3))
    return in_sensor(c, axis, lambda run: warmth(run, SENSOR, late), "offset_temperature_lag")


@kind("offset_temperature_lag", "two bodies side by side", FAMILY, "Primdahl 1979; core and housing warm at unlike rates")
def offset_side_by_side(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    tau, share = c.length * rng.uniform(0.05, 0.2), rng.uniform(0.6, 0.9)
    late = Response(0.0, np.array([share, 1 - share]), np.array([tau, 0.2 * tau]))
    return in_sensor(c, axis, lambda run: warmth(run, SENSOR, late), "offset_temperature_lag")


@kind("offset_temperature_inflection", "compensation that ends", FAMILY, "Jankowski and Sucksdorff 1996, IAGA Guide")
def compensated(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    at, before = rng.uniform(-3, 3), rng.uniform(-0.6, 0.2)
    return in_sensor(c, axis, lambda run: np.where(warmth(run, SENSOR) < at, before, 1.0) * (warmth(run, SENSOR) - at),
                     "offset_temperature_inflection", "offset_temperature")


@kind("offset_electronics_temperature", "amplifier", FAMILY, "Horowitz and Hill 2015, The Art of Electronics")
def amplifier(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return in_sensor(c, axis, lambda run: warmth(run, ELECTRONICS), "offset_electronics_temperature")


@kind("offset_electronics_temperature", "leakage that doubles", FAMILY, "Sze and Ng 2007, Physics of Semiconductor Devices: doubling each 10 K")
def leakage_current(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    every = rng.uniform(9, 14)
    return in_sensor(c, axis, lambda run: 2 ** (warmth(run, ELECTRONICS) / every), "offset_electronics_temperature")


@kind("sensitivity_electronics_temperature", "reference", FAMILY, "Acuna 2002, Rev. Sci. Instrum. 73, 3717")
def reference(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return in_sensor(c, axis, lambda run: own(c, run, axis) * 1e-5 * warmth(run, ELECTRONICS), "sensitivity_electronics_temperature")


@kind("sensitivity_temperature", "glass that hardly expands", FAMILY, "White 1979, thermal expansion of fused silica about its minimum")
def silica(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    bend = rng.uniform(0.01, 0.04)
    return in_sensor(c, axis, lambda run: own(c, run, axis) * 1e-5 * (warmth(run, SENSOR) + bend * warmth(run, SENSOR) ** 2),
                     "sensitivity_temperature")


@kind("sensitivity_temperature_lag", "former warmed from its end", FAMILY, "Carslaw and Jaeger 1959, 3.4")
def former(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    late = response.plate(c.length * rng.uniform(0.1, 0.5), 6)
    return in_sensor(c, axis, lambda run: own(c, run, axis) * 1e-5 * warmth(run, SENSOR, late), "sensitivity_temperature_lag")


@kind("axis_temperature", "wedge", FAMILY, "Acuna 2002, Rev. Sci. Instrum. 73, 3717")
def wedge(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    a, b = rng.normal(size=2)

    def turned(run: Run) -> np.ndarray:
        p = c.plain(run)
        return 1e-5 * (a * p[(axis + 1) % 3] + b * p[(axis + 2) % 3]) * warmth(run, SENSOR)

    return in_sensor(c, axis, turned, "axis_temperature")


@kind("coil_temperature", "former that expands", FAMILY, "NASA CR-156638, description of test facility")
def coil_expands(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    unit = np.eye(3)[axis]
    return in_geo(c, lambda run: np.outer(c.eta @ unit, 1e-5 * c.along(run)[axis] * warmth(run, COIL)), [("coil_temperature", AXES[axis])])


def of_column(c: Campaign, name: str, rng: np.random.Generator, late: Response | None = None, bend: float = 1.0) -> Effect:
    """A field in SEN in proportion to a column, or to a power of it."""
    v = rng.normal(size=3)

    level = {"humidity_percent": 45.0, "room_pressure_pa": 101_300.0}.get(name, 0.0)

    def x(run: Run) -> np.ndarray:
        s = run.columns[name]
        value = s.through(late, run.span[0])(run.at) if late else s(run.at)  # type: ignore[attr-defined]
        return np.sign(value - level) * np.abs(value - level) ** bend

    right = [("dependence", name)] + ([("stray_current", name)] if name.endswith("_a") else [])
    size = dict(zip(("x_nt_per_a", "y_nt_per_a", "z_nt_per_a"), v)) if late is None and bend == 1 and name.endswith("_a") else {}
    return Effect(linear([np.outer(c.mu.T @ v, x(run)) for run in c.runs]), right, truth={k: float(a) for k, a in size.items()})


@kind("stray_current", "heater", FAMILY, "Olsen et al. 2020, Earth Planets Space 72, 48")
def heater(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return of_column(c, "heater_current_a", rng)


@kind("stray_current", "panel logged late", FAMILY, "Olsen et al. 2020; the logger writes the value of some rows before")
def late_panel(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    effect = of_column(c, "panel_current_a", rng)
    rows = int(rng.integers(1, 4))
    for run in c.runs:
        true = run.columns["panel_current_a"]
        run.columns["panel_current_a"] = lambda t, true=true, by=rows * run.step: true(t - by)
    return effect


@kind("stray_current", "regulator in pulses", FAMILY, "a shunt whose conduction angle goes with the square root of the load")
def pulses(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return of_column(c, "panel_current_a", rng, bend=float(rng.uniform(1.3, 1.8)))


@kind("dependence", "humidity, late", FAMILY, "Fick's law in a thin case: one relaxation")
def humidity(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return of_column(c, "humidity_percent", rng, response.relaxation(c.length * rng.uniform(0.02, 0.15)))


@kind("dependence", "pressure", FAMILY, "an evacuated case that bends in proportion")
def pressure(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return of_column(c, "room_pressure_pa", rng)


@kind("coil_heating", "winding", FAMILY, "NASA CR-156638: temperature of the main winding; Joule's heat into one body")
def coil_heating(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    tau, unit = c.length * rng.uniform(0.05, 0.3), np.eye(3)[axis]

    def geo(run: Run) -> np.ndarray:
        fine = run.path(lambda t: run.current[axis](t) ** 2)
        dt = np.diff(run.at, prepend=run.at[0] - run.step * 1e-3)
        heat, warm = np.zeros(len(run.at)), 0.0
        for i, power in enumerate(fine.mean(1)):
            warm += (power - warm) * -np.expm1(-dt[i] / tau)
            heat[i] = warm
        return np.outer(c.eta @ unit, -1e-5 * c.along(run)[axis] * heat)

    return in_geo(c, geo, [("coil_heating", AXES[axis])])
