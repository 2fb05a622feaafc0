"""Noise of readings: white, flicker and random walk."""
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Noise:
    """One-sided density P(f) = 2 white^2 step + flicker f^-exponent, nT^2/Hz, and a walk of so many nT per root second."""

    white: float
    flicker: float = 0.0
    exponent: float = 1.0
    walk: float = 0.0

    def draw(self, rng: np.random.Generator, rows: int, step: float) -> np.ndarray:
        """So many readings of three sensors, nT; the flicker part began eight times as long ago."""
        long, out = 8 * rows, np.empty((3, rows))
        f = np.fft.rfftfreq(long, step)
        f[0] = f[1]
        amplitude = np.sqrt(self.flicker * f**-self.exponent / (2 * step))
        for sensor in out:
            sensor[:] = self.white * rng.normal(size=rows)
            if self.flicker:
                sensor += np.fft.irfft(np.fft.rfft(rng.normal(size=long)) * amplitude, long)[:rows]
            if self.walk:
                sensor += np.cumsum(rng.normal(size=rows)) * self.walk * np.sqrt(step)
        return out

    def declared(self, factor: float) -> dict[str, float]:
        """As a document declares it, its size wrong by a factor."""
        out = {"white_rms_nt": self.white * factor}
        if self.flicker:
            out |= {"flicker_nt2_per_hz_at_1hz": self.flicker * factor**2, "flicker_exponent": self.exponent}
        if self.walk:
            out["random_walk_nt_per_sqrt_s"] = self.walk * factor
        return out

    @property
    def manners(self) -> list[str]:
        return ["flicker noise"] * bool(self.flicker) + ["random walk"] * bool(self.walk)


def declaration(factor: float | None) -> str:
    """Whether a document declares its noise, in words."""
    return "noise not declared" if factor is None else "noise declared" if factor == 1 else "noise declared, a tenth wrong"


def of_size(rng: np.random.Generator, size: float, step: float, coloured: bool) -> Noise:
    """White noise of a size, nT, or with a tenth to a half of its variance in 1000 rows as flicker noise or a walk."""
    if not coloured:
        return Noise(size)
    # In 1000 rows f^-1 has about the variance A ln 500, a random walk half of what it ends with.
    share = rng.uniform(0.1, 0.5)
    if rng.uniform() < 0.3:
        return Noise(size * np.sqrt(1 - share), walk=size * np.sqrt(share / (500 * step)))
    return Noise(size * np.sqrt(1 - share), flicker=share * size**2 / np.log(500))
