"""What measures tracer and is not part of it: run with ``python -m benchmarks.NAME`` from a checkout."""
