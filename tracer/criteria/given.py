"""Criteria that a person gives: by name, as an object or a function, or as a Python file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from tracer.core.own_code import FILE_ENDING, run_file
from tracer.criteria import registry
from tracer.errors import SettingsError


def name_of(criterion: Any) -> Any:
    """Return the name by which ``get`` finds a criterion; what is neither an object, a function nor a file stays as is.

    A function that is not registered is taken to learn from radiance, and its importance to be the share of samples. A
    file, a path or a text that ends in ".py", is run and defines one criterion. Raises SettingsError if it does not.
    """
    if isinstance(criterion, Path) or (isinstance(criterion, str) and criterion.endswith(FILE_ENDING)):
        return the_criterion_in(Path(criterion))
    registry.import_all()
    if isinstance(criterion, registry.Criterion):
        if registry.registered.get(criterion.name) == criterion:
            return criterion.name
        name = f"criterion {criterion.name}"
        registry.functions[name] = replace(criterion, name=name)
        return name
    if not callable(criterion):
        return criterion
    registered_name = next((name for name, entry in registry.registered.items() if entry.importance is criterion), None)
    if registered_name is not None:
        return registered_name
    name = f"function {getattr(criterion, '__qualname__', type(criterion).__qualname__)}"
    registry.functions[name] = registry.Criterion(name, criterion, needs_radiance=True, spends="share")
    return name


def import_file(path: Path) -> list[str]:
    """Run a Python file, and return the names of the criteria that it registers; those of an earlier run are forgotten.

    Raises SettingsError, with the line, for a file that does not exist or does not run.
    """
    place = path.resolve()
    registry.import_all()
    for name in [name for name, file in registry.files.items() if file.resolve() == place]:
        registry.registered.pop(name, None)
    before = set(registry.registered)
    run_file(path, "criteria")
    names = sorted(set(registry.registered) - before)
    registry.files.update(dict.fromkeys(names, path))
    return names


def the_criterion_in(path: Path) -> str:
    """Run a Python file, and return the name of the criterion that it defines.

    Raises SettingsError for a file that does not run, or that does not define exactly one.
    """
    names = import_file(path)
    if len(names) == 1:
        return names[0]
    if not names:
        raise SettingsError(
            f"'{path}' defines no criterion: write @tracer.criteria.criterion(\"{path.stem}\", needs_radiance=True) "
            "above a function."
        )
    raise SettingsError(f"'{path}' defines {len(names)} criteria, {', '.join(names)}: leave one in each file.")
