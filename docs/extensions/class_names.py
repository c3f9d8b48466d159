"""Classes are headed by their names alone: what they are made of are their fields, which stand below with meanings."""

from typing import Any

from sphinx.application import Sphinx


def without_arguments(
    app: Sphinx, what: str, name: str, documented: Any, options: Any, signature: str, returns: str
) -> tuple[str, str | None] | None:
    """Return no arguments for a class, and None, which changes nothing, for all else."""
    return ("", None) if what == "class" else None


def setup(app: Sphinx) -> dict[str, bool]:
    """Let signatures be changed before they are shown."""
    app.connect("autodoc-process-signature", without_arguments)
    return {"parallel_read_safe": True}
