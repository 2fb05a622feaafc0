"""The length of a vector: against a scalar magnetometer, or in a field of constant size in which sensors were turned by hand."""
import numpy as np

from . import by_hand
from .by_hand import mismatch
from .page import Page, Prediction, plus_minus, quantity, three, verdict
from .programs import AXES, DAY_S, Programs, Refused, Series, rms, scatter

NONE, CONRAD_NT, VERNADSKY_NT = np.zeros(3), np.array([20_680.0, 0.0, 43_450.0]), np.array([19_777.5, 5_570.0, -31_837.5])  # compensations
WAYS = {"a level and three slopes by plain least squares": by_hand.plane, "an ellipsoid by plain least squares": by_hand.ellipsoid}
PLANE, ELLIPSOID = WAYS
LEVEL = "the fitted part's level taken off"
UNDETERMINED = "scalarcal refuses: the rotations do not determine the calibration"
FARTHEST_NT = 300  # of a reading of the proton magnetometer from the middle one: a storm stays within
CLOCKS_APART_S = 38  # what its log's clock is ahead of its own on 9 September, by the first line of the file
RANGES = "the middles of the ranges"


def corrected(programs: Programs, parts: tuple[Series, Series], document: dict) -> list[np.ndarray]:
    """What is left of parts as `correct` has their field by a document's calibration and model, nT."""
    given = {key: document[key] for key in ("calibration", "model") if key in document}
    fields = (Series.of(programs.ask("correct", [], part.recording("vector-scalar", "free_run"), given=given)) for part in parts)
    return [mismatch(field, 0.0, "field") for field in fields]


def within(sensitivity: float, arcsec: float, offset_nt: np.ndarray = NONE, offset_std_nt: float = 0.0) -> dict:
    """What is stated of sensors, with standard uncertainties; offsets without an uncertainty are free."""
    sensors = {axis: {"sensitivity_nt_per_nt": {"value": 1.0, "std": sensitivity}, "offset_nt": {"value": nt, "std": offset_std_nt}}
               for axis, nt in zip(AXES, offset_nt)}
    return {"calibration": {"sensors": sensors, "axes": {"sensors": {"matrix": np.eye(3).tolist(), "std_arcsec": arcsec}}}}


def by_diagnose(programs: Programs, page: Page, parts: tuple[Series, Series], names: tuple[str, str], offset_nt: np.ndarray,
                way: str = PLANE, of: str = "") -> None:
    """Runs diagnose on the first of two parts with a vector (`sensor_*_nt`) and a scalar (`reference_nt`), corrects both by what it wrote,
    and shows what is left, nT; the offset is as maker or logger state it, added to the readings."""
    came, hand = [mismatch(part, offset_nt) for part in parts], [WAYS[way](parts[0], part, offset_nt) for part in parts]
    sensors = {axis: {"offset_nt": offset} for axis, offset in zip(AXES, offset_nt)}
    fitted = parts[0].recording("vector-scalar", "free_run")
    document = programs.ask("diagnose", ["--refit"], fitted, given={"calibration": {"sensors": sensors}})
    after = corrected(programs, parts, document)
    nt = {"as it came": came, LEVEL: [one - came[0].mean() for one in came], way: hand, "corrected by what diagnose wrote": after}
    nt = {what: left for what, left in nt.items() if left[0] is not None}
    # The level alone, or the constants by hand: what predicts the last third of the fitted part better.
    first, last = parts[0].split(share=2 / 3)
    tried = WAYS[way](first, last, offset_nt)
    alone = way not in nt or tried is None or scatter(tried) >= scatter(mismatch(last, offset_nt))
    best = nt[LEVEL if alone else way][1]
    page.predictions.append(Prediction(["the level alone" if alone else way], *(np.array([scatter(one)]) for one in (best, after[1])), of))
    page.table(["length of the vector less scalar, rms, nT", f"{names[0]} (fitted)", f"{names[1]} (held out)", "of which level"],
               [[what, *map(three, map(rms, left)), three(left[1].mean())] for what, left in nt.items()])
    if way in nt:
        level, fit = rms(nt[LEVEL][1]), rms(hand[1])
        page.head("scalar_head", alone=three(level), way=way, hand=three(fit))
        page.tell("by_hand_better" if fit < level else "by_hand_no_better")
    page.head("refits", nt=three(document["diagnosis"][0]["fit"]["rms_refitted_nt"]), verdict=verdict(document))
    page.diagnosis(document)
    lines = {what: np.concatenate(left) for what, left in nt.items() if what != "as it came"}
    page.plot([part.on_clock(parts[0].start_s).time_s / 3600 for part in parts], {"nT": lines})


