"""Two instruments side by side: a test instrument beside a reference in the natural field.

T = eta B + d + what acts + noise, R = B + noise of the reference (nT); the field is a function of time, so that a late
clock reads what the field was then. DIFF: the differential method.
"""
from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from . import noise, plan, signal
from .campaign import AXES, Parts, directions
from .cases import Case, sized
from .response import relaxation
from .signal import Signal

LEVEL = (20_300.0, 1_700.0, 44_100.0)
# What acts in ten pairs: one thing, nothing, several, or something without a name.
TURNS = ("single", "single", "clean", "single", "several", "single", "single", "unnamed", "clean", "single")


class Pair:
    """One differential recording before anything acts. Times in s from its beginning."""

    def __init__(self, rng: np.random.Generator, rows: int, step: float, noisy_reference: float) -> None:
        self.rng, self.step, self.span = rng, step, (0.0, rows * step)
        self.t = np.arange(rows) * step
        self.length = rows * step
        day = 2 * np.pi / 86_400
        self.field = []
        for level, tide, size in zip(LEVEL, (25, 15, 10), (12, 10, 5)):
            variations = signal.smooth(rng, 2 * self.length, 4 * step, size, 1.2, 80)
            sun = Signal(c=np.array([tide * np.exp(2j * np.pi * rng.uniform())]), omega=np.array([day]))
            self.field.append(variations.plus(sun).plus(Signal(level=level)))
        self.eta, self.offset = directions(rng, 15), rng.normal(size=3) * 20
        self.noise = noise.Noise(0.1)
        self.reference_noise = noise.Noise(noisy_reference)
        self.columns: dict[str, Callable[[np.ndarray], np.ndarray]] = {
            "test_temperature_c": self.daily(4.0), "electronics_temperature_c": self.heated(5.0),
            "load_current_a": self.switched([0.0, 2.0]), "relay_v": self.switched([0.0, 5.0]),
            "torquer_x_am2": self.switched([-0.2, 0.0, 0.2]), "panel_power_w": self.switched([0.0, 20.0, 40.0]),
            "humidity_percent": signal.smooth(rng, self.length, self.length / 20, 6.0, 2.0).plus(Signal(level=50.0)),
            "room_pressure_pa": signal.smooth(rng, self.length, self.length / 15, 80.0, 2.0).plus(Signal(level=101_300.0))}

    def daily(self, swing: float) -> Signal:
        """A room by day and night, with weather."""
        wave = Signal(c=np.array([swing * np.exp(2j * np.pi * self.rng.uniform())]), omega=np.array([2 * np.pi / min(86_400, self.length)]))
        return wave.plus(signal.smooth(self.rng, self.length, self.length / 30, 0.5 * swing, 2.0)).plus(Signal(level=20.0))

    def heated(self, swing: float) -> Signal:
        """A box with a heater that is switched."""
        load = self.switched([0.0, swing]).through(relaxation(self.rng.uniform(10, 30) * self.step), 0.0)
        return load.plus(Signal(level=20.0))

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


def chosen(rng: np.random.Generator, spec: plan.Spec, of: str) -> tuple[str, list[tuple[Any, float]]]:
    """What acts in a pair, and how strongly."""
    from .pair_kinds import kinds

    sort = TURNS[spec.index % len(TURNS)]
    if sort == "clean":
        return sort, []
    own = kinds(of, "unnamed" if sort == "unnamed" else "single")
    strong = lambda: float(rng.choice([1.0, 3.0, 10.0]))
    if sort == "several":
        return sort, [(own[i], strong()) for i in rng.choice(len(own), 2, replace=False)]
    index = spec.index // len(TURNS) * TURNS.count(sort) + TURNS[: spec.index % len(TURNS)].count(sort)
    which, strength = plan.of_kinds(index, len(own))
    return sort, [(own[which], strength if sort == "single" else strong())]


def make(rng: np.random.Generator, spec: plan.Spec, of: str) -> Case:
    """A pair as a case."""
    sort, acting = chosen(rng, spec, of)
    rows = plan.DAY_ROWS if spec.day else max(1000, plan.rows(rng))
    step = 1.0 if spec.day else float(rng.choice([1.0, 10.0, 60.0]))
    noisy = float(rng.choice([0.02, 0.05, 0.05, 0.1, 0.3]))
    pair = Pair(rng, rows, step, noisy)
    manners = [f"noise of the reference {noisy:g} nT"] + (["a day of seconds"] if spec.day else [])
    if rng.uniform() < 0.3:
        pair.noise = noise.of_size(rng, 0.1, step, True)
        manners.append("flicker noise" if pair.noise.flicker else "random walk")
    if rng.uniform() < 0.4:
        manners.append("decoys")
        wander = signal.smooth(rng, pair.length, pair.length / 40, 0.7, 2.0)
        near, own = pair.columns["electronics_temperature_c"], pair.field[0]
        pair.columns["room_temperature_c"] = lambda t: near(t) + wander(t)
        pair.columns["box_temperature_c"] = lambda t: 20 + 0.2 * (own(t) - LEVEL[0]) + wander(t)
    effects = [(kind, strength, kind.make(pair, rng)) for kind, strength in acting]
    keep = np.ones(rows, bool)
    if rng.uniform() < 0.3:
        manners.append("gaps")
        keep = rng.uniform(size=rows) > 0.02
        keep[rows // 3:rows // 3 + rows // 20] = False
    field, fitted = pair.at(), Fitted(pair.at())
    own_noise = np.stack([pair.noise.draw(rng, rows, step) for _ in range(3)])
    reference_noise = np.stack([pair.reference_noise.draw(rng, rows, step) for _ in range(3)])
    difference = own_noise - pair.eta @ reference_noise
    noise_nt = float(np.sqrt(np.mean(difference**2)))
    added, told = np.zeros((3, rows)), []
    for kind, strength, effect in effects:
        parts, size = sized(effect, fitted, strength * noise_nt)  # type: ignore[arg-type]
        added = added + parts[0]
        told.append(dict(kind=kind.name, form=kind.form, family=kind.family, source=kind.source, strength=strength, right=effect.right,
                         undecidable=False, left_nt=fitted.left(parts), parameters={k: v * size for k, v in effect.truth.items()}))
    columns = {"time_s": pair.t}
    for i, k in enumerate(AXES):
        columns[f"reference_{k}_nt"] = (field + reference_noise)[i]
        columns[f"test_{k}_nt"] = (pair.eta @ field + pair.offset[:, None] + added + own_noise)[i]
    columns |= {name: x(pair.t) for name, x in pair.columns.items()}
    recording = {"id": "pair", "procedure": "differential", "columns": {k: np.round(v[keep], 5).tolist() for k, v in columns.items()}}
    document: dict[str, Any] = {"fluxcal": 1, "recordings": [recording]}
    if rng.uniform() < 0.5:
        factor = float(rng.choice([1.0, 1.0, 1.0, 0.9, 1.1], p=[0.25, 0.25, 0.25, 0.125, 0.125]))
        document["instrument"] = {"noise": pair.noise.declared(factor)}
        recording["conditions"] = {"reference_noise": pair.reference_noise.declared(factor)}
        manners.append("noise declared" if factor == 1 else "noise declared, a tenth wrong")
    else:
        manners.append("noise not declared")
    floor = float(np.sqrt(np.mean(fitted.without(difference)[:, keep] ** 2)))
    truth = dict(sort="pair", turn=sort, effects=told, noise_nt=noise_nt, rows=int(keep.sum()), manners=manners, floor_nt=floor)
    return Case(document, truth, np.zeros(0))
