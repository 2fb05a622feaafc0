"""Two vector magnetometers side by side: diffmag's matrix, fitted on one part and held against another."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from . import by_hand
from .page import Page, each, figures, number, plus_minus, quantity
from .plot import svg
from .programs import Programs, Refused
from .series import AXES, Series, rms, scatter

Part = tuple[Series, Series]  # readings of the reference (`reference_*_nt`) and of the test (`test_*_nt`)
DAY_S = 86_400.0


def differences(series: Series, matrix: np.ndarray, offset_nt: np.ndarray) -> np.ndarray:
    """T − R η − d of each row, nT."""
    return series.vectors("test") - series.vectors("reference") @ matrix - offset_nt


def found(document: dict) -> tuple[np.ndarray, np.ndarray]:
    """η and d, nT, as diffmag wrote them."""
    differential = document["calibration"]["differential"]
    return np.array(differential["matrix"]), np.array([number(differential["offset_nt"][a]) for a in AXES])


def levels(series: Series) -> tuple[np.ndarray, np.ndarray]:
    """Axes and scales alike, and the mean levels of a series: what is known before anything is fitted."""
    return np.eye(3), np.nanmean(differences(series, np.eye(3), np.zeros(3)), axis=0)


def fit(document: dict) -> dict:
    return document["calibration"]["differential"]["fit"]


def findings(document: dict, words: str = "") -> list[str]:
    return [finding for finding in fit(document).get("findings", []) if words in finding]


def side_by_side(part: Part, late_s: Callable[[np.ndarray], np.ndarray]) -> Series:
    """Both at the test instrument's own times; the reference's readings are where it was when the test
    instrument's clock said `late_s` of the time more."""
    reference, test = part[0], part[1].on_clock(part[0].start_s)
    moved = reference.at(test.time_s - late_s(test.time_s)).assign(time_s=test.time_s)
    return moved.joined(test).complete()


def drift(document: dict, time_s: np.ndarray) -> Callable[[Series], np.ndarray]:
    """What diffmag found in the fitted part, at `time_s`, and goes on, nT: a straight drift and an exponential
    decay of each axis, and the housekeeping columns that it follows."""
    first_s, middle_s = time_s[0], (time_s[0] + time_s[-1]) / 2

    def of_axis(axis: dict, series: Series) -> np.ndarray:
        told, t = axis.get("drift", {}), series.time_s
        demanded = told.get("demanded", "none")
        per_day, decay = 0.0, np.zeros(len(t))
        if demanded in ("exponential", "both"):
            joint = told["joint"]
            per_day = number(joint.get("straight_nt_per_day"))
            decay = number(joint["amplitude_nt"]) * np.exp(-(t - first_s) / number(joint["time_constant_s"]))
        elif demanded != "none":
            per_day = number(told["straight_nt_per_day"])
        elif not axis.get("follows"):
            # What a drift that may be one is expected to bring; beside a column that is followed none is fitted.
            explanations = told.get("explanations", {})
            per_day = number(explanations.get("drift")) * number(explanations.get("straight_nt_per_day"))
        columns = [followed(one, series) for one in axis.get("follows") or [] if one["column"] in series]
        return per_day / DAY_S * (t - middle_s) + decay + sum(columns)
    axes = fit(document)["axes"]
    return lambda series: np.column_stack([of_axis(axes[axis], series) for axis in AXES])


def followed(one: dict, series: Series) -> np.ndarray:
    """c (x − x₀) + c₂ (x − x₀)², nT, with x behind the column by τ: τ dx/dt = column − x."""
    behind = series[one["column"]].copy()
    if one.get("lag_s"):
        shares = 1 - np.exp(-np.diff(series.time_s) / number(one["lag_s"]))
        for row, share in enumerate(shares, start=1):
            behind[row] = behind[row - 1] + share * (behind[row] - behind[row - 1])
    apart = behind - one["at"]
    return number(one["nt_per_unit"]) * apart + number(one.get("nt_per_unit2")) * apart**2


