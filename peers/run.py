"""fluxcal beside its peers: each job by both, in turns, with the answers compared; writes docs/performance.md.

    python run.py [--programs FOLDER] [--scale 1] [--runs 5] [--only JOB,...] [-o FILE]

Every way runs in a process of its own. Shown are medians with the least and the largest of the runs, for the whole process and, of a peer,
for the work without the start of Python; peak memory is that of the process. `--scale 0.01` tries it with a hundredth of the rows.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Iterable

import numpy as np
from peers import COPY

HERE = Path(__file__).resolve().parent
SIZES = [10_000, 100_000, 1_000_000, 10_000_000, 100_000_000]
# Files of a hundred million rows are made of that job alone: 4.5 GB.
LARGEST = {"stream-parquet": SIZES[-1]}
PIECE = 10_000_000


@dataclass
class Job:
    """One comparison."""

    name: str
    title: str
    # Makes the files in a folder; gives what the commands need.
    make: Callable[[Path, int], dict]
    # Of those: the command.
    ours: Callable[[dict], list[str]]
    peer: str
    libraries: list[str]
    rows: int
    # Of what the command wrote: numbers to compare, and how far they may be apart.
    answer: Callable[[dict], list[float]] = lambda made: []
    apart: float = 0.0
    note: str = ""
    # What the peer gets.
    theirs: Callable[[dict], str] = lambda made: made["path"]
    # Whether nothing is faster than reading that file.
    reads: bool = True


@dataclass
class Times:
    """Of one way."""

    seconds: list[float] = field(default_factory=list)
    inner: list[float] = field(default_factory=list)
    peak_mb: float = 0.0
    answer: list[float] = field(default_factory=list)


def run(command: list[str]) -> tuple[float, float, bytes]:
    """Seconds of the whole process, its peak of memory in MB, and what it printed."""
    with tempfile.NamedTemporaryFile() as told:
        alone = [sys.executable, "-I", "-S", str(HERE / "alone.py"), told.name, *command]
        process = subprocess.run(alone, capture_output=True)
        if process.returncode:
            sys.exit(f"{' '.join(command)}: exit code {process.returncode}: {process.stderr.decode().strip()}")
        seconds, peak_kb = map(float, told.read().split())
        return seconds, peak_kb / 1024, process.stdout


def measure(job: Job, folder: Path, scale: float, runs: int) -> str:
    made = job.make(folder, max(1000, int(job.rows * scale)))
    ours, theirs = Times(), {library: Times() for library in job.libraries}
    for _ in range(runs):
        seconds, peak, _ = run(job.ours(made))
        ours.seconds.append(seconds)
        ours.peak_mb = max(ours.peak_mb, peak)
        for library, times in theirs.items():
            seconds, peak, printed = run([sys.executable, str(HERE / "peers.py"), job.peer, library, job.theirs(made)])
            told = json.loads(printed)
            times.seconds.append(seconds)
            times.inner.append(told["seconds"])
            times.peak_mb = max(times.peak_mb, peak)
            times.answer = told["answer"]
    ours.answer = job.answer(made)
    farthest = max(
        (abs(a - b) / max(abs(a), 1.0) for times in theirs.values() for a, b in zip(ours.answer, times.answer)), default=None
    )
    if farthest is not None and farthest > job.apart:
        sys.exit(f"{job.name}: the answers are {farthest:.1e} apart; expected at most {job.apart:.0e}")
    return page(job, made, ours, theirs, farthest)


def page(job: Job, made: dict, ours: Times, theirs: dict[str, Times], farthest: float | None) -> str:
    lines = [f"## {job.title.format(rows=made['rows'])}", ""]
    lines += ["| | whole process, s | work alone, s | memory, MB | fluxcal |", "| --- | --- | --- | --- | --- |"]
    mine = statistics.median(ours.seconds)
    lines.append(f"| **fluxcal** | {spread(ours.seconds)} | | {ours.peak_mb:.0f} | |")
    for library, times in theirs.items():
        whole, inner = statistics.median(times.seconds), statistics.median(times.inner)
        ratio = f"{ratio_words(whole / mine)}; without Python's start {ratio_words(inner / mine)}"
        lines.append(f"| {library} | {spread(times.seconds)} | {spread(times.inner)} | {times.peak_mb:.0f} | {ratio} |")
    if job.reads:
        words, seconds = reading(Path(made["path"]))
        lines.append(f"| *{words}* | *{seconds:.3f}* | | | |")
    lines.append("")
    agree = f"The answers agree to {max(farthest, 1e-16):.0e}." if farthest is not None else "The answers are not compared, because the peers do different work."
    lines += [agree, ""]
    if job.note:
        lines += [job.note, ""]
    return "\n".join(lines)


def spread(seconds: list[float]) -> str:
    return f"{statistics.median(seconds):.3f} ({min(seconds):.3f} to {max(seconds):.3f})"


def ratio_words(ratio: float) -> str:
    return f"is {ratio:.1f} times as fast" if ratio >= 1 else f"takes {1 / ratio:.1f} times as long"


def reading(path: Path) -> tuple[str, float]:
    """Reading the bytes of a file from the page cache."""
    best = float("inf")
    for _ in range(3):
        start = time.perf_counter()
        with open(path, "rb", buffering=0) as file:
            while file.read(1 << 22):
                pass
        best = min(best, time.perf_counter() - start)
    return f"reading the {os.path.getsize(path) / 1e6:.0f} MB alone", best


# What the jobs work on.


def write_csv(path: Path, names: list[str], columns: list[np.ndarray]):
    import pyarrow as pa
    import pyarrow.csv

    pa.csv.write_csv(pa.table(dict(zip(names, columns))), path, pa.csv.WriteOptions(quoting_style="none"))


def write_parquet(path: Path, names: list[str], columns: list[np.ndarray]):
    write_pieces(path, names, [columns])


def write_pieces(path: Path, names: list[str], pieces: Iterable[list[np.ndarray]]):
    """Columns piece by piece, CSV of one piece only."""
    import pyarrow as pa
    import pyarrow.parquet

    if path.suffix == ".csv":
        (columns,) = pieces
        return write_csv(path, names, columns)
    schema = pa.schema([(name, pa.float64()) for name in names])
    with pa.parquet.ParquetWriter(path, schema) as writer:
        for columns in pieces:
            writer.write_table(pa.table(dict(zip(names, columns)), schema))


PAIR = ["time_s", "reference_x_nt", "reference_y_nt", "reference_z_nt", "test_x_nt", "test_y_nt", "test_z_nt"]


def pair(folder: Path, rows: int, kind: str) -> dict:
    """A pair of instruments; the field swings by 500 nT and each test reading has white noise of 50 pT."""
    generator = np.random.default_rng(3)
    main = [20_000.0, 500.0, 45_000.0]
    mixing = np.eye(3) + 1e-3 * np.array([[1, 2, -1], [0.5, -2, 1], [1, 1, 3]])
    path = folder / f"pair-{rows}.{kind}"

    def piece(first: int) -> list[np.ndarray]:
        seconds = np.arange(first, min(first + PIECE, rows), dtype=float)
        reference = [b + 500 * np.sin(seconds / (700.0 + 90 * k)) for k, b in enumerate(main)]
        test = (np.column_stack(reference) @ mixing.T + generator.normal(0, 0.05, (len(seconds), 3))).T
        return [seconds, *[np.round(column, 4) for column in [*reference, *test]]]

    write_pieces(path, PAIR, (piece(first) for first in range(0, rows, PIECE)))
    return {"rows": rows, "path": str(path), "result": folder / "pair.json"}


def matrix_found(made: dict) -> list[float]:
    document = json.loads(made["result"].read_text())
    # Its columns are the test axes.
    return np.array(document["calibration"]["differential"]["matrix"]).T.ravel().tolist()


def logger(folder: Path, rows: int) -> dict:
    """A logger's CSV with times in ISO 8601."""
    generator = np.random.default_rng(4)
    start = np.datetime64("2026-03-01T00:00:00")
    stamps = (start + np.arange(rows).astype("timedelta64[s]")).astype(str)
    columns = [np.round(generator.normal(level, 50.0, rows), 3) for level in (20_000.0, 500.0, 45_000.0)]
    path = folder / "logger.csv"
    import pyarrow as pa

    names = ["time", "x_nt", "y_nt", "z_nt"]
    write_csv(path, names, [pa.array(np.char.add(stamps, "Z")), *columns])
    return {"rows": rows, "path": str(path), "result": folder / "logger.json", "sums": columns}


