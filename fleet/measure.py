"""What a month of a network takes, measured on this machine, and on paper what thirty years of a large one would: writes docs/fleet.md.

    python fleet/measure.py PROGRAMS FOLDER PAGE [RATE_HZ] [DAYS] [OBSERVATORIES] [SATELLITES]
"""

import json
import os
import shutil
import sys
import time

import network
from cluster import Cluster

# The network on paper.
STATIONS, YEARS, RATE_HZ = 150, 30, 1
ROWS = STATIONS * YEARS * 365.25 * 86400 * RATE_HZ
MONTHS = STATIONS * YEARS * 12
# A shared file system, bytes a second.
STORAGE = 1e9
TASKS = 500


def through_spark(readings, rows):
    """Run by spark-submit: readings that Spark reads and hands to Python as Arrow, of which nothing is made; and tasks that do nothing."""
    from pyspark.sql import SparkSession

    spark = SparkSession.builder.appName("through").getOrCreate()
    spark.sparkContext.setLogLevel("WARN")

    def count(batches):
        import pyarrow

        yield pyarrow.RecordBatch.from_pydict({"rows": [sum(batch.num_rows for batch in batches)]})

    def nothing(_):
        return 0

    # Twice, so that the second finds everything loaded.
    for _ in range(2):
        started = time.monotonic()
        found = spark.read.parquet(readings).mapInArrow(count, "rows long").collect()
        seconds = time.monotonic() - started
        assert sum(row.rows for row in found) == int(rows)
    spark.sparkContext.parallelize(range(8), 8).map(nothing).collect()
    started = time.monotonic()
    spark.sparkContext.parallelize(range(TASKS), TASKS).map(nothing).collect()
    print("MEASURED " + json.dumps({"through_s": seconds, "task_s": (time.monotonic() - started) / TASKS}))


def measured(programs, folder, rate_hz, days, observatories, satellites):
    programs, folder = os.path.abspath(programs), os.path.abspath(folder)
    path = network.make(folder, programs, observatories, satellites, "2026-03-01", days, 1 / rate_hz, repeated=True)
    readings, out, took = os.path.join(folder, "readings"), os.path.join(folder, "out"), {}
    for cores in (1, 2):
        cluster = Cluster(folder, cores)
        try:
            cluster.run("fleet.py", "run", path, readings, out, "--programs", programs, "--took", f"{folder}/took-{cores}.json")
            with open(f"{folder}/took-{cores}.json", encoding="utf-8") as file:
                took[cores] = json.load(file)
            took[cores]["load"] = os.getloadavg()[1]
            print(json.dumps(took[cores]), flush=True)
            if cores == 1:
                rows = took[1]["rows"] / (observatories + satellites)
                said = cluster.run("measure.py", "through", f"{readings}/station=OBS01", str(rows)).stdout
                line = next(line for line in said.splitlines() if line.startswith("MEASURED "))
                took["spark"] = {**json.loads(line[9:]), "rows": rows}
                print(line, flush=True)
        finally:
            cluster.stop()
        shutil.rmtree(out)
    shutil.rmtree(readings)
    return took


def hours(seconds):
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h" if seconds < 180000 else f"{seconds / 86400:.1f} d"


