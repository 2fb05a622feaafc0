"""Linear responses in continuous time, exact: a delay and a sum of relaxations."""
from dataclasses import dataclass, field

import numpy as np
from scipy.special import jn_zeros


@dataclass(frozen=True)
class Response:
    """H(s) = e^(-s d) (direct + sum_k w_k / (1 + s tau_k)); d and tau in s. Complex tau come in conjugate pairs."""

    direct: float = 1.0
    weights: np.ndarray = field(default_factory=lambda: np.zeros(0))
    taus: np.ndarray = field(default_factory=lambda: np.zeros(0))
    delay: float = 0.0

    def gain(self, omega: np.ndarray) -> np.ndarray:
        """Complex gain at angular frequencies in rad/s."""
        s = 1j * np.asarray(omega, float)
        sums = self.direct + (self.weights / (1 + s[:, None] * self.taus)).sum(1)
        return np.exp(-s * self.delay) * sums

    def then(self, other: "Response") -> "Response":
        """One after the other, by partial fractions: 1/((1+sa)(1+sb)) = (a/(1+sa) - b/(1+sb)) / (a-b), a not b."""
        weights = [other.direct * self.weights, self.direct * other.weights]
        taus = [self.taus, other.taus]
        for w, a in zip(self.weights, self.taus):
            for v, b in zip(other.weights, other.taus):
                b = b * (1 + 1e-6) if a == b else b
                weights.append(w * v * np.array([a, -b]) / (a - b))
                taus.append(np.array([a, b]))
        return Response(self.direct * other.direct, np.concatenate(weights), np.concatenate(taus), self.delay + other.delay)


def relaxation(tau: float) -> Response:
    """tau dy/dt = x - y."""
    return Response(0.0, np.array([1.0]), np.array([tau]))


def late(seconds: float) -> Response:
    """y(t) = x(t - d)."""
    return Response(delay=seconds)


def poles(taus: list[float]) -> Response:
    """A row of unlike relaxations, one after another."""
    out = relaxation(taus[0])
    for tau in taus[1:]:
        out = out.then(relaxation(tau))
    return out


def damped(tau: float, damping: float) -> Response:
    """Second order, 1 / (1 + 2 z tau s + tau^2 s^2), damping z < 1: a pair of complex relaxations."""
    root = damping + 1j * np.sqrt(1 - damping**2)
    pair = tau * np.array([root, np.conj(root)])
    weights = np.array([pair[0], -pair[1]]) / (pair[0] - pair[1])
    return Response(0.0, weights, pair)


def of_modes(weights: np.ndarray, taus: np.ndarray) -> Response:
    """Relaxations side by side; what is left out of them is direct."""
    return Response(1 - weights.sum(), weights, taus)


def plate(tau: float, modes: int = 12) -> Response:
    """Mean field in a conducting plate between equal fields, tanh(z)/z, z^2 = s tau, tau = mu0 sigma (thickness/2)^2.

    Carslaw and Jaeger 1959, Conduction of Heat in Solids, 3.4."""
    k = 2 * np.arange(modes) + 1
    return of_modes(8 / (np.pi * k) ** 2, 4 * tau / (np.pi * k) ** 2)


def cylinder(tau: float, modes: int = 20) -> Response:
    """Mean field in a long conducting cylinder along it, 2 I1(z) / (z I0(z)), z^2 = s tau. Knoepfel 2000, Magnetic Fields, 4.2."""
    k = jn_zeros(0, modes)
    return of_modes(4 / k**2, tau / k**2)


def sphere(tau: float, modes: int = 20) -> Response:
    """What a conducting sphere lets through of the field that its moment opposes. Wait 1951, Geophysics 16, 666."""
    k = np.arange(modes) + 1
    return of_modes(6 / (np.pi * k) ** 2, tau / k**2)
