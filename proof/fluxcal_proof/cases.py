"""A document and its truth, from a seed and a number."""
from collections.abc import Callable
from typing import Any

import numpy as np

from . import effects, groups, noise, pairs, plan, signal
from .basic import Basic
from .campaign import AXES, REFERENCE_C, Campaign, Parts, directions
from .groups import Kind
from .plan import Case

ARCSEC = 2.0  # what is stated of directions


def make(seed: int, number: int, of: str) -> Case:
    """A case of the group `develop` or `score`."""
    (sort, index), rng = plan.sort(number), np.random.default_rng([seed, number])
    return beside(rng, index, of) if sort == "pair" else campaign(rng, sort, index, of)


def chosen(rng: np.random.Generator, own: list[Kind], sort: str, index: int, several: Callable[[], int]) -> list[tuple[Kind, float]]:
    """Which kinds act, each with its strength in times the noise."""
    strong = lambda: float(rng.choice([1.0, 3.0, 10.0]))
    if sort == "clean":
        return []
    if sort == "several":
        return [(own[i], strong()) for i in rng.choice(len(own), several(), replace=False)]
    # Each kind comes in each strength before any comes again in one.
    rounds, which = divmod(index, len(own))
    return [(own[which], plan.STRENGTHS[(index + rounds) % len(plan.STRENGTHS)] if sort == "single" else strong())]


