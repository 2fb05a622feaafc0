"""The peer of the bench: SciPy fits |M (k v + o)| - F. Prints the seconds of the whole and of the fit alone, and values with uncertainties, as JSON.

Of `trf` and `lm`, with and without x_scale="jac", `lm` with it was the fastest.
"""

import time

start = time.perf_counter()

import json
import sys

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

table = pd.read_parquet(sys.argv[1])
volts = table[["sensor_x_v", "sensor_y_v", "sensor_z_v"]].to_numpy()
reference = table["reference_nt"].to_numpy()
began = time.perf_counter()


def residual(p):
    xy, yz, xz = np.sin(p[6:9])
    across = (yz - xz * xy) / np.sqrt(1 - xy * xy)
    axes = np.array([[1, 0, 0], [xy, np.sqrt(1 - xy * xy), 0], [xz, across, np.sqrt(1 - xz * xz - across * across)]])
    field = np.linalg.inv(axes) @ (volts * p[:3] + p[3:6]).T
    return np.sqrt(np.einsum("ij,ij->j", field, field)) - reference


fit = least_squares(residual, [6400.0] * 3 + [0.0] * 6, method="lm", x_scale="jac")
variance = np.sum(fit.fun**2) / (len(reference) - 9)
std = np.sqrt(np.diag(variance * np.linalg.inv(fit.jac.T @ fit.jac)))
end = time.perf_counter()
scale = np.array([1.0] * 6 + [np.degrees(1) * 3600] * 3)
print(json.dumps({"seconds": end - start, "fit": end - began, "value": (fit.x * scale).tolist(), "std": (std * scale).tolist()}))
