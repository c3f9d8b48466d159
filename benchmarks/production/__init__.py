"""Benchmark of production features: noise targets, overheads of live pictures and checkpoints, limits of time."""
