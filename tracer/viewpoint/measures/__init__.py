"""Measures of a view: one file a family, each measure a pure function of a ``Sight``."""

from tracer.viewpoint.measures.registry import Best, Measure, get, measure, names

__all__ = ["Best", "Measure", "get", "measure", "names"]
