"""Recordings and corrected series as frames of pandas, Polars or Arrow."""
from __future__ import annotations

import os
import tempfile
from datetime import datetime
from pathlib import Path
from typing import Any, Mapping

from ._run import Document, PathLike, text, to_json

# A pandas.DataFrame, a polars.DataFrame or a pyarrow.Table; none of them has to be installed.
Frame = Any


def frame(document: Mapping[str, Any], recording: str | None = None, *, kind: str = "pandas", folder: PathLike = ".") -> Frame:
    """The readings of a recording: a column each, and `time` (UTC) where the recording says when it began.

    `recording` is its id, and may be left out where there is one. `kind` is "pandas", "polars" or "arrow". Readings in a table beside the document are read from `folder`.
    """
    import pyarrow as pa

    found = _one(document, recording)
    if "table" in found:
        table = _read(Path(folder) / found["table"])
    elif "columns" in found:
        table = pa.table({name: pa.array(values, pa.float64()) for name, values in found["columns"].items()})
    else:
        raise ValueError(f"the recording {found['id']} has no readings" + (", a stage left them out" if "dropped" in found else ""))
    if "start" in found and "time_s" in table.column_names:
        start = datetime.fromisoformat(found["start"].replace("Z", "+00:00")).timestamp()
        moments = [None if second is None else round((start + second) * 1e6) for second in table["time_s"].to_pylist()]
        table = table.add_column(0, "time", pa.array(moments, pa.timestamp("us", tz="UTC")))
    return _as(table, kind)


def recording(readings: Frame, id: str, *, procedure: str = "free_run", start: str | None = None,
              conditions: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """A recording of a frame whose columns have a document's names; put it into `document["recordings"]`. `time` is left aside."""
    table, _ = _arrow(readings)
    columns = {name: table[name].cast("float64").to_pylist() for name in table.column_names if name != "time"}
    missing = {name: [None if value != value else value for value in values] for name, values in columns.items()}
    made: dict[str, Any] = {"id": id, "procedure": procedure, "conditions": dict(conditions or {}), "columns": missing}
    return {**made, "start": start} if start else made


def corrected(readings: Frame | PathLike, calibration: Document, *, kind: str | None = None, **options: Any) -> Frame:
    """The field of readings, by `correct --calibration`: `field_x_nt`, …, `field_std_x_nt`, …, `field_flags` beside what was there.

    `readings` is a frame, or a file of readings that `correct` reads (`map` is a mapping for it). A frame comes back as the same kind, a file as pandas unless `kind` says otherwise.
    """
    import pyarrow.parquet as parquet

    with tempfile.TemporaryDirectory(prefix="fluxcal-") as name:
        folder = Path(name)
        if isinstance(readings, (str, os.PathLike)):
            source, own = Path(readings), "pandas"
        else:
            table, own = _arrow(readings)
            source = folder / "readings.parquet"
            parquet.write_table(table.drop_columns([name for name in table.column_names if name == "time"]), source)
        if isinstance(calibration, Mapping):
            (folder / "calibration.json").write_text(to_json(calibration))
            calibration = folder / "calibration.json"
        text("correct", source, calibration=calibration, output=folder / "field.parquet", **options)
        return _as(_read(folder / "field.parquet"), kind or own)


def _one(document: Mapping[str, Any], id: str | None) -> Mapping[str, Any]:
    found: list[Mapping[str, Any]] = [one for one in document.get("recordings", []) if id is None or one["id"] == id]
    if len(found) != 1:
        ids = ", ".join(one["id"] for one in document.get("recordings", []))
        raise KeyError(f"name one recording of {ids or 'none'}" if id is None else f"no recording {id} among {ids or 'none'}")
    return found[0]


def _read(path: Path) -> Any:
    import pyarrow.csv
    import pyarrow.json
    import pyarrow.parquet

    readers = {".parquet": pyarrow.parquet.read_table, ".csv": pyarrow.csv.read_csv}
    return readers.get(path.suffix, pyarrow.json.read_json)(path)


def _arrow(readings: Frame) -> tuple[Any, str]:
    """A frame as an Arrow table, and the kind that it was."""
    import pyarrow as pa

    if isinstance(readings, pa.Table):
        return readings, "arrow"
    if hasattr(readings, "to_arrow"):
        return readings.to_arrow(), "polars"
    return pa.Table.from_pandas(readings, preserve_index=False).replace_schema_metadata(None), "pandas"


def _as(table: Any, kind: str) -> Frame:
    if kind == "arrow":
        return table
    if kind == "pandas":
        return table.to_pandas()
    if kind == "polars":
        import polars

        return polars.from_arrow(table)
    raise ValueError(f"found the kind {kind}; expected pandas, polars or arrow")
