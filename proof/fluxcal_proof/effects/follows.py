"""What follows a recorded temperature, current or another column."""
from collections.abc import Callable
from functools import partial

import numpy as np

from .. import response
from ..campaign import AXES, COIL, ELECTRONICS, SENSOR, Campaign, Run
from ..effect import NORMAL, Effect, in_geo, linear, sensor
from ..groups import Kind
from ..response import Response

FAMILY = "follows_column"
CURRENT = ("dependence", "stray_current")
# What columns are about that are not about zero.
LEVELS = {"humidity_percent": 45.0, "room_pressure_pa": 101_300.0}


def late(of: Callable[..., Response]) -> Callable[..., np.ndarray]:
    """The sensor's temperature through a response whose time is a share of a recording."""
    return lambda x, share, *more: x.warm(SENSOR, of(x.c.length * share, *more))


def coil_expands(c: Campaign, axis: int) -> Effect:
    unit = np.eye(3)[axis]
    return in_geo(c, lambda run: np.outer(c.eta @ unit, 1e-5 * c.along(run)[axis] * run.warm(COIL)), AXES[axis])


def coil_heating(c: Campaign, axis: int) -> Effect:
    tau, unit = c.length * c.rng.uniform(0.05, 0.3), np.eye(3)[axis]

    def geo(run: Run) -> np.ndarray:
        fine = run.path(lambda t: run.current[axis](t) ** 2)
        dt = np.diff(run.at, prepend=run.at[0] - run.step * 1e-3)
        heat, warm = np.zeros(len(run.at)), 0.0
        for i, power in enumerate(fine.mean(1)):
            warm += (power - warm) * -np.expm1(-dt[i] / tau)
            heat[i] = warm
        return np.outer(c.eta @ unit, -1e-5 * c.along(run)[axis] * heat)

    return in_geo(c, geo, AXES[axis])


def column(c: Campaign, axis: int, name: str, slow: tuple[float, float] | None = None, power: tuple[float, float] | None = None,
           logged: tuple[int, int] | None = None, through: Callable[[float], Response] = response.relaxation) -> Effect:
    """A field in SEN in proportion to a column, late by a response (its time a share of a recording), as a power, or written some rows late."""
    body = through(c.length * c.rng.uniform(*slow)) if slow else None
    bend, v = c.rng.uniform(*power) if power else 1.0, c.rng.normal(size=3)

    def x(run: Run) -> np.ndarray:
        s = run.columns[name]
        value = (s.through(body, run.span[0]) if body else s)(run.at) - LEVELS.get(name, 0.0)  # type: ignore[attr-defined]
        return np.sign(value) * np.abs(value) ** bend

    straight = name.endswith("_a") and not slow and not power
    effect = Effect(linear([np.outer(c.mu.T @ v, x(run)) for run in c.runs]), (name,),
                    truth={f"{k}_nt_per_a": float(a) for k, a in zip(AXES, v)} if straight else {})
    rows = int(c.rng.integers(*logged)) if logged else 0
    for run in c.runs if logged else []:
        run.columns[name] = lambda t, true=run.columns[name], by=rows * run.step: true(t - by)
    return effect


