"""Benchmark of views: how fast views are measured, and how good searches and estimates are."""
