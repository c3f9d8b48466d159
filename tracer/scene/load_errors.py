"""Turn Mitsuba's message about a scene that does not load into one sentence, with advice where there is any."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from tracer.core.suggest import nearest
from tracer.errors import SceneError
from tracer.scene.former_names import ELEMENTS, former_parameter, former_plugin, linear_colour

PYTHON_INTEGRATORS = ("direct_projective", "prb", "prb_basic", "prb_projective", "prbvolpath", "volprim_rf_basic")
"""Mitsuba's integrators that are written in Python: Mitsuba does not list them, and they have no compiled file."""
PYTHON_SAMPLERS = ("owen_sobol",)
"""Our samplers that are written in Python, whose kind Mitsuba does not know."""
KINDS = {"phasefunction": "phase", "reconstructionfilter": "rfilter"}
"""Kinds of plugins whose name in ``mi.ObjectType`` (the key) differs from that in messages and scenes (the value)."""


def load_error(subject: str, error: Exception, kind: str | None = None) -> SceneError:
    """Return a SceneError whose message is one line: what failed, where, and, where it is known, what to do.

    ``subject``: how the message names what does not load; ``kind``: kind of the plugin that was asked for, such as
    "integrator", for messages that do not say it.
    """
    # For an error in a plugin in Python, Mitsuba's message is the place, then the stack, then the plugin's own message.
    where, _, stack = str(error).partition("Traceback (most recent call last)")
    plugin_message = [line for line in stack.splitlines() if line.strip(" ^~")][-1:]
    lines = [line.strip() for line in (*where.splitlines(), *plugin_message) if line.strip()]
    lines = [re.sub(r"^[\w.]*Error: ", "", line) for line in lines]
    message = re.sub(r"\[\w+\.(?:cpp|h|py):\d+\]\s*", "", " ".join(lines)).strip().rstrip(".!")
    return SceneError(" ".join([f"{subject} does not load: {message}.", *advice(message, kind)]))


def render_error(subject: str, error: Exception) -> SceneError | None:
    """Return a SceneError for an error of Mitsuba or Dr.Jit while it renders a scene; None for other errors."""
    cause = error.__cause__
    if cause is not None and raised_in_mitsuba(cause):  # an integrator in Python that not every variant can run
        reason = f"its integrator fails under the active variant with {type(cause).__name__}: {cause}"
        return SceneError(
            f"{subject} cannot be rendered: {' '.join(reason.split()).rstrip('.!')}; "
            "choose another integrator or another variant."
        )
    is_ours = re.match(r"\[[A-Za-z]\w*(?:\.\w+:\d+)?\] |jit_\w+\(\): |drjit\.", str(error)) is None
    return (
        None if is_ours else SceneError(f"{subject} cannot be rendered: {' '.join(str(error).split()).rstrip('.!')}.")
    )


def raised_in_mitsuba(error: BaseException) -> bool:
    """Return whether an exception was raised in Mitsuba's own Python files."""
    frame = error.__traceback__
    while frame is not None and frame.tb_next is not None:
        frame = frame.tb_next
    return frame is not None and Path(frame.tb_frame.f_code.co_filename).is_relative_to(plugin_folder().parent)


def advice(message: str, kind: str | None = None) -> list[str]:
    """Return sentences that say what is likely meant, or what to do, about a name that Mitsuba does not know.

    ``message``: Mitsuba's, in one line; ``kind``: as for ``load_error``. The list is empty if nothing is known.
    """
    if element := re.search(r"unsupported XML element: <(\w+)>", message):
        replacement = ELEMENTS.get(element[1])
        return [f"<{element[1]}> is of earlier versions of Mitsuba; {replacement}."] if replacement else []
    if (colour := re.search(r'could not parse RGB value "([^"]+)"', message)) and (
        linear_numbers := linear_colour(colour[1])
    ):
        return [f'A colour is three numbers, linear in light; {colour[1]} of a screen is "{linear_numbers}".']
    if unused := re.search(r'unreferenced propert\w+ in (\w+) plugin of type "([^"]+)":(.*)', message):
        names = re.findall(r'- *\w+ "([^"]+)"', unused[3])
        return list(dict.fromkeys(filter(None, (about_parameter(unused[1], unused[2], name) for name in names))))
    if plugin := re.search(r'instantiate (\w+) plugin of type "([^"]+)"', message):
        kind = kind if plugin[1] == "unknown" else plugin[1]
        return about_plugin(kind, plugin[2], message)
    return []


def about_parameter(kind: str, plugin: str, name: str) -> str | None:
    """Return a sentence about a parameter that a plugin does not know, or None."""
    if replacement := former_parameter(kind, name):
        return f"'{name}' is of earlier versions of Mitsuba; {replacement}."
    hint = nearest(name, parameter_names(plugin))
    return f"Did you mean '{hint}'?" if hint else None


def about_plugin(kind: str | None, name: str, message: str) -> list[str]:
    """Return at most one sentence about a plugin that is missing or does not load; ``kind``: None if not known."""
    kinds = plugin_names()
    is_missing = f'Plugin "{name}" not found' in message
    if (is_missing or kind is not None) and (replacement := former_plugin(kind, name)):
        return [f"'{name}' is no {kind + ' ' if kind else ''}plugin of Mitsuba 3; {replacement}."]
    if not is_missing:
        is_of_another_kind = kind is not None and kinds.get(name, kind) != kind and "Type mismatch" not in message
        return [f"'{name}' is a plugin of kind {kinds[name]}, not {kind}."] if is_of_another_kind else []
    hint = nearest(name, [plugin for plugin, plugin_kind in kinds.items() if kind in (None, plugin_kind)])
    if hint is None:
        return []
    return [f"Did you mean '{hint}'?" if kind else f"Did you mean the {kinds[hint]} '{hint}'?"]


def plugin_folder() -> Path:
    """Return the folder of Mitsuba's compiled plugins."""
    import mitsuba

    return Path(mitsuba.__file__).parent / "plugins"


def plugin_names() -> dict[str, str]:
    """Return the kinds of Mitsuba's plugins and of ours, by name of the plugin."""
    our_plugins = getattr(sys.modules.get("tracer.plugins"), "PLUGINS", ())
    names = {path.stem for path in plugin_folder().iterdir()} | {*our_plugins, *PYTHON_INTEGRATORS}
    return {name: kind_of(name) for name in sorted(names)}


def kind_of(plugin: str) -> str:
    """Return the kind of a plugin, as Mitsuba's messages call it."""
    import mitsuba as mi

    if plugin in PYTHON_SAMPLERS:
        return "sampler"
    kind = mi.PluginManager.instance().plugin_type(plugin)
    # Mitsuba does not know the kind of plugins in Python; those that are no samplers are integrators.
    return "integrator" if kind == mi.ObjectType.Unknown else KINDS.get(kind.name.lower(), kind.name.lower())


def parameter_names(plugin: str) -> list[str]:
    """Return the words in the file of a compiled plugin that may be names of its parameters.

    Mitsuba publishes no list of them. They are constants of the program, or fields of what the plugin prints of itself.
    """
    names: set[str] = set()
    for path in plugin_folder().glob(f"{plugin}.*"):
        for word in re.findall(rb"(?<=[\x00 ])[a-z][a-z0-9_]{2,31}(?=\x00| = )", path.read_bytes()):
            names.add(word.decode())
    return sorted(names)
