"""fluxcal over a network: every day of every station corrected, its statistics merged by station and month, on Apache Spark.

    spark-submit fleet.py run NETWORK READINGS OUT --programs FOLDER

READINGS is a table of Parquet files, station=…/day=YYYY-MM-DD/…; NETWORK a JSON file that says which stages each station has. Spark hands out
months of stations and takes back what was found; the readings go from the file system to the programs and back, and never through Spark.
"""

import argparse
import datetime
import json
import os
import shutil
import sys
import tempfile
import time

import pyarrow as pa
import pyarrow.parquet as pq

import station as stations

COLUMNS = ["station", "month", "day", "stage", "kind", "message"]


def network_of(path):
    """The stations, each calibration as text in the place of its file."""
    with open(path, encoding="utf-8") as file:
        network = json.load(file)["stations"]
    for station in network.values():
        with open(os.path.join(os.path.dirname(path), station["calibration"]), encoding="utf-8") as file:
            station["calibration"] = file.read()
    return network


def months_of(network, readings, first=None, last=None):
    """The work: of each station the days from the first to the last that any of the network has, or from FROM to TO, by months."""
    found = stations.Folder(readings).days()
    there = [day for station in network for day in found.get(station, {})]
    if not there and not (first and last):
        raise SystemExit(f"{readings}: no folder station=…/day=… of a station of the network; expected at least one")
    day, last = (datetime.date.fromisoformat(text) for text in (first or min(there), last or max(there)))
    days = []
    while day <= last:
        days.append(day.isoformat())
        day += datetime.timedelta(days=1)
    work = []
    for station in sorted(network):
        for month in sorted({day[:7] for day in days}):
            files = [(day, tuple(found.get(station, {}).get(day, []))) for day in days if day[:7] == month]
            work.append(stations.Month(station, month, tuple(files)))
    return work


def write_findings(done, out):
    """One table, in an order that does not depend on who was first."""
    rows = [row for one in done for row in one.findings]
    rows.sort(key=lambda row: [row[name] or "" for name in COLUMNS])
    table = pa.table({name: pa.array([row[name] for row in rows], pa.string()) for name in COLUMNS})
    local = os.path.join(tempfile.gettempdir(), f"findings-{os.getpid()}.parquet")
    pq.write_table(table, local)
    stations.Folder(out).store("findings.parquet", local)
    os.remove(local)
    return rows


def total(done):
    """What all months took."""
    took = {}
    for one in done:
        for key, value in one.took.items():
            took[key] = max(took.get(key, 0), value) if key.endswith("_state_bytes") else took.get(key, 0) + value
    return took


def on_spark(work, network, readings, out, programs):
    """The same on the cluster that spark-submit or the configuration names, and when that began; the programs are sent along."""
    from pyspark import SparkFiles
    from pyspark.sql import SparkSession

    context = SparkSession.builder.appName("fluxcal").getOrCreate().sparkContext
    context.setLogLevel("WARN")
    context.addPyFile(os.path.abspath(stations.__file__))
    for program in ("correct", *stations.STAGES):
        context.addFile(os.path.join(programs, program))
    shared = context.broadcast(network)

    def task(month):
        import station

        return station.carry_out(month, shared.value, readings, out, SparkFiles.getRootDirectory())

    # A task is a month of a station: long beside the few milliseconds that handing it out takes, short beside the work of a network.
    # The first tasks start the workers' Python; Spark's own start is not counted.
    started = time.monotonic()
    return context.parallelize(work, len(work)).map(task).collect(), started


def place(text):
    """A URI, or a path that means the same on every machine."""
    return text if "://" in text else os.path.abspath(text)


def run(args):
    network = network_of(args.network)
    work = months_of(network, args.readings, args.first, args.last)
    started = time.monotonic()
    if args.alone:
        done = [stations.carry_out(month, network, args.readings, args.out, args.programs) for month in work]
    else:
        done, started = on_spark(work, network, args.readings, args.out, args.programs)
    wall_s = time.monotonic() - started
    rows = write_findings(done, args.out)
    for row in rows:
        if row["kind"] in ("missing", "empty", "failed"):
            print(f"{row['station']} {row['day'] or row['month']}: {row['kind']}: {row['message']}", file=sys.stderr)
    took = {**total(done), "wall_s": wall_s}
    if args.took:
        with open(args.took, "w", encoding="utf-8") as file:
            json.dump(took, file, indent=1)
    if not took.get("files"):
        raise SystemExit("fleet: no file of readings could be taken")
    print(f"fleet: {int(took['months'])} months of stations, {int(took.get('files', 0))} files, {int(took.get('rows', 0))} rows")


def main():
    parser = argparse.ArgumentParser(description="fluxcal over a network, on Apache Spark")
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("run", help="correct, summarise and calibrate")
    command.add_argument("network", help="JSON: the stations, their calibrations and stages")
    command.add_argument("readings", type=place, help="path or URI of the table of readings")
    command.add_argument("out", type=place, help="path or URI of the folder for what is found")
    command.add_argument("--programs", default=os.path.dirname(shutil.which("diffmag") or "./"), help="folder of the programs of fluxcal")
    command.add_argument("--from", dest="first", metavar="DAY", help="the first day that should be there; absent: the first of the network")
    command.add_argument("--to", dest="last", metavar="DAY", help="the last one")
    command.add_argument("--alone", action="store_true", help="in this process, without Spark")
    command.add_argument("--took", metavar="FILE", help="write what it took: seconds of processors by program, bytes, rows")
    run(parser.parse_args())


if __name__ == "__main__":
    main()
