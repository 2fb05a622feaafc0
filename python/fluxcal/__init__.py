"""fluxcal from Python: every program as a function, recordings as frames, faults as exceptions.

>>> import fluxcal
>>> document = fluxcal.scalarcal(fluxcal.ingest("rotation.csv"))
>>> document["calibration"]["sensors"]["x"]["offset_nt"]
{'value': 31.03, 'std': 0.073, ...}

A document is a dict, or the path of a file. Options are those of the programs, with _ for -; where one names a file, a dict may stand in its place. What the programs say on
standard error goes to the logger "fluxcal".
"""
from __future__ import annotations

import json
from typing import Any, Iterable, Mapping

from ._frames import corrected, frame, recording, results
from ._plot import plot
from ._run import Document, Error, PathLike, Refused, Undetermined, call, text

__all__ = [
    "Document", "Error", "Page", "Refused", "Undetermined", "absolute", "axescal", "certificate", "coilcal", "correct", "corrected", "design",
    "diagnose", "diffmag", "diffmag_merge", "diffmag_stream", "effects", "flight", "frame", "guess", "ingest", "observatory", "plot", "recording", "replay",
    "report", "results", "scalarcal", "scalarcal_merge", "scalarcal_stream", "sensorcal", "series", "simulate", "starcal", "starcal_merge",
    "starcal_stream", "sweep",
]
__version__ = "0.1.0"

# `**locals()` hands on the parameters as they are: each is an option of the program, but for `document`.


class Page(str):
    """A page of HTML that a notebook shows."""

    def _repr_html_(self) -> str:
        escaped = self.replace("&", "&amp;").replace('"', "&quot;")
        return f'<iframe srcdoc="{escaped}" style="width: 100%; height: 60em; border: 0"></iframe>'


def simulate(plan: Document, *, seed: int | None = None, place: Iterable[float] = (), date: str | None = None,
             field_model: str | None = None) -> dict[str, Any]:
    """The document that a plan would give; `place` is latitude, longitude and height in metres."""
    options = {name: value for name, value in locals().items() if name != "plan"}
    return call("simulate", "campaign", document=plan, **options)


def observatory(plan: Document, *, seed: int | None = None, place: Iterable[float] = (), date: str | None = None,
                field_model: str | None = None) -> dict[str, Any]:
    """Absolute measurements and a variometer, as an observatory with such a plan would have them."""
    options = {name: value for name, value in locals().items() if name != "plan"}
    return call("simulate", "observatory", document=plan, **options)


def flight(plan: Document, *, seed: int | None = None) -> dict[str, Any]:
    """Readings and star cameras in an orbit, as such a plan has them."""
    return call("simulate", "flight", document=plan, seed=seed)


def replay(document: Document, *, noise: bool = False, seed: int | None = None) -> dict[str, Any]:
    """What a document's recordings should have read."""
    return call("simulate", "replay", **locals())


def sweep(plan: Document, *, seeds: str | None = None, set: Iterable[str] = ()) -> list[dict[str, Any]]:
    """The documents of a plan for many seeds ("1..20") or values ("facility.theodolite_arcsec=1,2")."""
    return [json.loads(line) for line in text("simulate", "sweep", document=plan, seeds=seeds, set=set).splitlines()]


def effects(effect: str = "") -> str:
    """The catalogue of effects, or one of them."""
    return text("simulate", "effects", *effect.split(), quiet=False)


def ingest(*files: PathLike, map: Document | None = None, add: Document | None = None, as_: str | None = None, id: str | None = None,
           procedure: str | None = None, keep: str | None = None, sort: bool = False, trust_rows: bool = False,
           declination_base_arcmin: float | None = None, magnitude_nt: float | None = None, magnitude_std_nt: float | None = None,
           place: Iterable[float] = (), date: str | None = None, field_model: str | None = None) -> dict[str, Any]:
    """Files of one series as a document; the readings are in it, however many."""
    options = {name: value for name, value in locals().items() if name != "files"}
    return call("ingest", *files, inline=True, **options)


def guess(file: PathLike, *, as_: str | None = None) -> dict[str, Any]:
    """A mapping for a file of columns, to look at, change, and give to `ingest`."""
    return call("ingest", "guess", file, as_=as_)


def series(document: Document, operation: str, *names: str, **options: Any) -> dict[str, Any]:
    """Recordings cut, averaged, resampled, renamed or joined: `series(document, "average", window=60)`. `from_` is --from."""
    # Where names follow the operation, the document is an option.
    return call("series", operation, *names, **{"document_" if operation in ("rename", "join") else "document": document}, **options)


def coilcal(document: Document, *, off_centre_m: float | None = None, nyquist_hz: float | None = None,
            drop_recordings: bool = False) -> dict[str, Any]:
    """Constants and gradients of the coils."""
    return call("coilcal", **locals())


