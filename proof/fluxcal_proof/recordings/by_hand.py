"""What a careful person reaches with a few lines of least squares: what the programs are held against."""
from collections.abc import Callable
from itertools import combinations

import numpy as np

from .programs import Series, scatter

TEMPERATURE = "sensor_temperature_c"
Columns = Callable[[Series], list[np.ndarray]]
SideBySide = Callable[[float], Series]  # both instruments if the test instrument's times are late by so much, s


def least_squares(columns: list[np.ndarray], y: np.ndarray) -> np.ndarray | None:
    """c of y = Σ c_k column_k; None where columns of unit length are dependent, to 10⁻¹² of the largest singular value."""
    design = np.column_stack(columns)
    lengths = np.linalg.norm(design, axis=0)
    found, _, rank, _ = np.linalg.lstsq(design / lengths, y, rcond=1e-12)
    return (found.T / lengths).T if rank == len(columns) else None


def left(columns: Columns, y: Callable[[Series], np.ndarray], fitted: Series, part: Series) -> np.ndarray | None:
    """What is left of y in one part by constants that are fitted to another; None where they are not determined."""
    found = least_squares(columns(fitted), y(fitted))
    return None if found is None else y(part) - np.column_stack(columns(part)) @ found


def affine(instrument: str, *further: Callable[[Series], np.ndarray]) -> Columns:
    """An offset, three readings, and further columns."""
    return lambda series: [np.ones(len(series)), *series.vectors(instrument).T, *(column(series) for column in further)]


def test(series: Series) -> np.ndarray:
    return series.vectors("test")


def lag(fitted: SideBySide) -> float:
    """The lag, s, of least scatter with a 3×3 matrix and offset, each axis over that without: within three steps, to 1/20."""
    def by(late_s: float) -> np.ndarray:
        series = fitted(late_s)
        one = left(affine("reference"), test, series, series)
        return np.full(3, np.inf) if one is None else scatter(one)
    time, without, late_s = fitted(0.0).time_s, by(0.0), 0.0
    step_s = np.ptp(time) / (len(time) - 1) if np.isfinite(without).all() else 0.0
    for places in (0.5 * np.arange(-6, 7), 0.05 * np.arange(-10, 11)):
        late_s = min(late_s + step_s * places, key=lambda late: np.sum(by(late) / without))
    return late_s


def best_of_pair(fitted: SideBySide, held_out: SideBySide, late_s: float = 0.0) -> tuple[list[str], list[np.ndarray]]:
    """Of each axis the way that is fitted to the first two thirds of the fitted part and predicts its last third best: in words, and what
    it leaves of the part held out, nT, fitted to the whole fitted part."""
    further = {"straight drift": lambda series: series.time_s / 3600}
    if TEMPERATURE in fitted(0.0).frame:
        further["line in the temperature"] = lambda series: series[TEMPERATURE]
    clock = f", clock {abs(late_s):.3f} s {'early' if late_s < 0 else 'late'}"
    ways = [("levels alone", 0.0, lambda series: [np.ones(len(series))], lambda series: test(series) - series.vectors("reference"))]
    for names in (names for number in range(len(further) + 1) for names in combinations(further, number)):
        words, columns = ", ".join(["3×3 and offset", *names]), affine("reference", *(further[name] for name in names))
        ways += [(words, 0.0, columns, test), (words + clock, late_s, columns, test)][:2 if late_s else 1]
    tried, predicted = [], []
    for _, late, columns, y in ways:
        whole = fitted(late)
        one = left(columns, y, *whole.split(share=2 / 3))
        tried.append(np.full(3, np.inf) if one is None else scatter(one))
        predicted.append(left(columns, y, whole, held_out(late)))
    chosen = np.argmin(tried, axis=0)
    return [ways[k][0] for k in chosen], [predicted[k][:, axis] for axis, k in enumerate(chosen)]


def mismatch(series: Series, offset_nt: np.ndarray | float, instrument: str = "sensor") -> np.ndarray:
    """|v + offset| − reference of each row, nT."""
    return np.linalg.norm(series.vectors(instrument) + offset_nt, axis=1) - series["reference_nt"]


def plane(fitted: Series, part: Series, offset_nt: np.ndarray) -> np.ndarray | None:
    """What is left of it by a level and three slopes: to first order all that nine constants do where the field points one way."""
    return left(affine("sensor"), lambda series: mismatch(series, offset_nt), fitted, part)


# Which of the coefficients of xx, yy, zz, xy, xz, yz, x, y, z are alike; those that are zero are left out.
SHAPES = {
    "a sphere by plain least squares": [[0, 1, 2], [6], [7], [8]],
    "an ellipsoid along the axes by plain least squares": [[0], [1], [2], [6], [7], [8]],
    "an ellipsoid by plain least squares": [[k] for k in range(9)],
}


def magnitudes(shape: str, fitted: Series, part: Series, offset_nt: np.ndarray) -> np.ndarray | None:
    """Magnitudes of a part over that of the field, by an ellipsoid fitted to another part; None where it is none.

    (v + o)ᵀ Q (v + o) = F² is solved as vᵀ Q' v + 2 b'ᵀ v = 1; a magnitude is √(vᵀ Q' v + 2 b'ᵀ v + c) / √(1 + c) with c = b'ᵀ Q'⁻¹ b'."""
    size = np.linalg.norm(fitted.vectors("sensor") + offset_nt, axis=1).max()

    def terms(series: Series) -> np.ndarray:
        x, y, z = ((series.vectors("sensor") + offset_nt) / size).T
        return np.array([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z])
    found, solved = np.zeros(9), least_squares([terms(fitted)[group].sum(axis=0) for group in SHAPES[shape]], np.ones(len(fitted)))
    if solved is None:
        return None
    for group, value in zip(SHAPES[shape], solved):
        found[group] = value
    form = found[[[0, 3, 4], [3, 1, 5], [4, 5, 2]]]
    if np.linalg.eigvalsh(form)[0] <= 0:
        return None
    c = found[6:] @ np.linalg.solve(form, found[6:])
    return np.sqrt((found @ terms(part) + c) / (1 + c))


def ellipsoid(fitted: Series, part: Series, offset_nt: np.ndarray) -> np.ndarray | None:
    """Magnitude less that of the field by the full ellipsoid of another part, nT."""
    found = magnitudes("an ellipsoid by plain least squares", fitted, part, offset_nt)
    return None if found is None else fitted["reference_nt"][0] * (found - 1)
