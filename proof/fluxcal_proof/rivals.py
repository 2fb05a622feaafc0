"""What others would answer on the same document: stepwise regression with BIC, PySINDy's ensemble, and nothing.

Both choose among all columns of the document: straight, late by four relaxations, squared, and times the field, beside
powers and products of the field, its rate, and time. Each column has the catalogue's name that a careful person gives it.
"""
from __future__ import annotations

import time
from typing import Any

import numpy as np
from scipy.signal import lfilter

ROWS, LATE_ROWS, MOST = 3000, (5, 20, 80, 300), 25
# PySINDy: threshold in units of the residual, bags, share of bags that must have a column, rows at most.
THRESHOLD, BAGS, INCLUDED, BAG_ROWS = 0.1, 10, 0.9, 1000
Named = list[tuple[str, np.ndarray]]
Blocks = list[tuple[np.ndarray, np.ndarray, Named]]
TEMPERATURES = {"sensor_temperature_c": "temperature", "electronics_temperature_c": "electronics_temperature"}


def late(x: np.ndarray, rows: float) -> np.ndarray:
    """A relaxation over so many rows, at rest first."""
    a = float(np.exp(-1 / rows))
    return np.asarray(lfilter([1 - a], [1, -a], x - x[0]) + x[0])


def values(columns: dict[str, Any], name: str) -> np.ndarray:
    return np.array(columns[name], float)


def sorts(name: str, axis: str, column: str) -> str:
    """The name of a dependence that is `straight`, `late` or `product`."""
    known = TEMPERATURES.get(column)
    if known:
        return {"straight": f"offset_{known}", "late": f"offset_{known}_lag", "product": f"sensitivity_{known}"}[name] + f" {axis}"
    return "nulling_leakage" if column.startswith("outside") else f"dependence of {axis} on {column}"


def campaign(document: dict[str, Any]) -> Blocks:
    """For each sensor: readings, columns that the calibration takes up, and candidates."""
    c, runs, out = document["calibration"], document["recordings"], []
    eta, mu = (np.array(c["axes"][part]["matrix"]) for part in ("coils", "sensors"))
    constant = np.array([c["coils"][k]["constant_nt_per_a"]["value"] for k in "xyz"])
    for s, axis in enumerate("xyz"):
        parts: list[tuple[np.ndarray, np.ndarray, Named]] = []
        start = min(run["columns"]["time_s"][0] for run in runs)
        end = max(run["columns"]["time_s"][-1] for run in runs)
        for run in runs:
            x, r = run["columns"], np.array(run["conditions"]["orientation"])
            current = np.stack([values(x, f"coil_{k}_a") for k in "xyz"])
            field = mu.T @ r @ eta @ (constant[:, None] * current) / 5e4
            b, u, v = field[s], field[(s + 1) % 3], field[(s + 2) % 3]
            t = values(x, "time_s")
            age = (t - start) / (end - start)
            named: Named = [(f"quadratic_nonlinearity {axis}", b**2), (f"cubic_nonlinearity {axis}", b**3), (f"loop_bandwidth {axis}", np.gradient(b, t)),
                            *[(f"cross_field {axis}", y) for y in (u * u, v * v, u * v)], *[(f"cross_field_sensitivity {axis}", b * y) for y in (u, v)],
                            (f"ageing {axis}", age), (f"sensitivity_ageing {axis}", b * age), *[(f"warm_up {axis}", np.exp(-age / y)) for y in (0.03, 0.1, 0.3)]]
            for k, i in zip("xyz", current):
                named.append((f"coil_temperature {k}", i * (mu[:, s] @ r @ eta[:, "xyz".index(k)]) * (values(x, "coil_temperature_c") - 21)))
            named += dependences(x, axis, b)
            base = np.vstack([r @ eta @ (constant[:, None] * current), np.ones(len(t)), *[(mu[:, s] @ r)[a] * current for a in range(3)],
                              np.outer(mu[:, s] @ r, np.ones(len(t)))])
            parts.append((values(x, f"sensor_{axis}_nt"), base, named))
        names = [name for name, _ in parts[0][2]]
        merged = [(name, np.concatenate([part[2][i][1] for part in parts])) for i, name in enumerate(names)]
        out.append((np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts], 1), merged))
    return out


