"""A month of a station: readings of days in, corrected series, states and calibrations out, by the programs of fluxcal.

Nothing here knows Spark. What cannot be done for a day is a finding of that day; the rest of the month goes on. What is written depends
on what is read alone: a month that is done twice, because a machine was lost, is written twice with the same bytes.
"""

import json
import os
import resource
import subprocess
import tempfile
import uuid
from collections import defaultdict
from dataclasses import dataclass, field

import pyarrow.parquet as pq
from pyarrow import fs

# Statistics that can be merged, by program: where a document keeps what looks wrong.
STAGES = {"diffmag": ("calibration", "differential", "fit", "findings"), "scalarcal": ("calibration", "scalar", "findings")}


class Failed(Exception):
    """What a program or a file system said when something could not be done."""


@dataclass(frozen=True)
class Month:
    """The work of one task: the files of each day that should be there, none for a day that is missing."""

    station: str
    month: str
    days: tuple  # (day, (file, …)), in order


@dataclass
class Done:
    """What came of a month: rows of the table of findings, and what it took."""

    findings: list = field(default_factory=list)
    took: dict = field(default_factory=lambda: defaultdict(float))


class Folder:
    """A folder on any file system that pyarrow reaches by a URI or an absolute path: local, NFS, S3, GCS, HDFS."""

    def __init__(self, uri):
        self.files, self.root = fs.FileSystem.from_uri(uri)

    def fetch(self, name, local):
        """Copies a file here."""
        with self.files.open_input_stream(f"{self.root}/{name}", compression=None) as remote, open(local, "wb") as copy:
            while block := remote.read(1 << 22):
                copy.write(block)
        return os.path.getsize(local)

    def store(self, name, local):
        """Copies a file there, where it appears whole or not at all."""
        path = f"{self.root}/{name}"
        self.files.create_dir(os.path.dirname(path), recursive=True)
        unfinished = f"{os.path.dirname(path)}/.{uuid.uuid4().hex}"
        with open(local, "rb") as copy, self.files.open_output_stream(unfinished, compression=None) as remote:
            while block := copy.read(1 << 22):
                remote.write(block)
        self.files.move(unfinished, path)
        return os.path.getsize(local)

    def store_text(self, name, text, scratch):
        local = f"{scratch}/text"
        with open(local, "w", encoding="utf-8") as file:
            file.write(text)
        return self.store(name, local)

    def days(self):
        """The files of each station's days: {station: {day: [file, …]}}, from station=…/day=…/file.parquet."""
        found = defaultdict(lambda: defaultdict(list))
        for entry in self.files.get_file_info(fs.FileSelector(self.root, recursive=True)):
            parts = entry.path[len(self.root) :].strip("/").split("/")
            if len(parts) < 2 or not (parts[0].startswith("station=") and parts[1].startswith("day=")):
                continue
            files = found[parts[0][8:]][parts[1][4:]]
            if len(parts) == 3 and parts[2].endswith(".parquet"):
                files.append("/".join(parts))
        return {station: {day: sorted(files) for day, files in days.items()} for station, days in found.items()}


class Programs:
    """The programs, each on one thread: cores are shared out by tasks."""

    def __init__(self, folder, took):
        self.folder, self.took = folder, took
        self.environment = {**os.environ, "RAYON_NUM_THREADS": "1"}

    def __call__(self, name, *arguments, text=None):
        """What a program writes to standard output, and what it says on standard error."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([f"{self.folder}/{name}", *arguments], input=text, env=self.environment, capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.took[f"{name}_s"] += after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if done.returncode != 0:
            raise Failed(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"{name}: ended by signal {-done.returncode}")
        return done.stdout, done.stderr.strip()


def carry_out(month, network, source, target, programs):
    """Does a month. `network` says of each station which stages it has and with which options, and where its calibration is (a text)."""
    done, station = Done(), network[month.station]
    started = resource.getrusage(resource.RUSAGE_SELF)
    run, source, target = Programs(programs, done.took), Folder(source), Folder(target)
    states = {stage: [] for stage in STAGES if stage in station}

    def find(day, stage, kind, message):
        message = message.replace(scratch + "/", "")
        done.findings.append(dict(station=month.station, month=month.month, day=day, stage=stage, kind=kind, message=message))

    with tempfile.TemporaryDirectory() as scratch:
        calibration = f"{scratch}/calibration.json"
        with open(calibration, "w", encoding="utf-8") as file:
            file.write(station["calibration"])
        for day, files in month.days:
            if not files:
                find(day, "read", "missing", "no file of readings")
            for name in files:
                try:
                    found = one_file(name, calibration, station, states, (run, source, target, scratch), done.took)
                    if found == 0:
                        find(day, "read", "empty", f"{os.path.basename(name)}: no rows")
                except (Failed, OSError) as failure:
                    find(day, "read" if isinstance(failure, OSError) else str(failure).split(":")[0], "failed", str(failure))
        for stage, lines in states.items():
            if not lines:
                continue
            place = f"station={month.station}/month={month.month}/{stage}"
            try:
                options = list(station[stage].get("merge", []))
                if "--known" in options:
                    options += ["--document", calibration]
                state, _ = run(stage, "merge", "--partial", text="".join(lines))
                done.took["written_bytes"] += target.store_text(f"states/{place}.ndjson", state, scratch)
                answer, words = run(stage, "merge", *options, text=state)
                done.took["written_bytes"] += target.store_text(f"calibrations/{place}.json", answer, scratch)
                find(None, stage, "answer", words)
                for said in findings_of(json.loads(answer), STAGES[stage]):
                    find(None, stage, "finding", said)
            except (Failed, OSError) as failure:
                find(None, stage, "failed", str(failure))
    ended = resource.getrusage(resource.RUSAGE_SELF)
    done.took["python_s"] += ended.ru_utime + ended.ru_stime - started.ru_utime - started.ru_stime
    done.took["months"] += 1
    return done


def one_file(name, calibration, station, states, places, took):
    """Corrects the readings of a file and takes its statistics; gives its rows. The states are appended when all is done."""
    run, source, target, scratch = places
    # The name is that of the source, so that messages name it.
    raw, corrected = f"{scratch}/{os.path.basename(name)}", f"{scratch}/corrected.parquet"
    took["read_bytes"] += source.fetch(name, raw)
    run("correct", "-q", "--calibration", calibration, raw, "-o", corrected)
    lines = {stage: run(stage, "stream", "--partial", *station[stage].get("stream", []), corrected)[0] for stage in states}
    took["written_bytes"] += target.store(f"corrected/{name}", corrected)
    rows = pq.read_metadata(corrected).num_rows
    os.remove(raw)
    took["rows"] += rows
    took["files"] += 1
    for stage, line in lines.items():
        took[f"{stage}_state_bytes"] = max(took[f"{stage}_state_bytes"], len(line))
        states[stage].append(line)
    return rows


def findings_of(document, path):
    for key in path:
        document = document.get(key, {}) if isinstance(document, dict) else {}
    return document or []
