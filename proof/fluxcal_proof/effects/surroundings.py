"""Fields of the surroundings: leakage through the nulling, gradients, lines."""
from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.special import ellipe, ellipk

from .. import response, signal
from ..campaign import AXES, Campaign, Run
from ..effect import Effect, in_geo, kind, linear
from ..response import Response


def leakage(c: Campaign, rng: np.random.Generator, slow: Response, fast: float) -> Effect:
    """A share of the outside variations, per axis of GEO, some of it late."""
    v = rng.uniform(0.3, 1, 3)
    late = Response(fast, (1 - fast) * slow.weights, slow.taus, slow.delay)
    return in_geo(c, lambda run: np.stack([0.05 * v[k] * x.through(late)(run.at) for k, x in enumerate(run.outside)]), [("nulling_leakage", "")])


@kind("nulling_leakage", "slow and fast part", "outside_field", "NASA CR-156638, test of the Earth field nulling system")
def leak(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return leakage(c, rng, response.relaxation(c.step * rng.uniform(10, 60)), float(rng.uniform(0.1, 0.5)))


@kind("nulling_leakage", "loop of two poles", "outside_field", "a servo with an integrator and a filter, before an ideal coil")
def two_pole_leak(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    tau = c.step * rng.uniform(5, 30)
    return leakage(c, rng, response.poles([tau, 0.4 * tau]), float(rng.uniform(0.0, 0.2)))


@kind("nulling_leakage_across", "coils turned against the loop's sensors", "outside_field", "a loop that feeds back along axes of its own: small rotations, Wertz 1978, 12.1")
def turned_leak(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    matrix = 0.05 * np.diag(rng.uniform(0.3, 1, 3)) + 0.05 * np.cross(np.eye(3), rng.uniform(-1, 1, 3))
    late = response.relaxation(c.step * rng.uniform(10, 60))
    return in_geo(c, lambda run: matrix @ np.stack([x.through(late)(run.at) for x in run.outside]), [("nulling_leakage_across", "")])


@kind("nulling_leakage", "loop with a dead time", "outside_field", "a servo that computes: Franklin, Powell and Emami-Naeini")
def late_leak(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    slow = response.relaxation(c.step * rng.uniform(5, 30)).then(response.late(c.step * rng.uniform(0.5, 2)))
    return leakage(c, rng, slow, 0.0)


def gradient(c: Campaign, axis: int, of: np.ndarray) -> Effect:
    """Readings from a relative gradient (3, 3) of one coil's field in GEO, 1/m."""
    parts = []
    for run in c.runs:
        along, r = c.along(run)[axis] * 1e-3, run.turn
        parts.append(np.stack([c.mu[:, s] @ r @ of @ r.T @ c.positions[s] * along for s in range(3)]))
    return Effect(linear(parts), [("coil_gradient", AXES[axis])])


@kind("coil_gradient", "five components", "position", "no sources and no curl in the test volume: symmetric, without trace")
def five_components(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    g = rng.normal(size=(3, 3))
    g = g + g.T
    return gradient(c, axis, g - np.eye(3) * np.trace(g) / 3)


def ring(point: np.ndarray, radius: float, height: float) -> np.ndarray:
    """Field of a ring about z at a height, over mu0 I / (2 pi), (along the radius, along z). Jackson 1999, 5.5; lengths in m."""
    rho, z = max(float(np.hypot(point[0], point[1])), 1e-9), point[2] - height
    far, near = (radius + rho) ** 2 + z**2, (radius - rho) ** 2 + z**2
    m = 4 * radius * rho / far
    k, e = ellipk(m), ellipe(m)
    b_rho = z / (rho * np.sqrt(far)) * (-k + (radius**2 + rho**2 + z**2) / near * e)
    b_z = (k + (radius**2 - rho**2 - z**2) / near * e) / np.sqrt(far)
    return np.array([b_rho * point[0] / rho, b_rho * point[1] / rho, b_z])


@kind("coil_gradient", "rings of unlike radius, block off centre", "position", "Jackson 1999, Classical Electrodynamics, 5.5")
def rings(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    radii, off = (1.0, rng.uniform(1.02, 1.06)), rng.uniform(-0.1, 0.1, 3)
    order = [(axis + 1) % 3, (axis + 2) % 3, axis]
    pair = lambda p: ring(p, radii[0], -0.5) + ring(p, radii[1], 0.5)
    centre = pair(off[order])
    parts = []
    for run in c.runs:
        along, rows = c.along(run)[axis], []
        for s in range(3):
            b = np.zeros(3)
            b[order] = (pair((off + run.turn.T @ c.positions[s])[order]) - centre) / centre[2]
            rows.append(c.mu[:, s] @ run.turn @ b * along)
        parts.append(np.stack(rows))
    return Effect(linear(parts), [("coil_gradient", AXES[axis])])


def line(c: Campaign, rng: np.random.Generator, hertz: float, strength: Callable[[Run], float], right: list[str]) -> Effect:
    """A field of one frequency in GEO, by recording as strong as `strength` says."""
    v = rng.normal(size=3) * np.exp(1j * rng.uniform(0, 2 * np.pi, 3))
    return in_geo(c, lambda run: np.real(np.outer(v, run.wave(hertz))) * strength(run), [(name, "") for name in right])


@kind("mains", "load differs by recording", "lines", "IAGA Guide; currents of the power supply")
def mains(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    load = rng.uniform(0.3, 1, len(c.runs))
    return line(c, rng, 50 + rng.normal() * 0.01, lambda run: load[run.number], ["mains", "periodic_field"])


@kind("periodic_field", "pump in one recording", "lines", "a pump whose motor runs in one recording only")
def pump(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    number = int(rng.integers(len(c.runs)))
    return line(c, rng, rng.uniform(0.05, 0.45) / c.step, lambda run: float(run.number == number), ["periodic_field", "mains", "traction_power"])


@kind("traction_power", "trains by recording", "lines", "railway power of 16.7 Hz")
def trains(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    load = rng.uniform(0, 1, len(c.runs)) + 0.05
    return line(c, rng, 16.7 + rng.normal() * 0.005, lambda run: load[run.number], ["traction_power", "periodic_field"])


@kind("reaction_wheel", "magnet on a rotor", "lines", "Pope et al. 2011, Ann. Geophys. 29, 639")
def wheel(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    v = rng.normal(size=3) * np.exp(1j * rng.uniform(0, 2 * np.pi, 3))
    parts = []
    for run in c.runs:
        speed = signal.smooth(rng, run.span[1] - run.span[0], (run.span[1] - run.span[0]) / 4, 0.02 / c.step, 2.0, 8)
        base = rng.uniform(0.1, 0.3) / c.step
        # The phase is the integral of the rate, wave by wave.
        phase = signal.Signal(c=speed.c / (1j * speed.omega), omega=speed.omega)
        turns = lambda t, base=base, phase=phase, start=run.at[0]: base * (t - start) + phase(t)
        run.columns["wheel_1_hz"] = lambda t, base=base, speed=speed: base + speed(t)
        parts.append(c.mu.T @ np.real(np.outer(v, np.exp(2j * np.pi * turns(run.at)))))
    return Effect(linear(parts), [("reaction_wheel", "wheel_1_hz")])
