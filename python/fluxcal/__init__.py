"""fluxcal from Python: every program as a function, recordings as frames, faults as exceptions.

>>> import fluxcal
>>> document = fluxcal.scalarcal(fluxcal.ingest("rotation.csv"))
>>> document["calibration"]["sensors"]["x"]["offset_nt"]
{'value': 31.03, 'std': 0.073, ...}

A document is a dict, or the path of a file. Options are those of the programs, with _ for -; what they say on standard error goes to the logger "fluxcal". Where an option names a
file, a dict may stand in its place.
"""
from __future__ import annotations

from typing import Any, Iterable, Mapping

from ._frames import Frame, corrected, frame, recording
from ._plot import plot
from ._run import Document, Error, PathLike, Refused, Undetermined, call, text

__all__ = [
    "Document", "Error", "Page", "Refused", "Undetermined", "axescal", "certificate", "coilcal", "correct", "corrected", "design", "diagnose", "diffmag",
    "diffmag_merge", "diffmag_stream", "effects", "frame", "guess", "ingest", "plot", "recording", "replay", "report", "scalarcal",
    "scalarcal_merge", "scalarcal_stream", "sensorcal", "series", "simulate", "sweep",
]
__version__ = "0.1.0"


class Page(str):
    """A page of HTML that a notebook shows."""

    def _repr_html_(self) -> str:
        escaped = self.replace("&", "&amp;").replace('"', "&quot;")
        return f'<iframe srcdoc="{escaped}" style="width: 100%; height: 60em; border: 0"></iframe>'


def simulate(plan: Document, *, seed: int | None = None) -> dict[str, Any]:
    """The document that a plan would give."""
    return call("simulate", "campaign", document=plan, seed=seed)


def replay(document: Document, *, noise: bool = False, seed: int | None = None) -> dict[str, Any]:
    """What a document's recordings should have read."""
    return call("simulate", "replay", document=document, noise=noise, seed=seed)


def sweep(plan: Document, *, seeds: str | None = None, set: Iterable[str] = ()) -> list[dict[str, Any]]:
    """The documents of a plan for many seeds ("1..20") or values ("facility.theodolite_arcsec=1,2")."""
    import json

    lines = text("simulate", "sweep", document=plan, seeds=seeds, set=list(set)).splitlines()
    return [json.loads(line) for line in lines]


def effects(effect: str | None = None) -> str:
    """The catalogue of effects, or one of them."""
    return text("simulate", "effects", *([effect] if effect else []), quiet=False)


def ingest(*files: PathLike, map: Document | None = None, add: Document | None = None, as_: str | None = None, id: str | None = None,
           procedure: str | None = None, keep: str | None = None, sort: bool = False, trust_rows: bool = False,
           declination_base_arcmin: float | None = None) -> dict[str, Any]:
    """Files of one series as a document; the readings are in it, however many."""
    return call("ingest", *files, map=map, add=add, as_=as_, id=id, procedure=procedure, keep=keep, sort=sort, trust_rows=trust_rows,
                declination_base_arcmin=declination_base_arcmin, inline=True)


def guess(file: PathLike, *, as_: str | None = None) -> dict[str, Any]:
    """A mapping for a file of columns, to look at, change, and give to `ingest`."""
    return call("ingest", "guess", file, as_=as_)


def series(document: Document, operation: str, *names: str, **options: Any) -> dict[str, Any]:
    """Recordings cut, averaged, resampled, renamed or joined: `series(document, "average", window=60)`. `from_` is --from."""
    if operation in ("rename", "join"):
        return call("series", operation, *names, **{**options, "document": document})
    return call("series", operation, document=document, **options)


def coilcal(document: Document, *, off_centre_m: float | None = None, nyquist_hz: float | None = None,
            drop_recordings: bool = False) -> dict[str, Any]:
    """Constants and gradients of the coils."""
    return call("coilcal", document=document, off_centre_m=off_centre_m, nyquist_hz=nyquist_hz, drop_recordings=drop_recordings)


