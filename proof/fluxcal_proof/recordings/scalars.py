"""A vector magnetometer against a scalar one: the length of the vector less the scalar, before and after diagnose and scalarcal."""
from typing import NamedTuple

import numpy as np

from . import by_hand
from .by_hand import mismatch
from .page import Page, Prediction, effects, plus_minus, quantity, three, verdict
from .programs import Programs, Refused
from .series import AXES, DAY_S, Series, rms, scatter

NONE, CONRAD_NT, VERNADSKY_NT = np.zeros(3), np.array([20_680.0, 0.0, 43_450.0]), np.array([19_777.5, 5_570.0, -31_837.5])  # compensations
WAYS = {"a level and three slopes by plain least squares": by_hand.plane, "an ellipsoid by plain least squares": by_hand.ellipsoid}
PLANE, ELLIPSOID = WAYS
LEVEL, CORRECTED = "the fitted part's level taken off", "corrected by what diagnose wrote"
UNDETERMINED = "scalarcal refuses: the rotations do not determine the calibration"
OUTLIER_NT, FARTHEST_NT = 20, 300  # of the proton magnetometer: of a difference, of a reading in a storm


class Scalar(NamedTuple):
    """A vector (`sensor_*_nt`) and a scalar (`reference_nt`) at the same moments: a part that is fitted, and one held out."""

    parts: tuple[Series, Series]
    offset_nt: np.ndarray = NONE  # as maker or logger state it, added to the readings
    way: str = PLANE


def recording(part: Series) -> dict:
    return part.recording("vector-scalar", "free_run")


def corrected(programs: Programs, parts: tuple[Series, Series], document: dict) -> list[np.ndarray]:
    """What is left of parts as `correct` has their field by a document's calibration and model, nT."""
    given = {key: document[key] for key in ("calibration", "model") if key in document}
    fields = (Series.of(programs.ask("correct", [], recording(part), given=given)) for part in parts)
    return [mismatch(field, 0.0, "field") for field in fields]


def within(sensitivity: float, arcsec: float, offset_nt: np.ndarray = NONE, offset_std_nt: float = 0.0) -> dict:
    """What is stated of sensors, with standard uncertainties; offsets without an uncertainty are free."""
    sensors = {axis: {"sensitivity_nt_per_nt": {"value": 1.0, "std": sensitivity}, "offset_nt": {"value": nt, "std": offset_std_nt}}
               for axis, nt in zip(AXES, offset_nt)}
    return {"calibration": {"sensors": sensors, "axes": {"sensors": {"matrix": np.eye(3).tolist(), "std_arcsec": arcsec}}}}


def by_diagnose(programs: Programs, page: Page, scalar: Scalar, names: tuple[str, str], of: str = "") -> None:
    """Runs diagnose on the fitted part, corrects both parts by what it wrote, and shows what is left, nT."""
    parts, offset_nt, way = scalar
    came, hand = [mismatch(part, offset_nt) for part in parts], [WAYS[way](parts[0], part, offset_nt) for part in parts]
    nt = {"as it came": came, LEVEL: [one - came[0].mean() for one in came]} | ({} if hand[0] is None else {way: hand})
    sensors = {axis: {"offset_nt": offset} for axis, offset in zip(AXES, offset_nt)}
    document = programs.ask("diagnose", ["--refit"], recording(parts[0]), given={"calibration": {"sensors": sensors}})
    after = corrected(programs, parts, document)
    if np.abs(after[0] - came[0]).max() > 1e-6:
        nt[CORRECTED] = after
    # The level alone, or the constants by hand: what predicts the last third of the fitted part better.
    first, last = parts[0].split(share=2 / 3)
    tried = WAYS[way](first, last, offset_nt)
    alone = way not in nt or tried is None or scatter(tried) >= scatter(mismatch(last, offset_nt))
    best, ways = scatter(nt[LEVEL if alone else way][1]), ["the level alone" if alone else way]
    page.predictions.append(Prediction(ways, np.array([best]), np.array([scatter(after[1])]), of))
    page.table(["length of the vector less scalar, rms, nT", f"{names[0]} (fitted)", f"{names[1]} (held out)", "of which level"],
               [[what, *map(three, map(rms, left)), three(left[1].mean())] for what, left in nt.items()])
    if way in nt:
        level, fit = rms(nt[LEVEL][1]), rms(hand[1])
        page.head("scalar_head", alone=three(level), way=way, hand=three(fit))
        page.tell("by_hand_better" if fit < level else "by_hand_no_better")
    page.head("refits", nt=three(document["diagnosis"][0]["fit"]["rms_refitted_nt"]), verdict=verdict(document))
    page.diagnosis(document)
    if CORRECTED not in nt:
        page.tell("unmoved")
    lines = {what: np.concatenate(left) for what, left in nt.items() if what != "as it came"}
    page.plot([part.on_clock(parts[0].start_s).time_s / 3600 for part in parts], {"nT": lines})


