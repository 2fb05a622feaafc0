"""The job on a cluster of two workers gives what the programs give one after the other, also where a worker is lost half-way.

    python fleet/test_fleet.py PROGRAMS FOLDER

FOLDER must be new. It needs Java 17 or newer, and what requirements.txt names.
"""

import glob
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pyarrow.compute as pc
import pyarrow.parquet as pq

import network
from cluster import HERE, Cluster


def spoil(readings):
    """A missing day, an empty one, a folder without a file, a file that is cut short; an offset that jumps by 40 nT."""
    file = lambda station, day: f"{readings}/station={station}/day={day}/readings.parquet"
    os.remove(file("OBS01", "2026-02-27"))
    os.rmdir(os.path.dirname(file("OBS01", "2026-02-27")))
    os.remove(file("OBS01", "2026-03-02"))
    empty = file("OBS02", "2026-02-28")
    pq.write_table(pq.read_table(empty).slice(0, 0), empty)
    for day in ("2026-03-02", "2026-03-03"):
        table = pq.read_table(file("SAT03", day))
        jumped = pc.add(table["sensor_x_v"], 0.005)
        pq.write_table(table.set_column(table.column_names.index("sensor_x_v"), "sensor_x_v", jumped), file("SAT03", day))
    broken = file("SAT03", "2026-03-01")
    whole = open(broken, "rb").read()
    open(broken, "wb").write(whole[: len(whole) // 2])


def tree(folder):
    """Every file with its bytes; of hidden files none may be left."""
    files = {}
    for path, _, names in os.walk(folder):
        for name in names:
            with open(os.path.join(path, name), "rb") as file:
                files[os.path.relpath(os.path.join(path, name), folder)] = file.read()
    return files


def by_hand(path, readings, programs, out):
    """The same with the programs alone, written without a line of the job."""

    def run(name, *arguments, text=None):
        done = subprocess.run([os.path.join(programs, name), *arguments], input=text, capture_output=True, text=True)
        return done.stdout if done.returncode == 0 else None

    def write(name, text):
        os.makedirs(os.path.dirname(f"{out}/{name}"), exist_ok=True)
        open(f"{out}/{name}", "w").write(text)

    with open(path) as file:
        stations = json.load(file)["stations"]
    for station, about in stations.items():
        calibration = os.path.join(os.path.dirname(path), about["calibration"])
        months = {}
        for raw in sorted(glob.glob(f"{readings}/station={station}/day=*/*.parquet")):
            corrected = f"{out}/corrected/{os.path.relpath(raw, readings)}"
            os.makedirs(os.path.dirname(corrected), exist_ok=True)
            if run("correct", "-q", "--calibration", calibration, raw, "-o", corrected) is not None:
                months.setdefault(raw.split("day=")[1][:7], []).append(corrected)
            else:
                os.rmdir(os.path.dirname(corrected))
        for month, files in months.items():
            for stage in ("diffmag", "scalarcal"):
                if stage not in about:
                    continue
                lines = "".join(run(stage, "stream", "--partial", *about[stage].get("stream", []), file) for file in files)
                state = run(stage, "merge", "--partial", text=lines)
                known = ["--known", "--document", calibration] if stage == "scalarcal" else []
                answer = run(stage, "merge", "-q", *known, text=state)
                write(f"states/station={station}/month={month}/{stage}.ndjson", state)
                if answer is not None:
                    write(f"calibrations/station={station}/month={month}/{stage}.json", answer)


def main(programs, folder):
    programs, folder = os.path.abspath(programs), os.path.abspath(folder)
    os.makedirs(folder)
    path = network.make(folder, programs)
    readings = os.path.join(folder, "readings")
    spoil(readings)

    by_hand(path, readings, programs, f"{folder}/by-hand")
    expected = tree(f"{folder}/by-hand")
    assert len([name for name in expected if name.startswith("calibrations")]) == 6, sorted(expected)

    cluster = Cluster(folder)
    try:
        compare(cluster, path, readings, programs, folder, expected)
    finally:
        cluster.stop()


def compare(cluster, path, readings, programs, folder, expected):
    done = cluster.run("fleet.py", "run", path, readings, f"{folder}/whole", "--programs", programs)
    # spark-submit puts what the driver says on standard error among its output.
    said = done.stdout + done.stderr
    for told in (
        "OBS01 2026-02-27: missing: no file of readings",
        "OBS01 2026-03-02: missing: no file of readings",
        "OBS02 2026-02-28: empty: readings.parquet: no rows",
        "SAT03 2026-03-01: failed: correct: readings.parquet: found what cannot be decoded",
    ):
        assert told in said, f"{told} is not in\n{said}"
    whole = tree(f"{folder}/whole")
    findings = whole.pop("findings.parquet")
    rows = pq.read_table(f"{folder}/whole/findings.parquet").to_pylist()
    answered = [(row["station"], row["month"]) for row in rows if row["kind"] == "answer"]
    assert len(answered) == 6 and len(set(answered)) == 6, answered
    found = [(row["station"], row["month"]) for row in rows if row["kind"] == "finding"]
    assert set(found) == {("SAT03", "2026-03")}, f"findings of the jump alone: {found}"
    differ = sorted(name for name in whole.keys() | expected.keys() if whole.get(name) != expected.get(name))
    assert not differ, f"not what the programs give alone: {differ}"
    print(f"two workers give what the programs give alone: {len(whole)} files, the same bytes")

    before = []

    def lose():
        # Half-way: some days are done, most are not.
        days = lambda: len(glob.glob(f"{folder}/lost/corrected/*/*/*.parquet"))
        while days() < 4:
            time.sleep(0.01)
        cluster.lose_a_worker()
        before.append(days())

    losing = threading.Thread(target=lose)
    losing.start()
    # By a URI, and given the days that it finds by itself.
    cluster.run(
        "fleet.py", "run", path, f"file://{readings}", f"file://{folder}/lost", "--programs", programs, "--from", "2026-02-26", "--to", "2026-03-03"
    )
    losing.join()
    assert cluster.started[2].wait() == -signal.SIGKILL
    everything = len([name for name in whole if name.startswith("corrected")])
    assert before[0] < everything, f"{before[0]} of {everything} days were done before the worker was lost"
    lost = {name: data for name, data in tree(f"{folder}/lost").items() if not os.path.basename(name).startswith(".")}
    assert lost.pop("findings.parquet") == findings, "other findings where a worker was lost"
    differ = sorted(name for name in lost.keys() | whole.keys() if lost.get(name) != whole.get(name))
    assert not differ, f"not the same where a worker was lost: {differ}"
    print("with a worker lost half-way: the same bytes")

    # After a change of a baseline: the days since, here without Spark.
    since = [sys.executable, os.path.join(HERE, "fleet.py"), "run", "--alone", path, readings, f"{folder}/since", "--programs", programs]
    subprocess.run([*since, "--from", "2026-03-01", "--to", "2026-03-03"], check=True, capture_output=True)
    part = tree(f"{folder}/since")
    part.pop("findings.parquet")
    march = {name: data for name, data in whole.items() if "2026-03" in name}
    assert part == march, "not the days since a day"
    print("the days since a day: the same bytes as of all days")


if __name__ == "__main__":
    main(*sys.argv[1:])
