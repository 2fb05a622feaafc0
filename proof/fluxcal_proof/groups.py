"""Which kinds may be looked at while a program is developed, and which are scored.

The rule: a kind that an earlier generator of this project had in the same form, that a published page has scored, or that
anybody has looked at case by case is in DEVELOP, by name and form. Every other kind is scored. A kind that is looked at
after a page is added here before the next one.
"""
from __future__ import annotations

from .effect import KINDS, Kind

DEVELOP = {
    ("loop_bandwidth", "one pole"), ("delay", "filter of a converter"), ("clock_offset", "one recording"),
    ("loop_bandwidth", "two unlike poles"), ("eddy_currents", "plate"), ("eddy_currents", "many bodies"),
    ("offset_temperature", "bent"), ("offset_temperature_lag", "one body"),
    ("offset_electronics_temperature", "amplifier"), ("sensitivity_electronics_temperature", "reference"),
    ("axis_temperature", "wedge"), ("coil_temperature", "former that expands"), ("stray_current", "heater"), ("stray_current", "panel logged late"),
    ("dependence", "humidity, late"), ("coil_heating", "winding"),
    ("quadratic_nonlinearity", "square"), ("cubic_nonlinearity", "cube"), ("cross_field", "squares and products"),
    ("cross_field_sensitivity", "product"), ("saturation", "soft end"), ("hysteresis", "play"),
    ("hysteresis", "Preisach"), ("hysteresis", "Bouc and Wen"), ("perming", "one threshold"),
    ("nulling_leakage", "slow and fast part"), ("nulling_leakage", "loop of two poles"), ("nulling_leakage", "loop with a dead time"), ("coil_gradient", "five components"),
    ("mains", "load differs by recording"), ("reaction_wheel", "magnet on a rotor"),
    ("ageing", "straight"), ("sensitivity_ageing", "straight"), ("warm_up", "two bodies"), ("reading_step", "knock"),
    ("spike", "bit errors"), ("vehicle_pass", "dipole"), ("differential_nonlinearity", "one wrong bit"),
    ("quantisation", "too few codes"),
    ("unnamed", "contact that opens and closes"), ("unnamed", "product of the three fields"),
    ("unnamed", "gain that changes at a moment"), ("unnamed", "heater that nobody recorded"),
    ("unnamed", "product of panel current and temperature"), ("unnamed", "supply that sags"), ("unnamed", "crystal axes"),
    ("unnamed", "chaotic convection"), ("unnamed", "tank that fills and empties"),
    ("undecidable", "two equal temperatures"), ("undecidable", "two currents in proportion"),
    ("undecidable", "two loggers of one humidity"),
}


def group(kind: Kind) -> str:
    """`develop` or `score`."""
    return "develop" if (kind.name, kind.form) in DEVELOP else "score"


def kinds(of: str, sort: str) -> list[Kind]:
    """Kinds of a group and of a sort: single (with a name), unnamed or undecidable."""
    own = [kind for kind in KINDS if group(kind) == of]
    if sort in ("unnamed", "undecidable"):
        return [kind for kind in own if kind.name == sort]
    return [kind for kind in own if kind.name not in ("unnamed", "undecidable")]
