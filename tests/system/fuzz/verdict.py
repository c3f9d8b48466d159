"""Whether what became of an input is all right: a picture of numbers, or one sentence."""

import itertools
import json
import re
import signal
import xml.etree.ElementTree as Tree
from pathlib import Path

import numpy as np

from tracer.errors import TracerError
from tracer.io.exr import read_exr

from .known import known

CODES = (1, 2)
BELIEVED = ("resumed", "merged")
"""A checkpoint whose checksums agree is taken at its word, also where it says that a sum is no number."""
BRIGHT = 1e18
"""Beyond it float32 does not hold the square of a value, so the error of such a picture is not known."""
NOISE = re.compile(r"libpng (error|warning): |Corrupt JPEG data: |Premature end of JPEG")
"""What readers of pictures print themselves, whoever asks them not to."""


def complaint(outcome):
    """Return what is wrong with an outcome, or an empty string."""
    if outcome.stray:
        return f"files outside of the output folder: {', '.join(outcome.stray)}"
    if outcome.code is None:
        return "it hung"
    if outcome.code < 0:
        reason = known(outcome)
        return "" if reason else f"the process died of {signal.Signals(-outcome.code).name}"
    if "Traceback" in outcome.out + outcome.err:
        return f"a traceback: {last_steps(outcome.err)}"
    files = {path.name for path in (outcome.folder / "out").iterdir()} - {"state.ckpt"}
    if outcome.code == 0:
        return picture_complaint(outcome, files - {"live.png"})
    if outcome.code not in CODES:
        return "an unknown exit code"
    if files:
        return f"files were left: {', '.join(sorted(files))}"
    return sentence_complaint(outcome.err)


def last_steps(text):
    """Return the last lines of the stack in a traceback, and the error."""
    places = re.findall(r'File ".*?([^/]+/[^/]+)", line (\d+), in (.+)', text)
    where = " > ".join(f"{file}:{line} {name}" for file, line, name in places[-6:])
    return f"{where}: {text.strip().splitlines()[-1][:400]}"


def sentence_complaint(text):
    """Return what is wrong with what was said of a mistake."""
    lines = [line for line in text.splitlines() if not NOISE.match(line)]
    if len(lines) != 1:
        return f"{len(lines)} lines on standard error: {text[:1500]}"
    if not re.fullmatch(r"tracer: .+[.?]", lines[0]):
        return f"no sentence: {lines[0][:500]}"
    return ""


def picture_complaint(outcome, files):
    """Return what is wrong with the result of a command that ended well."""
    if outcome.arguments[0] == "score":
        return score_complaint(outcome)
    if not files:
        return "no picture was written"
    for name in files:
        try:
            names, values, _ = read_exr(outcome.folder / "out" / name)
        except TracerError as error:
            return str(error)
        bad = not_finite(names, values)
        if bad and outcome.kind not in BELIEVED:
            return f"values that are not finite in {', '.join(bad)}"
        size = expected_size(outcome.arguments)
        if size is not None and values.shape[1::-1] != size:
            return f"a picture of {values.shape[1::-1]} pixels instead of {size}"
    return ""


def not_finite(names, values):
    """Return the channels in which there is something else than numbers."""
    bright = np.nanmax(np.abs([values[..., k] for k, name in enumerate(names) if "." not in name])) > BRIGHT
    bad = [name for k, name in enumerate(names) if not np.isfinite(values[..., k]).all()]
    return [name for name in bad if not (bright and name.startswith("stderr."))]


def score_complaint(outcome):
    """Return what is wrong with printed scores."""
    if "--json" not in outcome.arguments:
        return "" if "relMSE" in outcome.out else "no table was printed"
    try:
        json.loads(outcome.out)
    except ValueError:
        return f"no JSON was printed: {outcome.out[:300]}"
    return ""


def expected_size(arguments):
    """Return the width and height that a picture must have, where options or a plain film tell, else None."""
    options = dict(itertools.pairwise(arguments))
    if arguments[0] != "render" or "--config" in options:
        return None
    try:
        root = Tree.fromstring(Path(arguments[1]).read_bytes())
        films = root.findall("./sensor/film")
        [film] = films
        numbers = {one.get("name"): one.get("value") for one in film.findall("integer")}
        width, height = int(numbers["width"]), int(numbers["height"])
    except (Tree.ParseError, ValueError, KeyError, TypeError):
        return None
    if any(name.startswith("crop") for name in numbers) and "--crop" not in options:
        return None
    if "--size" in options:
        new = int(options["--size"])
        width, height = new, max(1, round(height * new / width))
    if "--crop" in options:
        width, height = map(int, options["--crop"].split(",")[2:])
    return width, height
