"""Sensors turned by hand in a field whose size is taken as constant: what |B| says of nine constants."""
import numpy as np

from . import by_hand
from .page import Page, Prediction, three
from .programs import Programs, Refused
from .scalars import ELLIPSOID, UNDETERMINED, Scalar, study, within
from .series import Series

PHONE_NT = 52_000.0  # as the authors of the phone's runs take it
DATA_SHEET = within(0.05, 3600.0)  # what data sheets of small magnetometers promise: 5 %, and a degree
HALVES = ("first half", "second half")


def middle(series: Series) -> np.ndarray:
    """The middle of the readings of each sensor, nT: roughly where iron and offsets put the centre."""
    readings = series.vectors("sensor")
    return (readings.min(axis=0) + readings.max(axis=0)) / 2


def about(series: Series, centre: np.ndarray) -> np.ndarray:
    return np.linalg.norm(series.vectors("sensor") - centre, axis=1)


def spread(magnitudes: np.ndarray) -> float:
    """Standard deviation over the mean: whatever the scale is."""
    return magnitudes.std() / magnitudes.mean()


def marg_run(programs: Programs, name: str) -> Series:
    return programs.ingest(f"marg-hmc5883l-sunsided/{name}_mag.csv", mapping="ingest/real/marg")


def phone_run(programs: Programs, name: str) -> Series:
    mapping = "vn100" if name.startswith(("vn", "clear")) else "phone"
    return programs.ingest(f"phone-vn100-rotations/{name}.csv", mapping=f"ingest/real/{mapping}").only("sensor")


def by_diagnose(programs: Programs, page: Page, fitted: Series, held_out: Series, names: tuple[str, str], of: str,
                size_nt: float | None = None) -> None:
    """One run fitted, another held out."""
    centre = middle(fitted)
    size_nt = size_nt or about(fitted, centre).mean()
    runs = [series.assign(reference_nt=size_nt) for series in (fitted, held_out)]
    study(programs, page, Scalar(*runs, names, tuple(-centre), ELLIPSOID), of=of)


def marg(programs: Programs, page: Page) -> None:
    """HMC5883L: the fuller sphere fitted, the other held out."""
    full, partial = (marg_run(programs, name).rows(slice(None, None, 8))
                     for name in ("set2_full_sphere", "set1_tilt_sphere"))
    page.about()
    page.head("*Within a run.*")
    page.say("One run, its later part held out:")
    by_diagnose(programs, page, *full.split_share(0.6), ("first 60 %", "last 40 %"), "within a run")
    page.head("*From one run to another.*")
    page.say("One run fitted, another held out:")
    names = ("the full sphere", "the partial sphere, another run")
    by_diagnose(programs, page, full, partial, names, "from one run to another")


def phone(programs: Programs, page: Page) -> None:
    """Phone and VN-100, by themselves and with a magnet, about six readings a second."""
    page.about()
    for what, name, every in [("The phone by itself", "SLACleanMagnetometerUncalibrated", 4),
                              ("The phone, a magnet at 7 cm", "SLA7HardMagnetometerUncalibrated", 4),
                              ("The VN-100 by itself", "clearIMU", 6), ("The VN-100, a magnet at 7 cm", "vn7Hard", 6)]:
        page.head(f"*{what}.*")
        page.say(f"{what}:")
        parts = phone_run(programs, name).rows(slice(None, None, every)).split_share(0.6)
        by_diagnose(programs, page, *parts, ("first 60 %", "last 40 %"), what, PHONE_NT)


def best_by_hand(fitted: Series, part: Series) -> tuple[str, float]:
    """The way that predicts the last third of the fitted part best from its first two thirds, and the spread that
    it leaves of another part."""
    def by(shape: str, fitted: Series, part: Series) -> float:
        if shape not in by_hand.SHAPES:
            return spread(about(part, middle(fitted)))
        found = by_hand.magnitudes(shape, fitted, part, -middle(fitted))
        return np.inf if found is None else spread(found)
    first, last = fitted.split_share(2 / 3)
    ways = {way: by(way, first, last) for way in ("the middles of the ranges", *by_hand.SHAPES)
            if np.isfinite(by(way, fitted, part))}
    way = min(ways, key=ways.get)
    return way, by(way, fitted, part)


def calibrated(programs: Programs, fitted: Series, size_nt: float | None) -> tuple[dict | Refused, str]:
    """scalarcal as a user would run it: as it is, and where it refuses as its own words say."""
    conditions = {"magnitude_nt": size_nt} if size_nt else {}
    arguments = [] if size_nt else ["--constant-magnitude"]
    recording = [fitted.recording("turned", "free_run", **conditions)]
    try:
        return programs.ask("scalarcal", arguments, recording), "as it is"
    except Refused as words:
        if "--known" not in str(words):
            return words, "as it is"
    how = "with --known: alone it refuses, the rotations do not determine the calibration"
    try:
        return programs.ask("scalarcal", [*arguments, "--known"], recording, DATA_SHEET), how
    except Refused as words:
        return words, how


