"""Mistakes in how a command is written, such as an option that does not exist: each is told in one sentence."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any

from tracer.core.suggest import did_you_mean, nearest

NUMBERS = {1: "{}", 2: "two {}s", 3: "three {}s"}
"""What an option of so many values wants, by the name of one."""


def in_words(error: Any, program: Any, arguments: Sequence[str]) -> str:
    """Return the sentence for an error of the parser.

    ``error``: a ``UsageError`` of Click, which Typer brings along or installs, so that its classes are known by name.
    ``program``: the command of the whole program. ``arguments``: what was written after its name.
    """
    path, command = command_of(program, arguments)
    help = f"see {' '.join([*path, '--help'])}."
    parameter = getattr(error, "param", None)
    message = error.format_message().strip().rstrip(".")
    kind = type(error).__name__
    if kind == "NoSuchOption":
        names = [
            name for option in command.params for name in (*option.opts, *option.secondary_opts) if name[:1] == "-"
        ]
        likely = nearest(error.option_name.lstrip("-"), [name.lstrip("-") for name in names])
        hint = next((f", did you mean '{name}'?" for name in names if name.lstrip("-") == likely), f"; {help}")
        return f"There is no option '{error.option_name}'{hint}"
    if unknown := re.match(r"No such command '(.*?)'", message):
        return f"There is no command '{unknown[1]}'{did_you_mean(unknown[1], list(command.commands), f'; {help}')}"
    if kind == "MissingParameter" and parameter is not None:
        what = parameter.opts[0] if parameter.opts[0][0] == "-" else f"'{parameter.name}'"
        return f"{what} is missing: {(parameter.help or '').rstrip('.')}; {help}"
    if extra := re.match(r"Got unexpected extra arguments?(?:\(s\))? \((.*)\)", message):
        return f"'{' '.join(path)}' can do nothing with '{extra[1]}'; {help}"
    if kind == "BadParameter" and parameter is not None and (number := number_wanted(parameter, message)):
        name = max(parameter.opts, key=len)
        return f"{name}: write {number}{given_to(parameter, arguments)}."
    return f"{message}; {help}"


def command_of(program: Any, arguments: Sequence[str]) -> tuple[list[str], Any]:
    """Return the words that name a command, and the command: the innermost that the arguments begin with."""
    path, command = ["tracer"], program
    for word in arguments:
        if word not in getattr(command, "commands", {}):
            break
        path, command = [*path, word], command.commands[word]
    return path, command


def number_wanted(parameter: Any, message: str) -> str | None:
    """Return which number a parameter takes, in words; None if it does not take numbers."""
    if not re.search("integer|number|float|range|greater|less", message):
        return None
    kinds = parameter, getattr(parameter, "type", None)  # either has the bounds, by the version of Typer
    low, high = (next((x for kind in kinds if (x := getattr(kind, name, None)) is not None), None) for name in BOUNDS)
    whole = "integer" in message or any(isinstance(bound, int) for bound in (low, high))
    words = "whole number" if whole else "number"
    text = f"a {words}" if parameter.nargs == 1 else NUMBERS[parameter.nargs].format(words)
    if low is not None and high is not None:
        return f"{text} from {low:g} to {high:g}"
    return text if low is None else f"{text}, {low:g} or more"


BOUNDS = ("min", "max")
"""Attributes that hold the least and the largest value of a parameter."""


def given_to(parameter: Any, arguments: Sequence[str]) -> str:
    """Return what was written for an option, in parentheses; nothing where that is not known."""
    values = list(values_of(parameter, arguments))
    return f" (was '{values[-1]}')" if values else ""


def values_of(parameter: Any, arguments: Sequence[str]) -> Iterator[str]:
    """Yield the values that are written for an option."""
    for place, argument in enumerate(arguments):
        name, equals, value = argument.partition("=")
        if name in parameter.opts:
            yield value if equals else " ".join(arguments[place + 1 : place + 1 + parameter.nargs])
