"""A document and its truth, from a seed and a number."""
from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import effects, groups, noise, plan  # noqa: F401  (`effects` fills the table of kinds)
from .basic import Basic
from .campaign import AXES, REFERENCE_C, Campaign, Parts
from .effect import Effect, Kind

CONSTANTS = {"sensitivity": 1e-5, "offset": 0.3, "coil": 1e-5, "bias": 0.3, "arcsec": 2.0}
Document = dict[str, Any]


@dataclass
class Case:
    """`expected` are the readings without noise, `floor_nt` the rms that is left when the truth is fitted."""

    document: Document
    truth: dict[str, Any]
    expected: np.ndarray


def neutral(seed: int, number: int) -> str:
    """A name that says nothing."""
    return hashlib.sha256(f"{seed}/{number}".encode()).hexdigest()[:10]


def make(seed: int, number: int, of: str) -> Case:
    """A case of the group `develop` or `score`."""
    spec = plan.spec(number)
    rng = np.random.default_rng([seed, number])
    if spec.sort == "pair":
        from . import pairs

        return pairs.make(rng, spec, of)
    return campaign(rng, spec, of)


def chosen(rng: np.random.Generator, spec: plan.Spec, of: str) -> list[tuple[Kind, float]]:
    """Which kinds act, each with its strength in times the noise."""
    single = groups.kinds(of, "single")
    if spec.sort == "clean":
        return []
    if spec.sort == "several":
        which = rng.choice(len(single), int(rng.choice([2, 2, 3, 4])), replace=False)
        return [(single[i], float(rng.choice([1.0, 3.0, 10.0]))) for i in which]
    own = single if spec.sort == "single" else groups.kinds(of, spec.sort)
    which_one, strength = plan.of_kinds(spec.index, len(own))
    return [(own[which_one], strength if spec.sort == "single" else float(rng.choice([1.0, 3.0, 10.0])))]


def sized(effect: Effect, basic: Basic, target: float) -> tuple[Parts, float]:
    """An effect at the size at which the constants of the basic model leave so many nT of it, and that size."""
    size, parts = 1.0, effect.act(1.0)
    for _ in range(12):
        left = basic.left(parts)
        if abs(np.log(left / target)) < 0.02:
            break
        size *= float(np.clip((target / left) ** (1 / effect.power), 1e-3, 1e3))
        parts = effect.act(size)
    return parts, size


def campaign(rng: np.random.Generator, spec: plan.Spec, of: str) -> Case:
    """A campaign in coils. What acts acts on the field without the others."""
    kinds = chosen(rng, spec, of)
    manners = {name: bool(rng.uniform() < share) for name, share in dict(together=0.3, averages=0.25, uneven=0.3, gaps=0.35).items()}
    if any(kind.name == "reaction_wheel" for kind, _ in kinds):
        manners["averages"] = False
    c = Campaign(rng, plan.rows(rng), **manners)
    acting = [(kind, strength, kind.make(c, int(rng.integers(3)), rng)) for kind, strength in kinds]
    basic = Basic(c)
    own = noise.of_size(rng, float(rng.choice([0.1, 0.2, 0.5])), c.step, bool(rng.uniform() < 0.35))
    drawn = [np.stack([own.draw(rng, len(run.t), c.step) for _ in range(3)]) for run in c.runs]
    widened = [np.repeat(part, len(run.at) // len(run.t), axis=1) for run, part in zip(c.runs, drawn)]
    flat = basic.flat(widened)
    noise_nt = float(np.sqrt(np.mean(flat**2)))
    read = [c.plain(run) for run in c.runs]
    total = [np.zeros_like(part) for part in read]
    told = []
    for kind, strength, effect in sorted(acting, key=lambda one: one[2].codes):
        if effect.codes:
            effect.noisy[:] = [a + b + w for a, b, w in zip(read, total, widened)]
        target = strength * noise_nt
        parts, size = sized(effect, basic, target)
        # What cannot show, such as a threshold that no field reaches, is drawn again.
        for _ in range(20):
            if basic.left(parts) > 0.5 * target:
                break
            effect = kind.make(c, int(rng.integers(3)), rng)
            effect.noisy[:] = [a + b + w for a, b, w in zip(read, total, widened)]
            parts, size = sized(effect, basic, target)
        total = [a + b for a, b in zip(total, parts)]
        told.append(dict(kind=kind.name, form=kind.form, family=kind.family, source=kind.source, strength=strength,
                         right=effect.right, undecidable=effect.undecidable, left_nt=basic.left(parts),
                         parameters={k: v * size if k.endswith("nt") or "_nt_per" in k else v for k, v in effect.truth.items()}))
    taken = flat - basic.without(flat)
    before = basic.without(basic.flat(total))
    document, more = written(rng, c, own, [a + b + w for a, b, w in zip(read, total, widened)])
    expected = np.concatenate([((run.mean(a + b) - c.zero[:, None]) / c.gain[:, None])[:, run.keep].ravel() for run, a, b in zip(c.runs, read, total)])
    truth = dict(sort=spec.sort, effects=told, noise_nt=noise_nt, rows=int(sum(run.keep.sum() for run in c.runs)),
                 manners=[name for name, is_so in manners.items() if is_so] + more + (["flicker noise"] if own.flicker else ["random walk"] if own.walk else []),
                 taken_nt=float(np.sqrt(np.mean(taken**2))), before_nt=float(np.sqrt(np.mean((before - taken) ** 2))))
    return Case(document, truth, expected)


def written(rng: np.random.Generator, c: Campaign, own: noise.Noise, readings: Parts) -> tuple[Document, list[str]]:
    """The document: a calibration that is wrong by as much as it states, and the recordings."""
    more, factor = [], 1.0
    document: Document = {"fluxcal": 1, "facility": {"coils": {k: {"max_nt": 60_000} for k in AXES}},
                          "instrument": {"range_nt": 100_000, "positions_m": {k: c.positions[i].tolist() for i, k in enumerate(AXES)}}}
    if rng.uniform() < 0.5:
        factor = float(rng.choice([1.0, 1.0, 1.0, rng.choice([0.9, 1.1])]))
        document["instrument"]["noise"] = own.declared(factor)
        more.append("noise declared" if factor == 1 else "noise declared, a tenth wrong")
    else:
        more.append("noise not declared")

    def quantity(value: float, std: float) -> dict[str, float]:
        return {"value": float(value + rng.normal() * std), "std": float(std)}

    s = CONSTANTS
    names = ("sensor_temperature_c", "electronics_temperature_c", "coil_temperature_c")
    document["calibration"] = {
        "sensors": {k: {"sensitivity_nt_per_nt": quantity(c.gain[i], s["sensitivity"]), "offset_nt": quantity(c.zero[i], s["offset"])} for i, k in enumerate(AXES)},
        "coils": {k: {"constant_nt_per_a": quantity(c.coil[i], s["coil"] * c.coil[i]), "offset_nt": quantity(c.bias[i], s["bias"])} for i, k in enumerate(AXES)},
        "axes": {"sensors": {"matrix": misread(rng, c.mu).tolist(), "std_arcsec": s["arcsec"]}, "coils": {"matrix": misread(rng, c.eta).tolist(), "std_arcsec": s["arcsec"]}},
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
    return document, more


def misread(rng: np.random.Generator, directions: np.ndarray) -> np.ndarray:
    """Directions as they were measured: each turned by as much as is stated."""
    m = directions + rng.normal(size=(3, 3)) * np.deg2rad(CONSTANTS["arcsec"] / 3600)
    return np.asarray(m / np.linalg.norm(m, axis=0))
