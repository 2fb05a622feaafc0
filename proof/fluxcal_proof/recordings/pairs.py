"""Two vector magnetometers side by side: diffmag's matrix, fitted on one part and held against another."""
from dataclasses import dataclass

import numpy as np

from . import by_hand
from .by_hand import TEMPERATURE
from .page import Page, Prediction, each, number, plus_minus, quantity, three, verdict
from .programs import AXES, DAY_S, Programs, Series, relaxed, rms, scatter

Part = tuple[Series, Series]  # readings of the reference (`reference_*_nt`) and of the test instrument (`test_*_nt`)
PRINTED_NT = 0.0041  # standard uncertainty of the difference of two readings that are each printed to 0.01 nT
SURE = 5  # standard uncertainties beyond which a parameter is one
WILD_NT = 200_000.0  # faults of the balloon's logger: steel on the ground made 89 µT of the Earth's 53 µT


@dataclass
class Matrix:
    """T = R η + d, nT, with what drifts or follows housekeeping."""

    eta: np.ndarray
    offset_nt: dict  # d by axis
    fit: dict
    first_s: float  # of the fitted part
    middle_s: float

    @classmethod
    def found(cls, programs: Programs, time_s: np.ndarray, *recordings: dict, correct_clock: bool = False) -> "Matrix":
        """What diffmag makes of recordings with readings at these times."""
        of = programs.ask("diffmag", ["--correct-clock"] * correct_clock, *recordings)["calibration"]["differential"]
        return cls(np.array(of["matrix"]), of["offset_nt"], of["fit"], time_s[0], time_s[[0, -1]].mean())

    def apart(self, series: Series) -> np.ndarray:
        """T − R η − d of each row, nT."""
        return series.vectors("test") - series.vectors("reference") @ self.eta - [number(self.offset_nt[axis]) for axis in AXES]

    def left(self, series: Series) -> np.ndarray:
        """The same without what goes on."""
        return self.apart(series) - np.column_stack([self._goes_on(self.fit["axes"][axis], series) for axis in AXES])

    def _goes_on(self, axis: dict, series: Series) -> np.ndarray:
        """A straight drift, an exponential decay and the housekeeping columns that an axis follows, nT."""
        told, t = axis.get("drift", {}), series.time_s
        demanded, per_day, decay = told.get("demanded", "none"), number(told.get("straight_nt_per_day")), 0.0
        if demanded in ("exponential", "both"):
            joint = told["joint"]
            per_day = number(joint.get("straight_nt_per_day"))
            decay = number(joint["amplitude_nt"]) * np.exp(-(t - self.first_s) / number(joint["time_constant_s"]))
        elif demanded == "none":
            # What a drift that may be one is expected to bring; beside a column that is followed none is fitted.
            may_be = {} if axis.get("follows") else told.get("explanations", {})
            per_day = number(may_be.get("drift")) * number(may_be.get("straight_nt_per_day"))
        goes_on = per_day / DAY_S * (t - self.middle_s) + decay
        for one in axis.get("follows", []):  # c (x − x₀) + c₂ (x − x₀)², x behind the column by τ
            column = series[one["column"]]
            x = (relaxed(t, column, number(one["lag_s"])) if "lag_s" in one else column) - one["at"]
            goes_on = goes_on + number(one["nt_per_unit"]) * x + number(one.get("nt_per_unit2")) * x**2
        return goes_on

    def finding(self, code: str, of: str = "") -> tuple[str, bool]:
        """The first with a code, and whether there is one."""
        parts = [self.fit, self.fit.get("stability", {})]
        pairs = [pair for part in parts for pair in zip(part.get("finding_codes", []), part.get("findings", []))]
        told = [words for own, words in pairs if own.split(":")[0] == code or own == code]
        return of + (f"“{told[0]}”" if told else "nothing of it"), bool(told)

    def clock(self) -> str:
        offset, rate = self.fit["clock"]["offset_s"], self.fit["clock"]["rate_ppm"]
        late, fast = "late" if number(offset) >= 0 else "early", "fast" if number(rate) >= 0 else "slow"
        return f"{quantity(offset).removeprefix('-')} s {late}, {quantity(rate).removeprefix('-')} ppm {fast}"

    def elements(self, rows: str) -> list[list[str]]:
        """The nine elements with the uncertainty to be quoted, a row an axis of the test instrument."""
        of = self.fit["elements"]
        return [[f"{rows} {j}", *(plus_minus(of[i + j]["weighted"], of[i + j]["weighted_std"]) for i in AXES)] for j in AXES]


