"""Two instruments side by side: a test instrument beside a reference in the natural field, and what acts on it.

T = eta B + d + what acts + noise, R = B + noise of the reference (nT); the field is a function of time, so that a late
clock reads what the field was then. DIFF: the differential method.
"""
from collections.abc import Callable
from functools import partial

import numpy as np

from . import noise, response, signal
from .campaign import AXES, Parts, directions
from .effect import Effect
from .groups import Kind
from .response import Response
from .signal import Signal

LEVEL = (20_300.0, 1_700.0, 44_100.0)
FAMILY = "follows_column"
COLUMN = ("dependence", "stray_current")


class Pair:
    """One differential recording before anything acts. Times in s from its beginning."""

    def __init__(self, rng: np.random.Generator, rows: int, step: float, noisy_reference: float) -> None:
        self.rng, self.step, self.span = rng, step, (0.0, rows * step)
        self.t = np.arange(rows) * step
        self.length = rows * step
        self.field = [signal.smooth(rng, 2 * self.length, 4 * step, size, 1.2, 80).plus(self.wave(tide, 86_400)).plus(Signal(level=level))
                      for level, tide, size in zip(LEVEL, (25, 15, 10), (12, 10, 5))]
        self.eta, self.offset = directions(rng, 15 / 60), rng.normal(size=3) * 20
        self.noise = noise.Noise(0.1)
        self.reference_noise = noise.Noise(noisy_reference)
        # A room by day and night, with weather, and a box with a heater that is switched.
        room = self.wave(4.0, min(86_400, self.length)).plus(signal.smooth(rng, self.length, self.length / 30, 2.0, 2.0))
        box = self.switched([0.0, 5.0]).through(response.relaxation(rng.uniform(10, 30) * step), 0.0)
        self.columns: dict[str, Callable[[np.ndarray], np.ndarray]] = {
            "test_temperature_c": room.plus(Signal(level=20.0)), "electronics_temperature_c": box.plus(Signal(level=20.0)),
            "load_current_a": self.switched([0.0, 2.0]), "relay_v": self.switched([0.0, 5.0]),
            "torquer_x_am2": self.switched([-0.2, 0.0, 0.2]), "panel_power_w": self.switched([0.0, 20.0, 40.0]),
            "humidity_percent": signal.smooth(rng, self.length, self.length / 20, 6.0, 2.0).plus(Signal(level=50.0)),
            "room_pressure_pa": signal.smooth(rng, self.length, self.length / 15, 80.0, 2.0).plus(Signal(level=101_300.0))}

    def wave(self, size: float, period: float) -> Signal:
        return Signal(c=np.array([size * np.exp(2j * np.pi * self.rng.uniform())]), omega=np.array([2 * np.pi / period]))

    def switched(self, values: list[float]) -> Signal:
        """Switched at moments some tens of rows apart."""
        return signal.levels(self.rng, signal.moments(self.rng, *self.span, 20 * self.step, max(80 * self.step, self.length / 60)), values)

    def at(self, late: np.ndarray | float = 0.0) -> np.ndarray:
        """The field at the rows, or so many seconds before them, (3, rows)."""
        return np.stack([component(self.t - late) for component in self.field])


class Fitted:
    """Least squares of a level and three slopes: the basic model of a pair."""

    def __init__(self, field: np.ndarray) -> None:
        columns = np.vstack([np.ones(field.shape[1]), field - field.mean(1, keepdims=True)])
        self.basis = np.linalg.qr(columns.T)[0]

    def without(self, x: np.ndarray) -> np.ndarray:
        """What is left of (3, rows)."""
        return x - (x @ self.basis) @ self.basis.T

    def left(self, parts: Parts) -> float:
        """Rms on the axis that keeps most, nT."""
        return max(float(np.sqrt((self.without(parts[0]) ** 2).mean(1).max())), 1e-12)


def acts(pair: Pair, x: np.ndarray, on: str = "", key: str = "") -> Effect:
    """A function of time, less its mean, on all axes of the test instrument; `key` ends the names of its parameters."""
    v = pair.rng.normal(size=3)
    part = np.outer(v, x - x.mean())
    return Effect(lambda size: [size * part], (on,), truth={f"{k}_{key}": float(a) for k, a in zip(AXES, v)} if key else {})


def wall(pair: Pair) -> Response:
    """Heat that diffuses into a plate."""
    return response.plate(pair.length * pair.rng.uniform(0.02, 0.1), 8)


