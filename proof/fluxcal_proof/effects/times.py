"""Changes with time, events at moments, and codes of a converter."""
from collections.abc import Sequence
from functools import partial

import numpy as np

from ..campaign import AXES, Campaign, Parts, Run
from ..effect import Draw, Effect, Sensor, drawn, in_geo, one_sensor, sensor
from ..groups import Kind


def event(c: Campaign) -> tuple[Run, float]:
    """A recording, and a moment in its middle half that falls on rows that were kept."""
    run = c.runs[int(c.rng.integers(len(c.runs)))]
    rows = np.flatnonzero(run.keep)
    return run, float(run.t[rows[int(c.rng.uniform(0.25, 0.75) * len(rows))]]) - 0.3 * c.step


MOMENT: Draw = lambda c: event(c)[1]


def struck(c: Campaign) -> list[np.ndarray]:
    """Two rows of each of the first two recordings."""
    return [c.rng.choice(np.flatnonzero(run.keep), 2, replace=False) for run in c.runs[:2]]


def spikes(x: Sensor, rows: list[np.ndarray]) -> np.ndarray:
    out = np.zeros(len(x.run.t))
    if x.run.number < len(rows):
        out[rows[x.run.number]] = x.rng.uniform(0.6, 1.6, 2) * x.rng.choice([-1, 1], 2)
    return np.repeat(out, len(x.at) // len(x.run.t))


def dipole(rng: np.random.Generator, x: np.ndarray) -> np.ndarray:
    """Field at rest of a dipole that passes at distance 1 along x; Jackson 1999, 5.6; (3, times)."""
    m, way = rng.normal(size=3), np.stack([x, np.ones_like(x), np.full_like(x, rng.uniform(-0.3, 0.3))])
    r = np.linalg.norm(way, axis=0)
    return (3 * way * (m @ way) / r**2 - m[:, None]) / r**3


def passing(c: Campaign, axis: int, behind: Sequence[Draw] = ()) -> Effect:
    """Something magnetic passes once: a dipole, and others some distances behind it."""
    wagons, (passed, at) = [0.0, *drawn(c, behind)], event(c)
    half = c.rng.uniform(4, 15) * c.step
    field = sum(dipole(c.rng, (passed.at - at) / half - far) for far in wagons)
    return in_geo(c, lambda run: field if run is passed else np.zeros((3, len(run.at))))


def codes(c: Campaign, axis: int) -> Effect:
    def act(size: float) -> Parts:
        width = size * np.sqrt(12)
        return one_sensor(c, axis, lambda x: width * np.round(c.noisy[x.run.number][axis] / width) - c.noisy[x.run.number][axis])

    return Effect(act, (AXES[axis],), last=True)


KINDS = [Kind(*row) for row in [
    ("ageing", "straight", "time", lambda c, axis: sensor(lambda x: x.age, rate_nt_per_day=86400 / c.length)(c, axis),
     "NASA CR-156638, temporal drift in sensor offset", True),
    ("ageing", "power of time", "time", sensor(lambda x, power: np.maximum(x.age, 0) ** power, (0.7, 0.9)),
     "Nutting 1921, J. Franklin Inst. 191, 679: creep as t^0.7 to t^0.9", False, ("ageing", "warm_up")),
    ("ageing", "logarithm of time", "time", sensor(lambda x, fast: np.log1p(fast * np.maximum(x.age, 0)), (3, 20)),
     "Nutting 1921; creep as the logarithm of time", False, ("ageing", "warm_up")),
    ("sensitivity_ageing", "straight", "time", sensor(lambda x: 1e-5 * x.nt * x.age), "Toffner-Clausen et al. 2016, Earth Planets Space 68, 129", True),
    ("warm_up", "two bodies", "time", sensor(lambda x, tau: np.exp(-x.age / tau) + 0.3 * np.exp(-x.age / (4 * tau)), (0.1, 0.5)),
     "IAGA Guide; board and box", True),
    ("warm_up", "convection", "time", sensor(lambda x, tau: np.maximum(1 + x.age / tau, 0.1) ** -4.0, (0.5, 1.5)),
     "Incropera and DeWitt: free convection cools as (1 + t/tau)^-4", False),
    ("reading_step", "knock", "time", sensor(lambda x, at: (x.at >= at) * 1.0, MOMENT, height_nt=1.0), "IAGA Guide, steps in records", True),
    ("reading_step", "two steps", "time", sensor(lambda x, one, two, back: (x.at >= one) * 1.0 - back * (x.at >= two), MOMENT, MOMENT, (0.3, 0.8)),
     "a relay of ranges that goes over and back", True),
    ("reading_step", "range of one recording", "time", sensor(lambda x, which: np.full(len(x.at), float(x.run.number == which)), lambda c: c.rng.integers(len(c.runs))),
     "a range that is set for one recording", False),
    ("spike", "bit errors", "moments", sensor(spikes, struck), "IAGA Guide, spikes in records", True),
    ("vehicle_pass", "dipole", "moments", passing, "Jackson 1999, Classical Electrodynamics, 5.6", True),
    ("vehicle_pass", "lorry and trailer", "moments", partial(passing, behind=[(0.3, 0.8)]), "Jackson 1999, 5.6: two dipoles, unlike in direction", True),
    ("differential_nonlinearity", "one wrong bit", "codes",
     sensor(lambda x, period: np.where(np.mod(x.nt, period) < period / 2, 1.0, -1.0), (2000, 9000)),
     "Kester 2005, Data Conversion Handbook: a square wave along the reading", True),
    ("differential_nonlinearity", "two wrong bits", "codes",
     sensor(lambda x, period, share: sum(size * np.where(np.mod(x.nt, p) < p / 2, 1.0, -1.0) for size, p in ((1, period), (share, period / 4))),
            (4000, 9000), (0.3, 0.8)), "Kester 2005, Data Conversion Handbook", False),
    ("quantisation", "too few codes", "codes", codes, "Widrow and Kollar 2008, Quantization Noise", True),
]]
