"""Real recordings at rest as hosts for injected effects: which, how they are cut, and what a calibration takes up.

Nobody chooses by what is found in them later: of each instrument that lay still, the quiet stretches that its notes
name, whole days or nights.
"""
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .alone import marg_at_rest
from .by_hand import least_squares
from .pair import DAY_S
from .programs import Programs
from .scalars import CONRAD_COMPENSATION_NT, VERNADSKY_COMPENSATION_NT, conrad_day
from .series import AXES, Series, rms

COBENZL_EARLY_S = 18.38  # what the LEMI stamps its minutes too early by: diffmag --correct-clock over twelve days
ROWS = 100  # fewer are no host
CONRAD, COBENZL, BOULDER = "wic-conrad-2022-08", "wik-cobenzl-2011-09a", "usgs-bou-2016-01"


@dataclass
class Host:
    """A recording as a document, with what a calibration can take up of an effect that is added to it."""

    name: str
    folder: str
    words: str
    source: str
    series: Series = field(repr=False)
    offset_nt: np.ndarray  # as maker or logger state it, added to the readings
    code_nt: float  # width of a code; 0 where readings are means, whose codes are gone

    def __post_init__(self) -> None:
        has = self.series.__contains__
        self.kind = ("pair" if has("test_x_nt") else "scalar" if has("reference_nt")
                     else "ambient" if has("ambient_x_nt") else "single")
        self.quantity = "test" if self.kind == "pair" else "sensor"
        self.time_s, self.readings = self.series.time_s, self.series.vectors(self.quantity)
        self.rows = len(self.series)
        ones, conditions = [np.ones(self.rows)], {}
        if self.kind == "single":
            # What the field is nobody knows; its level is taken off by the offset.
            self.offset_nt = -self.readings.mean(axis=0)
            self.fields, design = np.zeros((self.rows, 3)), np.column_stack(ones)
        else:
            drive = {"pair": "reference", "ambient": "ambient", "scalar": "sensor"}[self.kind]
            drive = self.series.vectors(drive)
            design = np.column_stack([*ones, *(drive - drive.mean(axis=0)).T])
            self.fields = drive + (self.offset_nt if self.kind == "scalar" else 0)
        calibration = {"sensors": {axis: {"offset_nt": nt} for axis, nt in zip(AXES, self.offset_nt)}}
        if self.kind == "pair":
            constants = least_squares([*ones, *drive.T], self.readings)
            self.fields = drive @ constants[1:]
            calibration = {"differential": {"matrix": constants[1:].tolist(),
                                            "offset_nt": dict(zip(AXES, constants[0].tolist()))}}
        if self.kind == "ambient":
            conditions = {"orientation": np.eye(3).tolist()}
        procedure = "differential" if self.kind == "pair" else "free_run"
        self.document = {"fluxcal": 1, "title": self.name, "calibration": calibration,
                         "recordings": [self.series.recording("run", procedure, **conditions)]}
        self.basis = np.linalg.qr(design / np.linalg.norm(design, axis=0))[0]
        residual = self.readings
        if self.kind == "scalar":
            residual = (np.linalg.norm(self.fields, axis=1) - self.series["reference_nt"])[:, None]
        self.scatter_nt = float(rms(self._without_constants(residual), axis=None))

    def _without_constants(self, columns: np.ndarray) -> np.ndarray:
        return columns - self.basis @ (self.basis.T @ columns)

    def left(self, added: np.ndarray) -> np.ndarray:
        """What is left of what is added to the readings (rows × 3, nT) when all constants of the basic model are
        fitted to it: δM_i = Σ_j a_ij B_j + o_i, each sensor; beside a scalar magnetometer one column, the change of
        the vector's length less a level and slopes along the readings."""
        if self.kind == "scalar":
            longer = np.linalg.norm(self.fields + added, axis=1) - np.linalg.norm(self.fields, axis=1)
            added = longer[:, None]
        return self._without_constants(added)

    def size_nt(self, added: np.ndarray) -> float:
        """The measure of strengths: rms of what is left in the sensor that keeps most of it."""
        return float(rms(self.left(added)).max())

    @property
    def suits(self) -> tuple[str, ...]:
        """The members of which it has the inputs."""
        from .inject import MEMBERS
        return tuple(name for name, member in MEMBERS.items() if member.needs <= self.has)

    @property
    def has(self) -> set[str]:
        """A temperature that moves by a tenth of a kelvin, a known field that moves, a second vector, a working day
        with its nights, or a reading each ten seconds, for a vehicle that passes in a minute."""
        there = {self.kind}
        there |= {name for name in ("sensor_temperature_c", "electronics_temperature_c")
                  if name in self.series and np.ptp(self.series[name]) > 0.1}
        if self.kind != "single":
            there.add("field")
        if self.kind != "single" and np.ptp(self.fields, axis=0).max() > 0.1 * np.linalg.norm(self.fields, axis=1).max():
            there.add("drive")
        if np.ptp(self.time_s) > 85_000 and self.series.start_s > 0:
            there.add("day")
        return there | ({"quick"} if np.median(np.diff(self.time_s)) <= 10 else set())


