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
MARG = {"full sphere": "set2_full_sphere", "partial sphere": "set1_tilt_sphere"}
PHONE = {"phone alone": "SLAClean", "phone, iron at 7 cm": "SLA7Soft", "phone, magnet at 7 cm": "SLA7Hard",
         "phone, iron at 30 cm": "SLA30Soft", "phone, magnet at 30 cm": "SLA30Hard"}
VN100 = {"VN-100 alone": "clearIMU", "VN-100, iron at 7 cm": "vn7Soft", "VN-100, magnet at 7 cm": "vn7Hard",
         "VN-100, magnet at 30 cm": "vn30Hard"}


def read_marg(programs: Programs) -> dict[str, Series]:
    return {what: programs.ingest(f"marg-hmc5883l-sunsided/{name}_mag.csv", mapping="ingest/real/marg") for what, name in MARG.items()}


def read_phone(programs: Programs, name: str) -> Series:
    mapping, end = ("phone", "MagnetometerUncalibrated") if name.startswith("SLA") else ("vn100", "")
    return programs.ingest(f"phone-vn100-rotations/{name}{end}.csv", mapping=f"ingest/real/{mapping}").only("sensor")


def middle(series: Series) -> np.ndarray:
    """The middle of the readings of each sensor, nT: roughly where iron and offsets put the centre."""
    readings = series.vectors("sensor")
    return (readings.min(axis=0) + readings.max(axis=0)) / 2


def about_middle(fitted: Series, part: Series) -> np.ndarray:
    """Lengths of the readings of a part about the middle of another, nT."""
    return np.linalg.norm(part.vectors("sensor") - middle(fitted), axis=1)


def one_by_another(programs: Programs, page: Page, what: str, parts: tuple[Series, Series], names: tuple[str, str], size_nt: float) -> None:
    """A part that is fitted and one held out, beside the constant size of the field, by diagnose."""
    page.headline.append(f"*{what}.*")
    page.say(f"{what}:")
    sized = tuple(part.assign(reference_nt=size_nt) for part in parts)
    by_diagnose(programs, page, Scalar(sized, -middle(parts[0]), ELLIPSOID), names, what)


def marg(programs: Programs, page: Page) -> None:
    """Within a run, and from one run to another."""
    full, partial = (run.rows(slice(None, None, 8)) for run in read_marg(programs).values())
    for (what, *names), parts in zip(page.words["runs"], (full.split(share=0.6), (full, partial))):
        one_by_another(programs, page, what, parts, names, about_middle(parts[0], parts[0]).mean())


def phone(programs: Programs, page: Page) -> None:
    """About six readings a second."""
    for what, name, every in [("The phone by itself", "SLAClean", 4), ("The phone, a magnet at 7 cm", "SLA7Hard", 4),
                              ("The VN-100 by itself", "clearIMU", 6), ("The VN-100, a magnet at 7 cm", "vn7Hard", 6)]:
        parts = read_phone(programs, name).rows(slice(None, None, every)).split(share=0.6)
        one_by_another(programs, page, what, parts, page.words["parts"], PHONE_NT)


def spread(magnitudes: np.ndarray | None) -> float:
    """Standard deviation over the mean: whatever the scale is."""
    return np.inf if magnitudes is None else magnitudes.std() / magnitudes.mean()


def best_by_hand(fitted: Series, part: Series) -> tuple[str, float]:
    """The way that predicts the last third of the fitted part best from its first two thirds, and the spread of the magnitude that it
    leaves of another part."""
    def by(way: str, fitted: Series, part: Series) -> float:
        return spread(about_middle(fitted, part) if way == RANGES else by_hand.magnitudes(way, fitted, part, -middle(fitted)))
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
    size_nt = size_nt or about_middle(fitted, fitted).mean()
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


def by_turns(page: Page, halves: list[Prediction]) -> None:
    """Two halves that predict each other: where one is worse, that the two together are better, if they are."""
    told = [[one.by_hand_nt[0], np.inf if one.programs_nt is None else one.programs_nt[0]] for one in halves]
    hand, programs = np.hypot(*told)
    for one, other in zip(halves, told[::-1]):
        if programs < hand and not one.why:
            one.why = page.words["turns"].format(hand=three(other[0]), programs=three(other[1]))


def by_scalarcal(programs: Programs, page: Page, runs: dict[str, Series], size_nt: float | None = None, pairs: bool = True) -> None:
    """Halves of each run by turns; then the first run and each other."""
    (alone, first), *others = runs.items()
    rows = []
    for what, run in runs.items():
        halves, names = run.split(share=0.5), (f"{what}, first half", f"{what}, second half")
        rows += [predict(programs, page, names[::way], *halves[::way], size_nt) for way in (1, -1)]
        by_turns(page, page.predictions[-2:])
    for what, other in others * pairs:
        names, parts = (alone, what), (first, other)
        rows += [predict(programs, page, names[::way], *parts[::way], size_nt, page.words["between"]) for way in (1, -1)]
    page.table(["fitted", "held out", "best by hand: spread of the magnitude, % of its mean", "scalarcal and correct, %",
                "how scalarcal was run"], rows)


def marg_scalarcal(programs: Programs, page: Page) -> None:
    by_scalarcal(programs, page, read_marg(programs))


def phone_scalarcal(programs: Programs, page: Page) -> None:
    for names in (PHONE, VN100):
        by_scalarcal(programs, page, {what: read_phone(programs, name) for what, name in names.items()}, PHONE_NT)


def michigan_scalarcal(programs: Programs, page: Page) -> None:
    both = programs.ingest("mxl-quadrotor-2021-04-23/test1_esti.csv", mapping="ingest/real/quadrotor")
    balloon = programs.ingest("mxl-balloon-2025-02-22a/preflight_rotation_2025-02-12.csv", mapping="ingest/real/balloon", sort=True)
    by_scalarcal(programs, page, {
        "quadrotor, RM3100": both.only("test", "sensor"), "quadrotor, autopilot": both.only("reference", "sensor"),
        "balloon before the flight, RM3100": balloon.only("sensor").complete()}, pairs=False)
