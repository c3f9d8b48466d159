"""Files: written as a whole or not at all; one sentence says why one cannot be read or written."""