def side_by_side(part: Part, late_s: float, rate: float = 0.0, middle_s: float = 0.0) -> Series:
    """Both at the test instrument's own times, whose clock is late by so much: the reference is read that much earlier."""
    reference, test = part[0], part[1].on_clock(part[0].start_s)
    late = late_s + rate * (test.time_s - middle_s)
    return reference.at(test.time_s - late).assign(time_s=test.time_s).joined(test).complete()


def predict(page: Page, hand: tuple[list[str], list[np.ndarray]], left: np.ndarray) -> None:
    """What is left by hand and by the programs, of each axis."""
    ways = [f"{axis}: {way}" for axis, way in zip(AXES, hand[0])]
    page.predictions.append(Prediction(ways, np.array([scatter(one) for one in hand[1]]), scatter(left), why=page.words.get("why", "")))


def study(programs: Programs, page: Page, parts: tuple[Part, Part], correct_clock: bool = True) -> Matrix:
    """Runs diffmag on the first part and shows what its matrix leaves of both."""
    fitted, held_out = page.words["parts"]
    recordings = [series.recording(id, "differential") for series, id in zip(parts[0], ("reference", "test"))]
    raw = [side_by_side(part, 0.0) for part in parts]
    found = Matrix.found(programs, raw[0].time_s, *recordings, correct_clock=correct_clock)
    level_nt = (raw[0].vectors("test") - raw[0].vectors("reference")).mean(axis=0)
    levels = Matrix(np.eye(3), dict(zip(AXES, level_nt)), {}, 0.0, 0.0)
    clock = [correct_clock * number(found.fit["clock"][key]) for key in ("offset_s", "rate_ppm")]
    aligned = [side_by_side(part, clock[0], 1e-6 * clock[1], found.middle_s) for part in parts]
    before, after = [levels.apart(series) for series in raw], [found.left(series) for series in aligned]
    by_parts = [lambda late_s, part=part: side_by_side(part, late_s) for part in parts]
    hand = by_hand.best_of_pair(*by_parts, by_hand.lag(by_parts[0]))
    predict(page, hand, after[1])
    page.table(["test less reference, nT", *AXES], [[what, *map(three, values)] for what, values in [
        (f"{fitted} (fitted): scatter, levels alone", scatter(before[0])), ("… with the matrix", scatter(after[0])),
        (f"{held_out} (held out): scatter, levels alone", scatter(before[1])), ("… by hand", map(scatter, hand[1])),
        ("… with the matrix", scatter(after[1])), ("… its level, levels alone", before[1].mean(axis=0)),
        ("… its level, by hand", map(np.mean, hand[1])), ("… its level, with the matrix", after[1].mean(axis=0))]])
    page.head("pair_head", fitted=fitted, held_out=held_out, after=each(scatter(after[1])), before=each(scatter(before[1])))
    worse = " and ".join(axis for axis, a, b in zip(AXES, scatter(after[1]), scatter(before[1])) if a >= b)
    page.tell("pair_worse" if worse else "pair_better", axes=worse)
    rows = [[*row, quantity(found.offset_nt[axis])] for row, axis in zip(found.elements("test"), AXES)]
    page.table(["", "from reference x", "y", "z", "offset, nT"], rows)
    page.say(f"Clock of the test instrument: {found.clock()}.")
    curves = {what: np.vstack([one.apart(series) for series in aligned]).T for what, one in
              (("levels alone", levels), ("with the matrix", found))}
    panels = {f"{axis}, nT": {what: nt[k] for what, nt in curves.items()} for k, axis in enumerate(AXES)}
    page.plot([series.time_s / 3600 for series in aligned], panels)
    page.say(f"`diffmag` answers: {found.fit['answer']}.")
    page.say("`diffmag` also reports:")
    page.items(found.fit["findings"])
    return found


def read(programs: Programs, reference: str, test: str) -> Part:
    """Two instruments on the clock of the first."""
    reference = programs.read(reference).only("sensor", "reference")
    return reference, programs.read(test).only("sensor", "test").on_clock(reference.start_s)


def conrad(programs: Programs, page: Page) -> None:
    found = study(programs, page, tuple(zip(*(series.split(2 / 3 * DAY_S) for series in read(programs, "fge-2022-08-10", "lemi036")))))
    page.known.append(found.finding("contribution:short_periods"))


def cobenzl(programs: Programs, page: Page) -> None:
    found = study(programs, page, tuple(zip(*(series.split(8 * DAY_S) for series in read(programs, "didd", "lemi025")))))
    early = found.fit["clock"]["offset_s"]
    page.known.append((f"the test instrument's timestamps are {found.clock()}", -early["value"] > SURE * early["std"]))