def by_scalarcal(programs: Programs, page: Page, parts: tuple[Series, Series], offset_nt: np.ndarray) -> None:
    """scalarcal where the field points one way: as it is, and with what data sheets of observatories' fluxgates say (0.1 %, 2 mrad)."""
    known, last, fitted = within(1e-3, 413.0, offset_nt, 500.0), page.predictions[-1], parts[0].recording("vector-scalar", "free_run")
    one = Prediction(last.ways, last.by_hand_nt, None, "scalarcal --known", UNDETERMINED)
    page.predictions.append(one)
    try:
        programs.ask("scalarcal", [], fitted, given=known)
        page.tell("rotations_enough")
    except Refused as refusal:
        page.refused(refusal)
    document = programs.ask("scalarcal", ["--known"], fitted, given=known)
    left = corrected(programs, parts, document)
    one.programs_nt, one.why, found = np.array([scatter(left[1])]), "", document["calibration"]["scalar"]
    offsets = [f"{of['name']} {plus_minus(of['value'], of['std'])}" for of in found["parameters"] if of["name"].startswith("offset")]
    page.tell("with_known", found=f" {', '.join(offsets)} nT;" if offsets else "", rms=three(rms(left[0])), scatter=three(scatter(left[1])))
    weakest = found.get("weakest", {}).get("words")
    page.items(([f"shown least: {weakest}"] if weakest else []) + found.get("findings", []))


def study(programs: Programs, page: Page, parts: tuple[Series, Series], offset_nt: np.ndarray = NONE) -> None:
    by_diagnose(programs, page, parts, page.words["parts"], offset_nt)
    by_scalarcal(programs, page, parts, offset_nt)


def read_conrad(programs: Programs, date: str, step_s: float) -> Series:
    """A suspended fluxgate and a potassium magnetometer, means of a day."""
    vector, scalar = (programs.read(f"{name}-{date}") for name in ("fge", "gp20s3"))
    return vector.means(step_s).joined(scalar.on_clock(vector.start_s).means(step_s)).complete()


def boulder_month(programs: Programs, page: Page) -> None:
    """Beside it the survey's own answer."""
    raw, adjusted = (programs.read(f"boulder-{name}").complete().means(600).split(20 * DAY_S) for name in ("raw", "adjusted"))
    study(programs, page, raw)
    fitted, held_out = (mismatch(part, 0.0) for part in adjusted)
    level = fitted.mean()
    page.tell("adjusted", level=three(level), fitted=three(rms(fitted - level)), held_out=three(rms(held_out - level)))


def cobenzl(programs: Programs, page: Page) -> None:
    """A proton magnetometer beside another instrument, two days by the log's clock; then diagnose, by the magnetometer's own clock."""
    vector = programs.read("didd").only("sensor")

    def joined(day: int, late_s: float = 0.0) -> Series:
        """Means of a minute about the whole minute, without readings that no storm makes."""
        proton = programs.read(f"proton-{day}").on_clock(vector.start_s)
        proton = proton.rows(np.abs(proton["reference_nt"] - np.median(proton["reference_nt"])) < FARTHEST_NT)
        means = proton.assign(time_s=proton.time_s - late_s + 30).means(60)
        return vector.joined(means.assign(time_s=means.time_s - 30)).complete()
    study(programs, page, (joined(9), joined(10)))
    document = programs.ask("diagnose", [], joined(9, CLOCKS_APART_S).recording("vector-scalar", "free_run"))
    clocks = [one["parameters"]["offset_s"] for one in document["diagnosis"][0].get("effects", []) if one["effect"] == "clock_offset"]
    page.known.append((f"`clock_offset` {quantity(clocks[0])} s" if clocks else "no clock named", bool(clocks)))


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
    by_diagnose(programs, page, sized, names, -middle(parts[0]), ELLIPSOID, what)


