"""A picture of a recording, for notebooks."""
from __future__ import annotations

from typing import Any, Mapping

from ._frames import frame, results

_QUANTITIES = ("sensor", "reference", "test", "outside", "ambient", "field")


def plot(document: Mapping[str, Any], recording: str | None = None, *, result: str | None = None) -> Any:
    """The three axes of a recording against time, each less its median, one below the other: a matplotlib figure. A field that was corrected has its 95 % band.

    `result` draws one of `results` instead, by its path: each column against the first.
    """
    from matplotlib.figure import Figure

    if result is not None:
        return _result(results(document), result)
    table = frame(document, recording)
    along = next((name for name in ("time", "time_s") if name in table), None)
    times = table[along] if along else table.index
    figure = Figure(figsize=(9, 6), layout="constrained")
    panels = figure.subplots(3, sharex=True)
    for axis, panel in zip("xyz", panels):
        of_axis = [(quantity, f"{axis}_{unit}") for quantity in _QUANTITIES for unit in ("nt", "v")]
        for quantity, rest in [one for one in of_axis if "_".join(one) in table]:
            values = table[f"{quantity}_{rest}"]
            less = values - values.median()
            (line,) = panel.plot(times, less, label=f"{quantity}_{rest}, less {values.median():.6g}", linewidth=0.9)
            if (std := f"{quantity}_std_{rest}") in table:
                wide = 1.96 * table[std].fillna(0.0)
                panel.fill_between(times, less - wide, less + wide, color=line.get_color(), alpha=0.3, linewidth=0)
        panel.grid(alpha=0.3)
        if panel.lines:
            panel.legend(loc="best", fontsize="small")
    panels[-1].set_xlabel({"time": "time, UTC", "time_s": "time_s, s"}.get(along or "", "row"))
    return figure


def _result(found: Mapping[str, Any], path: str) -> Any:
    from matplotlib.figure import Figure

    if path not in found:
        raise KeyError(f"found the result {path}; expected one of {', '.join(found) or 'none'}")
    table = found[path]
    # Where a document says which column the others stand along, it is `x`.
    along = "x" if "x" in table else table.columns[0]
    figure = Figure(figsize=(9, 5), layout="constrained")
    panel = figure.subplots()
    wide = table[along].min() > 0 and table[along].max() > 1000 * table[along].min()
    table.plot(x=along, ax=panel, style=".-", grid=True, logx=bool(wide), logy=bool(wide and (table.min() > 0).all()))
    panel.set_title(path, fontsize="medium")
    return figure