def between(series: Series, from_s: float, to_s: float) -> Series:
    """What lies between two moments, on a clock that is zero at the first."""
    cut = series.between(from_s, to_s)
    return cut.on_clock(series.start_s + from_s) if series.start_s else cut


def conrad_pair(programs: Programs) -> Series:
    reference, test = (programs.ingest(f"{CONRAD}/{name}_2022-08-10_1s.csv").renamed("sensor", role)
                       for name, role in (("fge_s0252", "reference"), ("lemi036_xyz", "test")))
    return reference.joined(test).complete()


def conrad_vectors(programs: Programs) -> Series:
    """The test instrument of the pair in the field that the other one tells it has, by least squares."""
    pair = conrad_pair(programs).means(60)
    columns = [np.ones(len(pair)), *pair.vectors("reference").T]
    told = np.column_stack(columns) @ least_squares(columns, pair.vectors("test"))
    ambient = {f"ambient_{axis}_nt": told[:, k] for k, axis in enumerate(AXES)}
    return pair.only("test").renamed("test", "sensor").assign(**ambient)


def conrad_fge(programs: Programs) -> Series:
    return between(programs.ingest(f"{CONRAD}/fge_s0252_2022-08-10_1s.csv").complete(), 7200, 8100)


def vernadsky(programs: Programs) -> Series:
    return programs.ingest("aia-vernadsky-2020-03-03/SXY20200303vsec.sec").complete()


def boulder(programs: Programs, day: int) -> Series:
    month = programs.ingest(f"{BOULDER}/BOU201601vmin.min").complete()
    return between(month, (day - 1) * DAY_S, day * DAY_S)


def boulder_published(programs: Programs) -> Series:
    raw, adjusted = (programs.ingest(f"{BOULDER}/BOU201601{name}.min").only("sensor").renamed("sensor", role)
                     for name, role in (("vmin", "reference"), ("adj", "test")))
    return between(raw.joined(adjusted).complete(), 7 * DAY_S, 8 * DAY_S)


def w2naf(programs: Programs) -> Series:
    day = programs.ingest("hamsci-w2naf-2024-05-10/w2naf-20240510-runmag.csv", mapping="ingest/real/hamsci")
    return between(day, 2 * 3600, 8 * 3600).means(30, least=0).complete()


def cobenzl(programs: Programs) -> Series:
    didd = programs.ingest(*programs.files(f"{COBENZL}/didd", ".WIK"), mapping="ingest/real/didd")
    lemi = programs.ingest(*programs.files(f"{COBENZL}/lemi025", ".min")).on_clock(didd.start_s)
    reference = didd.only("sensor").renamed("sensor", "reference")
    test = lemi.only("sensor").renamed("sensor", "test").at(reference.time_s - COBENZL_EARLY_S)
    both = reference.joined(test.assign(time_s=reference.time_s)).complete()
    return between(both, DAY_S - 2 * 3600, DAY_S + 7.5 * 3600)


