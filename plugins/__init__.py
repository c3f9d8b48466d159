"""The plugins that Mitsuba loads by name: import this module after ``mi.set_variant`` to register them.

Mitsuba keeps plugins for each variant, so they are registered anew whenever the variant changes: from 3.10 on Mitsuba
reloads this module itself (entry point ``mitsuba``); on 3.9 a callback reloads it.
"""

from __future__ import annotations

import importlib
import sys

import mitsuba as mi

from tracer.core.backend import reload_plugins

PLUGINS = ("owen_sobol", "adaptive", "guided", "radiosity", "features")
"""Names of the plugins, which are the names of their modules."""

if (mi.variant() or "").startswith(("llvm_", "cuda_")):
    for name in PLUGINS:
        if f"{__name__}.{name}" in sys.modules:
            importlib.reload(sys.modules[f"{__name__}.{name}"])
        else:
            importlib.import_module(f"{__name__}.{name}")

mi.detail.add_variant_callback(reload_plugins)
