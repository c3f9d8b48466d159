"""Benchmark of radiosity: the gain of guided rays."""
