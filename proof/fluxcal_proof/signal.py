"""Functions of continuous time: waves, steps and what linear responses make of them, exact at every instant."""
from dataclasses import dataclass, field, replace

import numpy as np

from .response import Response

BLOCK = 1 << 14


@dataclass(frozen=True)
class Signal:
    """x(t) = level + Re sum_k c_k e^(i w_k t) + sum_j h_j S(t - t_j) + decays; S is the step response of `shape`."""

    level: float = 0.0
    c: np.ndarray = field(default_factory=lambda: np.zeros(0, complex))
    omega: np.ndarray = field(default_factory=lambda: np.zeros(0))
    at: np.ndarray = field(default_factory=lambda: np.zeros(0))
    height: np.ndarray = field(default_factory=lambda: np.zeros(0))
    shape: Response = Response()
    decays: tuple[tuple[complex, complex, float], ...] = ()

    def __call__(self, t: np.ndarray) -> np.ndarray:
        out = np.full(len(t), self.level) + self.waves(t) + self.steps(t)
        for size, tau, start in self.decays:
            out = out + np.real(size * np.exp(-(t - start) / tau))
        return out

    def waves(self, t: np.ndarray) -> np.ndarray:
        """The waves alone."""
        out = np.zeros(len(t))
        for first in range(0, len(t), BLOCK) if len(self.c) else ():
            part = slice(first, first + BLOCK)
            out[part] = np.real(np.exp(1j * np.outer(t[part], self.omega)) @ self.c)
        return out

    def steps(self, t: np.ndarray) -> np.ndarray:
        """The steps alone. With D what a relaxation still lacks just after a step, it lacks D e^(-(t-t_j)/tau) later."""
        if not len(self.at):
            return np.zeros(len(t))
        s = t - self.shape.delay
        last = np.searchsorted(self.at, s, side="right")
        reached = np.concatenate([[0.0], np.cumsum(self.height)])[last]
        out = (self.shape.direct + np.real(self.shape.weights.sum())) * reached
        for w, tau in zip(self.shape.weights, self.shape.taus):
            lacks = np.zeros(len(self.at) + 1, complex)
            for j, h in enumerate(self.height):
                gone = np.exp(-(self.at[j] - self.at[j - 1]) / tau) if j else 0.0
                lacks[j + 1] = lacks[j] * gone + h
            since = s - self.at[np.maximum(last - 1, 0)]
            out = out - np.real(w * lacks[last] * np.exp(-np.maximum(since, 0) / tau))
        return out

    def times(self, factor: float) -> "Signal":
        """The same, larger."""
        decays = tuple((factor * size, tau, start) for size, tau, start in self.decays)
        return replace(self, level=factor * self.level, c=factor * self.c, height=factor * self.height, decays=decays)

    def plus(self, other: "Signal") -> "Signal":
        """A sum; only one of the two has steps."""
        one, two = (self, other) if len(self.at) else (other, self)
        assert not len(two.at), "steps of two shapes are no signal"
        return Signal(one.level + two.level, np.concatenate([one.c, two.c]), np.concatenate([one.omega, two.omega]),
                      one.at, one.height, one.shape, one.decays + two.decays)

    def through(self, response: Response, rest: float | None = None) -> "Signal":
        """What a response makes of it; the waves went on for ever, or from `rest` on, where all was in equilibrium."""
        total = float(response.direct + np.real(response.weights.sum()))
        decays: list[tuple[complex, complex, float]] = []
        if rest is not None:
            now = self.waves(np.array([rest]))[0]
            for w, tau in zip(response.weights, response.taus):
                steady = np.sum(self.c / (1 + 1j * self.omega * tau) * np.exp(1j * self.omega * rest))
                decays.append((complex(w * (now - np.real(steady))), complex(tau), rest))
        return Signal(self.level * total, self.c * response.gain(self.omega) if len(self.c) else self.c, self.omega,
                      self.at, self.height, self.shape.then(response), self.decays + tuple(decays))


def smooth(rng: np.random.Generator, longest: float, shortest: float, rms: float, slope: float = 1.0, waves: int = 40) -> Signal:
    """Random waves with periods from longest to shortest, s, amplitudes in proportion to period^(slope/2), of some rms."""
    omega = 2 * np.pi / np.exp(rng.uniform(np.log(shortest), np.log(longest), waves))
    c = (rng.normal(size=waves) + 1j * rng.normal(size=waves)) * omega ** (-slope / 2)
    return Signal(c=c * rms * np.sqrt(2) / np.linalg.norm(c), omega=omega)


def triangle(rng: np.random.Generator, period: float, amplitude: float) -> Signal:
    """Up and down at a constant rate, its corners rounded: eight odd harmonics of a triangle."""
    k = 2 * np.arange(8) + 1
    omega, phase = 2 * np.pi * k / period, rng.uniform(0, 2 * np.pi)
    return Signal(c=amplitude * 8 / np.pi**2 / k**2 * np.exp(1j * k * phase), omega=omega)


def levels(rng: np.random.Generator, times: np.ndarray, values: list[float] | None = None, swing: float = 1.0) -> Signal:
    """Held levels that change at given times: drawn from `values`, else even between -swing and swing."""
    x = rng.uniform(-swing, swing, len(times) + 1)
    if values is not None:
        x[0] = rng.choice(values)
        for i in range(len(times)):
            x[i + 1] = rng.choice([v for v in values if v != x[i]])
    return Signal(level=float(x[0]), at=np.asarray(times, float), height=np.diff(x))


def moments(rng: np.random.Generator, start: float, end: float, least: float, most: float) -> np.ndarray:
    """Moments between start and end, from `least` to `most` apart, s."""
    gaps = rng.uniform(least, most, int((end - start) / least) + 1)
    at = start + np.cumsum(gaps)
    return at[at < end]
