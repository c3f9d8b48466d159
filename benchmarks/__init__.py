"""Benchmarks of tracer, which are not part of the package: ``python -m benchmarks NAME -o FOLDER``, from a checkout."""

import tracer  # noqa: F401  # names the LLVM library before Dr.Jit is imported
