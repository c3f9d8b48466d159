"""Measures of a view: each is a pure function of a ``Sight``, and each file holds a family of them."""

from tracer.viewpoint.measures.registry import Best, Measure, get, measure, names

__all__ = ["Best", "Measure", "get", "measure", "names"]
