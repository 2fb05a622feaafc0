"""Has each document answered by the programs and by the rivals, within a time, two at a time."""
import json
import os
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np

from . import folder as rounds
from . import rivals

# Large parts of an answer that no score reads.
LEFT_OUT = ("series", "energy", "detectable", "experiments")


def run(command: list[str], timeout: float) -> tuple[dict[str, Any] | None, float, str]:
    """A program's document, the seconds that it took, and why there is none."""
    start = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, env={**os.environ, "RAYON_NUM_THREADS": "1"})
    except subprocess.TimeoutExpired:
        return None, time.monotonic() - start, "time limit"
    seconds = time.monotonic() - start
    if done.returncode != 0:
        return None, seconds, (done.stderr.strip().splitlines() or ["no words"])[-1][:300]
    return json.loads(done.stdout), seconds, ""


def replayed(document: dict[str, Any], programs: Path, place: Path, timeout: float) -> np.ndarray | None:
    """What an answer's calibration and model predict: all sensors of all recordings in one row, missing readings as NaN."""
    place.write_text(json.dumps(document))
    predicted, _, _ = run([str(programs / "simulate"), "replay", "-q", str(place)], timeout)
    place.unlink()
    return np.concatenate([np.array(r["columns"][f"sensor_{k}_nt"], float) for r in predicted["recordings"] for k in "xyz"]) if predicted else None


def one(folder: Path, name: str, programs: Path, timeout: float) -> tuple[str, float]:
    path = folder / "documents" / f"{name}.json"
    given = json.loads(path.read_text())
    # What `--empirical` adopts has no name: it changes no verdict and no claim.
    document, seconds, why = run([str(programs / "diagnose"), "-q", "--empirical", "--refit", str(path)], timeout)
    answer: dict[str, Any] = {"seconds": seconds, "why_not": why, "entry": None}
    predicted = None
    if document:
        answer["entry"] = {k: v for k, v in document["diagnosis"][0].items() if k not in LEFT_OUT}
        # Only of a campaign in coils can readings be predicted.
        if "axes" in given.get("calibration", {}):
            predicted = replayed(document, programs, folder / "answers" / f"{name}.work.json", timeout)
    if given["recordings"][0]["procedure"] == "differential":
        document, answer["diffmag_seconds"], answer["diffmag_why_not"] = run([str(programs / "diffmag"), "-q", "--correct-clock", str(path)], timeout)
        answer["diffmag"] = document["calibration"]["differential"]["fit"] if document else None
    answer["rivals"] = rivals.all_of(given)
    if predicted is not None:
        np.save(folder / "answers" / f"{name}.npy", predicted)
    (folder / "answers" / f"{name}.json").write_text(json.dumps(answer))
    return name, seconds


def all_of(folder: Path, programs: Path, timeout: float) -> None:
    """Answers what has no answer yet."""
    rounds.refuse_if_opened(folder)
    left = [name for name in sorted(json.loads((folder / "seals.json").read_text())["seals"]) if not (folder / "answers" / f"{name}.json").exists()]
    for done, (name, seconds) in enumerate(rounds.both(one, [(folder, name, programs, timeout) for name in left]), 1):
        print(f"{done} of {len(left)}: {name} {seconds:.1f} s", flush=True)
