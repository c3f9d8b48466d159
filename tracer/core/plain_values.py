"""Turn what a caller gives into plain values of Python, or into one sentence about what is wrong with it."""

from __future__ import annotations

import operator
from typing import Any

from tracer.errors import SettingsError


def plain(value: Any) -> Any:
    """Return a number of another library, such as NumPy's, as a number of Python; anything else as it is."""
    if isinstance(value, str | bytes | bool | int | float):
        return value
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        return value.item()
    try:
        return operator.index(value)
    except TypeError:
        return value


def whole_number(name: str, value: Any) -> int:
    """Return ``value`` as an int. Raises SettingsError, with ``name`` in its sentence, if it is no whole number."""
    number = plain(value)
    if isinstance(number, bool) or not isinstance(number, int):
        raise SettingsError(f"{name}: write a whole number (was {value!r}).")
    return number


def whole_numbers(name: str, value: Any, count: int, meaning: str) -> tuple[int, ...]:
    """Return ``value`` as a tuple of ``count`` ints.

    ``name`` and ``meaning``: how the message calls them, and what it says they stand for. Raises SettingsError.
    """
    try:
        numbers = tuple(plain(entry) for entry in value)
    except TypeError:
        numbers = ()
    if isinstance(value, str) or len(numbers) != count or any(type(number) is not int for number in numbers):
        raise SettingsError(f"{name}: write {count} whole numbers, {meaning} (was {value!r}).")
    return numbers
