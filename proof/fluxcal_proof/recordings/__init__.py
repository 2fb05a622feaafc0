"""Recordings that others made, which are not in the repository: a page on what the programs make of them, and hosts of injected effects."""
