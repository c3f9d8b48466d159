"""Pictures as arrays: errors against a reference, colour, and which error is to be minimised."""
