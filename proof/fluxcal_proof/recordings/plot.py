"""Small pictures: what is left against time, one panel an axis; the same readings give the same bytes."""

from __future__ import annotations

import io

import matplotlib
import numpy as np

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the backend)

BINS = 220  # along a panel; each keeps its least and its greatest value
STYLE = {"svg.hashsalt": "fluxcal", "svg.fonttype": "none", "font.size": 8, "lines.linewidth": 0.6}
COLOURS = ("#c2410c", "#1d4ed8", "#15803d")


def thin(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least and the greatest of each bin of x, in order: peaks survive."""
    keep = np.isfinite(x) & np.isfinite(y)
    x, y = x[keep], y[keep]
    if len(x) <= 2 * BINS:
        return x, y
    edges = np.searchsorted(x, np.linspace(x[0], x[-1], BINS + 1)[1:-1])
    parts = [part for part in np.split(np.arange(len(x)), edges) if len(part)]
    rows = sorted({part[i] for part in parts for i in (np.argmin(y[part]), np.argmax(y[part]))})
    return x[rows], y[rows]


def svg(title: str, hours: np.ndarray, panels: dict[str, dict[str, np.ndarray]], from_h: float) -> str:
    """Panels by the label of y, of lines by their label; the dashed line is where the part held out begins."""
    with matplotlib.rc_context(STYLE):
        figure, axes = plt.subplots(len(panels), sharex=True, squeeze=False, layout="constrained",
                                    figsize=(7.2, 0.8 + 1.1 * len(panels)))
        for axis, (label, lines) in zip(axes[:, 0], panels.items()):
            for colour, (name, values) in zip(COLOURS, lines.items()):
                axis.plot(*thin(hours, values), color=colour, label=name)
            axis.axvline(from_h, color="#666", linestyle="--")
            axis.set_ylabel(label)
        axes[0, 0].set_title(title, fontsize=8, loc="left")
        axes[-1, 0].set_xlabel("time, h")
        axes[-1, 0].legend(fontsize=7, ncols=3, loc="upper left", frameon=False)
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(figure)
    return text.getvalue()
