"""What a caller gives, as plain values of Python, or one sentence about what is wrong with it."""

from __future__ import annotations

import operator
from typing import Any

from tracer.errors import SettingsError


def plain(value: Any) -> Any:
    """Return a number of any library, such as NumPy's, as Python's own, and anything else as it is."""
    if isinstance(value, str | bytes | bool | int | float):
        return value
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        return value.item()
    try:
        return operator.index(value)
    except TypeError:
        return value


def whole_number(name: str, value: Any) -> int:
    """Return a whole number. Raises SettingsError with one sentence that names it."""
    number = plain(value)
    if isinstance(number, bool) or not isinstance(number, int):
        raise SettingsError(f"{name}: write a whole number (was {value!r}).")
    return number


def whole_numbers(name: str, value: Any, count: int, meaning: str) -> tuple[int, ...]:
    """Return ``count`` whole numbers, of which a message says the ``meaning``. Raises SettingsError."""
    try:
        numbers = tuple(plain(entry) for entry in value)
    except TypeError:
        numbers = ()
    if isinstance(value, str) or len(numbers) != count or any(type(number) is not int for number in numbers):
        raise SettingsError(f"{name}: write {count} whole numbers, {meaning} (was {value!r}).")
    return numbers