def predict(programs: Programs, page: Page, fitted: tuple[str, Series], part: tuple[str, Series],
            size_nt: float | None, why: str = "") -> list[str]:
    """One part by another: a row of the table, and a prediction."""
    way, hand = best_by_hand(fitted[1], part[1])
    answer, how = calibrated(programs, fitted[1], size_nt)
    size_nt = size_nt or about(fitted[1], middle(fitted[1])).mean()
    if isinstance(answer, Refused):
        told, programs_nt = f"refused: scalarcal: {answer}", None
        why = UNDETERMINED if "do not determine" in str(answer) else ""
    else:
        field = programs.ask("correct", [], [part[1].recording("other", "free_run")],
                             {"calibration": answer["calibration"]})
        found = spread(np.linalg.norm(Series.of(field).vectors("field"), axis=1))
        told, programs_nt = three(100 * found), [found * size_nt]
        added_nt = size_nt * np.sqrt(max(found**2 - hand**2, 0))
        std_nt = max(sensor["offset_nt"].get("std", 0) for sensor in answer["calibration"]["sensors"].values())
        if added_nt <= std_nt:
            why = (f"scalarcal says that an offset may be off by ± {three(std_nt)} nT (standard uncertainty), which is "
                   f"more than the {three(added_nt)} nT that the spread is worse by in the sum of squares")
    page.predictions.append(Prediction([way], [hand * size_nt], programs_nt, f"{fitted[0]} predicts {part[0]}", why))
    return [fitted[0], part[0], f"{way}: {three(100 * hand)}", told, how]


def by_turns(page: Page) -> None:
    """Of the last two predictions, one half by the other and that by the first: where one is worse and has no
    other reason, that the two together are better, if they are."""
    pair = page.predictions[-2:]
    if any(one.programs_nt is None for one in pair):
        return
    if np.hypot(*(one.programs_nt[0] for one in pair)) < np.hypot(*(one.by_hand_nt[0] for one in pair)):
        for one, other in (pair, pair[::-1]):
            one.why = one.why or (
                f"the other way round it is {three(other.by_hand_nt[0])} nT by hand and {three(other.programs_nt[0])} "
                "nT by scalarcal, and the sum of the squares of both is less by scalarcal")


def by_scalarcal(programs: Programs, page: Page, runs: dict[str, Series], pairs: list[tuple[int, int]],
                 size_nt: float | None = None, between: str = "") -> None:
    """Halves of each run by turns, then pairs of runs."""
    page.say(page.words["turned"])
    rows = []
    for name, run in runs.items():
        first, last = ((f"{name}, {half}", part) for half, part in zip(HALVES, run.split_share(0.5)))
        rows += [predict(programs, page, *parts, size_nt) for parts in ((first, last), (last, first))]
        by_turns(page)
    named = list(runs.items())
    rows += [predict(programs, page, named[a], named[b], size_nt, between) for a, b in pairs]
    page.table(["fitted", "held out", "best by hand: spread of the magnitude, % of its mean",
                "scalarcal and correct, %", "how scalarcal was run"], rows)


def marg_scalarcal(programs: Programs, page: Page) -> None:
    page.about()
    runs = {"full sphere": marg_run(programs, "set2_full_sphere"), "partial sphere": marg_run(programs, "set1_tilt_sphere")}
    by_scalarcal(programs, page, runs, [(0, 1), (1, 0)])


def phone_scalarcal(programs: Programs, page: Page) -> None:
    """Runs without and with iron or a magnet, of the phone and of the VN-100."""
    page.about()
    phone = {"phone alone": "SLAClean", "phone, iron at 7 cm": "SLA7Soft", "phone, magnet at 7 cm": "SLA7Hard",
             "phone, iron at 30 cm": "SLA30Soft", "phone, magnet at 30 cm": "SLA30Hard"}
    vn100 = {"VN-100 alone": "clearIMU", "VN-100, iron at 7 cm": "vn7Soft", "VN-100, magnet at 7 cm": "vn7Hard",
             "VN-100, magnet at 30 cm": "vn30Hard"}
    for names, end in ((phone, "MagnetometerUncalibrated"), (vn100, "")):
        runs = {what: phone_run(programs, name + end) for what, name in names.items()}
        pairs = [pair for k in range(1, len(runs)) for pair in ((0, k), (k, 0))]
        by_scalarcal(programs, page, runs, pairs, PHONE_NT, page.words["between"])


def michigan_scalarcal(programs: Programs, page: Page) -> None:
    """Two magnetometers of a quadrotor, and one that was to fly on a balloon."""
    both = programs.ingest("mxl-quadrotor-2021-04-23/test1_esti.csv", mapping="ingest/real/quadrotor")
    balloon = programs.ingest("mxl-balloon-2025-02-22a/preflight_rotation_2025-02-12.csv",
                              mapping="ingest/real/balloon", sort=True).only("sensor")
    page.about()
    by_scalarcal(programs, page, {
        "quadrotor, RM3100": both.only("test").renamed("test", "sensor"),
        "quadrotor, autopilot": both.only("reference").renamed("reference", "sensor"),
        "balloon before the flight, RM3100": balloon.complete()}, [])
