"""Sets of pairs of vector magnetometers."""
import numpy as np

from . import by_hand
from .page import Page, each, effects, three, verdict
from .pair import DAY_S, Matrix, Part, predict, study
from .programs import Programs
from .series import AXES, Series, rms

PRINTED_NT = 0.0041  # standard uncertainty of the difference of two readings that are each printed to 0.01 nT
SURE = 5  # standard uncertainties beyond which a parameter is one
WILD_NT = 200_000.0  # faults of the balloon's logger: steel on the ground made 89 µT of the Earth's 53 µT


def read_conrad(programs: Programs) -> Part:
    reference, test = (programs.ingest(f"wic-conrad-2022-08/{name}_2022-08-10_1s.csv") for name in ("fge_s0252", "lemi036_xyz"))
    return reference.only("sensor", "reference"), test.only("sensor", "test")


def read_cobenzl(programs: Programs) -> Part:
    didd = programs.ingest(*programs.files("wik-cobenzl-2011-09a/didd", ".WIK"), mapping="ingest/real/didd")
    lemi = programs.ingest(*programs.files("wik-cobenzl-2011-09a/lemi025", ".min"))
    return didd.only("sensor", "reference"), lemi.only("sensor", "test")


def read_boulder(programs: Programs) -> Series:
    """A month as read and as published."""
    raw, adjusted = (programs.ingest(f"usgs-bou-2016-01/BOU201601{name}.min") for name in ("vmin", "adj"))
    return raw.only("sensor", "reference").joined(adjusted.only("sensor", "test")).complete()


def read_meson_hall(programs: Programs) -> Series:
    return programs.ingest("tucan-fluxgates-2019-08-09-quiet/online_data.csv", mapping="real/meson-hall-pair", sort=True)


def at(part: Part, at_s: float) -> tuple[Part, Part]:
    """Two instruments before and after a moment of the reference's clock."""
    return tuple(zip(part[0].split(at_s), part[1].on_clock(part[0].start_s).split(at_s)))


def both(series: Series, reference: str = "reference", test: str = "test") -> Part:
    return series.only(reference, "reference"), series.only(test, "test")


def knows(page: Page, found: Matrix, words: str, of: str = "") -> None:
    """Whether diffmag has a finding with some words."""
    told = found.findings(words)
    page.known.append((of + (f"“{told[0]}”" if told else "nothing of it"), bool(told)))


def conrad(programs: Programs, page: Page) -> None:
    found = study(programs, page, at(read_conrad(programs), 2 / 3 * DAY_S), clock=True)
    knows(page, found, "the responses of the instruments differ")


def cobenzl(programs: Programs, page: Page) -> None:
    found = study(programs, page, at(read_cobenzl(programs), 8 * DAY_S), clock=True)
    early = found.fit["clock"]["offset_s"]
    page.known.append((f"the test instrument's timestamps are {found.clock_in_words()}", -early["value"] > SURE * early["std"]))


def meson_hall(programs: Programs, page: Page) -> None:
    """Of the longest stretch without a gap of 30 s."""
    whole = read_meson_hall(programs)
    stretch = np.append(0, np.cumsum(np.diff(whole.time_s) > 30))
    parts = whole.rows(stretch == np.bincount(stretch).argmax()).split(share=2 / 3)
    found = study(programs, page, tuple(map(both, parts)))
    recordings = [series.recording(role, "differential") for series, role in zip(both(whole), ("reference", "test"))]
    of_whole = Matrix.found(programs.ask("diffmag", [], *recordings), whole.time_s)
    knows(page, of_whole, "the matrix is not constant", "of the whole run: ")
    page.head("shares", shares=each(np.linalg.norm(found.eta, axis=0)))