def sensorcal(document: Document, *, turn_deg: float | None = None, axes_std_deg: float | None = None,
              budget_field_nt: Iterable[float] = (), budget_warmer_k: Iterable[float] = (), drop_recordings: bool = False) -> dict[str, Any]:
    """Sensitivity, offset, noise, drift and coefficients of each sensor."""
    return call("sensorcal", **locals())


def axescal(document: Document, *, known_coils: bool = False, start: str | None = None, free_scales: bool = False, robust: bool = False,
            sensor: str | None = None, coil: str | None = None, drop_recordings: bool = False) -> dict[str, Any]:
    """Directions of the sensors and of the coils."""
    return call("axescal", **locals())


def design(**options: Any) -> dict[str, Any]:
    """The recordings that reach a target in arcseconds in the least time: `design(target_arcsec=0.5)`."""
    return call("axescal", "design", **options)


def scalarcal(document: Document, *, known: bool = False, reference_offset: bool = False, windows: float | None = None, robust: bool = False,
              constant_magnitude: bool = False, vector: bool = False, with_: Iterable[str] = (), scales_within: float | None = None,
              angles_within: float | None = None, only: str | None = None, magnitude_nt: float | None = None, magnitude_std_nt: float | None = None,
              place: Iterable[float] = (), date: str | None = None, field_model: str | None = None,
              drop_recordings: bool = False) -> dict[str, Any]:
    """Sensitivities, offsets and angles by the magnitude of the field; `place` is latitude, longitude and height in metres."""
    return call("scalarcal", **locals())


def starcal(document: Document, *, attitude_frame: str | None = None, field_model: str | None = None, ut1_utc_s: float | None = None,
            drop_recordings: bool = False) -> dict[str, Any]:
    """A vector magnetometer in flight, beside star cameras and in a model of the field."""
    return call("starcal", **locals())


def diffmag(document: Document, *, correct_clock: bool = False, drop_recordings: bool = False) -> dict[str, Any]:
    """Two magnetometers side by side."""
    return call("diffmag", **locals())


def absolute(document: Document, *, drop_recordings: bool = False) -> dict[str, Any]:
    """Declination, inclination and the baselines of a variometer by a theodolite with a magnetometer."""
    return call("absolute", **locals())


def diagnose(document: Document, *, against: Document | None = None, refit: bool = False, empirical: bool = False, without: Iterable[str] = (),
             seed: int | None = None, level: float | None = None, drop_recordings: bool = False) -> dict[str, Any]:
    """What physics the model left out."""
    return call("diagnose", **locals())


def diffmag_stream(*files: PathLike, **options: Any) -> dict[str, Any]:
    """`diffmag stream`: long series in files; `partial=True` gives the statistics, to be merged."""
    return call("diffmag", "stream", *files, **options)


def diffmag_merge(pieces: Iterable[Mapping[str, Any]], **options: Any) -> dict[str, Any]:
    """`diffmag merge` of what `diffmag_stream(…, partial=True)` gave."""
    return call("diffmag", "merge", lines=pieces, **options)


def scalarcal_stream(*files: PathLike, **options: Any) -> dict[str, Any]:
    """`scalarcal stream`; as `diffmag_stream`."""
    return call("scalarcal", "stream", *files, **options)


def starcal_stream(*files: PathLike, **options: Any) -> dict[str, Any]:
    """`starcal stream`; as `diffmag_stream`."""
    return call("starcal", "stream", *files, **options)


def starcal_merge(pieces: Iterable[Mapping[str, Any]], **options: Any) -> dict[str, Any]:
    """`starcal merge`; as `diffmag_merge`."""
    return call("starcal", "merge", lines=pieces, **options)


def scalarcal_merge(pieces: Iterable[Mapping[str, Any]], **options: Any) -> dict[str, Any]:
    """`scalarcal merge`; as `diffmag_merge`."""
    return call("scalarcal", "merge", lines=pieces, **options)


def correct(document: Document, *, frame: str | None = None, magnitude_nt: float | None = None, magnitude_std_nt: float | None = None,
            place: Iterable[float] = (), date: str | None = None, field_model: str | None = None) -> dict[str, Any]:
    """The document with the field in each recording. For files and frames see `corrected`."""
    return call("correct", **locals())


def report(document: Document, *, spec: Document | None = None) -> Page:
    """The page, which a notebook shows; `report(document).encode()` is what belongs in a file."""
    return Page(text("report", **locals()))


def certificate(document: Document, *, data: Document | None = None, spec: Document | None = None, paper: str | None = None) -> Page:
    """The calibration certificate; `data` are its administrative data, `spec` the requirements of a statement of conformity."""
    return Page(text("report", document=document, certificate="-", certificate_data=data, spec=spec, paper=paper))
