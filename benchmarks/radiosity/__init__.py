"""What guided rays are worth, measured: ``tracer radiosity-report``."""
