"""Real recordings at rest as hosts for injected effects: which, how they are cut, and what a calibration takes up.

Nobody chooses by what is found in them later: of each instrument that lay still, the quiet stretches that its notes name, whole days or
nights.
"""
from pathlib import Path

import numpy as np

from . import alone, lengths, pairs
from .by_hand import least_squares, left, affine, test
from .programs import TOML, Programs
from .lengths import CONRAD_NT, NONE, VERNADSKY_NT
from .series import AXES, DAY_S, Series, rms

COBENZL_EARLY_S = 18.38  # what the LEMI stamps its minutes too early by: diffmag --correct-clock over twelve days
MOVES_K, QUICK_S, DAY_AND_NIGHT_S = 0.1, 10, 85_000  # a temperature that moves; a vehicle that passes in a minute is more than one reading


class Host:
    """A recording as a document, with what a calibration can take up of an effect that is added to it."""

    def __init__(self, name: str, words: str, source: str, series: Series, offset_nt: np.ndarray, code_nt: float) -> None:
        self.name, self.words, self.source, self.series, self.code_nt = name, words, source, series, code_nt
        self.rows, self.time_s, there = len(series), series.time_s, series.frame
        self.kind = next(kind for kind, column in {"pair": "test_x_nt", "scalar": "reference_nt", "ambient": "ambient_x_nt",
                                                   "single": "time_s"}.items() if column in there)
        self.instrument = "test" if self.kind == "pair" else "sensor"
        self.readings, procedure, conditions = series.vectors(self.instrument), "free_run", {}
        if self.kind == "single":  # what the field is nobody knows; its level is taken off by the offset
            offset_nt, field = -self.readings.mean(axis=0), 0 * self.readings
        else:
            field = series.vectors({"pair": "reference", "ambient": "ambient", "scalar": "sensor"}[self.kind])
        self.fields = field + offset_nt * (self.kind == "scalar")
        calibration = {"sensors": {axis: {"offset_nt": nt} for axis, nt in zip(AXES, offset_nt)}}
        if self.kind == "pair":
            d_nt, *eta = least_squares(affine("reference")(series), self.readings)
            self.fields, procedure = field @ np.array(eta), "differential"
            calibration = {"differential": {"matrix": np.array(eta).tolist(), "offset_nt": dict(zip(AXES, d_nt))}}
        elif self.kind == "ambient":
            conditions = {"orientation": np.eye(3).tolist()}
        self.document = {"fluxcal": 1, "title": name, "calibration": calibration,
                         "recordings": [series.recording("run", procedure, **conditions)]}
        design = np.column_stack([np.ones(self.rows), field - field.mean(axis=0)])
        basis, sizes, _ = np.linalg.svd(design / np.maximum(np.linalg.norm(design, axis=0), 1e-300), full_matrices=False)
        self._basis = basis[:, sizes > 1e-9]
        residual = lengths.mismatch(series, offset_nt)[:, None] if self.kind == "scalar" else self.readings
        self.scatter_nt = float(rms(self._without_constants(residual), axis=None))

    def _without_constants(self, columns: np.ndarray) -> np.ndarray:
        return columns - self._basis @ (self._basis.T @ columns)

    def size_nt(self, added: np.ndarray) -> float:
        """The measure of strengths: rms of what is left of what is added to the readings (rows × 3, nT) when all constants of the basic
        model are fitted to it, δM_i = Σ_j a_ij B_j + o_i, in the sensor that keeps most. Beside a scalar magnetometer: of the change of
        the vector's length, less a level and slopes along the readings."""
        if self.kind == "scalar":
            added = (np.linalg.norm(self.fields + added, axis=1) - np.linalg.norm(self.fields, axis=1))[:, None]
        return float(rms(self._without_constants(added)).max())

    @property
    def has(self) -> set[str]:
        """What members may need: a field that is known as it moves, a second vector, a temperature that moves, a day with its night, or
        readings quick enough for a vehicle."""
        rules = {"field": self.kind != "single", "day": np.ptp(self.time_s) > DAY_AND_NIGHT_S and self.series.start_s > 0,
                 "quick": np.median(np.diff(self.time_s)) <= QUICK_S}
        rules |= {name: np.ptp(self.series[name]) > MOVES_K for name in self.series.frame if name.endswith("temperature_c")}
        return {self.kind} | {name for name, holds in rules.items() if holds}


