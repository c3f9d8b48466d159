"""The program ``tracer`` and its commands."""

from __future__ import annotations

import typer

from tracer.cli import compare, demo, info, render

app = typer.Typer(
    help="Render adaptively on Mitsuba 3: look first with cheap rays, spend expensive rays where they pay.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for command in (render.render, compare.compare, demo.demo, info.info):
    app.command()(command)
