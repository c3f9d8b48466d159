"""Pictures as arrays: errors against a reference, colour, what error is to be small."""
