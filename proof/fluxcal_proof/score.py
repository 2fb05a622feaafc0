"""All outcomes of a round, counted."""
from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from . import folder as rounds
from . import verdict
from .verdict import Outcome


def wilson(hits: int, trials: int, z: float = 1.959964) -> tuple[float, float]:
    """Wilson's interval of 95 % of a share. Wilson 1927, J. Am. Stat. Assoc. 22, 209."""
    if not trials:
        return 0.0, 1.0
    p, n = hits / trials, trials
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, float((middle - half) / (1 + z * z / n))), min(1.0, float((middle + half) / (1 + z * z / n)))


def outcomes(folder: Path) -> tuple[str, list[Outcome]]:
    """The commitment and what was made of each case; a case without an answer failed."""
    commitment, truths = rounds.open_truths(folder)
    out = []
    for name, truth in truths.items():
        path = folder / "answers" / f"{name}.json"
        answer = json.loads(path.read_text()) if path.exists() else {"entry": None, "seconds": 0.0}
        outcome = verdict.judge(name, truth, answer)
        expected = np.load(folder / "truths" / f"{name}.npy")
        if path.exists():
            with np.load(folder / "answers" / f"{name}.npz") as predicted:
                for key in predicted.files:
                    ratio = verdict.form(truth, expected, predicted[key])
                    if key == "diagnose":
                        outcome.form = ratio
                    else:
                        before = np.hypot(truth["noise_nt"], truth["before_nt"])
                        outcome.empirical = ratio * float(np.hypot(truth["noise_nt"], truth["taken_nt"]) / before)
        out.append(outcome)
    return commitment, sorted(out, key=lambda one: one.truth["number"])


def count(of: Iterable[Outcome], hit: Callable[[Outcome], bool]) -> tuple[int, int]:
    """Hits and trials."""
    all_of = list(of)
    return sum(bool(hit(one)) for one in all_of), len(all_of)


def share(hits: int, trials: int) -> str:
    """A share with Wilson's interval."""
    low, high = wilson(hits, trials)
    return f"{hits} of {trials}, {100 * hits / trials:.0f} % ({100 * low:.0f} to {100 * high:.0f})" if trials else "no case"