def by_scalarcal(programs: Programs, page: Page, scalar: Scalar) -> None:
    """scalarcal where the field points one way: as it is, and with what data sheets of observatories' fluxgates say."""
    known, last, fitted = within(1e-3, 413.0, scalar.offset_nt, 500.0), page.predictions[-1], recording(scalar.parts[0])
    one = Prediction(last.ways, last.by_hand_nt, None, "scalarcal --known", UNDETERMINED)
    page.predictions.append(one)
    try:
        programs.ask("scalarcal", [], fitted, given=known)
        page.tell("rotations_enough")
    except Refused as refusal:
        page.refused(refusal)
    try:
        document = programs.ask("scalarcal", ["--known"], fitted, given=known)
        left = corrected(programs, scalar.parts, document)
    except Refused as refusal:
        page.tell("with_known", told="")
        page.refused(refusal)
        return
    one.programs_nt, one.why, found = np.array([scatter(left[1])]), "", document["calibration"]["scalar"]
    offsets = [f"{of['name']} {plus_minus(of['value'], of['std'])}" for of in found["parameters"] if of["name"].startswith("offset")]
    told = page.words["known_leaves"].format(rms=three(rms(left[0])), scatter=three(scatter(left[1])))
    page.tell("with_known", told=f" {', '.join(offsets)} nT;" * bool(offsets) + told)
    weakest = found.get("weakest", {}).get("words")
    page.items([f"shown least: {weakest}"] * bool(weakest) + found.get("findings", []))


def study(programs: Programs, page: Page, parts: tuple[Series, Series], offset_nt: np.ndarray = NONE) -> None:
    by_diagnose(programs, page, Scalar(parts, offset_nt), page.words["parts"])
    by_scalarcal(programs, page, Scalar(parts, offset_nt))


def read_boulder(programs: Programs, name: str = "vmin") -> Series:
    return programs.ingest(f"usgs-bou-2016-01/BOU201601{name}.min").complete()


def read_conrad(programs: Programs, date: str, step_s: float) -> Series:
    """A suspended fluxgate and a potassium magnetometer, means of a day."""
    vector, scalar = (programs.ingest(f"wic-conrad-2022-08/{name}.csv") for name in (f"fge_s0252_{date}_1s", f"gp20s3_scalar_{date}"))
    return vector.means(step_s).joined(scalar.on_clock(vector.start_s).means(step_s)).complete()


def read_vernadsky(programs: Programs) -> Series:
    return programs.ingest("aia-vernadsky-2020-03-03/SXY20200303vsec.sec").complete()


def boulder_month(programs: Programs, page: Page) -> None:
    """Beside it the survey's own answer."""
    study(programs, page, read_boulder(programs).means(600).split(20 * DAY_S))
    fitted, held_out = (mismatch(part, 0.0) for part in read_boulder(programs, "adj").means(600).split(20 * DAY_S))
    level = fitted.mean()
    page.tell("adjusted", level=three(level), fitted=three(rms(fitted - level)), held_out=three(rms(held_out - level)))


