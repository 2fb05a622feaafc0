"""A network to try the job on: observatories with two variometers, and a satellite with a scalar magnetometer, simulated from plans of fixtures."""

import datetime
import json
import os
import subprocess

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

PLANS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "fixtures", "plans")
DAY_S = 86400.0


def plan(name, seed, start, length_s, step_s):
    with open(os.path.join(PLANS, f"{name}.json"), encoding="utf-8") as file:
        plan = json.load(file)
    plan.update(seed=seed, start=f"{start.isoformat()}T00:00:00Z")
    plan["procedures"][0].update(length_s=length_s, step_s=step_s)
    return plan


def simulated(programs, plan):
    """The columns of a campaign of one recording, and what is true of it."""
    made = subprocess.run(
        [os.path.join(programs, "simulate"), "campaign", "-q"], input=json.dumps(plan), capture_output=True, text=True, check=True
    )
    columns = json.loads(made.stdout)["recordings"][0]["columns"]
    return {name: pa.array(column, pa.float64()) for name, column in columns.items()}


def calibration(plan, names):
    """What was once found of the sensors: what is true, with an uncertainty, and of nanotesla nothing but offsets."""
    true = plan["truth"]["calibration"]
    sensors = {}
    for number, axis in enumerate("xyz"):
        known = true.get("sensors", {}).get(axis, {"offset_nt": plan["truth"].get("differential", {}).get("offset_nt", [0, 0, 0])[number]})
        sensors[axis] = {"offset_nt": {"value": known["offset_nt"], "std": 1.0}}
        if f"sensor_{axis}_v" in names:
            sensors[axis]["sensitivity_nt_per_v"] = {"value": known["sensitivity_nt_per_v"], "std": 1.0}
    axes = true.get("axes", {"sensors": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}})
    conditions = {key: value for key, value in true.get("reference_conditions", {}).items()}
    found = {"sensors": sensors, "axes": axes, **({"reference_conditions": conditions} if conditions else {})}
    return {"fluxcal": 1, "instrument": plan["instrument"], "calibration": found}


def write_days(folder, station, start, days, columns, repeated):
    """A file a day, with times since 1970. `repeated`: every day has the readings of the first."""
    epoch = (start - datetime.date(1970, 1, 1)).days * DAY_S
    time = columns["time_s"]
    rows = len(time) if repeated else len(time) // days
    for number in range(days):
        begin = 0 if repeated else number * rows
        part = {name: column.slice(begin, rows) for name, column in columns.items()}
        part["time_s"] = pc.add(part["time_s"], epoch + (number * DAY_S if repeated else 0.0))
        day = (start + datetime.timedelta(days=number)).isoformat()
        place = os.path.join(folder, f"station={station}", f"day={day}")
        os.makedirs(place)
        pq.write_table(
            pa.table(part), os.path.join(place, "readings.parquet"), compression="zstd", use_dictionary=False, use_byte_stream_split=True
        )


def make(folder, programs, observatories=2, satellites=1, start="2026-02-26", days=6, step_s=10.0, repeated=False):
    """Writes FOLDER/network.json with the calibrations beside it, and FOLDER/readings. Gives the path of the first."""
    start, stations = datetime.date.fromisoformat(start), {}
    for number in range(observatories + satellites):
        pair = number < observatories
        station = f"{'OBS' if pair else 'SAT'}{number + 1:02}"
        plan_of = plan("observatory-pair" if pair else "orbit", number + 1, start, DAY_S * (1 if repeated else days), step_s)
        columns = simulated(programs, plan_of)
        if pair:
            columns = {name.replace("test_", "sensor_"): column for name, column in columns.items()}
        else:
            columns = {name: column for name, column in columns.items() if not name.startswith(("ambient", "attitude"))}
        write_days(os.path.join(folder, "readings"), station, start, days, columns, repeated)
        with open(os.path.join(folder, f"{station}.json"), "w", encoding="utf-8") as file:
            json.dump(calibration(plan_of, columns), file)
        stage = {"diffmag": {"stream": ["--test", "field"]}} if pair else {"scalarcal": {"merge": ["--known"]}}
        stations[station] = {"calibration": f"{station}.json", **stage}
    path = os.path.join(folder, "network.json")
    with open(path, "w", encoding="utf-8") as file:
        json.dump({"stations": stations}, file, indent=1)
    return path
