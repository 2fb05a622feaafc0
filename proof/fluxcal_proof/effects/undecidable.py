"""Recordings that cannot tell two names apart, whoever looks: the right answer is the set of both."""
from __future__ import annotations

import numpy as np

from ..campaign import REFERENCE_C, Campaign
from ..effect import Effect, in_sensor, kind, linear
from ..signal import Signal
from .follows import ELECTRONICS, SENSOR, warmth


@kind("undecidable", "two equal temperatures", "follows_column", "sensor and electronics in one oven")
def together(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    for run in c.runs:
        run.temperature[ELECTRONICS] = run.temperature[SENSOR].plus(Signal(level=REFERENCE_C[1] - REFERENCE_C[0]))
    effect = in_sensor(c, axis, lambda run: warmth(run, SENSOR), "offset_temperature", "offset_electronics_temperature")
    effect.undecidable = True
    return effect


@kind("undecidable", "two currents in proportion", "follows_column", "a panel and its battery share a bus")
def currents(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    v, share = rng.normal(size=3), rng.uniform(0.4, 0.8)
    for run in c.runs:
        panel = run.columns["panel_current_a"]
        run.columns["battery_current_a"] = lambda t, panel=panel: 0.5 - share * panel(t)
    parts = [np.outer(v, run.columns["panel_current_a"](run.at)) for run in c.runs]
    return Effect(linear(parts), [("stray_current", "panel_current_a"), ("stray_current", "battery_current_a")], undecidable=True)


@kind("undecidable", "two loggers of one humidity", "follows_column", "one column written by two loggers")
def twins(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    for run in c.runs:
        humid = run.columns["humidity_percent"]
        run.columns["second_humidity_percent"] = lambda t, humid=humid: 1.02 * humid(t) - 1.5
    effect = in_sensor(c, axis, lambda run: run.columns["humidity_percent"](run.at) - 45)
    effect.right, effect.undecidable = [("dependence", "humidity_percent"), ("dependence", "second_humidity_percent")], True
    return effect


@kind("undecidable", "a gauge and its voltage", "follows_column", "one column in two units")
def gauge(c: Campaign, axis: int, rng: np.random.Generator) -> Effect:
    for run in c.runs:
        pressed = run.columns["room_pressure_pa"]
        run.columns["gauge_v"] = lambda t, pressed=pressed: 2.5 + 1e-4 * pressed(t)
    effect = in_sensor(c, axis, lambda run: run.columns["gauge_v"](run.at) - 2.5)
    effect.right, effect.undecidable = [("dependence", "room_pressure_pa"), ("dependence", "gauge_v")], True
    return effect