def iaga_day(folder: Path, rows: int) -> dict:
    """IAGA-2002 of a second, as observatories send it."""
    generator = np.random.default_rng(5)
    stamps = np.datetime64("2026-03-01T00:00:00.000") + np.arange(rows).astype("timedelta64[s]")
    columns = [np.round(generator.normal(level, 20.0, rows), 2) for level in (20_000.0, 500.0, 45_000.0)]
    total = np.sqrt(sum(column**2 for column in columns))
    head = [
        ("Format", "IAGA-2002"), ("Source of Data", "fluxcal"), ("Station Name", "Simulated"), ("IAGA Code", "SIM"),
        ("Geodetic Latitude", "48.2"), ("Geodetic Longitude", "16.3"), ("Elevation", "300"), ("Reported", "XYZF"),
        ("Sensor Orientation", "XYZF"), ("Digital Sampling", "1 second"), ("Data Interval Type", "1-second"), ("Data Type", "variation"),
    ]
    path = folder / "simulated.sec"
    with open(path, "w") as file:
        for key, value in head:
            file.write(f" {key:<23}{value:<45}|\n")
        file.write("DATE       TIME         DOY     SIMX      SIMY      SIMZ      SIMF   |\n")
        days = (stamps.astype("datetime64[D]") - stamps[0].astype("datetime64[Y]")).astype(int) + 1
        for stamp, day, x, y, z, f in zip(stamps.astype(str), days, *columns, total):
            file.write(f"{stamp[:10]} {stamp[11:]} {day:03d}   {x:10.2f}{y:10.2f}{z:10.2f}{f:10.2f}\n")
    return {"rows": rows, "path": str(path), "result": folder / "iaga.json"}


