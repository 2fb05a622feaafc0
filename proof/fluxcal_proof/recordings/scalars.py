"""A vector magnetometer against a scalar one: the length of the vector less the scalar, before and after what
diagnose and scalarcal found."""
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from . import by_hand
from .by_hand import mismatch
from .page import Page, each, plus_minus, quantity, three, verdict
from .pair import DAY_S
from .plot import svg
from .programs import Programs, Refused
from .series import AXES, Series, rms, scatter

PLANE = "a level and three slopes by plain least squares"
ELLIPSOID = "an ellipsoid by plain least squares"
WAYS = {PLANE: by_hand.plane, ELLIPSOID: by_hand.ellipsoid}
# What data sheets of observatories' fluxgates promise: sensitivities within 0.1 %, axes within 2 mrad; and how
# far a compensation may be off (standard uncertainties).
KNOWN = {"sensitivity": 1e-3, "arcsec": 413.0, "offset_std_nt": 500.0}
OUTLIER_NT, FARTHEST_NT = 20, 300  # of the proton magnetometer: of a difference, of a reading in a storm


@dataclass
class Scalar:
    """A vector (`sensor_*_nt`) and a scalar (`reference_nt`) at the same moments."""

    fitted: Series
    held_out: Series
    names: tuple[str, str]
    offset_nt: tuple[float, float, float] = (0.0, 0.0, 0.0)  # as maker or logger state it, added to the readings
    way: str = PLANE

    def left(self, of: Callable[[Series], np.ndarray]) -> list[np.ndarray]:
        return [of(self.fitted), of(self.held_out)]


def within(sensitivity: float, arcsec: float, offset_nt: tuple[float, float, float] = (0.0, 0.0, 0.0),
           offset_std_nt: float = 0.0) -> dict:
    """What is stated of sensors, with standard uncertainties; offsets without an uncertainty are free."""
    sensors = {axis: {"sensitivity_nt_per_nt": {"value": 1.0, "std": sensitivity},
                      "offset_nt": {"value": nt, "std": offset_std_nt}} for axis, nt in zip(AXES, offset_nt)}
    axes = {"sensors": {"matrix": np.eye(3).tolist(), "std_arcsec": arcsec}}
    return {"calibration": {"sensors": sensors, "axes": axes}}


def corrected(programs: Programs, scalar: Scalar, document: dict) -> list[np.ndarray]:
    """What is left of both parts as `correct` has their field by a document's calibration and model."""
    given = {key: document[key] for key in ("calibration", "model") if document.get(key)}
    return scalar.left(lambda part: mismatch(Series.of(programs.ask(
        "correct", [], [part.recording("vector-scalar", "free_run")], given)), 0.0, "field"))


def study(programs: Programs, page: Page, scalar: Scalar, plot: str | None = None, of: str = "") -> None:
    """Runs diagnose on the fitted part, corrects both parts by what it wrote, and shows what is left."""
    came = scalar.left(lambda part: mismatch(part, scalar.offset_nt))
    all_left = {"as it came": came,
                "the fitted part's level taken off": [nt - came[0].mean() for nt in came]}
    fit = WAYS[scalar.way]
    hand = scalar.left(lambda part: fit(scalar.fitted, part, scalar.offset_nt))
    if hand[0] is not None:
        all_left[scalar.way] = hand
    given = {"calibration": {"sensors": {axis: {"offset_nt": nt} for axis, nt in zip(AXES, scalar.offset_nt)}}}
    document, programs_nt = None, None
    try:
        document = programs.ask("diagnose", ["--refit"], [scalar.fitted.recording("vector-scalar", "free_run")], given)
        nt = corrected(programs, scalar, document)
        programs_nt = [scatter(nt[1])]
        if np.abs(nt[0] - came[0]).max() > 1e-6:
            all_left["corrected by what diagnose wrote"] = nt
    except Refused as words:
        page.refused("correct" if document else "diagnose", words)
    # The level alone, or the constants by hand: what predicts the last third of the fitted part better.
    first, last = scalar.fitted.split_share(2 / 3)
    tried, alone = fit(first, last, scalar.offset_nt), mismatch(last, scalar.offset_nt)
    way = scalar.way if hand[0] is not None and tried is not None and scatter(tried) < scatter(alone) else None
    best = hand[1] if way else all_left["the fitted part's level taken off"][1]
    page.predicts([way or "the level alone"], [best], programs_nt, of=of)
    page.table(["length of the vector less scalar, rms, nT", f"{scalar.names[0]} (fitted)",
                f"{scalar.names[1]} (held out)", "of which level"],
               [[what, three(rms(nt[0])), three(rms(nt[1])), three(nt[1].mean())] for what, nt in all_left.items()])
    if hand[0] is not None:
        level, by_fit = rms(all_left["the fitted part's level taken off"][1]), rms(hand[1])
        page.head(f"Held out, rms: level alone {three(level)} nT, {scalar.way} {three(by_fit)} nT.")
        page.say(f"By hand, the held-out part is predicted {'better than' if by_fit < level else 'no better than'} "
                 "by the level of the fitted part alone.")
    if document:
        refitted = document["diagnosis"][0]["fit"].get("rms_refitted_nt", np.nan)
        page.head(f"`diagnose` refits to {three(refitted)} nT: {verdict(document)}.")
        page.diagnosis(document)
        if "corrected by what diagnose wrote" not in all_left:
            page.say("It wrote no other calibration: what it says of readings held out is its own count.")
    if plot:
        shift_s = scalar.held_out.start_s - scalar.fitted.start_s
        hours = [scalar.fitted.time_s / 3600, (scalar.held_out.time_s + shift_s) / 3600]
        lines = {what: np.concatenate(nt) for what, nt in all_left.items() if what != "as it came"}
        title = f"vector less scalar; from the dashed line on ({scalar.names[1]}) it was held out of the fit"
        page.plot(plot, svg(title, np.concatenate(hours), {"nT": lines}, hours[1][0]), "mismatch before and after")


