"""What the peers do: one job by one library, in a process of its own.

    python peers.py JOB LIBRARY FILE...

prints one line of JSON: the seconds without the start of Python and the imports, and the answer, a list of numbers.
"""

import json
import sys
import time
from pathlib import Path

REFERENCE = ["reference_x_nt", "reference_y_nt", "reference_z_nt"]
TEST = ["test_x_nt", "test_y_nt", "test_z_nt"]


def matrix(library, path):
    """test = M reference + o by least squares: the matrix, row by row."""
    import numpy as np

    read = reader(library, REFERENCE + TEST)
    start = time.perf_counter()
    columns = read(path)
    design = np.column_stack([np.ones(len(columns[0])), *columns[:3]])
    # The normal equations: what the quickest few lines would do.
    eta = np.linalg.solve(design.T @ design, design.T @ np.column_stack(columns[3:]))
    return start, eta[1:].T.ravel().tolist()


def to_parquet(library, path):
    """A logger's CSV read and written as Parquet: the sum of each column of readings."""
    output = path + f".{library}.parquet"
    if library == "polars":
        import polars as pl

        start = time.perf_counter()
        table = pl.read_csv(path, try_parse_dates=True)
        table.write_parquet(output)
        return start, [float(table[name].sum()) for name in table.columns[1:]]
    if library == "pyarrow":
        import pyarrow.csv
        import pyarrow.compute
        import pyarrow.parquet

        start = time.perf_counter()
        table = pyarrow.csv.read_csv(path)
        pyarrow.parquet.write_table(table, output)
        return start, [pyarrow.compute.sum(table[name]).as_py() for name in table.column_names[1:]]
    return pandas_table("csv", path)


def iaga(library, path):
    """IAGA-2002 read and written as Parquet: the sum of each component."""
    return pandas_table("iaga", path)


def pandas_table(way, path):
    """A file read by pandas as the bench of `ingest` does it, and written as Parquet: the sum of X, Y and Z."""
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "crates/ingest/benches"))
    import pandas_peer

    start = time.perf_counter()
    table = getattr(pandas_peer, way)(path)
    table.to_parquet(path + ".pandas.parquet", index=False)
    return start, [float(table[name].sum()) for name in table.columns[1:4]]


COPY = "Polars, reading and writing the result"


def correct(library, path):
    """B = A (k V + o), the matrix alone, without effects and without uncertainties; or reading and writing the result."""
    if library == COPY:
        import polars as pl

        start = time.perf_counter()
        pl.read_parquet(Path(path).with_name("fields.parquet")).write_parquet(path + ".copy.parquet")
        return start, []
    names = ["time_s", "sensor_x_v", "sensor_y_v", "sensor_z_v"]
    import numpy as np

    read = reader(library, names)
    start = time.perf_counter()
    time_s, *volts = read(path)
    a = np.linalg.inv(np.eye(3) + 1e-3 * np.array([[0, 1, 2], [2, 0, 1], [1, 2, 0]]))
    field = (np.column_stack(volts) * 8000.0 + 10.0) @ a.T
    table = dict(zip(["time_s", "x", "y", "z"], [time_s, *field.T]))
    if library == "polars":
        import polars as pl

        pl.DataFrame(table).write_parquet(path + ".polars.parquet")
    else:
        import pyarrow as pa
        import pyarrow.parquet

        pa.parquet.write_table(pa.table(table), path + ".pyarrow.parquet")
    return start, []


def spectrum(library, path):
    """Amplitude of 1/f noise by Welch's method, or one Fourier transform alone."""
    import numpy as np

    series = np.fromfile(path)
    start = time.perf_counter()
    if library == "one FFT (NumPy)":
        np.abs(np.fft.rfft(series)) ** 2
        return start, []
    if library == "one FFT (SciPy)":
        import scipy.fft

        scipy.fft.rfft(series, workers=2)
        return start, []
    if library == "allantools":
        import allantools

        start = time.perf_counter()
        allantools.oadev(series, rate=1.0, data_type="freq", taus="octave")
        return start, []
    import scipy.signal

    start = time.perf_counter()
    scipy.signal.welch(series, fs=100.0, nperseg=1 << 18)
    return start, []


