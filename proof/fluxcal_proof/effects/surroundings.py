"""Fields of the surroundings: leakage through the nulling, gradients, lines."""
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from scipy.special import ellipe, ellipk

from .. import signal
from ..campaign import AXES, Campaign, Run
from ..effect import Draw, Effect, drawn, in_geo, linear
from ..groups import Kind
from ..response import Response, damped, poles, relaxation


def leakage(c: Campaign, axis: int, of: Callable[..., Response], steps: Sequence[Draw], fast: tuple[float, float] | None = None) -> Effect:
    """A share of the outside variations, per axis of GEO, late by a response whose times are drawn in steps; a part may be fast."""
    slow = of(*(c.step * number for number in drawn(c, steps)))
    share, v = c.rng.uniform(*fast) if fast else 0.0, c.rng.uniform(0.3, 1, 3)
    both = Response(share, (1 - share) * slow.weights, slow.taus, slow.delay)
    return in_geo(c, lambda run: np.stack([0.05 * v[k] * x.through(both)(run.at) for k, x in enumerate(run.outside)]))


def turned_leak(c: Campaign, axis: int) -> Effect:
    matrix = 0.05 * np.diag(c.rng.uniform(0.3, 1, 3)) + 0.05 * np.cross(np.eye(3), c.rng.uniform(-1, 1, 3))
    slow = relaxation(c.step * c.rng.uniform(10, 60))
    return in_geo(c, lambda run: matrix @ np.stack([x.through(slow)(run.at) for x in run.outside]))


def gradient(c: Campaign, axis: int, of: Callable[[Run, int], float], size: float = 1.0) -> Effect:
    """What a coil makes at each sensor's place beside what it makes in the middle, as a share of its field."""
    along = [c.along(run)[axis] * size for run in c.runs]
    return Effect(linear([np.stack([of(run, s) * field for s in range(3)]) for run, field in zip(c.runs, along)]), (AXES[axis],))


def five_components(c: Campaign, axis: int) -> Effect:
    """A relative gradient of the coil's field in GEO, 1/m."""
    g = c.rng.normal(size=(3, 3))
    g = g + g.T
    g = g - np.eye(3) * np.trace(g) / 3
    return gradient(c, axis, lambda run, s: c.mu[:, s] @ run.turn @ g @ run.turn.T @ c.positions[s], 1e-3)


def ring(point: np.ndarray, radius: float, height: float) -> np.ndarray:
    """Field of a ring about z at a height, over mu0 I / (2 pi), (along the radius, along z). Jackson 1999, 5.5; lengths in m."""
    rho, z = max(float(np.hypot(point[0], point[1])), 1e-9), point[2] - height
    far, near = (radius + rho) ** 2 + z**2, (radius - rho) ** 2 + z**2
    m = 4 * radius * rho / far
    k, e = ellipk(m), ellipe(m)
    b_rho = z / (rho * np.sqrt(far)) * (-k + (radius**2 + rho**2 + z**2) / near * e)
    b_z = (k + (radius**2 - rho**2 - z**2) / near * e) / np.sqrt(far)
    return np.array([b_rho * point[0] / rho, b_rho * point[1] / rho, b_z])


def rings(c: Campaign, axis: int) -> Effect:
    radii, off = (1.0, c.rng.uniform(1.02, 1.06)), c.rng.uniform(-0.1, 0.1, 3)
    order = [(axis + 1) % 3, (axis + 2) % 3, axis]
    pair = lambda p: ring(p, radii[0], -0.5) + ring(p, radii[1], 0.5)
    centre = pair(off[order])

    def share(run: Run, s: int) -> float:
        b = np.zeros(3)
        b[order] = (pair((off + run.turn.T @ c.positions[s])[order]) - centre) / centre[2]
        return float(c.mu[:, s] @ run.turn @ b)

    return gradient(c, axis, share)


def rod(c: Campaign, axis: int) -> Effect:
    """Iron beside the sensors that a coil magnetises along its field: a dipole, 3 r (m r) / r^5 - m / r^3. Jackson 1999, 5.6."""
    way = c.rng.normal(size=3)
    at, m = way / np.linalg.norm(way) * c.rng.uniform(0.3, 0.6), c.eta[:, axis]
    dipole = lambda r: 3 * r * (m @ r) / np.linalg.norm(r) ** 5 - m / np.linalg.norm(r) ** 3
    return gradient(c, axis, lambda run, s: c.mu[:, s] @ run.turn @ (dipole(run.turn.T @ c.positions[s] - at) - dipole(-at)), 1e-5)