def by_scalarcal(programs: Programs, page: Page, scalar: Scalar) -> None:
    """scalarcal where the field points one way: as it is, and with what data sheets say."""
    recording = [scalar.fitted.recording("vector-scalar", "free_run")]
    given = within(offset_nt=scalar.offset_nt, **KNOWN)
    try:
        programs.ask("scalarcal", [], recording, given)
        page.say("`scalarcal` takes the field's own changes as rotations enough.")
    except Refused as words:
        page.refused("scalarcal", words)
    last, of = page.predictions[-1], "scalarcal --known"
    stated = ("With `--known`, sensitivities within 0.1 %, angles within 2 mrad, offsets within 500 nT of what is "
              "stated (standard uncertainties)")
    try:
        document = programs.ask("scalarcal", ["--known"], recording, given)
        nt = corrected(programs, scalar, document)
    except Refused as words:
        page.say(f"{stated}:")
        page.refused("scalarcal", words)
        page.predictions.append(page.predictions[-1].__class__(last.ways, last.by_hand_nt, None, of, UNDETERMINED))
        return
    found = document["calibration"]["scalar"]
    offsets = [f"{one['name']} {plus_minus(one['value'], one['std'])}" for one in found.get("parameters", [])
               if one["name"].startswith("offset")]
    page.say(f"{stated}: {', '.join(offsets) + ' nT; ' if offsets else ''}the length less the scalar has an rms of "
             f"{three(rms(nt[0]))} nT where it was fitted, and scatters by {three(scatter(nt[1]))} nT in what was held out.")
    weakest = found.get("weakest", {}).get("words")
    page.list([f"shown least: {weakest}"] * bool(weakest) + found.get("findings", []))
    page.predictions.append(last.__class__(last.ways, last.by_hand_nt, [scatter(nt[1])], of))


UNDETERMINED = "scalarcal refuses: the rotations do not determine the calibration"


def boulder_month(programs: Programs, page: Page) -> None:
    """Twenty days fitted, nine held out; beside the survey's own answer."""
    raw, adjusted = (programs.ingest(f"usgs-bou-2016-01/BOU201601{name}.min").complete().means(600).split(20 * DAY_S)
                     for name in ("vmin", "adj"))
    page.about()
    scalar = Scalar(*raw, ("1 to 20 January", "21 to 29 January"))
    study(programs, page, scalar, "real-boulder-2016.svg")
    by_scalarcal(programs, page, scalar)
    own = [mismatch(part, 0.0) for part in adjusted]
    level = own[0].mean()
    page.say(page.words["adjusted"].format(level=three(level), fitted=three(rms(own[0] - level)),
                                           held_out=three(rms(own[1] - level))))


def boulder_storm(programs: Programs, page: Page) -> None:
    """Four days fitted, three with a storm held out."""
    series = programs.ingest(*programs.files("usgs-bou-2014-11", ".min")).complete()
    page.about()
    scalar = Scalar(*series.means(300).split(4 * DAY_S), ("1 to 4 November", "5 to 7 November"))
    study(programs, page, scalar, "real-boulder-2014.svg")
    by_scalarcal(programs, page, scalar)


def conrad_day(programs: Programs, date: str, step_s: float) -> Series:
    """The suspended fluxgate and the potassium magnetometer of a day, means."""
    vector, scalar = (programs.ingest(f"wic-conrad-2022-08/{name}.csv")
                      for name in (f"fge_s0252_{date}_1s", f"gp20s3_scalar_{date}"))
    scalar = scalar.renamed("sensor", "reference").on_clock(vector.start_s)
    return vector.means(step_s).joined(scalar.means(step_s)).complete()


CONRAD_COMPENSATION_NT = (20_680.0, 0.0, 43_450.0)
VERNADSKY_COMPENSATION_NT = (19_777.5, 5_570.0, -31_837.5)


def conrad(programs: Programs, page: Page) -> None:
    """2022-08-03 fitted, 2022-08-10 held out."""
    dates = ("2022-08-03", "2022-08-10")
    page.about()
    scalar = Scalar(*(conrad_day(programs, date, 60) for date in dates), dates, CONRAD_COMPENSATION_NT)
    study(programs, page, scalar, "real-conrad-scalar.svg")
    by_scalarcal(programs, page, scalar)


