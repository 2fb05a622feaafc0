"""Recordings as columns: what `ingest` read, cut, averaged and put side by side."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Series:
    """Columns by name, with `time_s`; NaN where a reading is missing."""

    frame: pd.DataFrame
    start_s: float = 0.0  # seconds since 1970 at which time_s is zero; 0 where no moment is stated

    @classmethod
    def of(cls, document: dict) -> Series:
        """The first recording of a document."""
        recording = document["recordings"][0]
        start_s = pd.Timestamp(recording["start"]).timestamp() if "start" in recording else 0.0
        return cls(pd.DataFrame(recording["columns"]).apply(pd.to_numeric, errors="coerce"), start_s)

    def __len__(self) -> int:
        return len(self.frame)

    def __contains__(self, name: str) -> bool:
        return name in self.frame

    def __getitem__(self, name: str) -> np.ndarray:
        return self.frame[name].to_numpy(float)

    @property
    def time_s(self) -> np.ndarray:
        return self["time_s"]

    def vectors(self, quantity: str) -> np.ndarray:
        """`{quantity}_x_nt`, `_y_nt`, `_z_nt`, one row a reading."""
        return self.frame[[f"{quantity}_{axis}_nt" for axis in AXES]].to_numpy(float)

    def assign(self, **columns: object) -> Series:
        return replace(self, frame=self.frame.assign(**columns))

    def only(self, *beginnings: str) -> Series:
        """Time, and the columns that begin so."""
        return replace(self, frame=self.frame[[c for c in self.frame if c.startswith(("time_s", *beginnings))]])

    def renamed(self, old: str, new: str) -> Series:
        """Readings of one instrument under another name, `sensor_x_nt` as `test_x_nt`."""
        names = {c: new + c.removeprefix(old) for c in self.frame if c.startswith(old) and c.endswith("_nt")}
        return replace(self, frame=self.frame.rename(columns=names))

    def rows(self, keep: np.ndarray | slice) -> Series:
        return replace(self, frame=self.frame[keep].reset_index(drop=True))

    def complete(self) -> Series:
        """The rows with every reading there."""
        return self.rows(np.isfinite(self.frame).all(axis=1).to_numpy())

    def between(self, from_s: float, to_s: float) -> Series:
        return self.rows((self.time_s >= from_s) & (self.time_s < to_s))

    def split(self, at_s: float) -> tuple[Series, Series]:
        """What is before a moment, and the rest."""
        return self.between(-np.inf, at_s), self.between(at_s, np.inf)

    def split_share(self, share: float) -> tuple[Series, Series]:
        """Cut after a share of the time that is covered."""
        first, last = self.time_s[[0, -1]]
        return self.split(first + share * (last - first))

    def on_clock(self, start_s: float) -> Series:
        """The same readings on a clock that is zero at `start_s`."""
        return Series(self.frame.assign(time_s=self.time_s + (self.start_s - start_s)), start_s)

    def means(self, step_s: float, least: float = 0.9) -> Series:
        """Means over blocks of the clock, at the middle of the block; blocks with less than the share `least`
        of the usual number of rows are left out. A mean with a reading missing is missing."""
        block = np.floor(self.time_s / step_s)
        first = np.flatnonzero(np.diff(block, prepend=np.nan) != 0)
        number = np.diff(first, append=len(block))
        means = pd.DataFrame({c: np.add.reduceat(self[c], first) / number for c in self.frame})
        means["time_s"] = (block[first] + 0.5) * step_s
        return replace(self, frame=means).rows(number >= least * np.sort(number)[len(number) // 2])

    def joined(self, other: Series) -> Series:
        """The rows whose times both have, to a millisecond, with the columns of both."""
        def keyed(series: Series) -> pd.DataFrame:
            frame = series.frame.set_index(np.floor(1000 * series.time_s + 0.5).astype(np.int64))
            return frame[~frame.index.duplicated(keep="last")]
        right = keyed(other.on_clock(self.start_s)).drop(columns="time_s")
        left = keyed(self).drop(columns=right.columns, errors="ignore")
        return replace(self, frame=left.join(right, how="inner").reset_index(drop=True))

    def at(self, times: np.ndarray) -> Series:
        """The readings at other times, by straight lines between neighbours; missing outside, and where
        neighbours are more than 1.5 of the usual step apart."""
        own = self.time_s
        after = np.clip(np.searchsorted(own, times), 1, len(own) - 1)
        step = own[after] - own[after - 1]
        share = (times - own[after - 1]) / step
        usual = np.sort(np.diff(own))[(len(own) - 1) // 2]
        missing = (share < 0) | (share > 1) | (step > 1.5 * usual) & (share > 0) & (share < 1)

        def line(values: np.ndarray) -> np.ndarray:
            left, right = values[after - 1], values[after]
            between = np.where(share == 0, left, np.where(share == 1, right, left + share * (right - left)))
            return np.where(missing, np.nan, between)
        lines = {c: line(self[c]) for c in self.frame}
        return replace(self, frame=pd.DataFrame(lines | {"time_s": times}))

    def recording(self, id: str, procedure: str, **conditions: object) -> dict:
        """A recording of a document."""
        values = self.frame.astype(object).where(np.isfinite(self.frame), None)
        recording = {"id": id, "procedure": procedure,
                     "columns": {c: values[c].tolist() for c in sorted(values)}}
        if self.start_s > 0:
            moment = pd.Timestamp(round(1e6 * self.start_s), unit="us", tz="UTC")
            recording["start"] = moment.isoformat().replace("+00:00", "Z")
        if conditions:
            recording["conditions"] = conditions
        return recording


def rms(values: np.ndarray, axis: int | None = 0) -> np.ndarray:
    """Root of the mean of squares, over what is there."""
    return np.sqrt(np.nanmean(np.square(values), axis=axis))


def scatter(values: np.ndarray) -> np.ndarray:
    """Standard deviation about the own mean, of each column."""
    return rms(values - np.nanmean(values, axis=0))
