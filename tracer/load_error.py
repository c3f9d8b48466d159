"""Turn what Mitsuba says of a scene that does not load into one sentence with the nearest known name."""

from __future__ import annotations

import difflib
import re
import sys
from pathlib import Path

from tracer.errors import SceneError

PYTHON_INTEGRATORS = ("direct_projective", "prb", "prb_basic", "prb_projective", "prbvolpath", "volprim_rf_basic")


def load_error(what: str, error: Exception) -> SceneError:
    """Return a SceneError whose message is one line: what failed, where, and the nearest known name if there is one."""
    # From a plugin in Python: Mitsuba says where, then comes the stack, then what the plugin has to say.
    where, _, stack = str(error).partition("Traceback (most recent call last)")
    said = [line for line in stack.splitlines() if line.strip(" ^~")][-1:]
    lines = [line.strip() for line in (*where.splitlines(), *said) if line.strip()]
    lines = [re.sub(r"^[\w.]*Error: ", "", line) for line in lines]
    message = re.sub(r"\[\w+\.(?:cpp|h|py):\d+\]\s*", "", " ".join(lines)).strip().rstrip(".!")
    hint = nearest_name(message)
    return SceneError(f"{what} does not load: {message}." + (f" Did you mean '{hint}'?" if hint else ""))


def render_error(what: str, error: Exception) -> SceneError | None:
    """Return a SceneError for what Mitsuba or Dr.Jit says of a scene that loads but cannot be rendered, else None."""
    cause = error.__cause__
    if cause is not None and raised_in_mitsuba(cause):  # an integrator in Python that not every variant can run
        said = f"its integrator fails under the active variant with {type(cause).__name__}: {cause}"
        return SceneError(
            f"{what} cannot be rendered: {' '.join(said.split()).rstrip('.!')}; choose another of either."
        )
    ours = re.match(r"\[[A-Za-z]\w*(?:\.\w+:\d+)?\] |jit_\w+\(\): |drjit\.", str(error)) is None
    return None if ours else SceneError(f"{what} cannot be rendered: {' '.join(str(error).split()).rstrip('.!')}.")


def raised_in_mitsuba(error: BaseException) -> bool:
    """Return whether an exception comes from Mitsuba's own Python."""
    frame = error.__traceback__
    while frame is not None and frame.tb_next is not None:
        frame = frame.tb_next
    return frame is not None and Path(frame.tb_frame.f_code.co_filename).is_relative_to(plugin_folder().parent)


def nearest_name(message: str) -> str | None:
    """Return the known plugin or parameter nearest to the unknown one that the message quotes, or None."""
    plugin = re.search(r'Plugin "([^"]+)" not found', message)
    if plugin:
        return nearest(plugin[1], plugin_names())
    parameter = re.search(r'unreferenced propert\w+ in \w+ plugin of type "([^"]+)": *- *\w+ "([^"]+)"', message)
    if parameter:
        return nearest(parameter[2], parameter_names(parameter[1]))
    return None


def nearest(name: str, known: list[str]) -> str | None:
    """Return the member of ``known`` most like ``name``, in whatever order its words are; None if none is alike."""
    return max(
        (word for word in known if likeness(name, word) >= 0.6), key=lambda word: likeness(name, word), default=None
    )


def likeness(name: str, other: str) -> float:
    """Return how alike two names are, 0 to 1: as they are written, or with the words between "_" and "-" sorted."""
    pairs = [(name, other), (sorted_words(name), sorted_words(other))]
    return max(difflib.SequenceMatcher(None, second, first).ratio() for first, second in pairs)


def sorted_words(name: str) -> str:
    """Return a name with its words in alphabetical order, so that "spp_max" is "max_spp"."""
    return "_".join(sorted(re.split("[_-]", name.lower())))


def plugin_folder() -> Path:
    """Return the folder of Mitsuba's compiled plugins."""
    import mitsuba

    return Path(mitsuba.__file__).parent / "plugins"


def plugin_names() -> list[str]:
    """Return the names of Mitsuba's plugins and of ours."""
    own = getattr(sys.modules.get("tracer.plugins"), "PLUGINS", ())
    return sorted({path.stem for path in plugin_folder().iterdir()} | {*own, *PYTHON_INTEGRATORS})


def parameter_names(plugin: str) -> list[str]:
    """Return the words of a compiled plugin that may be parameter names: Mitsuba publishes no list of them.

    Names are constants of the program, or fields of what the plugin prints of itself.
    """
    names: set[str] = set()
    for path in plugin_folder().glob(f"{plugin}.*"):
        for word in re.findall(rb"(?<=[\x00 ])[a-z][a-z0-9_]{2,31}(?=\x00| = )", path.read_bytes()):
            names.add(word.decode())
    return sorted(names)