def quadrotor(programs: Programs, page: Page) -> None:
    """The file's reference is the test instrument here."""
    series = programs.ingest("mxl-quadrotor-2021-04-23/test1_esti.csv", mapping="ingest/real/quadrotor")
    repeated = (np.diff(series.vectors("reference"), axis=0) == 0).all(axis=1).sum()
    page.about = {"repeated": repeated, "rows": len(series)}
    study(programs, page, tuple(both(part, "test", "reference") for part in series.split(share=0.5)), clock=True)


def balloon(programs: Programs, page: Page) -> None:
    """Fitted on the way into the cold, held against the way back, by four explanations; then diagnose."""
    whole = programs.ingest("mxl-balloon-2025-02-22a/flight_part1.csv", mapping="real/balloon-pair")
    wild = np.linalg.norm(whole.vectors("reference"), axis=1) > WILD_NT
    flight = whole.rows(~wild).between(3300, 6900).means(4)  # free flight: from the launch to the release
    warmth = flight[by_hand.TEMPERATURE]
    fitted, held_out = parts = flight.split(flight.time_s[warmth.argmin()] - 300)
    page.about = {"wild": wild.sum(), "first": three(warmth[0]), "least": three(warmth.min()), "last": three(warmth[-1])}
    explanations = {
        "the matrix alone": lambda s: [], "with a line in the temperature": lambda s: [s[by_hand.TEMPERATURE]],
        "with a line in the time": lambda s: [s.time_s / 3600], "with a parabola in the time": lambda s: [s.time_s / 3600, s.time_s**2]}
    rows, slopes = [], {}
    for what, further in explanations.items():
        def columns(series: Series) -> list[np.ndarray]:
            return by_hand.ones_and("reference")(series) + further(series)
        rows.append([what, *(each(rms(by_hand.left(columns, by_hand.test, fitted, part))) for part in parts)])
        slopes[what] = each(by_hand.least_squares(columns(fitted), by_hand.test(fitted))[-1])
    page.headline += ["Held out, rms of x; y; z in nT:", *(f"{what} {nt};" for what, _, nt in rows)]
    page.say("By least squares of this page's own, rms of x; y; z in nT:")
    page.table(["explanation", "cooling (fitted)", "coldest and warming (held out)"], rows)
    page.tell("slopes", slopes=slopes["with a line in the temperature"])
    found = Matrix.found(programs.ask("diffmag", [], fitted.recording("flight", "differential")), fitted.time_s)
    page.say(f"`diffmag`, fitted to the same part, answers: {found.fit['answer']}.")
    predict(page, by_hand.best_of_pair(lambda _: fitted, lambda _: held_out), found.left(held_out))
    document = programs.ask("diagnose", [], flight.recording("flight", "differential"))
    warm = next((effect["parameters"] for effect in effects(document) if "temperature_c" in effect.get("column", "")), {})
    slope = [warm.get(f"{axis}_nt_per_k", {"value": 0, "std": 1}) for axis in AXES]
    axes = sum(abs(one["value"]) > SURE * one["std"] for one in slope)
    page.known.append((f"the readings follow the temperature in {axes} of three axes", axes == 3))
    page.headline.append(f"`diagnose` {verdict(document)}.")
    page.diagnosis(document)


def boulder(programs: Programs, page: Page) -> None:
    """Between raw and adjusted minutes is one matrix, which diffmag must give back."""
    fitted, held_out = parts = read_boulder(programs).split(share=0.5)
    found = Matrix.found(programs.ask("diffmag", [], fitted.recording("adjusted", "differential")), fitted.time_s)
    left = [found.apart(part) for part in parts]
    told = [each(rms(one), "{:.4f}".format) for one in left]
    predict(page, by_hand.best_of_pair(lambda _: fitted, lambda _: held_out), left[1])
    page.known.append((f"a matrix that leaves {told[1]} nT where it was not fitted", bool((rms(left[1]) < 1.1 * PRINTED_NT).all())))
    page.table(["", "from H", "E", "Z"], found.elements("adjusted"))
    page.head("comes_back", held_out=told[1])
    page.tell("rounding", fitted=told[0], held_out=told[1], printed=PRINTED_NT)
