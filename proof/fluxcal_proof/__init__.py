"""Sealed cases for `diagnose` and `diffmag`: physics written from published equations, answers, scores, and a page.

Nothing here comes from the programs that are tested: they are run as programs, and their answers are read as JSON.
"""
import os

# Cases run two at a time; each with one thread of linear algebra.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
