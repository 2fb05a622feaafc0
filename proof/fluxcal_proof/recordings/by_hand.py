"""What a careful person reaches with a few lines of least squares: what the programs are held against."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .series import AXES, Series, scatter

SideBySide = Callable[[float], Series]  # both instruments if the test instrument's times are late by so much, s
TEMPERATURE = "sensor_temperature_c"


def least_squares(columns: list[np.ndarray], y: np.ndarray) -> np.ndarray | None:
    """c of y = Σ c_k column_k; None where columns of unit length are dependent (a singular value below
    10⁻¹² of the largest)."""
    design = np.column_stack(columns)
    lengths = np.linalg.norm(design, axis=0)
    found, _, rank, _ = np.linalg.lstsq(design / lengths, y, rcond=1e-12)
    return (found.T / lengths).T if rank == len(columns) else None


class Way(NamedTuple):
    """One way to explain a test axis."""

    matrix: bool
    drift: bool
    temperature: bool
    lag: bool

    def words(self, late_s: float) -> str:
        if not self.matrix:
            return "levels alone"
        lag = f", clock {abs(late_s):.3f} s {'early' if late_s < 0 else 'late'}"
        return ("3×3 and offset" + ", straight drift" * self.drift
                + ", line in the temperature" * self.temperature + lag * self.lag)

    def left(self, axis: str, fitted: Series, part: Series) -> np.ndarray | None:
        """What is left of an axis of one part, nT, by constants that are fitted to another."""
        test, reference = f"test_{axis}_nt", f"reference_{axis}_nt"
        if not self.matrix:
            return part[test] - part[reference] - np.mean(fitted[test] - fitted[reference])

        def columns(series: Series) -> list[np.ndarray]:
            further = [series.time_s / 3600] * self.drift
            further += [series[TEMPERATURE]] if self.temperature else []
            return [np.ones(len(series)), *series.vectors("reference").T, *further]
        found = least_squares(columns(fitted), fitted[test])
        return None if found is None else part[test] - np.column_stack(columns(part)) @ found


def lag(fitted: SideBySide) -> float:
    """The lag, s, of least scatter of what a 3×3 matrix with an offset leaves, each axis over its scatter
    without a lag; within three steps, to a twentieth of a step."""
    time = fitted(0.0).time_s
    step_s = (time[-1] - time[0]) / (len(time) - 1)
    way = Way(True, False, False, True)

    def of_each(late_s: float) -> np.ndarray:
        series = fitted(late_s)
        left = [way.left(axis, series, series) for axis in AXES]
        return np.array([np.inf if one is None else scatter(one) for one in left])
    without = of_each(0.0)
    if not np.isfinite(without).all():
        return 0.0

    def least(steps: np.ndarray) -> float:
        return steps[np.argmin([np.sum(of_each(step * step_s) / without) for step in steps])]
    coarse = least(-3 + 0.5 * np.arange(13))
    return least(coarse - 0.5 + 0.05 * np.arange(21)) * step_s


def best(fitted: SideBySide, held_out: SideBySide, clock: bool = True
         ) -> tuple[list[str], list[np.ndarray]]:
    """Of each axis the way that is fitted to the first two thirds of the fitted part and predicts its last
    third best: in words, and what it leaves of the part held out, nT, fitted to the whole fitted part."""
    late_s = lag(fitted) if clock else 0.0
    fitted_by, held_out_by = ([part(0.0), part(late_s)] for part in (fitted, held_out))
    tried = [series.split_share(2 / 3) for series in fitted_by]
    ways = [Way(False, False, False, False)] + [
        Way(True, drift, temperature, late) for drift in (False, True) for temperature in (False, True)
        for late in (False, True)
        if (TEMPERATURE in fitted_by[0] or not temperature) and (late_s != 0 or not late)]
    words, all_left = [], []
    for axis in AXES:
        def predicts(way: Way) -> float:
            left = way.left(axis, *tried[way.lag])
            return np.inf if left is None else scatter(left)
        way = min(ways, key=predicts)
        words.append(way.words(late_s))
        all_left.append(way.left(axis, fitted_by[way.lag], held_out_by[way.lag]))
    return words, all_left


def mismatch(series: Series, offset_nt: np.ndarray, quantity: str = "sensor") -> np.ndarray:
    """|v + offset| − reference of each row, nT."""
    return np.linalg.norm(series.vectors(quantity) + offset_nt, axis=1) - series["reference_nt"]


def plane(fitted: Series, part: Series, offset_nt: np.ndarray) -> np.ndarray | None:
    """What a level and slopes along the three readings leave of the mismatch: all that nine constants do to
    |B|, to first order, where the field points one way."""
    found = least_squares([np.ones(len(fitted)), *fitted.vectors("sensor").T], mismatch(fitted, offset_nt))
    if found is None:
        return None
    return mismatch(part, offset_nt) - found[0] - part.vectors("sensor") @ found[1:]


# Which of the coefficients xx, yy, zz, xy, xz, yz, x, y, z are alike; those that are zero are left out.
SHAPES = {
    "a sphere by plain least squares": [[0, 1, 2], [6], [7], [8]],
    "an ellipsoid along the axes by plain least squares": [[0], [1], [2], [6], [7], [8]],
    "an ellipsoid by plain least squares": [[k] for k in range(9)],
}


def magnitudes(shape: str, fitted: Series, part: Series, offset_nt: np.ndarray) -> np.ndarray | None:
    """Magnitudes of a part over that of the field, by an ellipsoid fitted to another part.

    (v + o)ᵀ Q (v + o) = F² is solved as vᵀ Q' v + 2 b'ᵀ v = 1; a magnitude is √(vᵀ Q' v + 2 b'ᵀ v + c) / √(1 + c)
    with c = b'ᵀ Q'⁻¹ b'. None where the form is that of no ellipsoid.
    """
    size = np.linalg.norm(fitted.vectors("sensor") + offset_nt, axis=1).max()

    def terms(series: Series) -> np.ndarray:
        x, y, z = ((series.vectors("sensor") + offset_nt) / size).T
        return np.array([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z])
    groups, all_terms = SHAPES[shape], terms(fitted)
    solved = least_squares([all_terms[group].sum(axis=0) for group in groups], np.ones(len(fitted)))
    if solved is None:
        return None
    found = np.zeros(9)
    for group, value in zip(groups, solved):
        found[group] = value
    xx, yy, zz, xy, xz, yz = found[:6]
    form = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if np.linalg.eigvalsh(form)[0] <= 0:
        return None
    c = found[6:] @ np.linalg.solve(form, found[6:])
    return np.sqrt((found @ terms(part) + c) / (1 + c))


def ellipsoid(fitted: Series, part: Series, offset_nt: np.ndarray) -> np.ndarray | None:
    """F times magnitude − F of each row of a part by the full ellipsoid of another, nT."""
    found = magnitudes("an ellipsoid by plain least squares", fitted, part, offset_nt)
    return None if found is None else fitted["reference_nt"][0] * (found - 1)
