"""The programs as they are shipped, each run by itself, and the recordings that they read."""
import json
import os
import subprocess
import tempfile
import tomllib
from pathlib import Path

from .series import Series

TOML = tomllib.loads(Path(__file__).with_name("sets.toml").read_text())
FIXTURES = Path(__file__).parents[3] / "fixtures"


class Refused(Exception):
    """A program refuses, in its own words."""

    def __init__(self, program: str, words: str) -> None:
        super().__init__(words)
        self.program = program


class Programs:
    """Programs in one folder, recordings in another."""

    def __init__(self, programs: Path, data: Path) -> None:
        self.folder, self.data = Path(programs), Path(data)

    def read(self, name: str) -> Series:
        """A recording of sets.toml, by `ingest`."""
        pattern, *further = TOML["files"][name]
        return self.ingest(sorted(self.data.glob(pattern)), *further)

    def ingest(self, files: list[Path], mapping: str = "", *arguments: str) -> Series:
        """Files of one series; `mapping` is a file below fixtures."""
        mapped = ["--map", f"{FIXTURES}/{mapping}.json"] if mapping else []
        return Series.of(self._run("ingest", ["--inline", *mapped, *arguments], *map(str, files)))

    def ask(self, program: str, arguments: list[str], *recordings: dict, given: dict | None = None, against: dict | None = None) -> dict:
        """The answer to a document of recordings, with calibration and instrument as given; with `against`, held against the readings of
        another recording."""
        with tempfile.TemporaryDirectory() as folder:
            def write(name: str, **content: object) -> str:
                Path(folder, name).write_text(json.dumps({"fluxcal": 1, **content}))
                return f"{folder}/{name}"
            against_it = ["--against", write("simulated.json", recordings=[against])] if against else []
            return self._run(program, arguments + against_it, write("document.json", recordings=recordings, **given or {}))

    def _run(self, program: str, arguments: list[str], *files: str) -> dict:
        # One thread: the answer does not depend on the number.
        run = subprocess.run([self.folder / program, *arguments, "-q", *files], capture_output=True, text=True, check=False,
                             env=os.environ | {"RAYON_NUM_THREADS": "1"})
        if run.returncode == 0:
            return json.loads(run.stdout)
        words = run.stderr.strip().removeprefix(f"{program}: ").replace(f"{Path(files[0]).parent}/", "")
        raise Refused(program, words.replace("document.json, ", "").replace("document.json", "the document"))
