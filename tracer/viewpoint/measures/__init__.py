"""Measures of a view: one file a family, each measure a pure function of a ``Sight``."""

from tracer.viewpoint.measures.registry import Measure, get, measure, names

__all__ = ["Measure", "get", "measure", "names"]
