"""A campaign in coils: facility, instrument and recordings, with every field and temperature a function of time.

B_GEO = eta (k I + B0) + e, B_SEN = R B_GEO, B_i = mu_i . B_SEN (nT): NASA CR-156638, McPherron 1977. GEO is x north, y east,
z down; SEN is the frame of the sensor block; columns of eta and mu are directions.
"""
from collections.abc import Callable

import numpy as np

from . import response, signal
from .signal import Signal

Parts = list[np.ndarray]
AXES = "xyz"
# Temperatures, and those at which the constants hold.
SENSOR, ELECTRONICS, COIL = range(3)
REFERENCE_C = (23.0, 26.0, 21.0)
# A logger that averages takes the mean of so many instants over this share of its step.
INSTANTS, SHARE = 5, 0.8


def directions(rng: np.random.Generator, degrees: float, about: np.ndarray = np.eye(3)) -> np.ndarray:
    """Unit vectors, as columns, about so far off others."""
    m = about + rng.normal(size=(3, 3)) * np.deg2rad(degrees)
    return m / np.linalg.norm(m, axis=0)


def quarter_turn(rng: np.random.Generator, before: list[np.ndarray]) -> np.ndarray:
    """One of the 24 rotations of a cube, unlike those before."""
    while True:
        r = np.eye(3)[rng.permutation(3)] * rng.choice([-1, 1], 3)
        if np.linalg.det(r) > 0 and not any((r == other).all() for other in before):
            return r