def two_bodies(pair: Pair) -> Response:
    """A core that warms at once with its housing, and a block that follows."""
    return Response(0.0, np.array([0.6, 0.4]), pair.length * pair.rng.uniform([0.005, 0.05], [0.02, 0.12]))


def body(least: float, most: float) -> Callable[[Pair], Response]:
    """One relaxation, its time a share of the length."""
    return lambda pair: response.relaxation(pair.length * pair.rng.uniform(least, most))


def column(pair: Pair, name: str, late: Callable[[Pair], Response] | None = None, bend: float = 1.0, logged: tuple[int, int] | None = None,
           gauge: Callable[[Pair], Response] | None = None) -> Effect:
    """A column that acts, late by a response, as a power, written so many rows late (early where less than none) or by a slow gauge."""
    true = pair.columns[name]
    x = true.through(late(pair), 0.0)(pair.t) if late else true(pair.t)  # type: ignore[attr-defined]
    x = x - x.min() if bend != 1 else x
    if logged:
        by = int(pair.rng.integers(logged[0], logged[1] + 1)) * pair.step
        pair.columns[name] = lambda t: true(t - by)
    if gauge:
        pair.columns[name] = true.through(gauge(pair), 0.0)  # type: ignore[attr-defined]
    unit = name.split("_")[-1]
    return acts(pair, np.sign(x) * np.abs(x) ** bend, name, f"nt_per_{'k' if unit == 'c' else unit}" if bend == 1 and late not in (wall, two_bodies) else "")


def saturating(pair: Pair) -> Effect:
    """A field that grows less and less with a current."""
    x = pair.columns["load_current_a"](pair.t)
    share = np.abs(x) / np.median(np.abs(x[x != 0]))
    return acts(pair, np.sign(x) * share / (1 + share), "load_current_a")


def clock(pair: Pair, late: Callable[[Pair], np.ndarray | float]) -> Effect:
    """The test instrument's clock is late by so many seconds, a function of time."""
    seconds = late(pair)
    field, sign = pair.at(), pair.rng.choice([-1, 1])
    return Effect(lambda size: [pair.eta @ (pair.at(sign * size * seconds) - field)])


def quartz(pair: Pair) -> np.ndarray:
    """A rate, with a bend of the quartz."""
    return 1e-4 * pair.t + 2e-5 * pair.length * (pair.t / pair.length) ** 2


def slow_sensor(pair: Pair) -> Effect:
    """One sensor of the test instrument is behind a filter of one pole."""
    axis = int(pair.rng.integers(3))
    own, field = np.outer(np.eye(3)[axis], pair.eta[axis]), pair.at()
    late = lambda tau: np.stack([component.through(response.relaxation(tau))(pair.t) for component in pair.field])
    return Effect(lambda size: [own @ (late(0.02 * size * pair.step) - field)], (AXES[axis],))


def pump(pair: Pair) -> Effect:
    """A motor at a constant rate."""
    return acts(pair, np.cos(2 * np.pi * (pair.rng.uniform(0.05, 0.45) / pair.step * pair.t + pair.rng.uniform())))


def vagabond(pair: Pair) -> Effect:
    """Currents that leak from a railway into the ground: loads of trains, each as it accelerates and brakes."""
    at = signal.moments(pair.rng, *pair.span, 5 * pair.step, max(40 * pair.step, pair.length / 120))
    return acts(pair, signal.levels(pair.rng, at).through(response.relaxation(pair.rng.uniform(2, 8) * pair.step), 0.0)(pair.t))


def of_time(of: Callable[[np.ndarray, np.random.Generator], np.ndarray]) -> Callable[[Pair], Effect]:
    """A function of time over the length of the recording."""
    return lambda pair: acts(pair, of(pair.t / pair.length, pair.rng))


