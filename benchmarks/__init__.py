"""What measures tracer and is not part of it: ``python -m benchmarks NAME -o FOLDER``, from a checkout."""
