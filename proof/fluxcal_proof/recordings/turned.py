"""Sensors turned by hand in a field whose size is taken as constant: what |B| says of nine constants."""
import numpy as np

from . import by_hand
from .page import Page, Prediction, three
from .programs import Programs, Refused
from .scalars import ELLIPSOID, UNDETERMINED, Scalar, by_diagnose, within
from .series import Series

PHONE_NT = 52_000.0  # as the authors of the phone's runs take it
DATA_SHEET = within(0.05, 3600.0)  # what data sheets of small magnetometers promise: 5 %, and a degree
RANGES = "the middles of the ranges"
PHONE = {"phone alone": "SLAClean", "phone, iron at 7 cm": "SLA7Soft", "phone, magnet at 7 cm": "SLA7Hard",
         "phone, iron at 30 cm": "SLA30Soft", "phone, magnet at 30 cm": "SLA30Hard"}
VN100 = {"VN-100 alone": "clearIMU", "VN-100, iron at 7 cm": "vn7Soft", "VN-100, magnet at 7 cm": "vn7Hard",
         "VN-100, magnet at 30 cm": "vn30Hard"}
MARG = {"full sphere": "set2_full_sphere", "partial sphere": "set1_tilt_sphere"}


def middle(series: Series) -> np.ndarray:
    """The middle of the readings of each sensor, nT: roughly where iron and offsets put the centre."""
    readings = series.vectors("sensor")
    return (readings.min(axis=0) + readings.max(axis=0)) / 2


def about(series: Series, centre: np.ndarray) -> np.ndarray:
    return np.linalg.norm(series.vectors("sensor") - centre, axis=1)


def mean_nt(series: Series) -> float:
    return about(series, middle(series)).mean()


def read_marg(programs: Programs, name: str) -> Series:
    return programs.ingest(f"marg-hmc5883l-sunsided/{name}_mag.csv", mapping="ingest/real/marg")


def read_phone(programs: Programs, name: str) -> Series:
    mapping, end = ("phone", "MagnetometerUncalibrated") if name.startswith("SLA") else ("vn100", "")
    return programs.ingest(f"phone-vn100-rotations/{name}{end}.csv", mapping=f"ingest/real/{mapping}").only("sensor")


def sized(parts: tuple[Series, Series], size_nt: float) -> Scalar:
    """A part that is fitted and one held out, beside the constant size of the field."""
    return Scalar(*(part.assign(reference_nt=size_nt) for part in parts), -middle(parts[0]), ELLIPSOID)


def marg(programs: Programs, page: Page) -> None:
    """Within a run, and from one run to another."""
    full, partial = (read_marg(programs, name).rows(slice(None, None, 8)) for name in MARG.values())
    for (head, *names), parts in zip(page.words["runs"], (full.split(share=0.6), (full, partial))):
        page.headline.append(f"*{head}.*")
        page.say(f"{head}:")
        by_diagnose(programs, page, sized(parts, mean_nt(parts[0])), names, head.lower())


def phone(programs: Programs, page: Page) -> None:
    """About six readings a second."""
    for what, name, every in [("The phone by itself", "SLAClean", 4), ("The phone, a magnet at 7 cm", "SLA7Hard", 4),
                              ("The VN-100 by itself", "clearIMU", 6), ("The VN-100, a magnet at 7 cm", "vn7Hard", 6)]:
        page.headline.append(f"*{what}.*")
        page.say(f"{what}:")
        parts = read_phone(programs, name).rows(slice(None, None, every)).split(share=0.6)
        by_diagnose(programs, page, sized(parts, PHONE_NT), page.words["parts"], what)


def spread(magnitudes: np.ndarray | None) -> float:
    """Standard deviation over the mean: whatever the scale is."""
    return np.inf if magnitudes is None else magnitudes.std() / magnitudes.mean()


def best_by_hand(fitted: Series, part: Series) -> tuple[str, float]:
    """The way that predicts the last third of the fitted part best from its first two thirds, and the spread of the magnitude that it
    leaves of another part."""
    def by(way: str, fitted: Series, part: Series) -> float:
        centre = middle(fitted)
        return spread(about(part, centre) if way == RANGES else by_hand.magnitudes(way, fitted, part, -centre))
    tried = {way: by(way, *fitted.split(share=2 / 3)) for way in (RANGES, *by_hand.SHAPES) if np.isfinite(by(way, fitted, part))}
    way = min(tried, key=tried.get)
    return way, by(way, fitted, part)


