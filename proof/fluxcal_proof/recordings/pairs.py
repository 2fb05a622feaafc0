"""Sets of pairs of vector magnetometers."""

from __future__ import annotations

import numpy as np

from . import by_hand
from .page import Page, each, three, verdict
from .pair import DAY_S, clock_in_words, differences, drift, findings, fit, found, matrix_table, study
from .programs import Programs, Refused
from .series import AXES, Series, rms, scatter

PRINTED_NT = 0.0041  # standard uncertainty of the difference of two readings that are each printed to 0.01 nT
SURE = 5  # standard uncertainties beyond which a parameter is one
WILD_NT = 200_000.0  # faults of the balloon's logger: steel on the ground made 89 µT of the Earth's 53 µT


def parts(reference: Series, test: Series, at_s: float) -> list[tuple[Series, Series]]:
    """Two instruments before and after a moment of the reference's clock."""
    return list(zip(reference.split(at_s), test.on_clock(reference.start_s).split(at_s)))


def both(series: Series) -> tuple[Series, Series]:
    return series.only("reference"), series.only("test")


def conrad(programs: Programs, page: Page) -> None:
    """Sixteen hours fitted, eight held out."""
    reference, test = (programs.ingest(f"wic-conrad-2022-08/{name}.csv").renamed("sensor", role) for name, role in
                       [("fge_s0252_2022-08-10_1s", "reference"), ("lemi036_xyz_2022-08-10_1s", "test")])
    page.about()
    document = study(programs, page, *parts(reference, test, 2 / 3 * DAY_S), ("0 to 16 h", "16 to 24 h"),
                     correct_clock=True, plot="real-conrad.svg")
    if document:
        unlike = findings(document, "the responses of the instruments differ")
        page.knows("notes of Conrad", "the LEMI passes 0.3 Hz at most, the FGE 1 Hz", "diffmag",
                   f"“{unlike[0]}”" if unlike else "nothing of it", bool(unlike))


def cobenzl(programs: Programs, page: Page) -> None:
    """Eight days fitted, four held out, with the storm of the 9th and 10th among them."""
    folder = "wik-cobenzl-2011-09a"
    didd = programs.ingest(*programs.files(f"{folder}/didd", ".WIK"), mapping="ingest/real/didd")
    lemi = programs.ingest(*programs.files(f"{folder}/lemi025", ".min"))
    reference, test = didd.only("sensor").renamed("sensor", "reference"), lemi.only("sensor").renamed("sensor", "test")
    page.about()
    document = study(programs, page, *parts(reference, test, 8 * DAY_S),
                     ("1 to 8 September", "9 to 12 September"), correct_clock=True, plot="real-cobenzl.svg")
    if document:
        clock = fit(document)["clock"]
        page.knows("notes of Cobenzl",
                   "the LEMI stamps the minutes of 15 to 105 s, whose middle is 60 s, at 47 s: 13 s early", "diffmag",
                   f"the test instrument's timestamps are {clock_in_words(clock)}",
                   -clock["offset_s"]["value"] > SURE * clock["offset_s"]["std"])


def meson_hall(programs: Programs, page: Page) -> None:
    """Two thirds of the longest stretch without a gap of 30 s fitted."""
    whole = programs.ingest("tucan-fluxgates-2019-08-09-quiet/online_data.csv", mapping="real/meson-hall-pair",
                            sort=True)
    stretches = np.split(np.arange(len(whole)), np.flatnonzero(np.diff(whole.time_s) > 30) + 1)
    fitted, held_out = whole.rows(np.isin(np.arange(len(whole)), max(stretches, key=len))).split_share(2 / 3)
    page.about()
    document = study(programs, page, both(fitted), both(held_out), ("the first two thirds", "the last third"))
    recordings = [series.recording(id, "differential") for series, id in zip(both(whole), ("reference", "test"))]
    moves = findings(programs.ask("diffmag", [], recordings), "the matrix is not constant")
    page.knows("notes of the Meson Hall",
               "the fluxgates are metres apart in a strong gradient: no common field, no one matrix", "diffmag",
               "of the whole run: " + (f"“{moves[0]}”" if moves else "nothing of it"), bool(moves))
    if document:
        lengths = np.linalg.norm(found(document)[0], axis=0)
        page.head(f"A test axis is {each(lengths)} (x; y; z) of the reference's field, where instruments in one "
                  "field have 1: no calibration.")


def quadrotor(programs: Programs, page: Page) -> None:
    """The first half fitted."""
    series = programs.ingest("mxl-quadrotor-2021-04-23/test1_esti.csv", mapping="ingest/real/quadrotor")
    repeated = np.all(np.diff(series.vectors("reference"), axis=0) == 0, axis=1).sum()
    fitted, held_out = ((part.only("test").renamed("test", "reference"),
                         part.only("reference").renamed("reference", "test")) for part in series.split_share(0.5))
    page.about(repeated=repeated, rows=len(series))
    study(programs, page, fitted, held_out, ("the first half", "the second half"), correct_clock=True,
          why=page.words["why"])