def meson_hall(programs: Programs, page: Page) -> None:
    """Of the longest stretch without a gap of 30 s."""
    whole = programs.read("meson-hall")
    stretch = np.append(0, np.cumsum(np.diff(whole.time_s) > 30))
    parts = whole.rows(stretch == np.bincount(stretch).argmax()).split(share=2 / 3)
    found = study(programs, page, [(part.only("reference"), part.only("test")) for part in parts], correct_clock=False)
    recordings = [whole.only(role).recording(role, "differential") for role in ("reference", "test")]
    of_whole = Matrix.found(programs, whole.time_s, *recordings)
    page.known.append(of_whole.finding("not_constant", "of the whole run: "))
    page.head("shares", shares=each(np.linalg.norm(found.eta, axis=0)))


def quadrotor(programs: Programs, page: Page) -> None:
    """The file's reference is the test instrument here."""
    series = programs.read("quadrotor")
    repeated = (np.diff(series.vectors("reference"), axis=0) == 0).all(axis=1).sum()
    page.about = {"repeated": repeated, "rows": len(series)}
    study(programs, page, [(part.only("test", "reference"), part.only("reference", "test")) for part in series.split(share=0.5)])


def balloon(programs: Programs, page: Page) -> None:
    """Fitted on the way into the cold, held against the way back, by four explanations; then diagnose."""
    whole = programs.read("balloon")
    wild = np.linalg.norm(whole.vectors("reference"), axis=1) > WILD_NT
    flight = whole.rows(~wild).between(3300, 6900).means(4)  # free flight: from the launch to the release
    warmth = flight[TEMPERATURE]
    fitted, held_out = parts = flight.split(flight.time_s[warmth.argmin()] - 300)
    page.about = {"wild": wild.sum(), "first": three(warmth[0]), "least": three(warmth.min()), "last": three(warmth[-1])}
    explanations = {
        "the matrix alone": [], "with a line in the temperature": [lambda s: s[TEMPERATURE]],
        "with a line in the time": [lambda s: s.time_s], "with a parabola in the time": [lambda s: s.time_s, lambda s: s.time_s**2]}
    rows = []
    for what, further in explanations.items():
        columns = by_hand.affine("reference", *further)
        rows.append([what, *(each(rms(by_hand.left(columns, by_hand.test, fitted, part))) for part in parts)])
        if what.endswith("temperature"):
            slopes = by_hand.least_squares(columns(fitted), by_hand.test(fitted))[-1]
    page.headline += ["Held out, rms of x; y; z in nT:", *(f"{what} {nt};" for what, _, nt in rows)]
    page.say("By least squares of this page's own, rms of x; y; z in nT:")
    page.table(["explanation", "cooling (fitted)", "coldest and warming (held out)"], rows)
    page.tell("slopes", slopes=each(slopes))
    found = Matrix.found(programs, fitted.time_s, fitted.recording("flight", "differential"))
    page.say(f"`diffmag`, fitted to the same part, answers: {found.fit['answer']}.")
    predict(page, by_hand.best_of_pair(lambda _: fitted, lambda _: held_out), found.left(held_out))
    document = programs.ask("diagnose", [], flight.recording("flight", "differential"))
    named = page.diagnosis(document)
    warm = next((one["parameters"] for one in named if "temperature_c" in one.get("column", "")), {})
    slopes = [warm[f"{axis}_nt_per_k"] for axis in AXES if f"{axis}_nt_per_k" in warm]
    axes = sum(abs(one["value"]) > SURE * one["std"] for one in slopes)
    page.known.append((f"the readings follow the temperature in {axes} of three axes", axes == 3))
    page.headline.append(f"`diagnose` {verdict(document)}.")


def boulder(programs: Programs, page: Page) -> None:
    """Between raw and adjusted minutes is one matrix, which diffmag must give back."""
    raw, adjusted = read(programs, "boulder-raw", "boulder-adjusted")
    fitted, held_out = parts = raw.joined(adjusted).complete().split(share=0.5)
    found = Matrix.found(programs, fitted.time_s, fitted.recording("adjusted", "differential"))
    left = [found.apart(part) for part in parts]
    told = [each(rms(one), "{:.4f}".format) for one in left]
    predict(page, by_hand.best_of_pair(lambda _: fitted, lambda _: held_out), left[1])
    page.known.append((f"a matrix that leaves {told[1]} nT where it was not fitted", bool((rms(left[1]) < 1.1 * PRINTED_NT).all())))
    page.table(["", "from H", "E", "Z"], found.elements("adjusted"))
    page.head("comes_back", held_out=told[1])
    page.tell("rounding", fitted=told[0], held_out=told[1], printed=PRINTED_NT)