def beside(made: dict, names: list[str]) -> list[float]:
    """Sums of columns of the Parquet file that `ingest` wrote beside its document."""
    import pyarrow.parquet

    document = json.loads(made["result"].read_text())
    table = pyarrow.parquet.read_table(made["result"].parent / document["recordings"][0]["table"])
    return [float(table[name].to_numpy().sum()) for name in names]


def volts(folder: Path, rows: int) -> dict:
    """Volts of three sensors with a temperature."""
    seconds = np.arange(rows, dtype=float)
    names = ["time_s", "sensor_temperature_c", "sensor_x_v", "sensor_y_v", "sensor_z_v"]
    columns = [
        seconds, 23 + 4 * np.sin(seconds / 900), 7 * np.sin(seconds / 31), 6 * np.cos(seconds / 43), 5 + np.sin(seconds / 29)
    ]
    path = folder / "volts.parquet"
    write_parquet(path, names, columns)
    return {"rows": rows, "path": str(path), "result": folder / "fields.parquet"}


def shield(folder: Path, rows: int) -> dict:
    """Noise in a shield, 1/f below 1 Hz."""
    generator = np.random.default_rng(6)
    spectrum = np.fft.rfft(generator.standard_normal(rows))
    frequency = np.fft.rfftfreq(rows, 0.01)
    frequency[0] = frequency[1]
    series = np.fft.irfft(spectrum * np.sqrt(1 + 1 / frequency), rows) * 0.01
    series.tofile(folder / "shield.f64")
    write_parquet(folder / "shield.parquet", ["time_s", "sensor_x_nt"], [np.arange(rows) * 0.01, series])
    document = {
        "fluxcal": 1,
        "recordings": [
            {"id": "shield", "procedure": "sensor_noise", "conditions": {"sensor": "x"}, "table": "shield.parquet"}
        ],
    }
    (folder / "shield.json").write_text(json.dumps(document))
    return {"rows": rows, "path": str(folder / "shield.f64"), "document": str(folder / "shield.json"), "result": folder / "noise.json"}


