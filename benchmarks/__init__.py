"""Benchmarks of tracer, which are not part of the package: ``python -m benchmarks NAME -o FOLDER``, from a checkout."""
