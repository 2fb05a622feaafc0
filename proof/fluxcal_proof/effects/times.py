"""Changes with time, events at moments, and codes of a converter."""
from __future__ import annotations

import numpy as np

from ..campaign import AXES, Campaign, Parts, Run
from ..effect import Effect, in_geo, in_sensor, kind, one_sensor


def age(c: Campaign, run: Run) -> np.ndarray:
    """Time since the campaign's beginning over the length of a recording."""
    return (run.at - c.runs[0].at[0]) / c.length


def moment(c: Campaign, rng: np.random.Generator) -> tuple[Run, float]:
    """A recording, and a moment in its middle half that falls on rows that were kept."""
    run = c.runs[int(rng.integers(len(c.runs)))]
    rows = np.flatnonzero(run.keep)
    return run, float(run.t[rows[int(rng.uniform(0.25, 0.75) * len(rows))]]) - 0.3 * c.step


@kind("ageing", "straight", "time", "NASA CR-156638, temporal drift in sensor offset")
def ageing(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return in_sensor(c, axis, lambda run: age(c, run), "ageing", truth={"rate_nt_per_day": 86400 / c.length})


@kind("ageing", "power of time", "time", "Nutting 1921, J. Franklin Inst. 191, 679: creep as t^0.7 to t^0.9")
def power_of_time(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    power = rng.uniform(0.7, 0.9)
    return in_sensor(c, axis, lambda run: np.maximum(age(c, run), 0) ** power, "ageing", "warm_up")


@kind("sensitivity_ageing", "straight", "time", "Toffner-Clausen et al. 2016, Earth Planets Space 68, 129")
def sensitivity(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return in_sensor(c, axis, lambda run: 1e-5 * c.plain(run)[axis] * age(c, run), "sensitivity_ageing")


@kind("warm_up", "two bodies", "time", "IAGA Guide; board and box")
def warm_up(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    tau = rng.uniform(0.1, 0.5)
    return in_sensor(c, axis, lambda run: np.exp(-age(c, run) / tau) + 0.3 * np.exp(-age(c, run) / (4 * tau)), "warm_up")


@kind("warm_up", "convection", "time", "Incropera and DeWitt: free convection cools as (1 + t/tau)^-4")
def convection(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    tau = rng.uniform(0.5, 1.5)
    return in_sensor(c, axis, lambda run: np.maximum(1 + age(c, run) / tau, 0.1) ** -4.0, "warm_up")


@kind("reading_step", "knock", "time", "IAGA Guide, steps in records")
def step(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    _, at = moment(c, rng)
    return in_sensor(c, axis, lambda run: (run.at >= at) * 1.0, "reading_step", truth={"height_nt": 1.0})


@kind("reading_step", "two steps", "time", "a relay of ranges that goes over and back")
def two_steps(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    (_, one), (_, two), back = moment(c, rng), moment(c, rng), rng.uniform(0.3, 0.8)
    return in_sensor(c, axis, lambda run: (run.at >= one) * 1.0 - back * (run.at >= two), "reading_step")


@kind("spike", "bit errors", "moments", "IAGA Guide, spikes in records")
def spikes(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    rows = [(run, rng.choice(np.flatnonzero(run.keep), 2, replace=False)) for run in c.runs[:2]]

    def of(run: Run) -> np.ndarray:
        out = np.zeros(len(run.t))
        for other, where in rows:
            if other is run:
                out[where] = rng.uniform(0.6, 1.6, 2) * rng.choice([-1, 1], 2)
        return np.repeat(out, len(run.at) // len(run.t))

    return in_sensor(c, axis, of, "spike")


def dipole(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    """Field at rest of a dipole that passes at distance 1 along x; Jackson 1999, 5.6; (3, times)."""
    m, way = rng.normal(size=3), np.stack([x, np.ones_like(x), np.full_like(x, rng.uniform(-0.3, 0.3))])
    r = np.linalg.norm(way, axis=0)
    return (3 * way * (m @ way) / r**2 - m[:, None]) / r**3


def passing(c: Campaign, rng: np.random.Generator, wagons: np.ndarray) -> Effect:
    """Something magnetic passes once: dipoles some distances behind each other."""
    run0, at = moment(c, rng)
    half = rng.uniform(4, 15) * c.step
    fields = {run.number: sum(dipole(rng, (run.at - at) / half - w) for w in wagons) if run is run0 else np.zeros((3, len(run.at))) for run in c.runs}
    return in_geo(c, lambda run: np.asarray(fields[run.number]), [("vehicle_pass", "")])


@kind("vehicle_pass", "dipole", "moments", "Jackson 1999, Classical Electrodynamics, 5.6")
def vehicle(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return passing(c, rng, np.zeros(1))


@kind("vehicle_pass", "lorry and trailer", "moments", "Jackson 1999, 5.6: two dipoles, unlike in direction")
def lorry(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    return passing(c, rng, np.array([0.0, rng.uniform(0.3, 0.8)]))


@kind("differential_nonlinearity", "one wrong bit", "codes", "Kester 2005, Data Conversion Handbook: a square wave along the reading")
def wrong_bit(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    period = rng.uniform(2000, 9000)
    return in_sensor(c, axis, lambda run: np.where(np.mod(c.plain(run)[axis], period) < period / 2, 1.0, -1.0), "differential_nonlinearity")


@kind("quantisation", "too few codes", "codes", "Widrow and Kollar 2008, Quantization Noise")
def codes(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    noisy: Parts = []

    def act(size: float) -> Parts:
        width = size * np.sqrt(12)
        return one_sensor(c, axis, lambda run: width * np.round(noisy[run.number][axis] / width) - noisy[run.number][axis])

    return Effect(act, [("quantisation", AXES[axis])], codes=True, noisy=noisy)
