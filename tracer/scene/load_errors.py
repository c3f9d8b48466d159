"""Turn what Mitsuba says of a scene that does not load into one sentence with the nearest known name."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from tracer.core.suggest import nearest
from tracer.errors import SceneError
from tracer.scene.former_names import ELEMENTS, former_parameter, former_plugin, linear_colour

PYTHON_INTEGRATORS = ("direct_projective", "prb", "prb_basic", "prb_projective", "prbvolpath", "volprim_rf_basic")
PYTHON_SAMPLERS = ("owen_sobol",)
KINDS = {"phasefunction": "phase", "reconstructionfilter": "rfilter"}
"""Of plugins: how Mitsuba's messages, and scenes, call those that ``mi.ObjectType`` calls otherwise."""


def load_error(what: str, error: Exception, kind: str | None = None) -> SceneError:
    """Return a SceneError whose message is one line: what failed, where, and what is known to be meant or to do.

    ``kind``: of the plugin that was asked for, as "integrator", where the message does not say.
    """
    # From a plugin in Python: Mitsuba says where, then comes the stack, then what the plugin has to say.
    where, _, stack = str(error).partition("Traceback (most recent call last)")
    said = [line for line in stack.splitlines() if line.strip(" ^~")][-1:]
    lines = [line.strip() for line in (*where.splitlines(), *said) if line.strip()]
    lines = [re.sub(r"^[\w.]*Error: ", "", line) for line in lines]
    message = re.sub(r"\[\w+\.(?:cpp|h|py):\d+\]\s*", "", " ".join(lines)).strip().rstrip(".!")
    return SceneError(" ".join([f"{what} does not load: {message}.", *advice(message, kind)]))


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


def advice(message: str, kind: str | None = None) -> list[str]:
    """Return sentences that say what is meant, or to do, about what Mitsuba says it does not know."""
    if element := re.search(r"unsupported XML element: <(\w+)>", message):
        instead = ELEMENTS.get(element[1])
        return [f"<{element[1]}> is of earlier versions of Mitsuba; {instead}."] if instead else []
    if (colour := re.search(r'could not parse RGB value "([^"]+)"', message)) and (linear := linear_colour(colour[1])):
        return [f'A colour is three numbers, linear in light; {colour[1]} of a screen is "{linear}".']
    if unused := re.search(r'unreferenced propert\w+ in (\w+) plugin of type "([^"]+)":(.*)', message):
        names = re.findall(r'- *\w+ "([^"]+)"', unused[3])
        return list(dict.fromkeys(filter(None, (about_parameter(unused[1], unused[2], name) for name in names))))
    if plugin := re.search(r'instantiate (\w+) plugin of type "([^"]+)"', message):
        kind = kind if plugin[1] == "unknown" else plugin[1]
        return about_plugin(kind, plugin[2], message)
    return []


def about_parameter(kind: str, plugin: str, name: str) -> str | None:
    """Return a sentence about a parameter that a plugin does not know, or None."""
    if instead := former_parameter(kind, name):
        return f"'{name}' is of earlier versions of Mitsuba; {instead}."
    hint = nearest(name, parameter_names(plugin))
    return f"Did you mean '{hint}'?" if hint else None


def about_plugin(kind: str | None, name: str, message: str) -> list[str]:
    """Return a sentence about a plugin that is missing or does not load, of a kind if that is known, or none."""
    known = plugin_names()
    missing = f'Plugin "{name}" not found' in message
    if (missing or kind is not None) and (instead := former_plugin(kind, name)):
        return [f"'{name}' is no {kind + ' ' if kind else ''}plugin of Mitsuba 3; {instead}."]
    if not missing:
        other = kind is not None and known.get(name, kind) != kind and "Type mismatch" not in message
        return [f"'{name}' is a plugin of kind {known[name]}, not {kind}."] if other else []
    hint = nearest(name, [plugin for plugin, its in known.items() if kind in (None, its)])
    if hint is None:
        return []
    return [f"Did you mean '{hint}'?" if kind else f"Did you mean the {known[hint]} '{hint}'?"]


def plugin_folder() -> Path:
    """Return the folder of Mitsuba's compiled plugins."""
    import mitsuba

    return Path(mitsuba.__file__).parent / "plugins"


def plugin_names() -> dict[str, str]:
    """Return the names of Mitsuba's plugins and of ours, each with its kind."""
    own = getattr(sys.modules.get("tracer.plugins"), "PLUGINS", ())
    names = {path.stem for path in plugin_folder().iterdir()} | {*own, *PYTHON_INTEGRATORS}
    return {name: kind_of(name) for name in sorted(names)}


def kind_of(plugin: str) -> str:
    """Return the kind of a plugin, as Mitsuba's messages call it."""
    import mitsuba as mi

    if plugin in PYTHON_SAMPLERS:
        return "sampler"
    kind = mi.PluginManager.instance().plugin_type(plugin)
    # Mitsuba does not know what plugins in Python are; the others are integrators.
    return "integrator" if kind == mi.ObjectType.Unknown else KINDS.get(kind.name.lower(), kind.name.lower())


def parameter_names(plugin: str) -> list[str]:
    """Return the words of a compiled plugin that may be parameter names: Mitsuba publishes no list of them.

    Names are constants of the program, or fields of what the plugin prints of itself.
    """
    names: set[str] = set()
    for path in plugin_folder().glob(f"{plugin}.*"):
        for word in re.findall(rb"(?<=[\x00 ])[a-z][a-z0-9_]{2,31}(?=\x00| = )", path.read_bytes()):
            names.add(word.decode())
    return sorted(names)