def boulder_storm(programs: Programs, page: Page) -> None:
    study(programs, page, programs.ingest(*programs.files("usgs-bou-2014-11", ".min")).complete().means(300).split(4 * DAY_S))


def conrad(programs: Programs, page: Page) -> None:
    study(programs, page, tuple(read_conrad(programs, date, 60) for date in page.words["parts"]), CONRAD_NT)


def vernadsky(programs: Programs, page: Page) -> None:
    study(programs, page, read_vernadsky(programs).means(60).split(16 * 3600), VERNADSKY_NT)


def clocks_apart_s(line: str) -> float:
    """What the log's clock is ahead of the instrument's in a line `00:00:04  48520,3  0831235932`, s."""
    log, _, instrument = line.replace(":", "").split()[:3]
    hours, minutes, seconds = (int(log[k:k + 2]) - int(instrument[4 + k:6 + k]) for k in (0, 2, 4))
    return (3600 * hours + 60 * minutes + seconds + 43_200) % 86_400 - 43_200


def centred(proton: Series, shift_s: float = 0.0) -> Series:
    """Means of a minute about the whole minute, as the DIDD gives them, of times that are moved."""
    means = proton.assign(time_s=proton.time_s + shift_s + 30).means(60)
    return means.assign(time_s=means.time_s - 30)


def near(values: np.ndarray, within_nt: float) -> np.ndarray:
    """Which are near the middle one."""
    return np.abs(values - np.sort(values)[np.isfinite(values).sum() // 2]) < within_nt


def cobenzl(programs: Programs, page: Page) -> None:
    """A proton magnetometer against the DIDD's own total field, by shifts of its clock; then two days by diagnose."""
    didd = programs.ingest(*programs.files("wik-cobenzl-2011-09a/didd", ".WIK"), mapping="ingest/real/didd")
    vector, total = didd.only("sensor"), Series(didd.frame[["time_s"]].assign(didd_nt=didd["reference_nt"]), didd.start_s)

    def apart_nt(proton: Series, shift_s: float) -> float:
        both = total.joined(centred(proton, shift_s))
        nt = both["didd_nt"] - both["reference_nt"]
        return scatter(nt[near(nt, OUTLIER_NT)])

    def joined(proton: Series) -> Series:
        return vector.joined(centred(proton.rows(near(proton["reference_nt"], FARTHEST_NT)))).complete()
    days, refusals, rows, fits = {}, {}, [], 0
    for day, file in enumerate(programs.files("wik-cobenzl-2011-09a/pmag", ".txt"), start=1):
        try:
            proton = programs.ingest(file, mapping="ingest/real/proton").on_clock(didd.start_s)
        except Refused as refusal:
            refusals[f"{day} September:"] = refusal
            continue
        apart_s = clocks_apart_s((programs.data / file).read_text().splitlines()[0])
        nt, own = {shift: apart_nt(proton, shift) for shift in range(-60, 61, 5)}, apart_nt(proton, -apart_s)
        best = min(nt, key=nt.get)
        days[day], fits = (proton, apart_s), fits + (own > nt[0])
        rows.append([f"{day} September", f"{apart_s:+.0f}", three(nt[0]), three(own), f"{three(nt[best])} at {best:+d} s"])
    page.tell("shifts", outlier=OUTLIER_NT)
    page.table(["day", "log less instrument, s", "by the log, nT", "by the instrument, nT", "least of all shifts"], rows)
    page.head("log_agrees", fits=fits, days=len(rows))
    page.tell("log_fits", fits=fits, days=len(rows))
    for day, refusal in refusals.items():
        page.say(day)
        page.refused(refusal)
    study(programs, page, (joined(days[9][0]), joined(days[10][0])))
    proton, apart_s = days[9]
    document = programs.ask("diagnose", [], recording(joined(proton.assign(time_s=proton.time_s - apart_s))))
    clocks = [one["parameters"]["offset_s"] for one in effects(document) if one["effect"] == "clock_offset"]
    page.known.append((f"`clock_offset` {quantity(clocks[0])} s" if clocks else "no clock named", bool(clocks)))
