"""The peer of the bench: pandas reads the file, NumPy fits it at once. Prints seconds, peak memory in kB and the matrix, as JSON."""

import json
import resource
import sys
import time

import numpy as np
import pandas as pd

start = time.perf_counter()
path = sys.argv[1]
table = pd.read_parquet(path) if path.endswith(".parquet") else pd.read_csv(path)
design = np.column_stack([np.ones(len(table)), table[["reference_x_nt", "reference_y_nt", "reference_z_nt"]].to_numpy()])
test = table[["test_x_nt", "test_y_nt", "test_z_nt"]].to_numpy()
eta, *_ = np.linalg.lstsq(design, test, rcond=None)
left = test - design @ eta
rms = np.sqrt((left * left).sum(axis=0) / (len(table) - 4))
seconds = time.perf_counter() - start
peak_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps({"seconds": seconds, "peak_kb": peak_kb, "matrix": eta[1:].tolist(), "rms_nt": rms.tolist()}))
