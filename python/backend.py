"""Builds the wheel (PEP 517): the module, and the programs, which become scripts of the environment. Needs Python and cargo, nothing else.

The programs are built by cargo, or taken from the folder FLUXCAL_PROGRAMS where they are built already.
"""
import base64
import hashlib
import os
import subprocess
import sysconfig
import tomllib
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
PROGRAMS = "simulate ingest series coilcal sensorcal axescal scalarcal starcal diffmag absolute diagnose correct report fluxcal".split()
SUFFIX = ".exe" if os.name == "nt" else ""
# Nothing of a wheel depends on when it was made.
EARLIEST = (1980, 1, 1, 0, 0, 0)


def programs() -> Path:
    """The folder of the programs."""
    if folder := os.environ.get("FLUXCAL_PROGRAMS"):
        return Path(folder)
    names = [word for name in PROGRAMS for word in ("-p", name)]
    subprocess.run(["cargo", "build", "--locked", "--profile", "dist", "--bins", *names], cwd=HERE.parent, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", HERE.parent / "target")) / "dist"


def metadata(version: str) -> str:
    project = tomllib.loads((HERE / "pyproject.toml").read_text())["project"]
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {version}", f"Summary: {project['description']}",
             f"Requires-Python: {project['requires-python']}"]
    for extra, needs in project["optional-dependencies"].items():
        lines += [f"Provides-Extra: {extra}", *(f'Requires-Dist: {need}; extra == "{extra}"' for need in needs)]
    return "\n".join(lines) + "\n"


def build_wheel(wheel_directory: str, config_settings: object = None, metadata_directory: object = None) -> str:
    """Writes the wheel and gives its name."""
    version = tomllib.loads((HERE.parent / "Cargo.toml").read_text())["workspace"]["package"]["version"]
    tag = "py3-none-" + sysconfig.get_platform().replace("-", "_").replace(".", "_")
    name, info = f"fluxcal-{version}-{tag}.whl", f"fluxcal-{version}.dist-info"
    files = [(f"fluxcal/{path.name}", path.read_bytes(), 0o644) for path in sorted((HERE / "fluxcal").iterdir()) if path.is_file()]
    folder = programs()
    for program in PROGRAMS:
        file = program + SUFFIX
        files.append((f"fluxcal-{version}.data/scripts/{file}", (folder / file).read_bytes(), 0o755))
    wheel = f"Wheel-Version: 1.0\nGenerator: fluxcal\nRoot-Is-Purelib: false\nTag: {tag}\n"
    files += [(f"{info}/METADATA", metadata(version).encode(), 0o644), (f"{info}/WHEEL", wheel.encode(), 0o644)]
    digest = lambda content: base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    record = "".join(f"{path},sha256={digest(content)},{len(content)}\n" for path, content, _ in files)
    files.append((f"{info}/RECORD", (record + f"{info}/RECORD,,\n").encode(), 0o644))
    with zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content, mode in files:
            entry = zipfile.ZipInfo(path, EARLIEST)
            entry.external_attr = (0o100000 | mode) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    return name
