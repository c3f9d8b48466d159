"""Directive ``commands``: every command of the program, written from its own help."""

from collections.abc import Iterator
from typing import Any

import typer
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from tracer.cli.app import app
from tracer.cli.options import all_shown


def all_commands(command: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Yield the full name of every command below ``command`` that is not itself a group, and the command."""
    below = getattr(command, "commands", None)
    if below is None:
        yield name, command
        return
    for word, part in below.items():
        yield from all_commands(part, f"{name} {word}")


def in_markdown(name: str, command: Any) -> str:
    """Return the section of a command: what it does, its arguments, and its options in their groups."""
    context = command.context_class(command, info_name=name)
    groups: dict[str, list[str]] = {}
    for parameter in command.params:
        with all_shown(command):
            record = parameter.get_help_record(context)
        is_argument = parameter.param_type_name == "argument"
        group = "Arguments" if is_argument else getattr(parameter, "rich_help_panel", None) or "Options"
        if record is not None:
            flags, text = record
            groups.setdefault(group, []).append(
                f"`{flags.strip('* ')}`\n: {' '.join(text.split()).replace('<', '&lt;') or 'See above.'}\n"
            )
    usage = " ".join([name, *command.collect_usage_pieces(context)])
    about = (command.help or "").replace("\b", "").replace("<", "\\<")
    parts = [f"## {name}", f"```text\n{usage}\n```", about]
    for title, lines in groups.items():
        parts += [f"**{title}**", "\n".join(lines)]
    return "\n\n".join(parts)


class Commands(SphinxDirective):
    """Write a section for each command."""

    def run(self) -> list[nodes.Node]:
        """Return the sections."""
        program = typer.main.get_command(app)
        text = "\n\n".join(in_markdown(name, command) for name, command in all_commands(program, "tracer"))
        return self.parse_text_to_nodes(text, allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Make the directive known."""
    app.add_directive("commands", Commands)
    return {"parallel_read_safe": True}
