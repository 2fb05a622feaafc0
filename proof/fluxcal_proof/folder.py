"""A round in a folder: documents, sealed truths, answers; what was opened is not answered again."""
import hashlib
import io
import json
import secrets
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from . import cases, plan
from .plan import Case
from .recordings import hosts


class Refused(Exception):
    """A step that would break the seals."""


def both(of: Callable[..., Any], jobs: Iterable[tuple]) -> Iterator[Any]:
    """Results in order, two at a time; a job has the arguments."""
    with ProcessPoolExecutor(2) as pool:
        yield from pool.map(of, *zip(*jobs))


def digest(truth: bytes, expected: bytes) -> str:
    """The seal of a truth: SHA-256 over its JSON and the readings without noise."""
    return hashlib.sha256(truth + expected).hexdigest()


def write(folder: Path, seed: int, of: str, nonce: str, number: int, case: Case | None) -> tuple[str, str]:
    """Writes document, truth and readings without noise of a case, which is made where there is none yet; its name and seal."""
    name, case = hashlib.sha256(f"{seed}/{number}".encode()).hexdigest()[:10], case or cases.make(seed, number, of)
    (folder / "documents" / f"{name}.json").write_text(json.dumps(case.document))
    truth = json.dumps({"seed": seed, "number": number, "set": of, "nonce": nonce, **case.truth}, sort_keys=True).encode()
    expected = io.BytesIO()
    np.save(expected, case.expected)
    (folder / "truths" / f"{name}.json").write_bytes(truth)
    (folder / "truths" / f"{name}.npy").write_bytes(expected.getvalue())
    return name, digest(truth, expected.getvalue())


def make(folder: Path, seed: int | None, count: int, of: str, only: str, real: tuple[Path, Path] | None = None) -> str:
    """Makes and seals a round; the commitment is the SHA-256 over all seals in the order of their names.

    `real` are the folders of real recordings and of the programs that read them."""
    if folder.exists():
        raise Refused(f"{folder} is there already: a round needs a folder of its own")
    seed = secrets.randbelow(2**32) if seed is None else seed
    found = [(number, None) for number in plan.numbers(count, only)] + (hosts.cases(*real, seed) if real else [])
    for part in ("documents", "truths", "answers"):
        (folder / part).mkdir(parents=True)
    seals = dict(sorted(both(write, [(folder, seed, of, secrets.token_hex(16), *one) for one in found])))
    commitment = hashlib.sha256("".join(seals.values()).encode()).hexdigest()
    (folder / "seals.json").write_text(json.dumps({"commitment": commitment, "seals": seals}, indent=1) + "\n")
    return commitment


def refuse_if_opened(folder: Path) -> None:
    """Answers after the opening of truths are refused."""
    if (folder / "opened").exists():
        raise Refused("the truths of this round are open: it takes no more answers")


def open_truths(folder: Path) -> tuple[str, dict[str, dict[str, Any]]]:
    """The commitment and all truths, each held against its seal; from now on there are no answers."""
    sealed = json.loads((folder / "seals.json").read_text())
    if hashlib.sha256("".join(sealed["seals"].values()).encode()).hexdigest() != sealed["commitment"]:
        raise Refused("the seals are not those of the commitment")
    (folder / "opened").write_text(sealed["commitment"] + "\n")
    truths = {}
    for name, seal in sealed["seals"].items():
        truth = (folder / "truths" / f"{name}.json").read_bytes()
        if digest(truth, (folder / "truths" / f"{name}.npy").read_bytes()) != seal:
            raise Refused(f"the truth of {name} is not the one that was sealed")
        truths[name] = json.loads(truth)
    return sealed["commitment"], truths
