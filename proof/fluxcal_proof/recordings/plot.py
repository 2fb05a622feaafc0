"""Small pictures: what is left against time, one panel an axis; the same readings give the same bytes."""
import io

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from .page import Page

BINS = 120  # along a panel; each keeps its least and its greatest value
STYLE = {"svg.hashsalt": "fluxcal", "svg.fonttype": "none", "font.size": 8, "lines.linewidth": 0.6}


def thin(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least and the greatest of each bin of x, in order: peaks survive."""
    edges = np.searchsorted(x, np.linspace(x[0], x[-1], BINS + 1)[1:-1])
    parts = [part for part in np.split(np.arange(len(x)), edges) if len(part)]
    rows = sorted({part[row] for part in parts for row in (np.argmin(y[part]), np.argmax(y[part]))})
    return x[rows], y[rows]


def svg(page: Page, hours: list[np.ndarray], panels: dict[str, dict[str, np.ndarray]]) -> None:
    """Panels by the label of y, of lines by their label, over both parts; a dashed line is where the part held out begins."""
    with rc_context(STYLE):
        figure = Figure((7.2, 0.8 + 1.1 * len(panels)), layout="constrained")
        axes = figure.subplots(len(panels), sharex=True, squeeze=False)[:, 0]
        for axis, (label, lines) in zip(axes, panels.items()):
            for colour, (name, values) in zip(("#c2410c", "#1d4ed8", "#15803d"), lines.items()):
                axis.plot(*thin(np.concatenate(hours), values), color=colour, label=name)
            axis.axvline(hours[1][0], color="#666", linestyle="--")
            axis.set_ylabel(label)
        axes[0].set_title(page.words["plot_title"].format(held_out=page.words["parts"][1]), fontsize=8, loc="left")
        axes[-1].set_xlabel("time, h")
        axes[-1].legend(fontsize=7, ncols=3, loc="upper left", frameon=False)
        text = io.StringIO()
        FigureCanvasSVG(figure).print_svg(text, metadata={"Date": None, "Creator": None})
    name = page.words["plot"]
    page.say(f"![what is left before and after]({name})")
    page.plots[name] = text.getvalue()
