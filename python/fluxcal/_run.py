"""Runs the programs: arguments, standard streams, faults."""
from __future__ import annotations

import json
import logging
import math
import os
import re
import shutil
import subprocess
import sysconfig
import tempfile
from pathlib import Path
from typing import Any, Iterable, Mapping, Union

PathLike = Union[str, "os.PathLike[str]"]
Document = Union[Mapping[str, Any], PathLike]
Option = Union[bool, float, Document, Iterable[Any], None]

_LOG = logging.getLogger("fluxcal")
# axescal: standard input, line 87: recordings[0].columns.sensor_z_v[1]: found …
_PLACE = re.compile(r"^(?:(?P<file>.+?), line (?P<line>\d+): )?(?:(?P<path>[A-Za-z_]\w*(?:[.\[][^:]*)?): (?=found))?")


class Error(Exception):
    """A program refused, or could not answer.

    `message` is what it said; `path` is the JSON path, `file` and `line` the place, where it named them; `exit_code` is its exit code.
    """

    def __init__(self, program: str, exit_code: int, said: str) -> None:
        self.program, self.exit_code = program, exit_code
        # What is said before the fault (which rows were taken) is not the fault.
        self.message = re.split(rf"^{program}: ", said.strip(), flags=re.MULTILINE)[-1]
        match = _PLACE.match(self.message)
        place: dict[str, str | None] = match.groupdict() if match else {}
        self.file, self.path = place.get("file"), place.get("path")
        self.line = int(place.get("line") or 0) or None
        super().__init__(f"{program}: {self.message or f'ended with {exit_code}'}")


class Refused(Error):
    """The request or the document is wrong (exit code 2)."""


class Undetermined(Error):
    """The data do not allow the answer; the message says what is missing (exit code 1)."""


def program(name: str) -> str:
    """Where a program is: in the folder FLUXCAL_PROGRAMS, else where pip puts scripts, else on the PATH."""
    pip = [sysconfig.get_path("scripts"), sysconfig.get_path("scripts", sysconfig.get_preferred_scheme("user"))]
    folders = os.environ.get("FLUXCAL_PROGRAMS") or os.pathsep.join([*pip, os.environ.get("PATH", os.defpath)])
    if found := shutil.which(name, path=folders):
        return found
    raise FileNotFoundError(f"the program {name} was not found; install the wheel, or name its folder in FLUXCAL_PROGRAMS")


def _plain(value: Any) -> Any:
    """Values as JSON has them: arrays as lists, a missing reading as None."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    return _plain(value.tolist()) if hasattr(value, "tolist") else value


def _arguments(options: Mapping[str, Option], folder: Path) -> Iterable[str]:
    for name, value in options.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        if isinstance(value, Mapping):
            (folder / f"{name}.json").write_text(json.dumps(_plain(value)))
            value = folder / f"{name}.json"
        if isinstance(value, bool) or value is None:
            yield from [option] if value else []
        elif isinstance(value, Iterable) and not isinstance(value, str):
            values = list(value)
            if values and not isinstance(values[0], str):
                values = [",".join(map(str, values))]
            yield from (f"{option}={one}" for one in values)
        else:
            yield f"{option}={value}"


def text(name: str, *words: PathLike, document: Document | None = None, lines: Iterable[Mapping[str, Any]] = (), quiet: bool = True,
         **options: Option) -> str:
    """What a program writes on standard output. A document that is a dict goes to its standard input; so do `lines`, one a line."""
    if document is not None and not isinstance(document, Mapping):
        words += (document,)
    given = [document] if isinstance(document, Mapping) else lines
    standard_input = "\n".join(json.dumps(_plain(one)) for one in given)
    if quiet and not _LOG.isEnabledFor(logging.INFO):
        options["quiet"] = True
    with tempfile.TemporaryDirectory(prefix="fluxcal-") as folder:
        done = subprocess.run([program(name), *words, *_arguments(options, Path(folder))], input=standard_input.encode(), capture_output=True)
    said = done.stderr.decode().rstrip()
    if done.returncode != 0:
        raise {1: Undetermined, 2: Refused}.get(done.returncode, Error)(name, done.returncode, said)
    if said:
        _LOG.info(said)
    return done.stdout.decode()


def call(name: str, *words: PathLike, **given: Any) -> dict[str, Any]:
    """The document that a program writes."""
    answer: dict[str, Any] = json.loads(text(name, *words, **given))
    return answer
