"""Mistakes in how a command is written: one sentence, with what to write instead."""

import pytest

MISTAKES = [
    ("render s.xml --sppp 3", "There is no option '--sppp', did you mean '--spp'?"),
    ("render s.xml --spp-max 3", "There is no option '--spp-max', did you mean '--max-spp'?"),
    ("render s.xml --zebra", "There is no option '--zebra'; see tracer render --help."),
    ("-q", "There is no option '-q'; see tracer --help."),
    ("rendr s.xml", "There is no command 'rendr', did you mean 'render'?"),
    ("view bst s.ply", "There is no command 'bst', did you mean 'best'?"),
    ("render", "'scene' is missing: Mitsuba scene file (XML); see tracer render --help."),
    ("view best s.ply", "--output is missing: Folder for pictures, cameras, tables; see tracer view best --help."),
    ("render s.xml t.xml", "'tracer render' can do nothing with 't.xml'; see tracer render --help."),
    ("render s.xml --spp x", "--spp: write a whole number (was 'x')."),
    ("render s.xml --noise=x", "--noise: write a number (was 'x')."),
    ("compare s.xml --seeds 0", "--seeds: write a whole number, 1 or more (was '0')."),
    ("view best s.ply -o o --side 7", "--side: write a whole number from 8 to 4096 (was '7')."),
    ("view best s.ply -o o --centre 1 x 2", "--centre: write three numbers (was '1 x 2')."),
    ("render s.xml --spp", "Option '--spp' requires an argument; see tracer render --help."),
]


@pytest.mark.parametrize(("line", "sentence"), MISTAKES)
def test_a_mistake_is_one_sentence(tracer_program, line, sentence):
    assert tracer_program(*line.split()) == (2, "", f"tracer: {sentence}\n")


@pytest.mark.parametrize("line", ["", "view"])
def test_without_a_command_there_is_help(tracer_program, line):
    code, out, err = tracer_program(*line.split())
    assert (code, "Usage: tracer" in out, err) == (2, True, "")
