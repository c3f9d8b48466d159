"""Files: whole or not at all, with one sentence where they cannot be read or written."""