def meson_hall(programs: Programs) -> Series:
    """The longest part without a gap."""
    series = programs.ingest("tucan-fluxgates-2019-08-09-quiet/online_data.csv", mapping="real/meson-hall-pair",
                             sort=True).complete()
    return between(series, series.time_s[-1] - 1000, series.time_s[-1] + 1)


ZERO = (0.0, 0.0, 0.0)
# Name, folder, how it is read, offset nT, code nT, and what it is.
CANDIDATES: list[tuple[str, str, Callable[[Programs], Series], tuple[float, float, float], float, str]] = [
    ("conrad-scalar-20s", CONRAD, lambda p: conrad_day(p, "2022-08-03", 20), CONRAD_COMPENSATION_NT, 0,
     "suspended fluxgate beside a potassium magnetometer, a tunnel's quiet day (2022-08-03), means of 20 s"),
    ("conrad-scalar-60s", CONRAD, lambda p: conrad_day(p, "2022-08-10", 60), CONRAD_COMPENSATION_NT, 0,
     "the same two a week later (2022-08-10), means of a minute"),
    ("conrad-vectors", CONRAD, conrad_vectors, ZERO, 0,
     "LEMI-036, 2022-08-10, means of a minute, in the field as the FGE 200 m away has it (by least squares)"),
    ("conrad-fge", CONRAD, conrad_fge, ZERO, 0.001,
     "the FGE by itself, 2022-08-10, 2 to 2.25 h, each second; its scatter is the field's own variation"),
    ("vernadsky", "aia-vernadsky-2020-03-03", vernadsky, VERNADSKY_COMPENSATION_NT, 0.01,
     "LEMI-025 and a scalar magnetometer in the Antarctic, 2020-03-03, each ten seconds"),
    *((f"boulder-{day}", BOULDER, lambda p, day=day: boulder(p, day), ZERO, 0.01,
       f"fluxgate and independent scalar magnetometer of an observatory, minutes of {day} January 2016")
      for day in (8, 16, 25)),
    ("hmc5883l", "marg-hmc5883l-sunsided", lambda p: marg_at_rest(p, 0.2), ZERO, 0,
     "HMC5883L lying still indoors for eleven minutes, the thermometer of another chip beside it, means of 0.2 s"),
    ("w2naf-night", "hamsci-w2naf-2024-05-10", w2naf, ZERO, 0,
     "RM3100 with two thermometers, 2 to 8 h UTC before a storm, means of 30 s; its scatter is the field's own"),
    ("conrad-pair", CONRAD, lambda p: conrad_pair(p).means(120), ZERO, 0,
     "suspended fluxgate and LEMI-036 in buildings 200 m apart, 2022-08-10, means of two minutes"),
    ("boulder-published", BOULDER, boulder_published, ZERO, 0.01,
     "minutes of 8 January 2016 as read and as published, a moving field; its scatter is two roundings"),
    ("cobenzl-night", COBENZL, cobenzl, ZERO, 0,
     "DIDD and LEMI-025 at the edge of a city, 22 to 7.5 h of 2 September 2011, the LEMI's minutes moved by 18.38 s"),
    ("meson-hall", "tucan-fluxgates-2019-08-09-quiet", meson_hall, ZERO, 0,
     "two fluxgates under a cyclotron, read each second for eleven minutes"),
]


def hosts(data: Path, programs: Path) -> list[Host]:
    """The candidates whose folder is there, with rows enough for the constants."""
    from .__main__ import WORDS
    sources = {words["folder"]: words["source"] for words in WORDS.values() if "folder" in words}
    stages, found = Programs(programs, data), []
    for name, folder, read, offset_nt, code_nt, words in CANDIDATES:
        if not (Path(data) / folder).is_dir():
            print(f"{name}: no host, no folder {folder} with the recordings")
        elif len(series := read(stages)) >= ROWS:
            found.append(Host(name, folder, words, sources[folder], series, np.array(offset_nt), code_nt))
    return found