def page(took, rate_hz, days, observatories, satellites):
    one, two, spark = took[1], took[2], took["spark"]
    stations, rows = observatories + satellites, one["rows"]
    processors = {cores: sum(value for key, value in took[cores].items() if key.endswith("_s") and key != "wall_s") for cores in (1, 2)}
    # Of the two instruments of an observatory, which is what the network on paper has.
    share = observatories / stations
    # What reads, corrects and carries is shared by all; diffmag belongs to the observatories.
    cost = (one["correct_s"] + one["python_s"]) / rows + one["diffmag_s"] / (share * rows)
    read, written = one["read_bytes"] / rows, one["written_bytes"] / rows
    lines = [
        "# fleet: a network on Apache Spark",
        "",
        "What [fleet](../fleet/README.md) costs in time and storage. `just fleet-measure` measures it and writes this page.",
        "",
        "## Measured",
        "",
        f"{stations} stations, {days} days at {rate_hz:g} Hz, {rows / stations / 1e6:.3g} million rows a station, {rows / 1e6:.4g} million in all: {observatories} observatories with two variometers (`correct`, `diffmag stream "
        f"--partial`, `merge`) and {satellites} satellites with a scalar magnetometer (`correct`, `scalarcal`). One day of each station is simulated and used for all its days, with the times shifted. Standalone "
        f"cluster with one core a worker on a machine with {os.cpu_count()} cores, shared with other work (load {one['load']:.1f} and {two['load']:.1f}). Processor time "
        "(without Java's) measures the work; elapsed time depends on the load. Files are on the local disk, mostly in its cache.",
        "",
        "| | one core | two cores |",
        "| --- | --- | --- |",
        f"| elapsed time, without the start of Spark | {one['wall_s']:.0f} s | {two['wall_s']:.0f} s |",
        f"| processor time, programs and Python | {processors[1]:.0f} s | {processors[2]:.0f} s |",
        *(f"| … `{name}` | {one[f'{name}_s']:.0f} s | {two[f'{name}_s']:.0f} s |" for name in ("correct", "diffmag", "scalarcal")),
        f"| … Python, including copies of files | {one['python_s']:.1f} s | {two['python_s']:.1f} s |",
        f"| read; written | {one['read_bytes'] / 1e9:.2f}; {one['written_bytes'] / 1e9:.2f} GB | the same |",
        f"| processor time a row | {1e6 * processors[1] / rows:.2f} µs | {1e6 * processors[2] / rows:.2f} µs |",
        "",
        f"A row of an observatory takes {1e6 * cost:.2f} µs of a core ({1e6 * cost / 6:.2f} µs each of its six readings), {read:.0f} bytes read and {written:.0f} written. The state of a day has at most "
        f"{one['diffmag_state_bytes'] / 1000:.0f} kB (`diffmag`) and {one.get('scalarcal_state_bytes', 0) / 1000:.0f} kB (`scalarcal`).",
        "",
        f"**Why the readings do not go through Spark.** Read by Spark and handed to Python as Arrow (`mapInArrow`), without further work, {spark['rows'] / 1e6:.3g} million rows take {spark['through_s']:.0f} s on one core, "
        f"{1e6 * spark['through_s'] / spark['rows']:.2f} µs a row, before any program has seen them; copying the files, and everything else that Python does, costs {1e6 * one['python_s'] / rows:.3f} µs. The programs read and write Parquet themselves, so that "
        "no Arrow stream is needed.",
        "",
        "## Extrapolated",
        "",
        f"{STATIONS} observatories, {YEARS} years at {RATE_HZ} Hz: {ROWS / 1e9:.0f} billion (10⁹) rows, {MONTHS} station months, each a task of {ROWS / MONTHS * cost:.0f} s. From the figures above, with {STORAGE / 1e9:g} GB/s of shared storage and "
        f"{1000 * spark['task_s']:.1f} ms of scheduling a task (measured on {TASKS} empty tasks with cluster and driver on the same core, hence an upper limit):",
        "",
        "| cores | processors | storage | scheduling of tasks | total | bottleneck |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    storage, tasks = ROWS * (read + written) / STORAGE, MONTHS * spark["task_s"]
    for cores in (10, 100, 1000):
        parts = {"processors": ROWS * cost / cores, "storage": storage, "scheduling": tasks}
        most = max(parts, key=parts.get)
        lines.append(f"| {cores} | {hours(parts['processors'])} | {hours(storage)} | {hours(tasks)} | {hours(parts[most])} | {most} |")
    per_core = (read + written) / cost
    lines += [
        "",
        f"A core reads and writes {per_core / 1e6:.0f} MB/s, so that storage of {STORAGE / 1e9:g} GB/s feeds {STORAGE / per_core:.0f} cores; beyond that it is the bottleneck, and more of it (object stores, local disks) is "
        "what helps. If storage keeps up with 1 000 cores, the scheduling of tasks is next, and a task should then be more than a month. "
        f"{ROWS * read / 1e12:.1f} TB are read and {ROWS * written / 1e12:.1f} TB written. The states of all months are {MONTHS * one['diffmag_state_bytes'] / 1e9:.1f} GB: "
        "calibrations between other dates are merges of these and need no readings. When a baseline changes, only the months since are processed again.",
        "",
        "These figures do not include the network between machines, slow machines at the end of a run, or other load on the storage.",
        "",
    ]
    return "\n".join(lines)


def main(programs, folder, target, rate_hz="1", days="30", observatories="8", satellites="2"):
    given = (float(rate_hz), int(days), int(observatories), int(satellites))
    os.makedirs(folder)
    took = measured(programs, folder, *given)
    with open(target, "w", encoding="utf-8") as file:
        file.write(page(took, *given))


if __name__ == "__main__":
    if sys.argv[1] == "through":
        through_spark(sys.argv[2], float(sys.argv[3]))
    else:
        main(*sys.argv[1:])
