"""Benchmark of workers: measured on this machine, and extrapolated to more workers by a model."""
