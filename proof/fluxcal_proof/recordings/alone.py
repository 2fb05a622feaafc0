"""Instruments by themselves, fluxgates beside coils, and makers' certificates."""
import numpy as np

from .page import Page, each, plus_minus, three, verdict
from .programs import Programs, Refused
from .series import AXES, Series, rms, scatter

DRIVE_A = 2.5 / 21.5  # half of the stated 5 V from peak to peak over the stated 21.5 ohm
LEVEL_NT = 100  # a reading belongs to a level of the square wave within so much
NOISE_NT = 5.0  # what the readings of one level scatter by before the first switching
FIELD_NT = 50_000  # in which an angle is told as nT
ROUNDING_NT_PER_V = 1.5  # what rounding a resistor to 0.1 kohm and a scale to 0.1 nT/V makes at most


def ask(programs: Programs, page: Page, name: str, series: Series) -> None:
    """diagnose, with the mean of each sensor as what its offset takes away: only changes are looked at."""
    levels = zip(AXES, np.nanmean(series.vectors("sensor"), axis=0))
    given = {"calibration": {"sensors": {axis: {"offset_nt": -level} for axis, level in levels}}}
    document = programs.ask("diagnose", [], [series.recording(name, "free_run")], given)
    page.head(f"{name}: {verdict(document)}.")
    page.diagnosis(document)


def w2naf(programs: Programs, page: Page) -> None:
    """Sixteen hours before the storm, then the whole day."""
    day = programs.ingest("hamsci-w2naf-2024-05-10/w2naf-20240510-runmag.csv", mapping="ingest/real/hamsci").means(120)
    quiet = day.between(-np.inf, 16 * 3600)
    page.about(readings=each(scatter(quiet.vectors("sensor"))).replace(";", ","),
               sensor=three(scatter(quiet["sensor_temperature_c"])),
               electronics=three(scatter(quiet["electronics_temperature_c"])))
    page.say("The quiet hours:")
    ask(programs, page, "quiet", quiet)
    page.say("The whole day, with the storm:")
    ask(programs, page, "day", day)


def marg_at_rest(programs: Programs, step_s: float) -> Series:
    """An HMC5883L lying still, with the thermometer of another chip on its board; means at uneven times."""
    field, thermometer = (
        programs.ingest(f"marg-hmc5883l-sunsided/set2_static_10min_{name}.csv", mapping=mapping).means(step_s, least=0)
        for name, mapping in (("mag", "ingest/real/marg"), ("temp_decim10", "real/marg-temperature")))
    return field.joined(thermometer).complete()


def marg(programs: Programs, page: Page) -> None:
    both = marg_at_rest(programs, 1)
    page.about(rows=len(both), warmth=three(scatter(both["sensor_temperature_c"])),
               readings=each(scatter(both.vectors("sensor"))).replace(";", ","))
    ask(programs, page, "static", both)


