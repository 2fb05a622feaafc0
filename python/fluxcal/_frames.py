"""Recordings and corrected series as frames of pandas, Polars or Arrow."""
from __future__ import annotations

import os
import tempfile
from datetime import datetime
from pathlib import Path
from typing import Any, Mapping

from ._run import Document, PathLike, text

# A pandas.DataFrame, a polars.DataFrame or a pyarrow.Table; none of them has to be installed.
Frame = Any


def frame(document: Mapping[str, Any], recording: str | None = None, *, kind: str = "pandas", folder: PathLike = ".") -> Frame:
    """The readings of a recording: a column each, and `time` (UTC) where the recording says when it began.

    `recording` is its id, and may be left out where there is one. `kind` is "pandas", "polars" or "arrow". Readings in a table beside the document are read from `folder`.
    """
    import pyarrow as pa

    named = {one["id"]: one for one in document.get("recordings", [])}
    if recording is None and len(named) == 1:
        (recording,) = named
    if recording not in named:
        raise KeyError(f"found the recording {recording}; expected one of {', '.join(named) or 'none'}")
    found = named[recording]
    if "table" in found:
        table = _read(Path(folder) / found["table"])
    elif "columns" in found:
        table = pa.table({name: pa.array(values, pa.float64()) for name, values in found["columns"].items()})
    else:
        raise ValueError(f"the recording {recording} has no readings" + (", a stage left them out" if "dropped" in found else ""))
    if "start" in found and "time_s" in table.column_names:
        start = datetime.fromisoformat(found["start"].replace("Z", "+00:00")).timestamp()
        moments = [None if second is None else round((start + second) * 1e6) for second in table["time_s"].to_pylist()]
        table = table.add_column(0, "time", pa.array(moments, pa.timestamp("us", tz="UTC")))
    return _as(table, kind)


def results(document: Mapping[str, Any], *, kind: str = "pandas") -> dict[str, Frame]:
    """What stages found as columns, a frame for each, by its path: `results(document)["calibration.sensors.x.noise.allan"]`.

    Columns are lists of numbers of one length that stand side by side: residuals, spectra, Allan deviations, series of a diagnosis.
    """
    import pyarrow as pa

    found: dict[str, Frame] = {}

    def search(path: str, part: Any) -> None:
        children = part.items() if isinstance(part, Mapping) else enumerate(part) if isinstance(part, list) else ()
        columns = {name: values for name, values in part.items() if _numbers(values)} if isinstance(part, Mapping) else {}
        if len(columns) > 1 and len({len(values) for values in columns.values()}) == 1:
            found[path] = _as(pa.table({name: pa.array(values, pa.float64()) for name, values in columns.items()}), kind)
        for name, child in children:
            search(f"{path}.{name}" if path else str(name), child)

    for part in ("calibration", "diagnosis"):
        search(part, document.get(part))
    return found


def _numbers(values: Any) -> bool:
    number = lambda value: value is None or (isinstance(value, (int, float)) and not isinstance(value, bool))
    return isinstance(values, list) and len(values) > 1 and all(map(number, values))


def recording(readings: Frame, id: str, *, procedure: str = "free_run", start: str | None = None,
              conditions: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """A recording of a frame whose columns have a document's names; put it into `document["recordings"]`. `time` is left aside."""
    table, _ = _arrow(readings)
    numbers = {name: table[name].cast("float64").to_pylist() for name in table.column_names}
    columns = {name: [None if value != value else value for value in values] for name, values in numbers.items()}
    made = {"id": id, "procedure": procedure, "conditions": dict(conditions or {}), "columns": columns}
    return {**made, "start": start} if start else made


def corrected(readings: Frame | PathLike, calibration: Document, *, kind: str | None = None, **options: Any) -> Frame:
    """The field of readings, by `correct --calibration`: `field_x_nt`, …, `field_std_x_nt`, …, `field_flags` beside what was there.

    `readings` is a frame, or a file of readings that `correct` reads (`map` is a mapping for it). A frame comes back as the same kind, a file as pandas unless `kind` says otherwise.
    """
    import pyarrow.parquet as parquet

    own = "pandas"
    with tempfile.TemporaryDirectory(prefix="fluxcal-") as folder:
        source, field = Path(folder) / "readings.parquet", Path(folder) / "field.parquet"
        if isinstance(readings, (str, os.PathLike)):
            source = Path(readings)
        else:
            table, own = _arrow(readings)
            parquet.write_table(table, source)
        text("correct", source, calibration=calibration, output=field, **options)
        return _as(_read(field), kind or own)


def _read(path: Path) -> Any:
    import pyarrow.csv
    import pyarrow.json
    import pyarrow.parquet

    readers = {".parquet": pyarrow.parquet.read_table, ".csv": pyarrow.csv.read_csv}
    return readers.get(path.suffix, pyarrow.json.read_json)(path)


def _arrow(readings: Frame) -> tuple[Any, str]:
    """A frame as an Arrow table without `time`, and the kind that it was."""
    import pyarrow as pa

    if isinstance(readings, pa.Table):
        table, kind = readings, "arrow"
    elif hasattr(readings, "to_arrow"):
        table, kind = readings.to_arrow(), "polars"
    else:
        table, kind = pa.Table.from_pandas(readings, preserve_index=False).replace_schema_metadata(None), "pandas"
    return table.select([name for name in table.column_names if name != "time"]), kind


def _as(table: Any, kind: str) -> Frame:
    if kind == "polars":
        import polars

        return polars.from_arrow(table)
    kinds = {"pandas": table.to_pandas, "arrow": lambda: table}
    if kind not in kinds:
        raise ValueError(f"found the kind {kind}; expected pandas, polars or arrow")
    return kinds[kind]()
