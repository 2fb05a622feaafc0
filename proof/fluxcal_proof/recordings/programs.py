"""The programs as they are shipped, each run by itself, and the recordings that they read, as columns."""
import json
import os
import subprocess
import tempfile
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

AXES = ("x", "y", "z")
DAY_S = 86_400.0
TOML = tomllib.loads(Path(__file__).with_name("sets.toml").read_text())
FIXTURES = Path(__file__).parents[3] / "fixtures"


@dataclass(frozen=True)
class Series:
    """Columns by name, with `time_s`; NaN where a reading is missing."""

    frame: pd.DataFrame
    start_s: float = 0.0  # seconds since 1970 at which time_s is zero; 0 where no moment is stated

    @classmethod
    def of(cls, document: dict) -> "Series":
        """The first recording of a document."""
        recording = document["recordings"][0]
        start_s = pd.Timestamp(recording["start"]).timestamp() if "start" in recording else 0.0
        return cls(pd.DataFrame(recording["columns"]).apply(pd.to_numeric, errors="coerce"), start_s)

    def __len__(self) -> int:
        return len(self.frame)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.frame[name].to_numpy(float)

    @property
    def time_s(self) -> np.ndarray:
        return self["time_s"]

    def vectors(self, instrument: str) -> np.ndarray:
        """`{instrument}_x_nt`, `_y_nt`, `_z_nt`, one row a reading."""
        return self.frame[[f"{instrument}_{axis}_nt" for axis in AXES]].to_numpy(float)

    def assign(self, **columns: object) -> "Series":
        return replace(self, frame=self.frame.assign(**columns))

    def only(self, old: str, new: str = "") -> "Series":
        """Time and the vectors of one instrument, which may get another name."""
        names = {f"{old}_{axis}_nt": f"{new or old}_{axis}_nt" for axis in AXES}
        return replace(self, frame=self.frame[["time_s", *names]].rename(columns=names))

    def rows(self, keep: np.ndarray | slice) -> "Series":
        return replace(self, frame=self.frame[keep].reset_index(drop=True))

    def complete(self) -> "Series":
        """The rows with every reading there."""
        return replace(self, frame=self.frame.dropna(ignore_index=True))

    def between(self, from_s: float, to_s: float) -> "Series":
        return self.rows((self.time_s >= from_s) & (self.time_s < to_s))

    def split(self, at_s: float = 0.0, share: float | None = None) -> "tuple[Series, Series]":
        """What is before a moment, which may be a share of the time that is covered, and the rest."""
        at_s = at_s if share is None else self.time_s[0] + share * np.ptp(self.time_s)
        return self.between(-np.inf, at_s), self.between(at_s, np.inf)

    def on_clock(self, start_s: float) -> "Series":
        """The same readings on a clock that is zero at `start_s`."""
        return Series(self.frame.assign(time_s=self.time_s + (self.start_s - start_s)), start_s)

    def means(self, step_s: float, least: float = 0.9) -> "Series":
        """Means over blocks of the clock, at their middle; blocks with less than the share `least` of the usual rows are left out."""
        block = np.floor(self.time_s / step_s)
        first = np.flatnonzero(np.diff(block, prepend=np.nan))
        number = np.diff(first, append=len(block))
        means = pd.DataFrame({column: np.add.reduceat(self[column], first) / number for column in self.frame})
        usual = np.sort(number)[len(number) // 2]
        return replace(self, frame=means).assign(time_s=(block[first] + 0.5) * step_s).rows(number >= least * usual)

    def joined(self, other: "Series") -> "Series":
        """The rows whose times both have, to a millisecond, with the columns of both."""
        left, right = (one.frame.set_index(np.rint(1000 * one.time_s).astype(np.int64)) for one in (self, other.on_clock(self.start_s)))
        return replace(self, frame=left.join(right.drop(columns="time_s"), how="inner").reset_index(drop=True))

    def at(self, times: np.ndarray) -> "Series":
        """The readings at other times, by straight lines; missing outside, and between neighbours more than 1.5 usual steps apart."""
        own = self.time_s
        steps, after = np.diff(own), np.clip(np.searchsorted(own, times), 1, len(own) - 1)
        gap = (steps[after - 1] > 1.5 * np.sort(steps)[len(steps) // 2]) & (times != own[after])
        lines = {column: np.where(gap, np.nan, np.interp(times, own, self[column], np.nan, np.nan)) for column in self.frame}
        return replace(self, frame=pd.DataFrame(lines | {"time_s": times}))

    def recording(self, id: str, procedure: str, **conditions: object) -> dict:
        """A recording of a document."""
        values = self.frame.astype(object).where(self.frame.notna(), None)
        recording = {"id": id, "procedure": procedure, "columns": {column: values[column].tolist() for column in sorted(values)}}
        if self.start_s:
            moment = pd.Timestamp(round(1e6 * self.start_s), unit="us", tz="UTC")
            recording["start"] = moment.isoformat().replace("+00:00", "Z")
        return recording | ({"conditions": conditions} if conditions else {})


def rms(values: np.ndarray, axis: int | None = 0) -> np.ndarray:
    """Root of the mean of squares, over what is there."""
    return np.sqrt(np.nanmean(np.square(values), axis=axis))


def scatter(values: np.ndarray) -> np.ndarray:
    """Standard deviation about the own mean, of each column."""
    return rms(values - np.nanmean(values, axis=0))


def relaxed(t: np.ndarray, x: np.ndarray, tau: float) -> np.ndarray:
    """τ dy/dt = x − y, exact for x straight between rows; at rest in the first row."""
    y, step = np.array(x, float), np.diff(t)
    lag = np.diff(x) / step * tau
    for row, decay in enumerate(np.exp(-step / tau)):
        y[row + 1] = x[row + 1] - lag[row] + (y[row] - x[row] + lag[row]) * decay
    return y


class Refused(Exception):
    """A program refuses, in its own words."""

    def __init__(self, program: str, words: str) -> None:
        super().__init__(words)
        self.program = program


@dataclass(frozen=True)
class Programs:
    """Programs in one folder, recordings in another."""

    folder: Path
    data: Path

    def read(self, name: str) -> Series:
        """A recording of sets.toml, by `ingest`."""
        pattern, *mapping = TOML["files"][name]
        mapped = ["--map", f"{FIXTURES}/{mapping[0]}.json", *mapping[1:]] if mapping else []
        files = sorted(self.data.glob(pattern)) or [self.data / pattern]  # what is missing `ingest` refuses
        return Series.of(self._run("ingest", ["--inline", *mapped], *map(str, files)))

    def ask(self, program: str, arguments: list[str], *recordings: dict, given: dict | None = None, against: dict | None = None) -> dict:
        """The answer to a document of recordings, with calibration and instrument as given; `against` is another to hold it against."""
        with tempfile.TemporaryDirectory() as folder:
            def write(name: str, **content: object) -> str:
                Path(folder, name).write_text(json.dumps({"fluxcal": 1, **content}))
                return f"{folder}/{name}"
            against_it = ["--against", write("simulated.json", recordings=[against])] if against else []
            return self._run(program, arguments + against_it, write("document.json", recordings=recordings, **given or {}))

    def _run(self, program: str, arguments: list[str], *files: str) -> dict:
        one_thread = os.environ | {"RAYON_NUM_THREADS": "1"}  # the answer does not depend on the number
        run = subprocess.run([self.folder / program, *arguments, "-q", *files], capture_output=True, text=True, check=False, env=one_thread)
        if run.returncode == 0:
            return json.loads(run.stdout)
        words = run.stderr.strip().removeprefix(f"{program}: ").replace(f"{Path(files[0]).parent}/", "")
        raise Refused(program, words.replace("document.json, ", "").replace("document.json", "the document"))
