"""The programs as they are shipped, each run by itself on documents in a temporary folder."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from pathlib import Path

from .series import Series

FIXTURES = Path(__file__).parents[3] / "fixtures"


class Refused(Exception):
    """A program refuses, in its own words."""


class Programs:
    """Programs in one folder, recordings in another."""

    def __init__(self, programs: Path, data: Path) -> None:
        self.folder, self.data = Path(programs), Path(data)

    def files(self, folder: str, end: str) -> list[str]:
        """Files of a folder of the recordings by name, below the data."""
        return sorted(f"{folder}/{path.name}" for path in (self.data / folder).iterdir()
                      if path.name.endswith(end))

    def ingest(self, *names: str, mapping: str | None = None, sort: bool = False) -> Series:
        """Files of one series; `mapping` is a file below fixtures."""
        arguments = ["--inline"] + ["--sort"] * sort
        if mapping:
            arguments += ["--map", str(FIXTURES / f"{mapping}.json")]
        return Series.of(self._run("ingest", arguments, *(str(self.data / name) for name in names)))

    def ask(self, program: str, arguments: list[str], recordings: list[dict], given: dict | None = None,
            against: list[dict] | None = None) -> dict:
        """What a program answers to a document of these recordings, with calibration and instrument as given;
        with `against`, held against the readings of another document."""
        with tempfile.TemporaryDirectory() as folder:
            def write(name: str, content: dict) -> str:
                path = Path(folder, name)
                path.write_text(json.dumps({"fluxcal": 1, **content}))
                return str(path)
            document = write("document.json", {"recordings": recordings, **(given or {})})
            if against is not None:
                arguments = [*arguments, "--against", write("simulated.json", {"recordings": against})]
            return self._run(program, arguments, document)

    def _run(self, program: str, arguments: list[str], *files: str) -> dict:
        # One thread: the answer does not depend on the number.
        run = subprocess.run([self.folder / program, *arguments, "-q", *files], capture_output=True, text=True,
                             env=os.environ | {"RAYON_NUM_THREADS": "1"}, check=False)
        if run.returncode == 0:
            return json.loads(run.stdout)
        words = run.stderr.strip().removeprefix(f"{program}: ")
        for file in files:
            words = words.replace(f"{file}, ", "").replace(file, Path(file).name)
        raise Refused(words.replace("document.json", "the document"))