def marg(programs: Programs, page: Page) -> None:
    """Within a run, and from one run to another."""
    full, partial = (programs.read(f"{name} sphere").rows(slice(None, None, 8)) for name in ("full", "partial"))
    for (what, *names), parts in zip(page.words["runs"], (full.split(share=0.6), (full, partial))):
        one_by_another(programs, page, what, parts, names, about_middle(parts[0], parts[0]).mean())


def phone(programs: Programs, page: Page) -> None:
    """About six readings a second."""
    for what, name, every in page.words["runs"]:
        parts = programs.read(name).only("sensor").rows(slice(None, None, every)).split(share=0.6)
        one_by_another(programs, page, what, parts, page.words["parts"], page.words["magnitude_nt"])


def spread(magnitudes: np.ndarray | None) -> float:
    """Standard deviation over the mean: whatever the scale is."""
    return np.inf if magnitudes is None else magnitudes.std() / magnitudes.mean()


def best_by_hand(fitted: Series, part: Series) -> tuple[str, float]:
    """The way that predicts the last third of the fitted part best from the rest, and the spread that it leaves of another part."""
    def by(way: str, fitted: Series, part: Series) -> float:
        return spread(about_middle(fitted, part) if way == RANGES else by_hand.magnitudes(way, fitted, part, -middle(fitted)))
    tried = {way: by(way, *fitted.split(share=2 / 3)) for way in (RANGES, *by_hand.SHAPES) if np.isfinite(by(way, fitted, part))}
    way = min(tried, key=tried.get)
    return way, by(way, fitted, part)


def predict(programs: Programs, page: Page, fitted_run: tuple[str, Series], part_run: tuple[str, Series], size_nt: float | None,
            why: str = "") -> list[str]:
    """scalarcal as a user would run it, as it is and where it refuses as its own words say, with what data sheets of small magnetometers
    promise (5 %, and a degree): a row of the table of one part that predicts another, and a prediction."""
    names, (fitted, part) = zip(fitted_run, part_run)
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
            calibration = programs.ask("scalarcal", [*arguments, "--known"], turned, given=within(0.05, 3600.0))["calibration"]
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


def by_turns(programs: Programs, page: Page, runs: dict[str, Series]) -> None:
    """Halves of each run by turns; then the first run and each other, where they are of one instrument."""
    (alone, *others), rows, size_nt = runs.items(), [], page.words.get("magnitude_nt")
    for what, run in runs.items():
        first, last = zip((f"{what}, first half", f"{what}, second half"), run.split(share=0.5))
        rows += [predict(programs, page, *by, size_nt) for by in ((first, last), (last, first))]
        # Where one is worse: that the two together are better, if they are.
        told = [[one.by_hand_nt[0], np.inf if one.programs_nt is None else one.programs_nt[0]] for one in page.predictions[-2:]]
        hand, together = np.hypot(*told)
        for one, other in zip(page.predictions[-2:], told[::-1]):
            if together < hand and not one.why:
                one.why = page.words["turns"].format(hand=three(other[0]), programs=three(other[1]))
    for other in others if "between" in page.words else []:
        rows += [predict(programs, page, *by, size_nt, page.words["between"]) for by in ((alone, other), (other, alone))]
    page.table(["fitted", "held out", "best by hand: spread of the magnitude, % of its mean", "scalarcal and correct, %",
                "how scalarcal was run"], rows)


def runs(programs: Programs, page: Page) -> None:
    """Runs of one instrument, or instruments that do not predict each other, each by its recording and its role there."""
    for names in page.words["runs"]:
        roles = page.words.get("roles") or {name: (name, "sensor") for name in names}
        by_turns(programs, page, {name: programs.read(roles[name][0]).only(roles[name][1], "sensor").complete() for name in names})
