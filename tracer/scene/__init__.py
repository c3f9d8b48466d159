"""From what a person gives, such as a file or a dictionary, to an open scene with its sensor, film and channels."""
