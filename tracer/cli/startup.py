"""When the program was started."""

from __future__ import annotations

import time

STARTED = time.perf_counter()
"""Seconds on the clock when the package of the command line was imported: limits of time count from here."""