def sensorcal(document: Document, *, turn_deg: float | None = None, axes_std_deg: float | None = None,
              budget_field_nt: Iterable[float] = (), budget_warmer_k: Iterable[float] = (), drop_recordings: bool = False) -> dict[str, Any]:
    """Sensitivity, offset, noise, drift and coefficients of each sensor."""
    return call("sensorcal", document=document, turn_deg=turn_deg, axes_std_deg=axes_std_deg, budget_field_nt=list(budget_field_nt),
                budget_warmer_k=list(budget_warmer_k), drop_recordings=drop_recordings)


def axescal(document: Document, *, known_coils: bool = False, start: str | None = None, free_scales: bool = False, robust: bool = False,
            sensor: str | None = None, coil: str | None = None, drop_recordings: bool = False) -> dict[str, Any]:
    """Directions of the sensors and of the coils."""
    return call("axescal", document=document, known_coils=known_coils, start=start, free_scales=free_scales, robust=robust, sensor=sensor,
                coil=coil, drop_recordings=drop_recordings)


def design(**options: Any) -> dict[str, Any]:
    """The recordings that reach a target in arcseconds in the least time: `design(target_arcsec=0.5)`."""
    return call("axescal", "design", **options)


def scalarcal(document: Document, *, known: bool = False, reference_offset: bool = False, windows: float | None = None, robust: bool = False,
              constant_magnitude: bool = False, vector: bool = False, with_: Iterable[str] = (), drop_recordings: bool = False) -> dict[str, Any]:
    """Sensitivities, offsets and angles by the magnitude of the field."""
    return call("scalarcal", document=document, known=known, reference_offset=reference_offset, windows=windows, robust=robust,
                constant_magnitude=constant_magnitude, vector=vector, with_=list(with_), drop_recordings=drop_recordings)


def diffmag(document: Document, *, correct_clock: bool = False, drop_recordings: bool = False) -> dict[str, Any]:
    """Two magnetometers side by side."""
    return call("diffmag", document=document, correct_clock=correct_clock, drop_recordings=drop_recordings)


def diagnose(document: Document, *, against: Document | None = None, refit: bool = False, without: Iterable[str] = (), seed: int | None = None,
             level: float | None = None, drop_recordings: bool = False) -> dict[str, Any]:
    """What physics the model left out."""
    return call("diagnose", document=document, against=against, refit=refit, without=list(without), seed=seed, level=level,
                drop_recordings=drop_recordings)


def diffmag_stream(*files: PathLike, **options: Any) -> dict[str, Any]:
    """`diffmag stream`: long series in files; `partial=True` gives the statistics, to be merged."""
    return call("diffmag", "stream", *files, **options)


def diffmag_merge(pieces: Iterable[Mapping[str, Any]], **options: Any) -> dict[str, Any]:
    """`diffmag merge` of what `diffmag_stream(…, partial=True)` gave."""
    return call("diffmag", "merge", lines=pieces, **options)


def scalarcal_stream(*files: PathLike, **options: Any) -> dict[str, Any]:
    """`scalarcal stream`; as `diffmag_stream`."""
    return call("scalarcal", "stream", *files, **options)


def scalarcal_merge(pieces: Iterable[Mapping[str, Any]], **options: Any) -> dict[str, Any]:
    """`scalarcal merge`; as `diffmag_merge`."""
    return call("scalarcal", "merge", lines=pieces, **options)


def correct(document: Document, *, frame: str | None = None) -> dict[str, Any]:
    """The document with the field in each recording. For files and frames see `corrected`."""
    return call("correct", document=document, frame=frame)


def report(document: Document, *, spec: Document | None = None) -> Page:
    """The page, which a notebook shows; `report(document).encode()` is what belongs in a file."""
    return Page(text("report", document=document, spec=spec))


def certificate(document: Document, *, data: Document | None = None, paper: str | None = None) -> Page:
    """The calibration certificate; `data` are its administrative data."""
    return Page(text("report", document=document, certificate="-", certificate_data=data, paper=paper))
