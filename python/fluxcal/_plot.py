"""A picture of a recording, for notebooks."""
from __future__ import annotations

from typing import Any, Mapping

from ._frames import frame

_QUANTITIES = ("sensor", "reference", "test", "outside", "ambient", "field")


def plot(document: Mapping[str, Any], recording: str | None = None) -> Any:
    """The three axes of a recording against time, each less its median, one below the other: a matplotlib figure. A field that was corrected has its 95 % band."""
    from matplotlib.figure import Figure

    table = frame(document, recording, kind="arrow")
    names = table.column_names
    along = next((name for name in ("time", "time_s") if name in names), None)
    times = table[along].to_pylist() if along else list(range(table.num_rows))
    figure = Figure(figsize=(9, 6), layout="constrained")
    panels = figure.subplots(3, sharex=True)
    for axis, panel in zip("xyz", panels):
        for quantity in _QUANTITIES:
            for unit in ("nt", "v"):
                if (name := f"{quantity}_{axis}_{unit}") in names:
                    values = [float("nan") if value is None else value for value in table[name].to_pylist()]
                    known = sorted(value for value in values if value == value)
                    middle = known[len(known) // 2] if known else 0.0
                    less = [value - middle for value in values]
                    (line,) = panel.plot(times, less, label=f"{name}, less {middle:.6g}", linewidth=0.9)
                    if (std := f"{quantity}_std_{axis}_{unit}") in names:
                        wide = [1.96 * (value or 0.0) for value in table[std].to_pylist()]
                        low, high = ([value + sign * width for value, width in zip(less, wide)] for sign in (-1, 1))
                        panel.fill_between(times, low, high, color=line.get_color(), alpha=0.3, linewidth=0)
        panel.grid(alpha=0.3)
        if panel.lines:
            panel.legend(loc="best", fontsize="small")
    panels[-1].set_xlabel({"time": "time, UTC", "time_s": "time_s, s"}.get(along or "", "row"))
    return figure
