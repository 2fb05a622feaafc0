"""Two vector magnetometers side by side: diffmag's matrix, fitted on one part and held against another."""
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from . import by_hand
from .page import Page, Prediction, each, figures, number, plus_minus, quantity
from .plot import svg
from .programs import Programs
from .series import AXES, Series, scatter

DAY_S = 86_400.0
Part = tuple[Series, Series]  # readings of the reference (`reference_*_nt`) and of the test instrument (`test_*_nt`)


@dataclass
class Matrix:
    """T = R η + d, nT, with what drifts or follows housekeeping."""

    eta: np.ndarray
    d_nt: np.ndarray
    fit: dict
    time_s: np.ndarray  # first and last of the fitted part

    @classmethod
    def found(cls, document: dict, time_s: np.ndarray) -> "Matrix":
        """As diffmag wrote it, of readings at these times."""
        of = document["calibration"]["differential"]
        return cls(np.array(of["matrix"]), np.array([number(of["offset_nt"][axis]) for axis in AXES]), of["fit"], time_s[[0, -1]])

    def apart(self, series: Series) -> np.ndarray:
        """T − R η − d of each row, nT."""
        return series.vectors("test") - series.vectors("reference") @ self.eta - self.d_nt

    def left(self, series: Series) -> np.ndarray:
        """The same without what goes on."""
        return self.apart(series) - np.column_stack([self._goes_on(self.fit["axes"][axis], series) for axis in AXES])

    def _goes_on(self, axis: dict, series: Series) -> np.ndarray:
        """A straight drift, an exponential decay and the housekeeping columns that an axis follows, nT."""
        told, t = axis.get("drift", {}), series.time_s
        demanded, straight, decay = told.get("demanded", "none"), told.get("straight_nt_per_day"), 0.0
        per_day = number(straight) if demanded != "none" else 0.0
        if demanded in ("exponential", "both"):
            joint = told["joint"]
            per_day = number(joint.get("straight_nt_per_day"))
            decay = number(joint["amplitude_nt"]) * np.exp(-(t - self.time_s[0]) / number(joint["time_constant_s"]))
        elif demanded == "none" and not axis.get("follows"):
            # What a drift that may be one is expected to bring; beside a column that is followed none is fitted.
            may_be = told.get("explanations", {})
            per_day = number(may_be.get("drift")) * number(may_be.get("straight_nt_per_day"))
        columns = [followed(one, series) for one in axis.get("follows", []) if one["column"] in series.frame]
        return per_day / DAY_S * (t - self.time_s.mean()) + decay + sum(columns)

    def findings(self, words: str = "") -> list[str]:
        return [finding for finding in self.fit.get("findings", []) if words in finding]

    def clock_in_words(self) -> str:
        """Late or early and fast or slow, with sizes."""
        def words(of: dict, unit: str, above: str, below: str) -> str:
            value, std = (figures(abs(of[key]), 2, of["std"]) for key in ("value", "std"))
            return f"{value} ± {std} {unit} {below if of['value'] < 0 else above}"
        clock = self.fit["clock"]
        return f"{words(clock['offset_s'], 's', 'late', 'early')}, {words(clock['rate_ppm'], 'ppm', 'fast', 'slow')}"

    def elements(self, rows: str) -> list[list[str]]:
        """The nine elements with the uncertainty to be quoted, a row an axis of the test instrument."""
        of = self.fit["elements"]
        return [[f"{rows} {j}", *(plus_minus(of[i + j]["weighted"], of[i + j]["weighted_std"]) for i in AXES)] for j in AXES]


def alike(series: Series) -> Matrix:
    """Axes and scales alike, and the mean levels of a series: what is known before anything is fitted."""
    level_nt = (series.vectors("test") - series.vectors("reference")).mean(axis=0)
    return Matrix(np.eye(3), level_nt, {}, series.time_s[[0, -1]])


def followed(one: dict, series: Series) -> np.ndarray:
    """c (x − x₀) + c₂ (x − x₀)², nT, with x behind the column by τ: τ dx/dt = column − x."""
    behind = series[one["column"]].copy()
    if "lag_s" in one:
        shares = 1 - np.exp(-np.diff(series.time_s) / number(one["lag_s"]))
        for row, share in enumerate(shares, start=1):
            behind[row] = behind[row - 1] + share * (behind[row] - behind[row - 1])
    apart = behind - one["at"]
    return number(one["nt_per_unit"]) * apart + number(one.get("nt_per_unit2")) * apart**2


