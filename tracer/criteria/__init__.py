"""Criteria: rules that decide where samples are worth it, one file for each rule.

A criterion is a function from Evidence to the importance of each pixel, and samples are allocated by importance. To add
a criterion, put a file in this folder with a function under ``@criterion(...)``: every module here is imported. Code
elsewhere may use the decorator too, if its module is imported before rendering. ``tracer.render`` also takes a function
without the decorator, a ``Criterion``, and, as ``tracer render --criterion`` does, a Python file that defines one.
"""

from tracer.criteria.given import import_file, name_of
from tracer.criteria.registry import Criterion, Evidence, criterion, get, is_function, names

__all__ = ["Criterion", "Evidence", "criterion", "get", "import_file", "is_function", "name_of", "names"]