def flicker_plan(folder: Path, rows: int) -> dict:
    """Three channels of flicker noise."""
    each = rows // 3
    plan = {
        "fluxcal": 1,
        "instrument": {"noise": {"flicker_nt2_per_hz_at_1hz": 1e-4}},
        "procedures": [{"procedure": "sensor_noise", "id": "shield", "series": [{"length_s": each * 0.01, "step_s": 0.01}]}],
    }
    path = folder / "flicker.json"
    path.write_text(json.dumps(plan))
    return {"rows": rows, "path": str(path), "result": folder / "simulated.json"}


def long_document(folder: Path, rows: int) -> dict:
    """A small campaign for `coilcal` with long readings beside it that it passes on."""
    generator = np.random.default_rng(7)
    columns = {"time_s": np.arange(rows).tolist()}
    for axis, level in zip("xyz", (20_000.0, 500.0, 45_000.0)):
        columns[f"sensor_{axis}_nt"] = np.round(generator.normal(level, 20.0, rows), 3).tolist()
    recording = {"id": "run", "procedure": "free_run", "start": "2026-03-01T00:00:00Z", "columns": columns}
    path = folder / "long.json"
    document = json.loads((HERE.parent / "fixtures/coilcal/uneven/input.json").read_text())
    document["recordings"].append(recording)
    path.write_text(json.dumps(document))
    return {"rows": rows, "path": str(path), "result": folder / "long-out.json"}


def switched(folder: Path, rows: int, step_s: float) -> dict:
    """A pair of instruments, a current that is switched and moves the test instrument, and a temperature that does nothing."""
    generator = np.random.default_rng(8)
    seconds = np.arange(rows) * step_s
    waves = [size * np.sin(2 * np.pi * seconds / 86_400 + phase) for size, phase in ((25, 0.0), (15, 1.6), (10, 1.0))]
    walks = np.cumsum(generator.normal(size=(3, rows)), axis=1) * np.array([[0.3], [0.25], [0.12]]) * np.sqrt(step_s / 60)
    field = np.array([[20_500.0], [1_500.0], [44_000.0]]) + waves + walks
    turn = np.eye(3) + np.array([[0.001, 0.004, -0.002], [-0.004, -0.001, 0.003], [0.002, -0.003, 0.0005]])
    current = 2.0 * (np.cumsum(generator.random(rows) < step_s / 2400) % 2)
    test = turn @ field + np.outer([3.0, -1.0, 2.0], current) + generator.normal(0, 0.1, (3, rows))
    columns = dict(zip(PAIR, [seconds, *(field + generator.normal(0, 0.05, (3, rows))), *test]))
    columns |= {"load_current_a": current, "test_temperature_c": 20 + 5 * np.sin(2 * np.pi * seconds / 86_400)}
    written = {name: np.round(values, 4).tolist() for name, values in columns.items()}
    path = folder / "switched.json"
    path.write_text(json.dumps({"fluxcal": 1, "recordings": [{"id": "pair", "procedure": "differential", "columns": written}]}))
    return {"rows": rows, "path": str(path), "result": folder / "explained.json"}


def coefficients_found(made: dict) -> list[float]:
    (effect,) = json.loads(made["result"].read_text())["diagnosis"][0]["effects"]
    return [effect["parameters"][f"{axis}_nt_per_a"]["value"] for axis in "xyz"]


