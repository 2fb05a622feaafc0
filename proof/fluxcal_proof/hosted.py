"""Real recordings as cases: as they came, where nothing may be claimed, and with an effect added to their readings."""
from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .cases import Case

INJECTED, RECORDED = 1_000_000, 2_000_000
COUNT = 100


def case(document: dict[str, Any], sort: str, rows: int, words: str, effects: list[dict[str, Any]]) -> Case:
    """A document under a neutral title; what it predicts is not held against a truth, which nobody knows."""
    truth = dict(sort=sort, effects=effects, noise_nt=0.0, rows=rows, manners=[words])
    return Case({**document, "title": "a recording"}, truth, np.zeros(0))


def cases(data: Path, programs: Path, seed: int) -> list[tuple[int, Case]]:
    """At least a hundred injections where the hosts carry them, then the hosts themselves, with numbers of their own."""
    from . import recordings

    found = recordings.hosts(data, programs)
    rows = {host.name: host.rows for host in found}
    out = []
    for i, one in enumerate(recordings.injections(found, seed, COUNT)):
        t = one.truth
        right = [(name.split()[0], " ".join(name.split()[1:])) for name in t["accepted"]]
        effect = dict(kind=t["member"], form="in a real recording", family=t["family"], source=t["host"], strength=float(t["strength"]), right=right,
                      undecidable=False, left_nt=float(t["left_nt"]), parameters={k: float(v) for k, v in t["parameters"].items() if np.isscalar(v)})
        out.append((INJECTED + i, case(one.document, "injected", rows[t["host"]], t["host"], [effect])))
    return out + [(RECORDED + i, case(host.document, "recorded", host.rows, host.name, [])) for i, host in enumerate(found)]