def side_by_side(part: Part, late_s: float | Callable[[np.ndarray], np.ndarray]) -> Series:
    """Both at the test instrument's own times; the reference's readings are where it was when the test instrument's clock said so
    much more."""
    reference, test = part[0], part[1].on_clock(part[0].start_s)
    late = late_s(test.time_s) if callable(late_s) else late_s
    return reference.at(test.time_s - late).assign(time_s=test.time_s).joined(test).complete()


def predict(page: Page, hand: tuple[list[str], list[np.ndarray]], left: np.ndarray) -> None:
    """What is left by hand and by the programs, of each axis."""
    ways = [f"{axis}: {way}" for axis, way in zip(AXES, hand[0])]
    page.predictions.append(Prediction(ways, np.array([scatter(one) for one in hand[1]]), scatter(left), why=page.words.get("why", "")))


def study(programs: Programs, page: Page, parts: tuple[Part, Part], clock: bool = False) -> Matrix:
    """Runs diffmag on the first part and shows what its matrix leaves of both; with `clock`, the test instrument's times are corrected
    by what is found."""
    fitted, held_out = page.words["parts"]
    recordings = [series.recording(role, "differential") for series, role in zip(parts[0], ("reference", "test"))]
    document = programs.ask("diffmag", ["--correct-clock"] * clock, *recordings)
    raw = [side_by_side(part, 0.0) for part in parts]
    found, levels = Matrix.found(document, raw[0].time_s), alike(raw[0])

    def late_s(t: np.ndarray) -> np.ndarray:
        told = found.fit["clock"]
        return number(told["offset_s"]) + 1e-6 * number(told["rate_ppm"]) * (t - found.time_s.mean())
    aligned = [side_by_side(part, late_s) for part in parts] if clock else raw
    before, after = [levels.apart(series) for series in raw], [found.left(series) for series in aligned]
    by_parts = [partial(side_by_side, part) for part in parts]
    hand = by_hand.best_of_pair(*by_parts, by_hand.lag(by_parts[0]))
    predict(page, hand, after[1])
    page.table(["test less reference, nT", *AXES], [[what, *each(values).split("; ")] for what, values in [
        (f"{fitted} (fitted): scatter, levels alone", scatter(before[0])), ("… with the matrix", scatter(after[0])),
        (f"{held_out} (held out): scatter, levels alone", scatter(before[1])), ("… by hand", map(scatter, hand[1])),
        ("… with the matrix", scatter(after[1])), ("… its level, levels alone", before[1].mean(axis=0)),
        ("… its level, by hand", map(np.mean, hand[1])), ("… its level, with the matrix", after[1].mean(axis=0))]])
    page.head("pair_head", fitted=fitted, held_out=held_out, after=each(scatter(after[1])), before=each(scatter(before[1])))
    worse = [axis for axis, a, b in zip(AXES, scatter(after[1]), scatter(before[1])) if a >= b]
    page.tell("pair_worse" if worse else "pair_better", axes=" and ".join(worse))
    offsets = [quantity(document["calibration"]["differential"]["offset_nt"][axis]) for axis in AXES]
    page.table(["", "from reference x", "y", "z", "offset, nT"], [[*row, nt] for row, nt in zip(found.elements("test"), offsets)])
    page.say(f"Clock of the test instrument: {found.clock_in_words()}.")
    if "plot" in page.words:
        curves = {what: np.vstack([one.apart(series) for series in aligned]) for what, one in
                  (("levels alone", levels), ("with the matrix", found))}
        panels = {f"{axis}, nT": {what: nt[:, k] for what, nt in curves.items()} for k, axis in enumerate(AXES)}
        svg(page, [series.time_s / 3600 for series in aligned], panels)
    page.say(f"`diffmag` answers: {found.fit['answer']}.")
    if found.findings():
        page.say("`diffmag` also reports:")
        page.items(found.findings())
    return found
