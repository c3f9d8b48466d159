"""What the commands of this folder that renew files share."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from tracer.errors import TracerError


def exit_code_of_each(names: list[str], renew: Callable[[Path], None]) -> int:
    """Renew what each name of a file or folder stands for, and return an exit code: 2 after the first that cannot be.

    A sentence on standard error says why.
    """
    try:
        for name in names:
            renew(Path(name))
    except (TracerError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0
