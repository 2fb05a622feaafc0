"""What others would answer on the same document: stepwise regression with BIC, PySINDy's ensemble, and nothing.

Both choose among all columns of the document: straight, late by four relaxations, squared, and times the field, beside
powers and products of the field, its rate, and time. Each column has the catalogue's name that a careful person gives it.
"""
import time
from typing import Any

import numpy as np
from scipy.signal import lfilter

from .basic import spanned

ROWS, LATE_ROWS, MOST = 3000, (5, 20, 80, 300), 25
# PySINDy: threshold in units of the residual, bags, share of bags that must have a column, rows at most.
THRESHOLD, BAGS, INCLUDED, BAG_ROWS = 0.1, 10, 0.9, 1000
# Names of what follows a temperature: straight and squared, late, and times the field.
TEMPERATURES = {column: (f"offset_{name}", f"offset_{name}_lag", f"sensitivity_{name}") for column, name in
                (("sensor_temperature_c", "temperature"), ("electronics_temperature_c", "electronics_temperature"))}
# Of one sensor: its readings, columns that the calibration takes up, and candidates by name.
Named = list[tuple[str, np.ndarray]]
Block = tuple[np.ndarray, np.ndarray, Named]


def late(x: np.ndarray, rows: float) -> np.ndarray:
    """A relaxation over so many rows, at rest first."""
    a = float(np.exp(-1 / rows))
    return np.asarray(lfilter([1 - a], [1, -a], x - x[0]) + x[0])


def campaign(document: dict[str, Any]) -> list[Block]:
    c, runs = document["calibration"], document["recordings"]
    eta, mu = (np.array(c["axes"][part]["matrix"]) for part in ("coils", "sensors"))
    constant = np.array([c["coils"][k]["constant_nt_per_a"]["value"] for k in "xyz"])
    start = min(run["columns"]["time_s"][0] for run in runs)
    end = max(run["columns"]["time_s"][-1] for run in runs)

    def block(run: dict[str, Any], s: int, axis: str) -> Block:
        x, r = {name: np.array(column, float) for name, column in run["columns"].items()}, np.array(run["conditions"]["orientation"])
        current, t = np.stack([x[f"coil_{k}_a"] for k in "xyz"]), x["time_s"]
        field = mu.T @ r @ eta @ (constant[:, None] * current) / 5e4
        b, u, v = field[s], field[(s + 1) % 3], field[(s + 2) % 3]
        age = (t - start) / (end - start)
        named: Named = [(f"quadratic_nonlinearity {axis}", b**2), (f"cubic_nonlinearity {axis}", b**3), (f"loop_bandwidth {axis}", np.gradient(b, t)),
                        *[(f"cross_field {axis}", y) for y in (u * u, v * v, u * v)], *[(f"cross_field_sensitivity {axis}", b * y) for y in (u, v)],
                        (f"ageing {axis}", age), (f"sensitivity_ageing {axis}", b * age), *[(f"warm_up {axis}", np.exp(-age / y)) for y in (0.03, 0.1, 0.3)]]
        for k, (name, i) in enumerate(zip("xyz", current)):
            named.append((f"coil_temperature {name}", i * (mu[:, s] @ r @ eta[:, k]) * (x["coil_temperature_c"] - 21)))
        base = np.vstack([r @ eta @ (constant[:, None] * current), np.ones(len(t)), *[(mu[:, s] @ r)[a] * current for a in range(3)],
                          np.outer(mu[:, s] @ r, np.ones(len(t)))])
        return x[f"sensor_{axis}_nt"], base, named + dependences(x, axis, b)

    out = []
    for s, axis in enumerate("xyz"):
        readings, bases, named = zip(*(block(run, s, axis) for run in runs))
        merged = [(one[0][0], np.concatenate([column for _, column in one])) for one in zip(*named)]
        out.append((np.concatenate(readings), np.concatenate(bases, 1), merged))
    return out


def pair(document: dict[str, Any]) -> list[Block]:
    x, out = {name: np.array(column, float) for name, column in document["recordings"][0]["columns"].items()}, []
    t, reference = x["time_s"], np.stack([x[f"reference_{k}_nt"] for k in "xyz"])
    age = (t - t[0]) / (t[-1] - t[0])
    for axis in "xyz":
        named: Named = [("ageing", age), *[("warm_up", np.exp(-age / y)) for y in (0.03, 0.1, 0.3)], *[("clock_offset", np.gradient(y, t)) for y in reference]]
        named += [(f"dependence {column}", y) for column in x for _, y in dependences({column: x[column]}, axis, None)]
        out.append((x[f"test_{axis}_nt"], np.vstack([np.ones(len(t)), reference]), named))
    return out


