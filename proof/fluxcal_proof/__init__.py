"""Sealed cases for `diagnose` and `diffmag`: physics written from published equations, answers, scores, and a page.

Nothing here comes from the programs that are tested: they are run as programs, and their answers are read as JSON.
"""