def line(c: Campaign, axis: int, load: Callable[[Campaign, int], np.ndarray], hertz: Callable[[Campaign], float]) -> Effect:
    """A field of one frequency in GEO, in each of so many recordings as strong as its load."""
    strength, frequency = load(c, len(c.runs)), hertz(c)
    v = c.rng.normal(size=3) * np.exp(1j * c.rng.uniform(0, 2 * np.pi, 3))
    return in_geo(c, lambda run: np.real(np.outer(v, run.wave(frequency))) * strength[run.number])


def wheel(c: Campaign, axis: int) -> Effect:
    v = c.rng.normal(size=3) * np.exp(1j * c.rng.uniform(0, 2 * np.pi, 3))
    parts = []
    for run in c.runs:
        speed = signal.smooth(c.rng, run.span[1] - run.span[0], (run.span[1] - run.span[0]) / 4, 0.02 / c.step, 2.0, 8)
        base = c.rng.uniform(0.1, 0.3) / c.step
        # The phase is the integral of the rate, wave by wave.
        phase = signal.Signal(c=speed.c / (1j * speed.omega), omega=speed.omega)
        run.columns["wheel_1_hz"] = lambda t, base=base, speed=speed: base + speed(t)
        parts.append(c.mu.T @ np.real(np.outer(v, np.exp(2j * np.pi * (base * (run.at - run.at[0]) + phase(run.at))))))
    return Effect(linear(parts), ("wheel_1_hz",))


KINDS = [Kind(*row) for row in [
    ("nulling_leakage", "slow and fast part", "outside_field", partial(leakage, of=relaxation, steps=[(10, 60)], fast=(0.1, 0.5)),
     "NASA CR-156638, test of the Earth field nulling system", True),
    ("nulling_leakage", "loop of two poles", "outside_field", partial(leakage, of=lambda tau: poles([tau, 0.4 * tau]), steps=[(5, 30)], fast=(0.0, 0.2)),
     "a servo with an integrator and a filter, before an ideal coil", True),
    ("nulling_leakage_across", "coils turned against the loop's sensors", "outside_field", turned_leak,
     "a loop that feeds back along axes of its own: small rotations, Wertz 1978, 12.1", True),
    ("nulling_leakage", "loop that swings", "outside_field", partial(leakage, of=lambda tau: damped(tau, 0.6), steps=[(5, 20)], fast=(0.0, 0.2)),
     "Franklin, Powell and Emami-Naeini: second order, damped", False),
    ("coil_gradient", "iron rod", "position", rod, "Jackson 1999, Classical Electrodynamics, 5.6", False),
    ("coil_gradient", "five components", "position", five_components, "no sources and no curl in the test volume: symmetric, without trace", True),
    ("coil_gradient", "rings of unlike radius, block off centre", "position", rings, "Jackson 1999, Classical Electrodynamics, 5.5", False),
    ("mains", "load differs by recording", "lines",
     partial(line, load=lambda c, runs: c.rng.uniform(0.3, 1, runs), hertz=lambda c: 50 + c.rng.normal() * 0.01),
     "IAGA Guide; currents of the power supply", True, ("mains", "periodic_field")),
    ("periodic_field", "pump in one recording", "lines",
     partial(line, load=lambda c, runs: np.eye(runs)[c.rng.integers(runs)], hertz=lambda c: c.rng.uniform(0.05, 0.45) / c.step),
     "a pump whose motor runs in one recording only", False, ("periodic_field", "mains", "traction_power")),
    ("traction_power", "trains by recording", "lines",
     partial(line, load=lambda c, runs: c.rng.uniform(0, 1, runs) + 0.05, hertz=lambda c: 16.7 + c.rng.normal() * 0.005),
     "railway power of 16.7 Hz", False, ("traction_power", "periodic_field")),
    ("reaction_wheel", "magnet on a rotor", "lines", wheel, "Pope et al. 2011, Ann. Geophys. 29, 639", True),
]]