def predict(programs: Programs, page: Page, names: tuple[str, str], fitted: Series, part: Series, size_nt: float | None,
            why: str = "") -> list[str]:
    """scalarcal as a user would run it, as it is and where it refuses as its own words say: a row of the table of one part that
    predicts another, and a prediction."""
    way, hand = best_by_hand(fitted, part)
    arguments, how = [] if size_nt else ["--constant-magnitude"], "as it is"
    turned = fitted.recording("turned", "free_run", **{"magnitude_nt": size_nt} if size_nt else {})
    size_nt = size_nt or mean_nt(fitted)
    one = Prediction([way], np.array([hand * size_nt]), None, " predicts ".join(names), why)
    page.predictions.append(one)
    try:
        try:
            calibration = programs.ask("scalarcal", arguments, turned)["calibration"]
        except Refused as refusal:
            if "--known" not in str(refusal):
                raise
            how = "with --known: alone it refuses, the rotations do not determine the calibration"
            calibration = programs.ask("scalarcal", [*arguments, "--known"], turned, given=DATA_SHEET)["calibration"]
        other = programs.ask("correct", [], part.recording("other", "free_run"), given={"calibration": calibration})
        found = spread(np.linalg.norm(Series.of(other).vectors("field"), axis=1))
        told, one.programs_nt = three(100 * found), np.array([found * size_nt])
        added_nt = size_nt * np.sqrt(max(found**2 - hand**2, 0))
        std_nt = max(sensor["offset_nt"].get("std", 0) for sensor in calibration["sensors"].values())
        if added_nt <= std_nt:
            one.why = page.words["offset_std"].format(std=three(std_nt), added=three(added_nt))
    except Refused as refusal:
        told, one.why = f"refused: {refusal.program}: {refusal}", UNDETERMINED if "do not determine" in str(refusal) else ""
    return [*names, f"{way}: {three(100 * hand)}", told, how]


def by_turns(page: Page, one: Prediction, other: Prediction) -> None:
    """Two halves that predict each other: where one is worse, that the two together are better, if they are."""
    both = [one, other]
    if all(this.programs_nt is not None for this in both) and (
            np.hypot(*(this.programs_nt[0] for this in both)) < np.hypot(*(this.by_hand_nt[0] for this in both))):
        for this, that in (both, both[::-1]):
            this.why = this.why or page.words["turns"].format(hand=three(that.by_hand_nt[0]), programs=three(that.programs_nt[0]))


def by_scalarcal(programs: Programs, page: Page, runs: dict[str, Series], pairs: bool = True, size_nt: float | None = None) -> None:
    """Halves of each run by turns; then the first run and each other."""
    rows = []
    for what, run in runs.items():
        (first, last), names = run.split(share=0.5), (f"{what}, first half", f"{what}, second half")
        rows.append(predict(programs, page, names, first, last, size_nt))
        rows.append(predict(programs, page, names[::-1], last, first, size_nt))
        by_turns(page, *page.predictions[-2:])
    (alone, first), *others = runs.items()
    for what, other in others * pairs:
        rows.append(predict(programs, page, (alone, what), first, other, size_nt, page.words["between"]))
        rows.append(predict(programs, page, (what, alone), other, first, size_nt, page.words["between"]))
    page.table(["fitted", "held out", "best by hand: spread of the magnitude, % of its mean", "scalarcal and correct, %",
                "how scalarcal was run"], rows)


def marg_scalarcal(programs: Programs, page: Page) -> None:
    by_scalarcal(programs, page, {what: read_marg(programs, name) for what, name in MARG.items()})


def phone_scalarcal(programs: Programs, page: Page) -> None:
    for names in (PHONE, VN100):
        by_scalarcal(programs, page, {what: read_phone(programs, name) for what, name in names.items()}, size_nt=PHONE_NT)


def michigan_scalarcal(programs: Programs, page: Page) -> None:
    both = programs.ingest("mxl-quadrotor-2021-04-23/test1_esti.csv", mapping="ingest/real/quadrotor")
    balloon = programs.ingest("mxl-balloon-2025-02-22a/preflight_rotation_2025-02-12.csv", mapping="ingest/real/balloon", sort=True)
    by_scalarcal(programs, page, {
        "quadrotor, RM3100": both.only("test", "sensor"), "quadrotor, autopilot": both.only("reference", "sensor"),
        "balloon before the flight, RM3100": balloon.only("sensor").complete()}, pairs=False)
