"""The reports that the commands ``tracer view ...`` make: numbers, pictures, cameras. Each command has a file here."""