def study(programs: Programs, page: Page, fitted: Part, held_out: Part, names: tuple[str, str],
          correct_clock: bool = False, plot: str | None = None, why: str = "") -> dict | None:
    """Runs diffmag and shows what its matrix leaves, in the fit and out of it; the document that it wrote."""
    recordings = [fitted[0].recording("reference", "differential"), fitted[1].recording("test", "differential")]
    try:
        document = programs.ask("diffmag", ["--correct-clock"] * correct_clock, recordings)
    except Refused as words:
        page.refused("diffmag", words)
        page.head("`diffmag` refuses.")
        return None
    constants, clock = found(document), fit(document).get("clock") or {}
    parts, raw = (fitted, held_out), [side_by_side(part, lambda t: 0 * t) for part in (fitted, held_out)]
    goes_on, middle_s = drift(document, raw[0].time_s), np.mean(raw[0].time_s[[0, -1]])

    def late_s(t: np.ndarray) -> np.ndarray:
        rate = 1e-6 * number(clock.get("rate_ppm"))
        return correct_clock * (number(clock.get("offset_s")) + rate * (t - middle_s))
    aligned = [side_by_side(part, late_s) for part in parts]
    alike = levels(raw[0])
    before = [differences(series, *alike) for series in raw]
    after = [differences(series, *constants) - goes_on(series) for series in aligned]
    ways, by_hand_left = by_hand.best(*(lambda s, part=part: side_by_side(part, lambda t: s + 0 * t)
                                        for part in parts))
    page.predicts([f"{axis}: {way}" for axis, way in zip(AXES, ways)], by_hand_left,
                  list(scatter(after[1])), why=why)
    hand_scatter, hand_level = ([f(left) for left in by_hand_left] for f in (scatter, np.mean))
    page.table(["test less reference, nT", *AXES], [[what, *each(values).split("; ")] for what, values in [
        (f"{names[0]} (fitted): scatter, levels alone", scatter(before[0])),
        ("… with the matrix", scatter(after[0])),
        (f"{names[1]} (held out): scatter, levels alone", scatter(before[1])),
        ("… by hand", hand_scatter),
        ("… with the matrix", scatter(after[1])),
        ("… its level, levels alone", before[1].mean(axis=0)),
        ("… its level, by hand", hand_level),
        ("… its level, with the matrix", after[1].mean(axis=0)),
    ]])
    page.head(f"On {names[1]}, held out, the matrix fitted to {names[0]} leaves a scatter of "
              f"{each(scatter(after[1]))} nT (x; y; z); levels alone leave {each(scatter(before[1]))} nT.")
    worse = [axis for axis, a, b in zip(AXES, scatter(after[1]), scatter(before[1])) if a >= b]
    page.say(f"The matrix predicts what was held out no better than levels alone in {' and '.join(worse)}." if worse
             else "The matrix predicts the held-out part better than levels alone in every axis.")
    matrix_table(page, document)
    if clock:
        page.say(f"Clock of the test instrument: {clock_in_words(clock)}.")
    if plot:
        curves = [np.vstack([differences(series, *one) for series in aligned]) for one in (alike, constants)]
        panels = {f"{axis}, nT": {"levels alone": curves[0][:, k], "with the matrix": curves[1][:, k]}
                  for k, axis in enumerate(AXES)}
        hours = np.concatenate([series.time_s for series in aligned]) / 3600
        title = f"test less reference; from the dashed line on ({names[1]}) it was held out of the fit"
        page.plot(plot, svg(title, hours, panels, aligned[1].time_s[0] / 3600), "differences before and after")
    if "answer" in fit(document):
        page.say(f"`diffmag` answers: {fit(document)['answer']}.")
    if findings(document):
        page.say("`diffmag` also reports:")
        page.list(findings(document))
    return document


def matrix_table(page: Page, document: dict, rows: str = "test", columns: tuple[str, ...] = (
        "from reference x", "y", "z"), offsets: bool = True) -> None:
    """The nine elements with the uncertainty to be quoted."""
    def element(i: str, j: str) -> str:
        of = fit(document)["elements"][i + j]
        return plus_minus(of["weighted"], of["weighted_std"]) if of.get("weighted_std") else "unknown"
    offset_nt = document["calibration"]["differential"]["offset_nt"]
    page.table(["", *columns] + ["offset, nT"] * offsets, [
        [f"{rows} {j}", *(element(i, j) for i in AXES)] + [quantity(offset_nt[j])] * offsets for j in AXES])


def clock_in_words(clock: dict) -> str:
    """Late or early and fast or slow, with sizes."""
    def words(of: dict, unit: str, above: str, below: str) -> str:
        value, std = of["value"], of["std"]
        decimals = 1 - int(f"{std:.1e}".split("e")[1])
        value, std = (f"{round(one, decimals):.{max(decimals, 0)}f}" for one in (abs(value), std))
        return f"{value} ± {std} {unit} {below if of['value'] < 0 else above}"
    return f"{words(clock['offset_s'], 's', 'late', 'early')}, {words(clock['rate_ppm'], 'ppm', 'fast', 'slow')}"