def dependences(x: dict[str, np.ndarray], axis: str, field: np.ndarray | None) -> Named:
    """All columns that are no field, drive or time."""
    own: Named = []
    for column, y in x.items():
        if column == "time_s" or column[:-4] in ("sensor_", "test_", "reference_") or column in ("coil_x_a", "coil_y_a", "coil_z_a"):
            continue
        y = np.where(np.isfinite(y), y, np.nanmean(y)) - np.nanmean(y)
        straight, slow, product = (f"{name} {axis}" for name in TEMPERATURES[column]) if column in TEMPERATURES else (
            ("nulling_leakage" if column.startswith("outside") else f"dependence of {axis} on {column}",) * 3)
        own += [(straight, y), (straight, y**2), *((slow, late(y, rows)) for rows in LATE_ROWS)]
        own += [(product, y * field)] if field is not None else []
    return own


def projected(block: Block) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Residual and unit candidates beside the calibration's columns, on some thousand rows evenly spread."""
    reading, base, named = block
    rows = np.unique(np.linspace(0, len(reading) - 1, min(ROWS, len(reading))).astype(int))
    u = spanned(base[:, rows].T)
    x = np.stack([y[rows] for _, y in named], 1)
    x = x / (np.linalg.norm(x, axis=0) + 1e-300)
    x = x - u @ (u.T @ x)
    size = np.linalg.norm(x, axis=0)
    there = size > 1e-6
    y = reading[rows] - u @ (u.T @ reading[rows])
    y = y - u @ (u.T @ y)
    return y, x[:, there] / size[there], [name for (name, _), is_there in zip(named, there) if is_there]


def stepwise(y: np.ndarray, x: np.ndarray) -> list[int]:
    """Forward, then backward, by BIC = n ln(R/n) + k ln n. Schwarz 1978, Ann. Statist. 6, 461."""
    n, chosen, left, rest = len(y), [], y.copy(), x.copy()
    while len(chosen) < MOST:
        sizes = (rest**2).sum(0)
        gains = np.where(sizes > 1e-6, (rest.T @ left) ** 2 / np.maximum(sizes, 1e-12), 0)
        best = int(gains.argmax())
        if n * np.log(max(left @ left - gains[best], 1e-300) / (left @ left)) + np.log(n) >= 0:
            break
        q = rest[:, best] / np.sqrt(sizes[best])
        left, rest = left - q * (q @ left), rest - np.outer(q, q @ rest)
        chosen.append(best)

    def criterion(some: list[int]) -> float:
        a = x[:, some]
        off = y - a @ np.linalg.lstsq(a, y, rcond=None)[0] if some else y
        return float(n * np.log(off @ off / n) + len(some) * np.log(n))

    for one in list(chosen):
        fewer = [other for other in chosen if other != one]
        if criterion(fewer) < criterion(chosen):
            chosen = fewer
    return chosen


def ensemble(y: np.ndarray, x: np.ndarray) -> list[int]:
    """Columns that sequentially thresholded least squares keeps in nine of ten bags. Fasel et al. 2022, Proc. R. Soc. A 478, 20210904."""
    from pysindy import STLSQ
    from pysindy.optimizers import EnsembleOptimizer
    from sklearn import config_context

    np.random.seed(1)
    rows = np.linspace(0, len(y) - 1, min(BAG_ROWS, len(y))).astype(int)
    x, y, root = x[rows], y[rows], np.sqrt(len(y))
    # Which columns stay is all that counts; the same numbers are not checked again in each bag.
    model = EnsembleOptimizer(STLSQ(threshold=THRESHOLD, alpha=0.05 * len(y), max_iter=20, unbias=False), bagging=True, n_models=BAGS)
    with config_context(assume_finite=True, skip_parameter_validation=True):
        model.fit(x * root, (y / (np.std(y) + 1e-300))[:, None])
    return [int(i) for i in np.flatnonzero((np.array(model.coef_list)[:, 0, :] != 0).mean(0) >= INCLUDED)]


def all_of(document: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Names and seconds by rival; a rival that is not installed has no entry."""
    started = time.monotonic()
    is_pair = document["recordings"][0]["procedure"] == "differential"
    if not is_pair and "axes" not in document.get("calibration", {}):
        return {}
    ready = [projected(block) for block in (pair if is_pair else campaign)(document)]
    prepared, out = time.monotonic() - started, {"nothing": {"names": [], "seconds": 0.0}}
    for title, choose in (("stepwise", stepwise), ("ensemble", ensemble)):
        started = time.monotonic()
        try:
            names = sorted({named[i] for y, x, named in ready for i in choose(y, x)})
        except ImportError:
            continue
        out[title] = {"names": names, "seconds": prepared + time.monotonic() - started}
    return out
