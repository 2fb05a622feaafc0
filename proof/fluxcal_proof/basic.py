"""The basic model: what a calibration can take up, and what is left of an effect or of readings beside it."""
from __future__ import annotations

import numpy as np

from .campaign import Campaign, Parts

PIECES = 24


class Basic:
    """All constants of the chain at once, linear: gains and directions of sensors and coils, offsets of both."""

    def __init__(self, c: Campaign) -> None:
        self.c = c
        blocks = []
        for run in c.runs:
            currents = run.mean(np.stack([i(run.at) for i in run.current]))[:, run.keep] * c.coil[:, None]
            n = currents.shape[1]
            to_sensor = c.mu.T @ run.turn
            field = run.turn @ c.eta @ currents
            for s in range(3):
                block = np.zeros((n, 24))
                block[:, 3 * s:3 * s + 3] = field.T
                block[:, 9 + s] = 1
                block[:, 12:21] = np.concatenate([to_sensor[s, a] * currents.T for a in range(3)], 1)
                block[:, 21:24] = to_sensor[s]
                blocks.append(block)
        a = np.concatenate(blocks)
        a /= np.linalg.norm(a, axis=0) + 1e-300
        u, sizes, _ = np.linalg.svd(a, full_matrices=False)
        self.basis = u[:, sizes > 1e-9 * sizes[0]]

    def flat(self, parts: Parts) -> np.ndarray:
        """Values at instants (3, instants) of each recording as one row of readings that were kept."""
        return np.concatenate([run.mean(part)[:, run.keep].ravel() for run, part in zip(self.c.runs, parts)])

    def without(self, flat: np.ndarray) -> np.ndarray:
        """What no constant takes up."""
        return flat - self.basis @ (self.basis.T @ flat)

    def worst(self, flat: np.ndarray) -> float:
        """Rms in the sensor that has most of it."""
        sums, counts, at = np.zeros(3), np.zeros(3), 0
        for run in self.c.runs:
            n = int(run.keep.sum())
            for s in range(3):
                sums[s] += np.sum(flat[at:at + n] ** 2)
                counts[s], at = counts[s] + n, at + n
        return float(np.sqrt((sums / counts).max()))

    def left(self, parts: Parts) -> float:
        """Rms in the sensor that keeps most of an effect when all constants are fitted to it, nT."""
        return max(self.worst(self.without(self.flat(parts))), 1e-12)
