"""Runs a command and says how long it took and its peak of memory, kB: `python -I -S alone.py FILE COMMAND…` writes both to FILE.

A process inherits the peak of the one that started it, so that this one is small.
"""

import os
import sys
import time

start = time.perf_counter()
child = os.posix_spawnp(sys.argv[2], sys.argv[2:], os.environ)
_, status, usage = os.wait4(child, 0)
with open(sys.argv[1], "w") as file:
    file.write(f"{time.perf_counter() - start} {usage.ru_maxrss}")
sys.exit(os.waitstatus_to_exitcode(status))
