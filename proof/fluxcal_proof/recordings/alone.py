"""Instruments by themselves, and fluxgates beside coils."""
import numpy as np
import pandas as pd

from .page import Page, each, number, plus_minus, three, verdict
from .programs import AXES, Programs, Refused, Series, rms, scatter

DRIVE_A = 2.5 / 21.5  # half of the stated 5 V from peak to peak over the stated 21.5 ohm


def ask(programs: Programs, page: Page, name: str, series: Series) -> None:
    """diagnose, with the mean of each sensor as what its offset takes away: only changes are looked at."""
    sensors = {axis: {"offset_nt": -level} for axis, level in zip(AXES, np.nanmean(series.vectors("sensor"), axis=0))}
    document = programs.ask("diagnose", [], series.recording(name, "free_run"), given={"calibration": {"sensors": sensors}})
    page.headline.append(f"{name}: {verdict(document)}.")
    page.diagnosis(document)


def w2naf(programs: Programs, page: Page) -> None:
    """Sixteen hours before the storm, then the whole day."""
    day = programs.read("w2naf").means(120)
    quiet, _ = day.split(16 * 3600)
    moves = {name: three(scatter(quiet[f"{name}_temperature_c"])) for name in ("sensor", "electronics")}
    page.about = {"readings": ", ".join(map(three, scatter(quiet.vectors("sensor")))), **moves}
    page.say("The quiet hours:")
    ask(programs, page, "quiet", quiet)
    page.say("The whole day, with the storm:")
    ask(programs, page, "day", day)


def read_marg(programs: Programs, step_s: float) -> Series:
    """An HMC5883L lying still, with the thermometer of another chip on its board; means at uneven times."""
    field, thermometer = (programs.read(name).means(step_s, least=0) for name in ("still", "still-temperature"))
    return field.joined(thermometer).complete()


def marg(programs: Programs, page: Page) -> None:
    both = read_marg(programs, 1)
    readings = ", ".join(map(three, scatter(both.vectors("sensor"))))
    page.about = {"rows": len(both), "warmth": three(scatter(both["sensor_temperature_c"])), "readings": readings}
    ask(programs, page, "static", both)


def drive(z: np.ndarray) -> np.ndarray:
    """The drive, A, which was not recorded: its sign is taken from z; unknown beside a switching. The first row is an artefact."""
    low, high = np.sort(z)[[len(z) // 10, -1 - len(z) // 10]]
    sign = np.where(z > (low + high) / 2, 1.0, -1.0)
    level = np.where(np.abs(z - np.where(sign > 0, high, low)) < 100, sign, 0)  # within 100 nT a reading belongs to a level
    level[0] = level[1]
    before, after = np.append(level[0], level[:-1]), np.append(level[1:], level[-1])
    return np.where((level != 0) & (level == before) & (level == after), sign * DRIVE_A, np.nan)


def square_wave(programs: Programs, page: Page) -> None:
    """A fluxgate beside a coil; the first row of the logger is known to be an artefact, and diagnose is not told."""
    series = programs.read("square-wave")
    current, half = drive(series["sensor_z_nt"]), len(series) // 2

    def steps(rows: slice) -> str:
        high, low = (series.vectors("sensor")[rows][sign * current[rows] > 0] for sign in (1, -1))
        std = np.hypot(*(level.std(axis=0) / np.sqrt(len(level)) for level in (high, low)))
        return "; ".join(map(plus_minus, high.mean(axis=0) - low.mean(axis=0), std))
    page.about = {"first": steps(slice(1, half)), "second": steps(slice(half, None))}
    ambient = {f"ambient_{axis}_nt": series[f"sensor_{axis}_nt"][1:].mean() for axis in AXES}
    driven = series.assign(coil_z_a=current, **ambient).recording("square", "free_run")
    coil = {"calibration": {"coils": {"z": {"constant_nt_per_a": 3000.0}}}}
    noise = {"instrument": {"noise": {"white_rms_nt": 5.0}}}
    for what, given in [("With a scatter of 5 nT declared", coil | noise), ("Without any noise declared", coil)]:
        page.say(f"{what}:")
        document = programs.ask("diagnose", [], driven, given=given)
        named = page.diagnosis(document)
        found = sum(one["effect"] == "spike" and number(one["parameters"].get("time_s", 1)) == 0 for one in named)
        page.known.append((f"{what} a spike in the first row of {found} of three axes", found == 3))
        page.head("artefact", what=what, found=found, verdict=verdict(document))
    page.tell("not_told")
    total = pd.DataFrame({"coil_z_a": current, "reference_nt": np.linalg.norm(series.vectors("sensor"), axis=1)})
    try:
        programs.ask("coilcal", [], Series(total).recording("square", "coil_constant", coil="z"))
    except Refused as refusal:
        page.refused(refusal)


def gradiometer(programs: Programs, page: Page) -> None:
    """An empty scan as the simulation against which another empty scan, and one with a foil, are held."""
    empty, again, foil = (programs.read(name) for name in ("scan-empty", "scan-empty-again", "scan-foil"))

    def scan(series: Series) -> dict:
        return series.only("reference", "sensor").assign(position_m=empty["position_m"]).recording("scan", "free_run")
    told = []
    for what, series in [("The empty holder again", again), ("With the foil", foil)]:
        page.say(f"{what}: rms of the difference x; y; z {each(rms(series.vectors('reference') - empty.vectors('reference')))} nT.")
        document = programs.ask("diagnose", [], scan(series), against=scan(empty))
        told.append(verdict(document))
        page.headline.append(f"{what}: {told[-1]}.")
        page.diagnosis(document)
    page.known.append((f"{told[1]} with the foil, {told[0]} of the empty holder", told[0] == "agrees" and told[1] != "agrees"))