def jobs(programs: Path) -> list[Job]:
    def program(name: str) -> str:
        return str(programs / name)

    fixtures = HERE.parent / "fixtures"

    def stream(kind: str) -> Job:
        return Job(
            name=f"stream-{kind}",
            title="A pair compared: `diffmag stream`, {rows} rows of " + {"csv": "CSV", "parquet": "Parquet"}[kind],
            make=lambda folder, rows: pair(folder, rows, kind),
            ours=lambda made: [program("diffmag"), "stream", "-q", made["path"], "-o", str(made["result"])],
            peer="matrix",
            libraries=["polars", "pyarrow", "pandas"],
            rows=2_000_000,
            answer=matrix_found,
            apart=1e-5,
            note="The peers compute only the matrix, by normal equations in NumPy. `diffmag` also gives its uncertainty, searches for steps, clock errors and outliers, and never holds the whole file.",
        )

    def ingest(kind: str, title: str, make: Callable, peer: str, libraries: list[str], rows: int) -> Job:
        return Job(
            name=f"ingest-{kind}",
            title=title + ": `ingest`, {rows} rows",
            make=make,
            ours=lambda made: [program("ingest"), "-q", "--beside", made["path"], "-o", str(made["result"])],
            peer=peer,
            libraries=libraries,
            rows=rows,
            answer=lambda made: beside(made, ["sensor_x_nt", "sensor_y_nt", "sensor_z_nt"]),
            apart=1e-9,
        )

    def explain(name: str, title: str, rows: int, step_s: float) -> Job:
        return Job(
            name=name,
            title=title + ": `diagnose`, {rows} rows",
            make=lambda folder, rows: switched(folder, rows, step_s),
            ours=lambda made: [program("diagnose"), "-q", made["path"], "-o", str(made["result"])],
            peer="stepwise",
            libraries=["stepwise regression (NumPy)"],
            rows=rows,
            answer=coefficients_found,
            apart=0.02,
            note="Both find the current and its three coefficients. The peer tries two columns in fourteen forms with white noise. `diagnose` also compares the clocks, weighs sixteen forms of noise and the noise of the reference, searches for steps and outliers, and holds out readings.",
        )

    return [
        explain("explain", "A pair explained, three days of minutes", 4_320, 60.0),
        explain("explain-day", "A pair explained, a day of seconds", 86_400, 1.0),
        stream("csv"),
        stream("parquet"),
        ingest("csv", "A logger's CSV to Parquet", logger, "to_parquet", ["polars", "pyarrow", "pandas"], 4_000_000),
        ingest("iaga", "IAGA-2002 to Parquet", iaga_day, "iaga", ["pandas"], 86_400 * 10),
        Job(
            name="correct",
            title="Readings corrected with three effects: `correct`, {rows} rows of Parquet",
            make=volts,
            ours=lambda made: [
                program("correct"), "-q", "--calibration", str(fixtures / "correct/flight/input.json"), made["path"], "-o", str(made["result"])
            ],
            peer="correct",
            libraries=["polars", "pyarrow", COPY],
            rows=10_000_000,
            note="The peers apply a matrix to three columns and write four; the last one reads the twelve columns that `correct` wrote and writes them again. `correct` also subtracts three effects and gives each sample its uncertainty, for which it takes the derivatives of the field along fifteen sources in every row: a third of its processor time.",
        ),
        Job(
            name="spectrum",
            title="Noise of a sensor: `sensorcal`, {rows} samples",
            make=shield,
            ours=lambda made: [program("sensorcal"), "-q", made["document"], "-o", str(made["result"])],
            peer="spectrum",
            libraries=["one FFT (NumPy)", "one FFT (SciPy)", "SciPy's welch", "allantools"],
            rows=8_640_000,
            note="`sensorcal` reads the Parquet file, fits white and flicker noise to the periodogram by Whittle's likelihood, computes the Allan deviation and searches for spectral lines. Each peer does one of these, on numbers already in memory.",
        ),
        Job(
            name="flicker",
            title="Flicker noise simulated: `simulate campaign`, {rows} samples, three channels",
            make=flicker_plan,
            ours=lambda made: [program("simulate"), "campaign", "-q", "--beside", made["path"], "-o", str(made["result"])],
            theirs=lambda made: str(made["rows"]),
            reads=False,
            peer="flicker",
            libraries=["NumPy"],
            rows=30_000_000,
            note="`simulate` also writes its samples to a Parquet file; NumPy discards them.",
        ),
        Job(
            name="document",
            title="Readings in JSON that are passed on: `coilcal`, {rows} rows",
            make=long_document,
            ours=lambda made: [program("coilcal"), "-q", made["path"], "-o", str(made["result"])],
            peer="document",
            libraries=["orjson", "json"],
            rows=5_000_000,
            note="The peers read the document and write it again. `coilcal` also calibrates a coil from another recording, and its time includes the digest of the input.",
        ),
    ]


