"""Studies that come with tracer."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from tracer.errors import SettingsError
from tracer.study.plan import Plan, parse_plan, read_plan, unknown
from tracer.study.toml_location import Origin

STUDIES = files("tracer.study") / "studies"
"""Folder with the TOML files of the studies."""


def names() -> list[str]:
    """Return the names of the studies that come with tracer, sorted."""
    return sorted(entry.name.removesuffix(".toml") for entry in STUDIES.iterdir() if entry.name.endswith(".toml"))


def find_plan(name: str, folder: Path | None = None) -> Plan:
    """Return the plan of a bundled study or of a TOML file.

    ``name``: the name of the study, or the path of the file; ``folder``: where its scenes are. Raises SettingsError.
    """
    if folder is not None and not folder.is_dir():
        raise SettingsError(f"There is no folder '{folder}'.")
    if name not in names():
        path = Path(name)
        if path.suffix == ".toml" or path.is_file():
            return read_plan(path, folder)
        message = unknown("study", name, names())
        raise SettingsError(f"{message[0].upper()}{message[1:]}; or name a TOML file.")
    text = (STUDIES / f"{name}.toml").read_text(encoding="utf-8")
    plan = parse_plan(text, Origin(f"study '{name}'", text), Path(), folder)
    if folder is None and any(scene.path is not None for scene in plan.scenes):
        raise SettingsError(f"The study '{name}' needs the folder of its scenes: tracer study {name} FOLDER -o OUTPUT.")
    return plan