def drive(z: np.ndarray) -> np.ndarray:
    """The drive of the square wave, A, which was not recorded: its sign is taken from z, and it is unknown beside a
    switching. The first row is taken at its word."""
    low, high = np.sort(z)[[len(z) // 10, len(z) - 1 - len(z) // 10]]
    sign = np.where(z > (low + high) / 2, 1.0, -1.0)
    at_level = np.abs(z - np.where(sign > 0, high, low)) < LEVEL_NT
    at_level[0] = True
    same = sign[1:] == sign[:-1]
    same[0] = True
    held = at_level & np.append(at_level[1:] & same, True) & np.append(True, at_level[:-1] & same)
    held[0] = True
    return np.where(held, sign * DRIVE_A, np.nan)


def square_wave(programs: Programs, page: Page) -> None:
    """A fluxgate beside a coil; the first row of the logger is known to be an artefact, and diagnose is not told."""
    series = programs.ingest("tucan-coil-tests/squareCoil_F=0.1Hz_Resistor.csv")
    current = drive(series["sensor_z_nt"])

    def steps(rows: slice) -> str:
        told = []
        for values in series.vectors("sensor")[rows].T:
            levels = [values[current[rows] * sign > 0] for sign in (1, -1)]
            std = np.hypot(*(np.std(level) / np.sqrt(len(level)) for level in levels))
            told.append(plus_minus(levels[0].mean() - levels[1].mean(), std))
        return "; ".join(told)
    half = len(series) // 2
    page.about(first=steps(slice(1, half)), second=steps(slice(half, None)))
    ambient = {f"ambient_{axis}_nt": series[f"sensor_{axis}_nt"][1:].mean() for axis in AXES}
    driven = series.assign(coil_z_a=current, **ambient)
    coil = {"calibration": {"coils": {"z": {"constant_nt_per_a": 3000.0}}}}
    for what, given in [("With a scatter of 5 nT declared", {"instrument": {"noise": {"white_rms_nt": NOISE_NT}}}),
                        ("Without any noise declared", {})]:
        page.say(f"{what}:")
        document = programs.ask("diagnose", [], [driven.recording("square", "free_run")], coil | given)
        moments = [effect["parameters"]["time_s"] for effect in document["diagnosis"][0]["effects"]
                   if effect["effect"] == "spike" and "time_s" in effect["parameters"]]
        found = sum((moment["value"] if isinstance(moment, dict) else moment) == 0 for moment in moments)
        page.knows("notes of the square wave", "the logger's first row is a start-up artefact", "diagnose",
                   f"{what} a spike in the first row of {found} of three axes", found == 3)
        page.head(f"{what}: the known artefact of the first row is found in {found} of three axes; {verdict(document)}.")
        page.diagnosis(document)
    page.say("The logger's first row is known to be an artefact; diagnose was not told.")
    total = series.assign(coil_z_a=current, reference_nt=np.linalg.norm(series.vectors("sensor"), axis=1))
    try:
        recording = total.only("coil", "reference").recording("square", "coil_constant", coil="z")
        programs.ask("coilcal", [], [recording])
    except Refused as words:
        page.refused("coilcal", words)


def gradiometer(programs: Programs, page: Page) -> None:
    """An empty scan as the simulation against which another empty scan, and one with a foil, are held."""
    empty, again, foil = (
        programs.ingest(f"tucan-coil-tests/2021-03-03_16-{name}.csv", mapping="ingest/real/gradiometer")
        .only("reference", "position").renamed("reference", "sensor")
        for name in ("00-03-background-2", "10-01-background-3", "03-59-FOIL4-Primary"))
    page.about()
    told = []
    for what, scan in [("The empty holder again", again), ("With the foil", foil)]:
        rows = min(len(scan), len(empty))
        apart = rms(scan.vectors("sensor")[:rows] - empty.vectors("sensor")[:rows])
        page.say(f"{what}: rms of the difference x; y; z {each(apart)} nT.")
        scan = scan.assign(position_m=empty["position_m"])
        document = programs.ask("diagnose", [], [scan.recording("scan", "free_run")],
                                against=[empty.recording("scan", "free_run")])
        told.append(verdict(document))
        page.head(f"{what}: {told[-1]}.")
        page.diagnosis(document)
    page.knows("notes of the gradiometer", "a magnetised foil in one scan, the holder empty in the other", "diagnose",
               f"{told[1]} with the foil, {told[0]} of the empty holder", told[0] == "agrees" and told[1] != "agrees")


def figures_of(text: str) -> dict[str, float]:
    """The figures of a certificate's table by name."""
    rows = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in text.splitlines()]
    found = {}
    for row in rows:
        try:
            found[row[0]] = float(row[2])
        except (IndexError, ValueError):
            continue
    return found


def certificates(programs: Programs, page: Page) -> None:
    """Do the figures of four certificates agree with one another, and how large are real angles?"""
    scales, angles, largest, agree, compared = [], [], 0.0, 0, 0
    for file in programs.files("geonet-fge-constants", ".const.md"):
        of, name = figures_of((programs.data / file).read_text()), file.split("/")[-1].removesuffix(".const.md")
        for axis in "XYZ":
            own = of[f"{axis}-coil"] / of["res"]  # nT/mA over kohm is nT/V
            printed = of.get(f"{axis}-scale")
            if printed is not None:
                compared, agree = compared + 1, agree + (abs(printed - own) <= ROUNDING_NT_PER_V)
            told = ["not printed", ""] if printed is None else [f"{printed:.1f}", f"{round(printed - own, 1) + 0:+.1f}"]
            scales.append([f"{name} {axis}", f"{own:.1f}", *told])
        mrad = [of[f"ε{k}"] for k in range(5) if f"ε{k}" in of]
        largest = max(largest, *map(abs, mrad))
        angles.append([name, ", ".join(f"{one:g}" for one in mrad)])
    page.about()
    page.head(f"Of {compared} printed scales {agree} agree with the coil's constant over the resistor.")
    page.table(["instrument", "coil over resistor, nT/V", "printed, nT/V", "apart, nT/V"], scales)
    page.table(["instrument", "ε0 to ε4, mrad"], angles)
    page.say(page.words["angle"].format(mrad=largest, arcsec=round(largest * 206.265),
                                        nt=three(1e-3 * largest * FIELD_NT)))