def small(programs: Path, runs: int) -> str:
    """Each stage on its smallest golden document."""
    fixtures = HERE.parent / "fixtures"
    documents = {
        "coilcal": "coilcal", "sensorcal": "sensorcal", "axescal": "axescal", "diffmag": "diffmag", "scalarcal": "scalarcal", "correct": "correct"
    }
    lines = ["## A small document, from start to end", "", "| | milliseconds, whole process |", "| --- | --- |"]
    for name, folder in documents.items():
        inputs = sorted((fixtures / folder).glob("*/input.json"), key=lambda path: path.stat().st_size)
        # Some of the golden documents are answered with a refusal.
        answered = lambda path: subprocess.run([str(programs / name), "-q", str(path)], capture_output=True).returncode == 0
        inputs = [path for path in inputs if answered(path)]
        seconds = [run([str(programs / name), "-q", str(inputs[0])])[0] for _ in range(4 * runs)]
        lines.append(f"| `{name}` on {inputs[0].parent.name} | {1000 * statistics.median(seconds):.1f} ({1000 * min(seconds):.1f} to {1000 * max(seconds):.1f}) |")
    python = [run([sys.executable, str(HERE / "peers.py"), "nothing", "scipy", "-"])[0] for _ in range(runs)]
    lines.append(f"| Python with NumPy and SciPy, doing nothing | {1000 * statistics.median(python):.0f} |")
    return "\n".join([*lines, ""])


def growth(chosen: list[Job], folder: Path, scale: float) -> str:
    """Time and memory at ten times the rows, with the exponent that fits."""
    lines = [
        "## Ten times the rows", "",
        "Seconds of the fastest of three runs and peak memory. The exponent is the slope of log time over log rows in the last step.", "",
        "| | " + " | ".join(f"{int(size * scale):,}".replace(",", " ") for size in SIZES) + " | exponent of time | of memory |",
        "| --- |" + " --- |" * (len(SIZES) + 2),
    ]
    for job in chosen:
        cells, seconds, peaks = [], [], []
        for size in SIZES:
            if size > LARGEST.get(job.name, PIECE):
                cells.append("")
                continue
            made = job.make(folder, max(1000, int(size * scale)))
            best = [run(job.ours(made))[:2] for _ in range(3)]
            seconds.append(min(one for one, _ in best))
            peaks.append(max(peak for _, peak in best))
            cells.append(f"{seconds[-1]:.3f} s, {peaks[-1]:.0f} MB")
            Path(made["path"]).unlink()
        of = lambda series: np.log10(series[-1] / series[-2])
        lines.append(f"| `{job.name}` | {' | '.join(cells)} | {of(seconds):.2f} | {of(peaks):.2f} |")
    return "\n".join([*lines, ""])


def machine() -> str:
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "unknown")
    import importlib.metadata as metadata

    names = ["numpy", "scipy", "pandas", "polars", "pyarrow", "orjson", "allantools"]
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in names)
    return f"{os.cpu_count()} cores ({model}), Python {platform.python_version()}, {versions}."


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=Path, default=HERE.parent / "target/release")
    parser.add_argument("--scale", type=float, default=1.0)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--only", default="")
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    wanted = [name for name in arguments.only.split(",") if name]
    chosen = [job for job in jobs(arguments.programs) if not wanted or job.name in wanted]
    parts = [
        "# Performance", "",
        f"Written by `just bench-peers`. {machine()} All programs run in turn, {arguments.runs} times each: median, with minimum and maximum in brackets.", "",
    ]
    with tempfile.TemporaryDirectory() as name:
        for job in chosen:
            print(job.name, file=sys.stderr)
            folder = Path(name) / job.name
            folder.mkdir()
            parts.append(measure(job, folder, arguments.scale, arguments.runs))
            subprocess.run(["rm", "-r", str(folder)], check=True)
        if not wanted or "small" in wanted:
            parts.append(small(arguments.programs, arguments.runs))
        if not wanted or "growth" in wanted:
            streams = [job for job in jobs(arguments.programs) if job.name in ("stream-csv", "stream-parquet", "correct", "spectrum")]
            parts.append(growth(streams, Path(name), arguments.scale))
    text = "\n".join(parts)
    if arguments.output:
        arguments.output.write_text(text)
    else:
        print(text)


if __name__ == "__main__":
    main()