class Run:
    """One recording: when readings are taken, and the signals that act."""

    def __init__(self, c: "Campaign", number: int, start: float, rows: int) -> None:
        self.rng, self.step, self.number, self.averages = c.rng, c.step, number, c.averages
        even = start + np.arange(rows) * self.step
        # What averages does not begin before it has ended.
        strays = (1 - SHARE) / 2 if c.averages else 0.2
        self.t = even + (c.rng.uniform(-strays, strays, rows) * self.step if c.uneven else 0.0)
        self.t = np.round(np.sort(self.t), 6)
        inside = (np.arange(INSTANTS) + 0.5) / INSTANTS - 0.5 if self.averages else np.zeros(1)
        self.width, self.span = SHARE * self.step if self.averages else 0.0, (start, even[-1] + self.step)
        self.at = (self.t[:, None] + inside * self.width).ravel()
        self.keep = np.ones(rows, bool)
        if c.gaps:
            self.keep = c.rng.uniform(size=rows) > 0.01
            first = int(c.rng.integers(rows // 4, rows // 2))
            self.keep[first:first + int(c.rng.integers(5, rows // 8))] = False
        self.turn = quarter_turn(c.rng, [run.turn for run in c.runs])
        self.held = number % 2 == 1
        self.current = [self.drive().times(48_000 / c.coil[k]) for k in range(3)]
        self.temperature = [self.warmth(mean, swing) for mean, swing in zip(REFERENCE_C, (8, 7, 4))]
        if c.together:
            self.temperature[ELECTRONICS] = self.temperature[SENSOR].through(response.relaxation(0.1 * c.length), self.span[0])
        self.outside = [signal.smooth(c.rng, c.length, 4 * self.step, size, 1.0) for size in (12, 8, 9)]
        # The last two have nothing to do with the readings.
        self.columns: dict[str, Callable[[np.ndarray], np.ndarray]] = {
            "panel_current_a": self.switched(30, 90, [0.0, 0.4, 1.0, 1.6]),
            "heater_current_a": self.switched(15, 60, [0.0, 1.0]),
            "humidity_percent": signal.smooth(c.rng, c.length, c.length / 20, 5.0).plus(Signal(level=45.0)),
            "lamp_current_a": self.switched(20, 120, [0.0, 0.3]),
            "room_pressure_pa": signal.smooth(c.rng, c.length, c.length / 15, 80.0, 2.0).plus(Signal(level=101_300.0)),
        }

    def drive(self) -> Signal:
        """Waves and triangles in every other recording; else levels that are set just after a reading."""
        rng = self.rng
        if self.held:
            rows = np.cumsum(rng.integers(15, 50, len(self.t) // 15 + 1))
            rows = rows[rows < len(self.t)]
            # Outside what a logger averages, whatever the times of its rows.
            share = 0.5 if self.averages else rng.uniform(0.1, 0.4)
            return signal.levels(rng, (1 - share) * self.t[rows - 1] + share * self.t[rows])
        if rng.uniform() < 0.3:
            return signal.triangle(rng, rng.uniform(100, 300) * self.step, rng.uniform(0.5, 1))
        waves = signal.smooth(rng, 400 * self.step, 40 * self.step, 1.0, 1.0, 12)
        return waves.times(rng.uniform(0.6, 1) / np.abs(waves.c).sum())

    def warmth(self, mean: float, swing: float) -> Signal:
        """A chamber's programme of steps through the thermal bodies between heater and thermometer, with slow weather."""
        rng, (start, end) = self.rng, self.span
        bodies = response.poles(list((end - start) * rng.uniform([0.02, 0.06], [0.05, 0.15])))
        at = np.sort(rng.uniform(start, end, int(rng.integers(2, 5))))
        programme = Signal(at=at, height=rng.uniform(0.4, 1, len(at)) * swing * rng.choice([-1, 1], len(at)))
        weather = signal.smooth(rng, 2 * (end - start), (end - start) / 12, 0.25 * swing, 2.0)
        return programme.through(bodies).plus(weather).plus(Signal(level=mean + rng.uniform(-3, 3)))

    def switched(self, least: float, most: float, values: list[float]) -> Signal:
        """A load that is switched at moments some rows apart."""
        return signal.levels(self.rng, signal.moments(self.rng, *self.span, least * self.step, most * self.step), values)

    def warm(self, which: int, late: response.Response | None = None) -> np.ndarray:
        """A temperature over its reference, K, at all instants; late: at rest when the recording begins."""
        t = self.temperature[which]
        return (t.through(late, self.span[0]) if late else t)(self.at) - REFERENCE_C[which]

    def mean(self, x: np.ndarray) -> np.ndarray:
        """What a logger makes of values at all instants (last axis)."""
        return x.reshape(*x.shape[:-1], len(self.t), -1).mean(-1)

    def wave(self, hertz: float) -> np.ndarray:
        """e^(i w t) as the logger has it, at all instants: an average over T takes sinc(f T) of it."""
        row = np.exp(2j * np.pi * hertz * self.t) * np.sinc(hertz * self.width)
        return np.repeat(row, len(self.at) // len(self.t))

    def path(self, x: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Values on the way from each instant to the next, (instants, 6): the last is at the instant."""
        before = np.concatenate([[self.at[0] - self.step * 1e-3], self.at[:-1]])
        fine = before[:, None] + (self.at - before)[:, None] * (np.arange(6) + 1) / 6
        return x(fine.ravel()).reshape(-1, 6)


class Campaign:
    """Some recordings of so many rows in all, with their true constants. Constants in nT, nT/A and radians."""

    def __init__(self, rng: np.random.Generator, rows: int, *, together: bool, averages: bool, uneven: bool, gaps: bool) -> None:
        self.rng, self.together, self.averages, self.uneven, self.gaps = rng, together, averages, uneven, gaps
        self.noisy: Parts = []  # readings with noise and all that acts so far
        self.coil = rng.uniform(30_000, 42_000, 3)
        self.eta, self.mu = directions(rng, 10 / 60), directions(rng, 30 / 60)
        self.bias, self.gain, self.zero = rng.normal(size=3), 1 + rng.normal(size=3) * 5e-4, rng.normal(size=3) * 4
        self.positions = rng.uniform(-0.06, 0.06, (3, 3))
        self.step = float(rng.choice([2.0, 5.0, 10.0, 20.0]))
        count = int(rng.integers(2, 5))
        self.length = rows // count * self.step
        self.runs: list[Run] = []
        start = 0.0
        for number in range(count):
            self.runs.append(Run(self, number, start, rows // count))
            start = float(np.ceil(self.runs[-1].span[1] + rng.uniform(600, 7200)))

    def along(self, run: Run, t: np.ndarray | None = None, through: Callable[[int, Signal], Signal] | None = None) -> np.ndarray:
        """Fields of the coils along their axes, nT, (3, instants)."""
        t = run.at if t is None else t
        change = through or (lambda k, x: x)
        return np.stack([change(k, run.current[k].times(self.coil[k]))(t) for k in range(3)]) + self.bias[:, None]

    def geo_to_reading(self, run: Run, geo: np.ndarray) -> np.ndarray:
        """Fields in GEO to components along the sensors."""
        return self.mu.T @ run.turn @ geo

    def plain(self, run: Run, t: np.ndarray | None = None) -> np.ndarray:
        """Components along the sensors with nothing acting, nT, (3, instants)."""
        return self.geo_to_reading(run, self.eta @ self.along(run, t))