def campaign(rng: np.random.Generator, sort: str, index: int, of: str) -> Case:
    """A campaign in coils. What acts acts on the field without the others."""
    kinds = chosen(rng, groups.of_group(effects.KINDS, of, sort), sort, index, lambda: int(rng.choice([2, 2, 3, 4])))
    manners = {name: bool(rng.uniform() < share) for name, share in dict(together=0.3, averages=0.25, uneven=0.3, gaps=0.35).items()}
    if any(kind.name == "reaction_wheel" for kind, _ in kinds):
        manners["averages"] = False
    c = Campaign(rng, plan.rows(rng), **manners)
    acting = [(kind, strength, kind.make(c, int(rng.integers(3)))) for kind, strength in kinds]
    basic = Basic(c)
    own = noise.of_size(rng, float(rng.choice([0.1, 0.2, 0.5])), c.step, bool(rng.uniform() < 0.35))
    widened = [np.repeat(own.draw(rng, len(run.t), c.step), len(run.at) // len(run.t), axis=1) for run in c.runs]
    flat = basic.flat(widened)
    noise_nt = float(np.sqrt(np.mean(flat**2)))
    read = [c.plain(run) for run in c.runs]
    total = [np.zeros_like(part) for part in read]
    told = []
    for kind, strength, effect in sorted(acting, key=lambda one: one[2].last):
        c.noisy = [a + b + w for a, b, w in zip(read, total, widened)]
        # What cannot show, such as a threshold that no field reaches, is drawn again.
        for again in range(21):
            effect = kind.make(c, int(rng.integers(3))) if again else effect
            parts, size = effect.sized(basic, strength * noise_nt)
            if basic.left(parts) > 0.5 * strength * noise_nt:
                break
        total = [a + b for a, b in zip(total, parts)]
        told.append(kind.truth(effect, size, strength, basic.left(parts)))
    taken = flat - basic.without(flat)
    before = basic.without(basic.flat(total))
    document, more = written(rng, c, own, [a + b + w for a, b, w in zip(read, total, widened)])
    expected = np.concatenate([((run.mean(a + b) - c.zero[:, None]) / c.gain[:, None])[:, run.keep].ravel() for run, a, b in zip(c.runs, read, total)])
    truth = dict(sort=sort, effects=told, noise_nt=noise_nt, rows=int(sum(run.keep.sum() for run in c.runs)),
                 manners=[name for name, is_so in manners.items() if is_so] + more + own.manners,
                 taken_nt=float(np.sqrt(np.mean(taken**2))), before_nt=float(np.sqrt(np.mean((before - taken) ** 2))))
    return Case(document, truth, expected)


def written(rng: np.random.Generator, c: Campaign, own: noise.Noise, readings: Parts) -> tuple[dict[str, Any], list[str]]:
    """The document: a calibration that is wrong by as much as it states, and the recordings; and what is declared of noise."""
    document: dict[str, Any] = {"fluxcal": 1, "facility": {"coils": {k: {"max_nt": 60_000} for k in AXES}},
                                "instrument": {"range_nt": 100_000, "positions_m": {k: c.positions[i].tolist() for i, k in enumerate(AXES)}}}
    factor = None
    if rng.uniform() < 0.5:
        factor = float(rng.choice([1.0, 1.0, 1.0, rng.choice([0.9, 1.1])]))
        document["instrument"]["noise"] = own.declared(factor)

    def quantity(value: float, std: float) -> dict[str, float]:
        return {"value": float(value + rng.normal() * std), "std": float(std)}

    names = ("sensor_temperature_c", "electronics_temperature_c", "coil_temperature_c")
    document["calibration"] = {
        "sensors": {k: {"sensitivity_nt_per_nt": quantity(c.gain[i], 1e-5), "offset_nt": quantity(c.zero[i], 0.3)} for i, k in enumerate(AXES)},
        "coils": {k: {"constant_nt_per_a": quantity(c.coil[i], 1e-5 * c.coil[i]), "offset_nt": quantity(c.bias[i], 0.3)} for i, k in enumerate(AXES)},
        "axes": {part: {"matrix": directions(rng, ARCSEC / 3600, m).tolist(), "std_arcsec": ARCSEC} for part, m in (("sensors", c.mu), ("coils", c.eta))},
        "reference_conditions": dict(zip(names, REFERENCE_C))}
    document["recordings"] = []
    for run, reading in zip(c.runs, readings):
        raw = (run.mean(reading) - c.zero[:, None]) / c.gain[:, None]
        columns = {"time_s": run.t}
        for i, k in enumerate(AXES):
            columns[f"coil_{k}_a"] = run.mean(run.current[i](run.at))
            columns[f"sensor_{k}_nt"] = np.round(raw[i], 4)
            columns[f"outside_{k}_nt"] = np.round(run.mean(run.outside[i](run.at)) + (20_000, 300, 43_000)[i], 3)
        columns |= {name: np.round(run.mean(t(run.at)), 4) for name, t in zip(names, run.temperature)}
        columns |= {name: run.mean(x(run.at)) for name, x in run.columns.items()}
        conditions: dict[str, Any] = {"orientation": run.turn.tolist()}
        if run.averages:
            conditions["integration_s"] = run.width
        document["recordings"].append({"id": f"run-{run.number + 1}", "procedure": "free_run", "conditions": conditions,
                                       "columns": {k: np.round(v[run.keep], 9).tolist() for k, v in columns.items()}})
    return document, [noise.declaration(factor)]


def beside(rng: np.random.Generator, number: int, of: str) -> Case:
    """A test instrument beside a reference."""
    (sort, index), day = plan.turn(plan.TURNS, number), number % plan.DAY_EVERY == 10
    kinds = chosen(rng, groups.of_group(pairs.KINDS, of, sort), sort, index, lambda: 2)
    rows = plan.DAY_ROWS if day else max(1000, plan.rows(rng))
    step = 1.0 if day else float(rng.choice([1.0, 10.0, 60.0]))
    noisy = float(rng.choice([0.02, 0.05, 0.05, 0.1, 0.3]))
    pair = pairs.Pair(rng, rows, step, noisy)
    manners = [f"noise of the reference {noisy:g} nT"] + (["a day of seconds"] if day else [])
    if rng.uniform() < 0.3:
        pair.noise = noise.of_size(rng, 0.1, step, True)
        manners += pair.noise.manners
    if rng.uniform() < 0.4:
        manners.append("decoys")
        wander = signal.smooth(rng, pair.length, pair.length / 40, 0.7, 2.0)
        near, own = pair.columns["electronics_temperature_c"], pair.field[0]
        pair.columns["room_temperature_c"] = lambda t: near(t) + wander(t)
        pair.columns["box_temperature_c"] = lambda t: 20 + 0.2 * (own(t) - pairs.LEVEL[0]) + wander(t)
    acting = [(kind, strength, kind.make(pair)) for kind, strength in kinds]
    keep = np.ones(rows, bool)
    if rng.uniform() < 0.3:
        manners.append("gaps")
        keep = rng.uniform(size=rows) > 0.02
        keep[rows // 3:rows // 3 + rows // 20] = False
    field, fitted = pair.at(), pairs.Fitted(pair.at())
    own_noise, reference_noise = (one.draw(rng, rows, step) for one in (pair.noise, pair.reference_noise))
    difference = own_noise - pair.eta @ reference_noise
    noise_nt = float(np.sqrt(np.mean(difference**2)))
    added, told = np.zeros((3, rows)), []
    for kind, strength, effect in acting:
        parts, size = effect.sized(fitted, strength * noise_nt)
        added = added + parts[0]
        told.append(kind.truth(effect, size, strength, fitted.left(parts)))
    columns = {"time_s": pair.t}
    for i, k in enumerate(AXES):
        columns[f"reference_{k}_nt"] = (field + reference_noise)[i]
        columns[f"test_{k}_nt"] = (pair.eta @ field + pair.offset[:, None] + added + own_noise)[i]
    columns |= {name: x(pair.t) for name, x in pair.columns.items()}
    recording = {"id": "pair", "procedure": "differential", "columns": {k: np.round(v[keep], 5).tolist() for k, v in columns.items()}}
    document: dict[str, Any] = {"fluxcal": 1, "recordings": [recording]}
    factor = None
    if rng.uniform() < 0.5:
        factor = float(rng.choice([1.0, 1.0, 1.0, 0.9, 1.1], p=[0.25, 0.25, 0.25, 0.125, 0.125]))
        document["instrument"] = {"noise": pair.noise.declared(factor)}
        recording["conditions"] = {"reference_noise": pair.reference_noise.declared(factor)}
    manners.append(noise.declaration(factor))
    floor = float(np.sqrt(np.mean(fitted.without(difference)[:, keep] ** 2)))
    truth = dict(sort="pair", turn=sort, effects=told, noise_nt=noise_nt, rows=int(keep.sum()), manners=manners, floor_nt=floor)
    return Case(document, truth, np.zeros(0))