def between(series: Series, from_s: float, to_s: float) -> Series:
    """What lies between two moments, on a clock that is zero at the first."""
    cut = series.between(from_s, to_s)
    return cut.on_clock(series.start_s + from_s) if series.start_s else cut


def pair(p: Programs, *names: str) -> Series:
    reference, test = pairs.read(p, *names)
    return reference.joined(test).complete()


def conrad_vectors(p: Programs) -> Series:
    """The test instrument of the pair in the field that the other one tells it has, by least squares."""
    both = pair(p, "fge-2022-08-10", "lemi036").means(60)
    ambient = both.vectors("test") - left(affine("reference"), test, both, both)
    return both.only("test", "sensor").assign(**{f"ambient_{axis}_nt": column for axis, column in zip(AXES, ambient.T)})


def cobenzl_night(p: Programs) -> Series:
    reference, test = pairs.read(p, "didd", "lemi025")
    test = test.at(reference.time_s - COBENZL_EARLY_S).assign(time_s=reference.time_s)
    return between(reference.joined(test).complete(), DAY_S - 2 * 3600, DAY_S + 7.5 * 3600)


# Folder, how it is read, what maker or logger state as offset (nT), and the width of a code (nT; 0 where readings are means).
CANDIDATES = {
    "conrad-scalar-20s": ("wic-conrad-2022-08", lambda p: lengths.read_conrad(p, "2022-08-03", 20), CONRAD_NT, 0.0),
    "conrad-scalar-60s": ("wic-conrad-2022-08", lambda p: lengths.read_conrad(p, "2022-08-10", 60), CONRAD_NT, 0.0),
    "conrad-vectors": ("wic-conrad-2022-08", conrad_vectors, NONE, 0.0),
    "conrad-fge": ("wic-conrad-2022-08", lambda p: between(p.read("fge-2022-08-10"), 7200, 8100), NONE, 0.001),
    "vernadsky": ("aia-vernadsky-2020-03-03", lambda p: p.read("vernadsky").complete(), VERNADSKY_NT, 0.01),
    **{f"boulder-{day}": ("usgs-bou-2016-01", lambda p, day=day: between(p.read("boulder-raw").complete(), (day - 1) * DAY_S, day * DAY_S),
                          NONE, 0.01) for day in (8, 16, 25)},
    "hmc5883l": ("marg-hmc5883l-sunsided", lambda p: alone.read_marg(p, 0.2), NONE, 0.0),
    "w2naf-night": ("hamsci-w2naf-2024-05-10", lambda p: between(p.read("w2naf"), 7200, 28_800).means(30, 0).complete(), NONE, 0.0),
    "conrad-pair": ("wic-conrad-2022-08", lambda p: pair(p, "fge-2022-08-10", "lemi036").means(120), NONE, 0.0),
    "boulder-published": ("usgs-bou-2016-01", lambda p: between(pair(p, "boulder-raw", "boulder-adjusted"), 7 * DAY_S, 8 * DAY_S), NONE, 0.01),
    "cobenzl-night": ("wik-cobenzl-2011-09a", cobenzl_night, NONE, 0.0),
    "meson-hall": ("tucan-fluxgates-2019-08-09-quiet", lambda p: between(p.read("meson-hall").complete(), 408, 1060), NONE, 0.0),
}


def hosts(data: Path, programs: Path) -> list[Host]:
    """The candidates whose folder is there."""
    stages, found = Programs(programs, data), []
    for name, (folder, read, offset_nt, code_nt) in CANDIDATES.items():
        if (Path(data) / folder).is_dir():
            found.append(Host(name, TOML["hosts"][name], TOML["sources"][folder], read(stages), offset_nt, code_nt))
        else:
            print(f"{name}: no host, no folder {folder} with the recordings")
    return found
