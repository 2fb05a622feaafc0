"""What acts on the test instrument of a pair."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from . import response, signal
from .effect import Effect
from .pairs import Pair
from .response import Response

FAMILY = "follows_column"


@dataclass(frozen=True)
class PairKind:
    """As `effect.Kind`, for pairs; `looked_at` puts it into the group `develop`, by the rule of `groups`."""

    name: str
    form: str
    family: str
    make: Callable[[Pair, np.random.Generator], Effect]
    source: str
    looked_at: bool


def acts(x: np.ndarray, rng: np.random.Generator, right: list[tuple[str, str]], key: str = "") -> Effect:
    """A function of time, less its mean, on all axes of the test instrument; `key` ends the names of its parameters."""
    v = rng.normal(size=3)
    part = np.outer(v, x - x.mean())
    return Effect(lambda size: [size * part], right, truth={f"{k}_{key}": float(a) for k, a in zip("xyz", v)} if key else {})


def wall(pair: Pair, rng: np.random.Generator) -> Response:
    """Heat that diffuses into a plate."""
    return response.plate(pair.length * rng.uniform(0.02, 0.1), 8)


def column(name: str, late: Callable[[Pair, np.random.Generator], Response] | None = None, bend: float = 1.0,
           logged: tuple[int, int] | None = None) -> Callable[[Pair, np.random.Generator], Effect]:
    """A column that acts, late by a response, as a power, or written so many rows late (early where less than none)."""

    def make(pair: Pair, rng: np.random.Generator) -> Effect:
        true = pair.columns[name]
        x = true.through(late(pair, rng), 0.0)(pair.t) if late else true(pair.t)  # type: ignore[attr-defined]
        x = x - x.min() if bend != 1 else x
        if logged:
            by = int(rng.integers(logged[0], logged[1] + 1)) * pair.step
            pair.columns[name] = lambda t: true(t - by)
        return acts(np.sign(x) * np.abs(x) ** bend, rng, [("dependence", name), ("stray_current", name)],
                    f"nt_per_{ {'c': 'k'}.get(name.split('_')[-1], name.split('_')[-1])}" if bend == 1 and late is not wall else "")

    return make


def saturating(pair: Pair, rng: np.random.Generator) -> Effect:
    """A field that grows less and less with a current."""
    x = pair.columns["load_current_a"](pair.t)
    share = np.abs(x) / np.median(np.abs(x[x != 0]))
    return acts(np.sign(x) * share / (1 + share), rng, [("dependence", "load_current_a"), ("stray_current", "load_current_a")])


def clock(rate: bool) -> Callable[[Pair, np.random.Generator], Effect]:
    """The test instrument's clock is late, or goes at another rate with a bend of its quartz."""

    def make(pair: Pair, rng: np.random.Generator) -> Effect:
        seconds = 1e-4 * pair.t + 2e-5 * pair.length * (pair.t / pair.length) ** 2 if rate else 0.1 * pair.step
        field, sign = pair.at(), rng.choice([-1, 1])
        right = [("clock_rate", ""), ("clock_offset", "")] if rate else [("clock_offset", "")]
        return Effect(lambda size: [pair.eta @ (pair.at(sign * size * seconds) - field)], right)

    return make


def of_time(of: Callable[[np.ndarray, np.random.Generator], np.ndarray], *right: str) -> Callable[[Pair, np.random.Generator], Effect]:
    """A function of time over the length of the recording."""
    return lambda pair, rng: acts(of(pair.t / pair.length, rng), rng, [(name, "") for name in right])


def body(least: float, most: float) -> Callable[[Pair, np.random.Generator], Response]:
    """One relaxation, its time a share of the length."""
    return lambda pair, rng: response.relaxation(pair.length * rng.uniform(least, most))


def stray(pair: Pair, rng: np.random.Generator) -> Effect:
    """A load that nobody recorded."""
    return acts(pair.switched([0.0, 1.0])(pair.t), rng, [])