def vernadsky(programs: Programs, page: Page) -> None:
    """Sixteen hours fitted, eight held out."""
    series = programs.ingest("aia-vernadsky-2020-03-03/SXY20200303vsec.sec").complete()
    page.about()
    scalar = Scalar(*series.means(60).split(16 * 3600), ("0 to 16 h", "16 to 24 h"), VERNADSKY_COMPENSATION_NT)
    study(programs, page, scalar, "real-vernadsky.svg")
    by_scalarcal(programs, page, scalar)


def clocks_apart_s(line: str) -> float:
    """What the log's clock is ahead of the instrument's in a line `00:00:04  48520,3  0831235932`, s."""
    log, _, instrument = line.split()[:3]
    def second(digits: str) -> int:
        return 3600 * int(digits[:2]) + 60 * int(digits[2:4]) + int(digits[4:6])
    return (second(log.replace(":", "")) - second(instrument[4:]) + 43_200) % 86_400 - 43_200


def centred(proton: Series, shift_s: float = 0.0) -> Series:
    """Means of a minute about the whole minute, as the DIDD gives them, of times that are moved."""
    means = proton.assign(time_s=proton.time_s + shift_s + 30).means(60)
    return means.assign(time_s=means.time_s - 30)


def middle(values: np.ndarray) -> float:
    return np.sort(values)[len(values) // 2]


def cobenzl(programs: Programs, page: Page) -> None:
    """The proton magnetometer against the DIDD's own total field, by shifts of its clock; then by diagnose."""
    folder = "wik-cobenzl-2011-09a"
    didd = programs.ingest(*programs.files(f"{folder}/didd", ".WIK"), mapping="ingest/real/didd")

    def apart_nt(proton: Series, shift_s: float) -> float:
        """Scatter of the DIDD's total field less the proton magnetometer's."""
        joined = didd.joined(centred(proton, shift_s).frame.rename(columns={"reference_nt": "proton_nt"}).pipe(
            Series, didd.start_s))
        nt = joined["reference_nt"] - joined["proton_nt"]
        nt = nt[np.isfinite(nt)]
        return scatter(nt[np.abs(nt - middle(nt)) < OUTLIER_NT])
    page.about()
    days, refusals, rows = {}, {}, []
    for day, file in enumerate(programs.files(f"{folder}/pmag", ".txt"), start=1):
        apart_s = clocks_apart_s((programs.data / file).read_text().splitlines()[0])
        try:
            proton = programs.ingest(file, mapping="ingest/real/proton").on_clock(didd.start_s)
        except Refused as words:
            refusals[day] = words
            continue
        days[day] = proton, apart_s
        shifts = 5 * np.arange(-12, 13)
        nt = np.array([apart_nt(proton, shift) for shift in shifts])
        rows.append((day, apart_s, nt[12], apart_nt(proton, -apart_s), nt.min(), shifts[nt.argmin()]))
    page.say("Standard deviation of the difference, nT, by steps of 5 s (readings farther than "
             f"{OUTLIER_NT} nT from the day's middle are left out):")
    page.table(["day", "log less instrument, s", "by the log, nT", "by the instrument, nT", "least of all shifts"],
               [[f"{day} September", f"{apart:+.0f}", three(log), three(instrument), f"{three(least)} at {shift:+d} s"]
                for day, apart, log, instrument, least, shift in rows])
    fits = sum(instrument > log for _, _, log, instrument, _, _ in rows)
    page.head(f"The field agrees with the log's clock, and not with the instrument's, on {fits} of {len(rows)} days.")
    page.say(f"The log's clock fits better than the instrument's on {fits} of {len(rows)} days.")
    for day, words in refusals.items():
        page.say(f"{day} September:")
        page.refused("ingest", words)
    vector = didd.only("sensor")

    def joined(proton: Series) -> Series:
        near = np.abs(proton["reference_nt"] - middle(proton["reference_nt"])) < FARTHEST_NT
        return vector.joined(centred(proton.rows(near))).complete()
    scalar = Scalar(joined(days[9][0]), joined(days[10][0]), ("9 September, storm", "10 September"))
    study(programs, page, scalar)
    by_scalarcal(programs, page, scalar)
    proton, apart_s = days[9]
    by_instrument = joined(proton.assign(time_s=proton.time_s - apart_s))
    document = programs.ask("diagnose", [], [by_instrument.recording("vector-scalar", "free_run")])
    clocks = [e["parameters"]["offset_s"] for e in document["diagnosis"][0]["effects"] if e["effect"] == "clock_offset"]
    page.knows("the field at Cobenzl, by shifts of the clock",
               "the proton magnetometer's own clock is off by half a minute and more; 9 September by that clock",
               "diagnose", f"`clock_offset` {quantity(clocks[0])} s" if clocks else "no clock named", bool(clocks))