def flicker(library, count):
    """Samples of 1/f noise by shaping white noise in the frequency domain."""
    import numpy as np

    start = time.perf_counter()
    n = int(count)
    generator = np.random.default_rng(1)
    spectrum = np.fft.rfft(generator.standard_normal(n))
    frequency = np.fft.rfftfreq(n, 1.0)
    frequency[0] = frequency[1]
    np.fft.irfft(spectrum / np.sqrt(frequency), n)
    return start, []


def document(library, path):
    """A document read and written again."""
    if library == "orjson":
        import orjson

        start = time.perf_counter()
        with open(path, "rb") as file:
            value = orjson.loads(file.read())
        with open(path + ".orjson", "wb") as file:
            file.write(orjson.dumps(value))
        return start, []
    start = time.perf_counter()
    with open(path) as file:
        value = json.load(file)
    with open(path + ".json", "w") as file:
        json.dump(value, file)
    return start, []


def stepwise(library, path):
    """Columns recorded beside a pair, in some forms, taken in by forward selection with the BIC: the coefficients of the column found first."""
    import numpy as np

    start = time.perf_counter()
    with open(path) as file:
        columns = {name: np.array(values) for name, values in json.load(file)["recordings"][0]["columns"].items()}
    test = np.column_stack([columns[name] for name in TEST])
    design = np.column_stack([np.ones(len(test)), *[columns[name] - columns[name].mean() for name in REFERENCE]])
    candidates = []
    for name in sorted(set(columns) - {"time_s", *REFERENCE, *TEST}):
        column = columns[name]
        candidates += [column, (column - column.mean()) ** 2, *[np.roll(column, rows) for rows in (-2, -1, 1, 2)]]
        for rows in (2, 4, 8, 15, 30, 60, 120, 240):
            late, weight = column.copy(), 1 - np.exp(-1 / rows)
            for row in range(1, len(late)):
                late[row] = late[row - 1] + weight * (column[row - 1] - late[row - 1])
            candidates.append(late)
    criterion, first = np.inf, None
    while True:
        tried = []
        for candidate in candidates:
            with_it = np.column_stack([design, candidate])
            fit = np.linalg.lstsq(with_it, test, rcond=None)[0]
            squares = np.mean((test - with_it @ fit) ** 2, axis=0)
            bic = len(test) * np.log(squares).sum() + 3 * with_it.shape[1] * np.log(len(test))
            tried.append((bic, with_it, fit[-1].tolist()))
        best = min(tried, key=lambda one: one[0])
        if best[0] >= criterion:
            return start, first
        criterion, design, first = best[0], best[1], first or best[2]


def nothing(library, path):
    """Starting Python with NumPy and SciPy, which every script does first."""
    import numpy  # noqa: F401
    import scipy.optimize  # noqa: F401

    return time.perf_counter(), []


def reader(library, names):
    """Reads columns of a CSV or Parquet file as arrays; the import is not timed."""
    if library == "polars":
        import polars as pl

        def read(path):
            table = pl.read_parquet(path, columns=names) if path.endswith("parquet") else pl.read_csv(path, columns=names)
            return [table[name].to_numpy() for name in names]
    elif library == "pyarrow":
        import pyarrow.csv
        import pyarrow.parquet

        def read(path):
            if path.endswith("parquet"):
                table = pyarrow.parquet.read_table(path, columns=names)
            else:
                options = pyarrow.csv.ConvertOptions(include_columns=names)
                table = pyarrow.csv.read_csv(path, convert_options=options)
            return [table[name].to_numpy() for name in names]
    else:
        import pandas as pd

        def read(path):
            table = pd.read_parquet(path, columns=names) if path.endswith("parquet") else pd.read_csv(path, usecols=names)
            return [table[name].to_numpy() for name in names]

    return read


if __name__ == "__main__":
    name, library, *paths = sys.argv[1:]
    start, answer = globals()[name](library, *paths)
    print(json.dumps({"seconds": time.perf_counter() - start, "answer": answer}))