def swinging(pair: Pair, rng: np.random.Generator) -> Effect:
    """A field of slow waves of its own on the test instrument's side, gone as it came."""
    wave = signal.smooth(rng, pair.length / 8, pair.length / 40, 1.0)
    return acts(wave(pair.t) * np.sin(np.pi * pair.t / pair.length) ** 2, rng, [])


def stepped(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return (t > rng.uniform(0.2, 0.8)) * 1.0


def there_and_back(t: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    first = rng.uniform(0.15, 0.45)
    return (t > first) * 1.0 - (t > first + rng.uniform(0.15, 0.4)) * rng.uniform(0.4, 0.9)


ALL = [PairKind(*row) for row in [
    ("stray_current", "load beside the test instrument", FAMILY, column("load_current_a"), "Biot and Savart: a field in proportion", True),
    ("dependence", "temperature by day", FAMILY, column("test_temperature_c"), "IAGA Guide, variometers", True),
    ("dependence", "temperature of a heater", FAMILY, column("electronics_temperature_c"), "IAGA Guide, variometers", True),
    ("dependence", "temperature, late by one body", FAMILY, column("test_temperature_c", body(0.01, 0.08)), "Newton's law of cooling", True),
    ("dependence", "temperature, square", FAMILY, column("test_temperature_c", None, 2.0), "NASA CR-156638, eq. 29", True),
    ("dependence", "relay logged late", FAMILY, column("relay_v", None, 1.0, (1, 3)), "a multiplexer's row before", True),
    ("dependence", "humidity beside a pair", FAMILY, column("humidity_percent"), "IAGA Guide", True),
    ("clock_offset", "pair", "late_response", clock(False), "INTERMAGNET Technical Reference Manual", True),
    ("reading_step", "pair", "time", of_time(stepped, "reading_step"), "IAGA Guide, steps", True),
    ("ageing", "pair", "time", of_time(lambda t, _: t, "ageing", "warm_up"), "IAGA Guide, base lines", True),
    ("warm_up", "pair", "time", of_time(lambda t, _: np.exp(-t / 0.15), "warm_up", "ageing"), "IAGA Guide", True),
    ("unnamed", "load that nobody recorded", "", stray, "Biot and Savart", True),
    ("stray_current", "torquer commanded early", FAMILY, column("torquer_x_am2", None, 1.0, (-2, -1)), "Wertz 1978, Spacecraft Attitude Determination", False),
    ("dependence", "temperature behind a wall", FAMILY, column("electronics_temperature_c", wall), "Carslaw and Jaeger 1959, 3.4", False),
    ("dependence", "pressure beside a pair", FAMILY, column("room_pressure_pa"), "a case that bends in proportion", False),
    ("dependence", "power of a panel", FAMILY, column("panel_power_w"), "a current at constant voltage", False),
    ("dependence", "power of a panel, its root", FAMILY, column("panel_power_w", None, 0.7), "a current through a resistance", True),
    ("stray_current", "load through a core that saturates", FAMILY, saturating, "a choke beside the sensor: Froelich's curve x/(1 + x)", False),
    ("dependence", "humidity, late beside a pair", FAMILY, column("humidity_percent", body(0.01, 0.05)), "Fick's law in a thin case", False),
    ("clock_rate", "pair", "late_response", clock(True), "Vig 1992, Introduction to Quartz Frequency Standards", False),
    ("reading_step", "pair, there and back", "time", of_time(there_and_back, "reading_step"), "a tool left on the pillar", False),
    ("ageing", "pair, logarithm", "time", of_time(lambda t, _: np.log1p(20 * t), "ageing", "warm_up"), "Nutting 1921; creep of a pillar", False),
    ("unnamed", "waves of a neighbour", "", swinging, "a process nearby", False),
]]


def kinds(of: str, sort: str) -> list[PairKind]:
    """Kinds of a group: with a name (single), or unnamed."""
    return [kind for kind in ALL if kind.looked_at == (of == "develop") and (kind.name == "unnamed") == (sort == "unnamed")]