def there_and_back(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    first = rng.uniform(0.15, 0.45)
    return (t > first) * 1.0 - (t > first + rng.uniform(0.15, 0.4)) * rng.uniform(0.4, 0.9)


def swinging(pair: Pair) -> Effect:
    """A field of slow waves of its own on the test instrument's side, gone as it came."""
    wave = signal.smooth(pair.rng, pair.length / 8, pair.length / 40, 1.0)
    return acts(pair, wave(pair.t) * np.sin(np.pi * pair.t / pair.length) ** 2)


KINDS = [Kind(*row) for row in [
    ("stray_current", "load beside the test instrument", FAMILY, partial(column, name="load_current_a"),
     "Biot and Savart: a field in proportion", True, COLUMN),
    ("dependence", "temperature by day", FAMILY, partial(column, name="test_temperature_c"), "IAGA Guide, variometers", True, COLUMN),
    ("dependence", "temperature, late by one body", FAMILY, partial(column, name="test_temperature_c", late=body(0.01, 0.08)),
     "Newton's law of cooling", True, COLUMN),
    ("dependence", "temperature, square", FAMILY, partial(column, name="test_temperature_c", bend=2.0), "NASA CR-156638, eq. 29", True, COLUMN),
    ("dependence", "relay logged late", FAMILY, partial(column, name="relay_v", logged=(1, 3)), "a multiplexer's row before", True, COLUMN),
    ("clock_offset", "pair", "late_response", partial(clock, late=lambda pair: 0.1 * pair.step), "INTERMAGNET Technical Reference Manual", True),
    ("reading_step", "pair", "time", of_time(lambda t, rng: (t > rng.uniform(0.2, 0.8)) * 1.0), "IAGA Guide, steps", True),
    ("ageing", "pair", "time", of_time(lambda t, _: t), "IAGA Guide, base lines", True, ("ageing", "warm_up")),
    ("warm_up", "pair", "time", of_time(lambda t, _: np.exp(-t / 0.15)), "IAGA Guide", True, ("warm_up", "ageing")),
    ("unnamed", "load that nobody recorded", "", lambda pair: acts(pair, pair.switched([0.0, 1.0])(pair.t)), "Biot and Savart", True),
    ("stray_current", "torquer commanded early", FAMILY, partial(column, name="torquer_x_am2", logged=(-2, -1)),
     "Wertz 1978, Spacecraft Attitude Determination", False, COLUMN),
    ("dependence", "temperature behind a wall", FAMILY, partial(column, name="electronics_temperature_c", late=wall),
     "Carslaw and Jaeger 1959, 3.4", True, COLUMN),
    ("dependence", "pressure beside a pair", FAMILY, partial(column, name="room_pressure_pa"), "a case that bends in proportion", True, COLUMN),
    ("dependence", "power of a panel", FAMILY, partial(column, name="panel_power_w"), "a current at constant voltage", False, COLUMN),
    ("stray_current", "load through a core that saturates", FAMILY, saturating, "a choke beside the sensor: Froelich's curve x/(1 + x)", False, COLUMN),
    ("dependence", "humidity, late beside a pair", FAMILY, partial(column, name="humidity_percent", late=body(0.01, 0.05)),
     "Fick's law in a thin case", False, COLUMN),
    ("clock_rate", "pair", "late_response", partial(clock, late=quartz),
     "Vig 1992, Introduction to Quartz Frequency Standards", True, ("clock_rate", "clock_offset")),
    ("reading_step", "pair, there and back", "time", of_time(there_and_back), "a tool left on the pillar", True),
    ("ageing", "pair, logarithm", "time", of_time(lambda t, _: np.log1p(20 * t)), "Nutting 1921; creep of a pillar", False, ("ageing", "warm_up")),
    ("unnamed", "waves of a neighbour", "", swinging, "a process nearby", True),
    ("dependence", "temperature, core and block", FAMILY, partial(column, name="test_temperature_c", late=two_bodies),
     "Primdahl 1979; core and housing warm at unlike rates", False, COLUMN),
    ("dependence", "temperature by a slow thermometer", FAMILY, partial(column, name="electronics_temperature_c", gauge=body(0.002, 0.01)),
     "a sheathed thermometer: Michalski et al. 2001, Temperature Measurement", False, COLUMN),
    ("clock_offset", "pair, set once", "late_response",
     partial(clock, late=lambda pair: 0.1 * pair.step * (pair.t < pair.rng.uniform(0.4, 0.7) * pair.length)), "RFC 5905: a clock that is stepped", False),
    ("loop_bandwidth", "pair, one sensor", "late_response", slow_sensor, "Primdahl 1979, J. Phys. E 12, 241", False, ("loop_bandwidth", "delay")),
    ("warm_up", "pair, two bodies", "time", of_time(lambda t, _: np.exp(-t / 0.05) + 0.5 * np.exp(-t / 0.3)), "IAGA Guide; board and box", False,
     ("warm_up", "ageing")),
    ("periodic_field", "pump beside a pair", "lines", pump, "a motor at a constant rate", False, ("periodic_field", "mains", "traction_power")),
    ("unnamed", "vagabond currents", "", vagabond, "Lowes 2009, Space Sci. Rev.: fields of railways of direct current", False),
]]
