"""One file per idea of "where is it worth it": arrays in, importance out.

A criterion is a function of Evidence that returns the importance of each pixel: samples are given in proportion to it.
To add one, put a file in this folder with a function under ``@criterion(...)``: every module here is found by itself.
Code elsewhere may use the decorator too, and import its module before rendering; ``tracer.render`` takes a function
without it as well.
"""

from tracer.criteria.registry import Criterion, Evidence, criterion, get, import_file, is_function, name_of, names

__all__ = ["Criterion", "Evidence", "criterion", "get", "import_file", "is_function", "name_of", "names"]