def balloon(programs: Programs, page: Page) -> None:
    """Fitted on the way into the cold, held against the way back, by four explanations; then diagnose."""
    flight = programs.ingest("mxl-balloon-2025-02-22a/flight_part1.csv", mapping="real/balloon-pair")
    wild = np.linalg.norm(flight.vectors("reference"), axis=1) > WILD_NT
    # Free flight: from the launch to the release.
    means = flight.rows(~wild).between(3300, 6900).means(4)
    temperature = means["sensor_temperature_c"]
    fitted, held_out = means.split(means.time_s[temperature.argmin()] - 300)
    page.about(wild=wild.sum(), first=three(temperature[0]), least=three(temperature.min()),
               last=three(temperature[-1]))
    page.head("Held out, rms of x; y; z in nT:")
    explanations = {
        "the matrix alone": lambda s: [],
        "with a line in the temperature": lambda s: [s["sensor_temperature_c"]],
        "with a line in the time": lambda s: [s.time_s / 3600],
        "with a parabola in the time": lambda s: [s.time_s / 3600, (s.time_s / 3600) ** 2],
    }
    rows, slopes = [], ""
    for what, further in explanations.items():
        columns = [[np.ones(len(s)), *s.vectors("reference").T, *further(s)] for s in (fitted, held_out)]
        constants = by_hand.least_squares(columns[0], fitted.vectors("test"))
        left = [each(rms(part.vectors("test") - np.column_stack(c) @ constants))
                for part, c in zip((fitted, held_out), columns)]
        rows.append([what, *left])
        page.head(f"{what} {left[1]};")
        if what.endswith("temperature"):
            slopes = each(constants[-1])
    page.say("By least squares of this page's own, rms of x; y; z in nT:")
    page.table(["explanation", "cooling (fitted)", "coldest and warming (held out)"], rows)
    page.say(page.words["slopes"].format(slopes=slopes))
    programs_nt = None
    try:
        document = programs.ask("diffmag", [], [fitted.recording("flight", "differential")])
        left = differences(held_out, *found(document)) - drift(document, fitted.time_s)(held_out)
        programs_nt = list(scatter(left))
        page.say(f"`diffmag`, fitted to the same part, answers: {fit(document).get('answer', 'nothing')}.")
    except Refused as words:
        page.refused("diffmag", words)
    ways, left = by_hand.best(lambda _: fitted, lambda _: held_out, clock=False)
    page.predicts([f"{axis}: {way}" for axis, way in zip(AXES, ways)], left, programs_nt)
    document = programs.ask("diagnose", [], [means.recording("flight", "differential")])
    warm = [effect["parameters"] for effect in document["diagnosis"][0]["effects"]
            if "temperature_c" in effect.get("column", "")]
    slopes = [one.get(f"{axis}_nt_per_k", {}) for one in warm[:1] for axis in AXES]
    axes = sum(abs(slope.get("value", 0)) > SURE * slope.get("std", np.inf) for slope in slopes)
    page.knows("the balloon's way back, by least squares",
               "the two go apart with the temperature of the die, and not with time", "diagnose",
               f"the readings follow the temperature in {axes} of three axes", axes == 3)
    page.head(f"`diagnose` {verdict(document)}.")
    page.diagnosis(document)


def boulder(programs: Programs, page: Page) -> None:
    """Between raw and adjusted minutes is one matrix, which diffmag must give back; the first half fitted."""
    raw, adjusted = (programs.ingest(f"usgs-bou-2016-01/BOU201601{name}.min").only("sensor").renamed("sensor", role)
                     for name, role in [("vmin", "reference"), ("adj", "test")])
    fitted, held_out = raw.joined(adjusted).complete().split_share(0.5)
    page.about()
    document = programs.ask("diffmag", [], [fitted.recording("adjusted", "differential")])
    left = [differences(part, *found(document)) for part in (fitted, held_out)]
    told = ["; ".join(f"{nt:.4f}" for nt in rms(one)) for one in left]
    ways, by_hand_left = by_hand.best(lambda _: fitted, lambda _: held_out, clock=False)
    page.predicts(ways, by_hand_left, list(scatter(left[1])))
    page.knows("the survey's notes", "adjusted data are raw data times one matrix, rounded to 0.01 nT", "diffmag",
               f"a matrix that leaves {told[1]} nT where it was not fitted",
               bool((rms(left[1]) < 1.1 * PRINTED_NT).all()))
    matrix_table(page, document, "adjusted", ("from H", "E", "Z"), offsets=False)
    page.head(f"The survey's matrix comes back; what was held out is met to {told[1]} nT, the rounding.")
    page.say(f"Left (rms of x; y; z): {told[0]} nT in the first half, {told[1]} nT in the second, which was held "
             f"out; two roundings make {PRINTED_NT}.")
