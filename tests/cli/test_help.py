"""What the program says of itself: its version, and help that fits the screen and lists all names."""

import re

import pytest
import typer

import tracer
from tracer import criteria
from tracer.cli.app import app
from tracer.image.objective import OBJECTIVES
from tracer.radiosity.spread import METHODS, SPREADS
from tracer.study import bundled
from tracer.viewpoint import measures


def test_the_version(tracer_program):
    assert tracer_program("--version")[:2] == (0, f"tracer {tracer.__version__}\n")


def test_the_help_of_render_is_one_screen_and_all_options_are_another(tracer_program, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr("typer.rich_utils.MAX_WIDTH", 80)
    code, out, _ = tracer_program("render", "--help")
    lines = out.splitlines()
    assert (code, len(lines) <= 49, max(map(len, lines)) <= 80, "…" in out) == (0, True, True, False)
    code, everything, _ = tracer_program("render", "--help-all")
    options = {option for parameter in render_parameters() for option in parameter.opts if option[:2] == "--"}
    assert (code, {option for option in options if option not in everything}) == (0, set())
    assert {option for option in options if option in out} >= {"--output", "--spp", "--noise", "--time", "--criterion"}
    assert tracer_program("render", "--help")[1] == out


@pytest.mark.parametrize("name", ["measure", "map", "best", "tour", "cover"])
def test_the_help_of_views_is_one_screen_and_all_options_are_another(tracer_program, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr("typer.rich_utils.MAX_WIDTH", 80)
    code, out, _ = tracer_program("view", name, "--help")
    lines = out.splitlines()
    assert (code, len(lines) <= 49, max(map(len, lines)) <= 80, "…" in out) == (0, True, True, False)
    parameters = typer.main.get_command(app).commands["view"].commands[name].params
    options = {option for parameter in parameters for option in parameter.opts if option[:2] == "--"}
    everything = tracer_program("view", name, "--help-all")[1]
    assert {option for option in options if option not in everything} == set()
    assert len(re.findall(r"--[a-z-]+", everything)) > len(re.findall(r"--[a-z-]+", out)) + 8
    assert tracer_program("view", name, "--help")[1] == out


def test_the_help_of_radiosity_is_one_screen_and_all_options_are_another(tracer_program, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr("typer.rich_utils.MAX_WIDTH", 80)
    code, out, _ = tracer_program("radiosity", "--help")
    lines = out.splitlines()
    assert (code, len(lines) <= 49, max(map(len, lines)) <= 80, "…" in out) == (0, True, True, False)
    assert set(SPREADS) | set(METHODS) <= set(re.split(r"[^\w]+", out))
    everything = tracer_program("radiosity", "--help-all")[1]
    parameters = typer.main.get_command(app).commands["radiosity"].params
    options = {option for parameter in parameters for option in parameter.opts if option[:2] == "--"}
    assert {option for option in options if option not in everything} == set()
    assert "--threshold" not in out
    assert tracer_program("radiosity", "--help")[1] == out


def render_parameters():
    return typer.main.get_command(app).commands["render"].params


@pytest.mark.parametrize(
    ("command", "names"),
    [
        (("render",), [*criteria.names(), *OBJECTIVES]),
        (("compare",), [*criteria.names(), *OBJECTIVES]),
        *((("view", name), measures.names()) for name in ("measure", "best", "tour")),
    ],
)
def test_help_lists_the_names_there_are(tracer_program, command, names):
    words = set(re.split(r"[^\w]+", tracer_program(*command, "--help")[1]))
    assert set(names) <= words


VIEWS = ("measure", "map", "best", "tour", "cover")
COMMANDS = [
    ["render"],
    ["merge"],
    ["radiosity"],
    ["compare"],
    ["study"],
    ["score"],
    ["demo"],
]
COMMANDS += [["demo"], ["info"], ["view"], *(["view", name] for name in VIEWS)]


@pytest.mark.parametrize("command", [[], *COMMANDS])
def test_help(tracer_program, command):
    code, out, _ = tracer_program(*command, "--help")
    assert code == 0
    assert "Usage" in out
    if command and command != ["view"]:
        assert "Example" in out


def test_the_help_of_study_names_all_studies_that_come_along(tracer_program):
    words = tracer_program("study", "--help")[1].replace(",", " ").replace(".", " ").split()
    assert set(bundled.names()) <= set(words)
