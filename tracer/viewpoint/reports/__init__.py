"""What the commands ``tracer view ...`` make: numbers, pictures, cameras; one file a command."""