def dependences(x: dict[str, Any], axis: str, field: np.ndarray | None) -> Named:
    """All columns that are no field, drive or time."""
    own: Named = []
    for column in x:
        if column == "time_s" or column[:-4] in ("sensor_", "test_", "reference_") or column in ("coil_x_a", "coil_y_a", "coil_z_a"):
            continue
        y = values(x, column)
        y = np.where(np.isfinite(y), y, np.nanmean(y)) - np.nanmean(y)
        own += [(sorts("straight", axis, column), y), (sorts("straight", axis, column), y**2)]
        own += [(sorts("late", axis, column), late(y, rows)) for rows in LATE_ROWS]
        own += [(sorts("product", axis, column), y * field)] if field is not None else []
    return own


def pair(document: dict[str, Any]) -> Blocks:
    """For each axis of the test instrument."""
    x, out = document["recordings"][0]["columns"], []
    t = values(x, "time_s")
    reference = np.stack([values(x, f"reference_{k}_nt") for k in "xyz"])
    age = (t - t[0]) / (t[-1] - t[0])
    for axis in "xyz":
        named: Named = [("ageing", age), *[("warm_up", np.exp(-age / y)) for y in (0.03, 0.1, 0.3)], *[("clock_offset", np.gradient(y, t)) for y in reference]]
        named += [(f"dependence {column}", y) for column in x for _, y in dependences({column: x[column]}, axis, None)]
        out.append((values(x, f"test_{axis}_nt"), np.vstack([np.ones(len(t)), reference]), named))
    return out


def projected(block: tuple[np.ndarray, np.ndarray, Named]) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Residual and unit candidates beside the calibration's columns, on some thousand rows evenly spread."""
    reading, base, named = block
    rows = np.unique(np.linspace(0, len(reading) - 1, min(ROWS, len(reading))).astype(int))
    base = (base / (np.linalg.norm(base, axis=1, keepdims=True) + 1e-300))[:, rows]
    u, sizes, _ = np.linalg.svd(base.T, full_matrices=False)
    u = u[:, sizes > 1e-9 * sizes[0]]
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

    np.random.seed(1)
    rows = np.linspace(0, len(y) - 1, min(BAG_ROWS, len(y))).astype(int)
    x, y, root = x[rows], y[rows], np.sqrt(len(y))
    model = EnsembleOptimizer(STLSQ(threshold=THRESHOLD, alpha=0.05 * len(y), max_iter=20), bagging=True, n_models=BAGS)
    model.fit(x * root, (y / (np.std(y) + 1e-300))[:, None])
    return [int(i) for i in np.flatnonzero((np.array(model.coef_list)[:, 0, :] != 0).mean(0) >= INCLUDED)]


def all_of(document: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Names and seconds by rival; a rival that is not installed has no entry."""
    started = time.monotonic()
    is_pair = document["recordings"][0]["procedure"] == "differential"
    if not is_pair and "axes" not in document.get("calibration", {}):
        return {}
    blocks = pair(document) if is_pair else campaign(document)
    ready = [projected(block) for block in blocks]
    prepared, out = time.monotonic() - started, {"nothing": {"names": [], "seconds": 0.0}}
    for title, choose in (("stepwise", stepwise), ("ensemble", ensemble)):
        started = time.monotonic()
        try:
            names = sorted({named[i] for y, x, named in ready for i in choose(y, x)})
        except ImportError:
            continue
        out[title] = {"names": names, "seconds": prepared + time.monotonic() - started}
    return out