KINDS = [Kind(*row) for row in [
    ("offset_temperature", "bent", FAMILY, sensor(lambda x, b: x.warm(SENSOR) * (1 + 0.02 * b * x.warm(SENSOR)), NORMAL), "NASA CR-156638, eq. 29", True),
    ("offset_temperature_lag", "one body", FAMILY, sensor(late(response.relaxation), (0.03, 0.3)), "Primdahl 1979, J. Phys. E 12, 241", True),
    ("offset_temperature_lag", "two bodies side by side", FAMILY,
     sensor(late(lambda tau, share: Response(0.0, np.array([share, 1 - share]), np.array([tau, 0.2 * tau]))), (0.05, 0.2), (0.6, 0.9)),
     "Primdahl 1979; core and housing warm at unlike rates", False),
    ("offset_temperature_lag", "heat through a wall", FAMILY, sensor(late(lambda tau: response.plate(tau, 6)), (0.1, 0.5)),
     "Carslaw and Jaeger 1959, 3.4", False),
    ("offset_temperature_inflection", "compensation that ends", FAMILY,
     sensor(lambda x, at, before: np.where(x.warm(SENSOR) < at, before, 1.0) * (x.warm(SENSOR) - at), (-3, 3), (-0.6, 0.2)),
     "Jankowski and Sucksdorff 1996, IAGA Guide", True, ("offset_temperature_inflection", "offset_temperature")),
    ("offset_electronics_temperature", "amplifier", FAMILY, sensor(lambda x: x.warm(ELECTRONICS)), "Horowitz and Hill 2015, The Art of Electronics", True),
    ("offset_electronics_temperature", "leakage that doubles", FAMILY, sensor(lambda x, every: 2 ** (x.warm(ELECTRONICS) / every), (9, 14)),
     "Sze and Ng 2007, Physics of Semiconductor Devices: doubling each 10 K", False),
    ("sensitivity_electronics_temperature", "reference", FAMILY, sensor(lambda x: x.nt * 1e-5 * x.warm(ELECTRONICS)),
     "Acuna 2002, Rev. Sci. Instrum. 73, 3717", True),
    ("sensitivity_temperature", "glass that hardly expands", FAMILY,
     sensor(lambda x, bend: x.nt * 1e-5 * (x.warm(SENSOR) + bend * x.warm(SENSOR) ** 2), (0.01, 0.04)),
     "White 1979, thermal expansion of fused silica about its minimum", False),
    ("sensitivity_temperature_lag", "former warmed from its end", FAMILY,
     sensor(lambda x, share: x.nt * 1e-5 * late(lambda tau: response.plate(tau, 6))(x, share), (0.1, 0.5)), "Carslaw and Jaeger 1959, 3.4", False),
    ("axis_temperature", "wedge", FAMILY, sensor(lambda x, a, b: 1e-5 * (a * x.across[0] + b * x.across[1]) * x.warm(SENSOR), NORMAL, NORMAL),
     "Acuna 2002, Rev. Sci. Instrum. 73, 3717", True),
    ("coil_temperature", "former that expands", FAMILY, coil_expands, "NASA CR-156638, description of test facility", True),
    ("stray_current", "heater", FAMILY, partial(column, name="heater_current_a"), "Olsen et al. 2020, Earth Planets Space 72, 48", True, CURRENT),
    ("stray_current", "panel logged late", FAMILY, partial(column, name="panel_current_a", logged=(1, 4)),
     "Olsen et al. 2020; the logger writes the value of some rows before", True, CURRENT),
    ("stray_current", "regulator in pulses", FAMILY, partial(column, name="panel_current_a", power=(1.3, 1.8)),
     "a shunt whose conduction angle goes with the square root of the load", False, CURRENT),
    ("dependence", "humidity, late", FAMILY, partial(column, name="humidity_percent", slow=(0.02, 0.15)), "Fick's law in a thin case: one relaxation", True),
    ("stray_current", "load through a core that fills", FAMILY, partial(column, name="panel_current_a", power=(0.5, 0.8)),
     "a choke beside the sensor whose permeability falls: Bozorth 1951, Ferromagnetism", False, CURRENT),
    ("dependence", "humidity through a coat of paint", FAMILY, partial(column, name="humidity_percent", slow=(0.05, 0.3), through=response.plate),
     "Crank 1975, The Mathematics of Diffusion, 4.3: a sheet", False),
    ("dependence", "pressure", FAMILY, partial(column, name="room_pressure_pa"), "an evacuated case that bends in proportion", False),
    ("coil_heating", "winding", FAMILY, coil_heating, "NASA CR-156638: temperature of the main winding; Joule's heat into one body", True),
]]
