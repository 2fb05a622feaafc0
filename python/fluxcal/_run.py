"""Runs the programs: arguments, standard streams, faults."""
from __future__ import annotations

import json
import logging
import math
import os
import re
import shutil
import subprocess
import tempfile
from importlib import metadata
from pathlib import Path
from typing import Any, Iterable, Mapping, Union

PathLike = Union[str, "os.PathLike[str]"]
Document = Union[Mapping[str, Any], str, "os.PathLike[str]"]
Option = Union[bool, int, float, str, "os.PathLike[str]", Mapping[str, Any], Iterable[Any], None]

_LOG = logging.getLogger("fluxcal")
# axescal: standard input, line 87: recordings[0].columns.sensor_z_v[1]: found …
_PLACE = re.compile(r"^(?:(?P<file>.+?), line (?P<line>\d+): )?(?:(?P<path>[A-Za-z_]\w*(?:[.\[][^:]*)?): (?=found))?")


class Error(Exception):
    """A program refused, or could not answer.

    `message` is what it said; `path` is the JSON path, `file` and `line` the place, where it named them; `exit_code` is its exit code.
    """

    def __init__(self, program: str, exit_code: int, said: str) -> None:
        self.program, self.exit_code = program, exit_code
        lines = said.strip().splitlines()
        # What is said before the fault (which rows were taken) is not the fault.
        first = max((at for at, line in enumerate(lines) if line.startswith(f"{program}: ")), default=0)
        self.message = "\n".join(lines[first:]).removeprefix(f"{program}: ")
        found = _PLACE.match(self.message)
        self.file: str | None = found["file"] if found else None
        self.line: int | None = int(found["line"]) if found and found["line"] else None
        self.path: str | None = found["path"] if found else None
        super().__init__(f"{program}: {self.message or f'ended with {exit_code}'}")


class Refused(Error):
    """The request or the document is wrong (exit code 2)."""


class Undetermined(Error):
    """The data do not allow the answer; the message says what is missing (exit code 1)."""


def program(name: str) -> str:
    """Where a program is: in the folder FLUXCAL_PROGRAMS, where the wheel put it, or on the PATH."""
    if folder := os.environ.get("FLUXCAL_PROGRAMS"):
        return str(Path(folder) / name)
    try:
        installed = metadata.files("fluxcal") or []
    except metadata.PackageNotFoundError:
        installed = []
    for file in installed:
        if file.stem == name and file.suffix in ("", ".exe") and Path(str(file.locate())).is_file():
            return str(file.locate())
    found = shutil.which(name)
    if found is None:
        raise FileNotFoundError(f"the program {name} was not found; install the wheel, or name its folder in FLUXCAL_PROGRAMS")
    return found


def _plain(value: Any) -> Any:
    """Values as JSON has them: arrays as lists, a missing reading as None."""
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    return [_plain(inner) for inner in value] if isinstance(value, (list, tuple)) else value


def to_json(value: Mapping[str, Any]) -> str:
    try:
        return json.dumps(value, allow_nan=False)
    except (ValueError, TypeError):
        return json.dumps(_plain(value), allow_nan=False)


def _arguments(options: Mapping[str, Option], folder: Path) -> list[str]:
    made: list[str] = []
    for name, value in options.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        if isinstance(value, bool) or value is None:
            made += [option] if value else []
        elif isinstance(value, Mapping):
            file = folder / f"{name}.json"
            file.write_text(to_json(value))
            made.append(f"{option}={file}")
        elif isinstance(value, (str, os.PathLike)):
            made.append(f"{option}={os.fspath(value)}")
        elif isinstance(value, Iterable):
            made += [f"{option}={one}" for one in value]
        else:
            made.append(f"{option}={value}")
    return made


def text(name: str, *words: PathLike, document: Document | None = None, lines: Iterable[Mapping[str, Any]] | None = None,
         quiet: bool = True, **options: Any) -> str:
    """What a program writes on standard output. A document that is a dict goes to its standard input; so do `lines`, one a line."""
    wanted = _LOG.isEnabledFor(logging.INFO)
    with tempfile.TemporaryDirectory(prefix="fluxcal-") as folder:
        command = [program(name), *(os.fspath(word) for word in words)]
        standard_input = ""
        if name == "series" and words and words[0] in ("rename", "join") and document is not None:
            options = {**options, "document": document}
        elif isinstance(document, Mapping):
            standard_input = to_json(document)
        elif document is not None:
            command.append(os.fspath(document))
        if lines is not None:
            standard_input = "".join(to_json(line) + "\n" for line in lines)
        command += _arguments(options, Path(folder))
        if quiet and not wanted:
            command.append("-q")
        done = subprocess.run(command, input=standard_input.encode(), capture_output=True)
    said = done.stderr.decode()
    if done.returncode != 0:
        kind = {1: Undetermined, 2: Refused}.get(done.returncode, Error)
        raise kind(name, done.returncode, said)
    if said.strip():
        _LOG.info(said.rstrip())
    return done.stdout.decode()


def call(name: str, *words: PathLike, document: Document | None = None, lines: Iterable[Mapping[str, Any]] | None = None,
         **options: Any) -> dict[str, Any]:
    """The document that a program writes."""
    answer: dict[str, Any] = json.loads(text(name, *words, document=document, lines=lines, **options))
    return answer
