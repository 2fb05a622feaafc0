"""All outcomes of a round, counted."""
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import folder as rounds
from . import verdict
from .effects import KINDS
from .verdict import Outcome


@dataclass
class Round:
    """What the program and each of the others made of the same cases; `others` lack those that were not run."""

    commitment: str
    seed: int
    of: str
    diagnose: list[Outcome]
    others: dict[str, list[Outcome]]


def wilson(hits: int, trials: int, z: float = 1.959964) -> tuple[float, float]:
    """Wilson's interval of 95 % of a share. Wilson 1927, J. Am. Stat. Assoc. 22, 209."""
    if not trials:
        return 0.0, 1.0
    p, n = hits / trials, trials
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, float((middle - half) / (1 + z * z / n))), min(1.0, float((middle + half) / (1 + z * z / n)))


def read(folder: Path) -> Round:
    """Opens the truths of a round and judges all answers; a case without an answer failed."""
    commitment, truths = rounds.open_truths(folder)
    families = {kind.name: kind.family for kind in KINDS}
    own: list[Outcome] = []
    others: dict[str, list[Outcome]] = {}
    for name, truth in sorted(truths.items(), key=lambda one: one[1]["number"]):
        path = folder / "answers" / f"{name}.json"
        answer = json.loads(path.read_text()) if path.exists() else {"entry": None, "seconds": 0.0}
        own.append(verdict.judge(name, truth, answer))
        if path.exists():
            forms(own[-1], folder)
        rivals: dict[str, Any] = dict(answer.get("rivals", {}))
        if "diffmag_seconds" in answer:
            told = verdict.of_diffmag(answer["diffmag"]) if answer["diffmag"] else None
            rivals["diffmag"] = {"names": told, "seconds": answer["diffmag_seconds"]}
        for rival, said in rivals.items():
            entry = None if said["names"] is None else verdict.of_names(said["names"], families)
            others.setdefault(rival, []).append(verdict.judge(name, truth, {"entry": entry, "seconds": said["seconds"]}))
    for outcomes in (own, *others.values()):
        leave_to_hosts(outcomes)
    return Round(commitment, own[0].truth["seed"], own[0].truth["set"], own, others)


def leave_to_hosts(outcomes: list[Outcome]) -> None:
    """What is claimed in a real recording as it came is held against that answer alone, and not against each injection into it."""
    bare = lambda names: {name.split(" with ")[0] for name in names}
    recorded = {one.truth["manners"][0]: set().union(*map(bare, one.claims)) for one in outcomes if one.sort == "recorded"}
    for one in outcomes:
        if one.sort == "injected":
            one.wrong = [names for names in one.wrong if not bare(names) & recorded.get(one.truth["manners"][0], set())]


def forms(outcome: Outcome, folder: Path) -> None:
    """How far predictions of new readings are off, rms: over the fitted truth's, and over the basic model's."""
    truth, expected, place = outcome.truth, np.load(folder / "truths" / f"{outcome.name}.npy"), folder / "answers" / f"{outcome.name}.npy"
    if not len(expected) or not place.exists():
        return
    off = truth["noise_nt"] ** 2 + np.nanmean((np.load(place) - expected) ** 2)
    over = lambda left_nt: float(np.sqrt(off / (truth["noise_nt"] ** 2 + left_nt**2)))
    outcome.form, outcome.empirical = over(truth["taken_nt"]), over(truth["before_nt"])


def count(of: Iterable[Outcome], hit: Callable[[Outcome], bool]) -> tuple[int, int]:
    """Hits and trials."""
    all_of = list(of)
    return sum(bool(hit(one)) for one in all_of), len(all_of)


def share(hits: int, trials: int) -> str:
    """A share with Wilson's interval."""
    low, high = wilson(hits, trials)
    return f"{hits} of {trials}, {100 * hits / trials:.0f} % ({100 * low:.0f} to {100 * high:.0f})" if trials else "no case"
