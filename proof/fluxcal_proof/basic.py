"""The basic model: what a calibration can take up, and what is left of an effect or of readings beside it."""
import numpy as np

from .campaign import Campaign, Parts


def spanned(columns: np.ndarray) -> np.ndarray:
    """An orthonormal basis of columns, whatever their units; what depends on the others counts once."""
    u, sizes, _ = np.linalg.svd(columns / (np.linalg.norm(columns, axis=0) + 1e-300), full_matrices=False)
    return u[:, sizes > 1e-9 * sizes[0]]


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
                own = np.zeros((n, 12))
                own[:, 3 * s:3 * s + 3], own[:, 9 + s] = field.T, 1
                blocks.append(np.hstack([own, *(to_sensor[s, a] * currents.T for a in range(3)), np.tile(to_sensor[s], (n, 1))]))
        self.basis = spanned(np.concatenate(blocks))

    def flat(self, parts: Parts) -> np.ndarray:
        """Values at instants (3, instants) of each recording as one row of readings that were kept."""
        return np.concatenate([run.mean(part)[:, run.keep].ravel() for run, part in zip(self.c.runs, parts)])

    def without(self, flat: np.ndarray) -> np.ndarray:
        """What no constant takes up."""
        return flat - self.basis @ (self.basis.T @ flat)

    def left(self, parts: Parts) -> float:
        """Rms in the sensor that keeps most of an effect when all constants are fitted to it, nT."""
        flat, squares, at = self.without(self.flat(parts)), np.zeros(3), 0
        for run in self.c.runs:
            n = int(run.keep.sum())
            squares += np.sum(flat[at:at + 3 * n].reshape(3, n) ** 2, axis=1)
            at += 3 * n
        return max(float(np.sqrt((squares / (at / 3)).max())), 1e-12)
