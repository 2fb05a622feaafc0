"""The peer of the bench: pandas reads the file as `ingest` does, and writes it as Parquet. Prints seconds and sums, as JSON.

    python3 pandas_peer.py iaga|csv|csv-pyarrow FILE
"""

import json
import sys
import time

import pandas as pd


def iaga(path):
    """The table of a file of IAGA-2002."""
    with open(path) as file:
        skip = next(number for number, line in enumerate(file) if line.startswith("DATE"))
    names = ["date", "time", "doy", "sensor_x_nt", "sensor_y_nt", "sensor_z_nt", "reference_nt"]
    table = pd.read_csv(path, sep=r"\s+", skiprows=skip + 1, header=None, names=names)
    when = pd.to_datetime(table["date"] + " " + table["time"], format="%Y-%m-%d %H:%M:%S.%f")
    table = table[names[3:]].mask(table[names[3:]] >= 88888)
    table.insert(0, "time", when)
    return table


def csv(path, **options):
    """The table of a CSV file with times in ISO 8601."""
    table = pd.read_csv(path, **options)
    table["time"] = pd.to_datetime(table["time"], format="ISO8601")
    return table


if __name__ == "__main__":
    way, path = sys.argv[1:]
    start = time.perf_counter()
    table = iaga(path) if way == "iaga" else csv(path, **({"engine": "pyarrow"} if way == "csv-pyarrow" else {}))
    read = time.perf_counter() - start
    sums = [float(table[name].sum()) for name in table.columns[1:]]
    table.to_parquet(path + ".peer.parquet", index=False)
    print(json.dumps({"read": read, "whole": time.perf_counter() - start, "rows": len(table), "sums": sums}))
