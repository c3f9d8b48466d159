"""The only place that finds LLVM and sets the Mitsuba variant.

Dr.Jit needs a libLLVM at run time, and not every version will do: on an AVX-512 machine versions 15 and 16 load and
then abort the process at the first render, and a Debian 12 offers version 15 first. So the library is chosen, and its
version is read, before Dr.Jit sees it.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import importlib.metadata
import os
import platform
import sys
from dataclasses import dataclass
from pathlib import Path

from tracer.errors import BackendError

DEFAULT_VARIANT = "llvm_ad_rgb"
"""Mitsuba variant that is activated if no other is active or asked for."""
MINIMUM_LLVM = 17
"""Oldest major version of LLVM that is used: versions 15 and 16 abort the process on an AVX-512 machine."""
VARIABLE = "DRJIT_LIBLLVM_PATH"
"""Environment variable in which a user, or this module, names the libLLVM file that Dr.Jit loads."""
REMEDY = (
    f"install version {MINIMUM_LLVM} or newer, for example with 'pip install karellen-llvm-core' "
    f"or 'apt-get install libllvm19', or set {VARIABLE} to the file of one"
)
"""What to do about an LLVM that is missing or cannot be used, as the end of a message."""


@dataclass(frozen=True)
class Library:
    """A libLLVM file and its version."""

    path: Path
    version: tuple[int, int, int]


def packaged_library() -> Path | None:
    """Return the libLLVM that came with the ``karellen-llvm-core`` wheel, or None."""
    try:
        files = importlib.metadata.files("karellen-llvm-core") or []
    except importlib.metadata.PackageNotFoundError:
        return None
    for file in files:
        if file.name in ("libLLVM.so", "libLLVM.dylib"):
            path = Path(str(file.locate())).resolve()
            if path.exists():
                return path
    return None


def point_to_library() -> None:
    """Point Dr.Jit to the packaged libLLVM, unless the user has named another. Must run before a variant is set."""
    if not os.environ.get(VARIABLE):
        packaged = packaged_library()
        if packaged is not None:
            os.environ[VARIABLE] = str(packaged)


def read_version(path: Path) -> tuple[int, int, int]:
    """Return the version of a libLLVM file without giving it to Dr.Jit. Raises BackendError for any other file."""
    if not path.is_file():
        raise BackendError(f"{VARIABLE} names '{path}', which is not a file: {REMEDY}.")
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        raise BackendError(f"The LLVM library '{path}' does not load ({error}): {REMEDY}.") from None
    if not hasattr(library, "LLVMGetVersion"):  # in the C interface since 16
        raise BackendError(f"'{path}' is not an LLVM library, or one older than 16 that would abort: {REMEDY}.")
    parts = [ctypes.c_uint() for _ in range(3)]
    library.LLVMGetVersion(*[ctypes.byref(part) for part in parts])
    return parts[0].value, parts[1].value, parts[2].value


def require_usable(library: Library) -> Library:
    """Return ``library``, or raise BackendError when rendering with it would abort the process."""
    if library.version[0] < MINIMUM_LLVM:
        version = ".".join(map(str, library.version))
        raise BackendError(
            f"LLVM {version} in '{library.path}' is too old and would abort the process: "
            f"import tracer before mitsuba, or {REMEDY}."
        )
    return library


def named_library() -> Library | None:
    """Return the checked library that the environment or the packaged wheel names, or None if neither names one.

    Raises BackendError if the named library cannot be used.
    """
    point_to_library()
    value = os.environ.get(VARIABLE)
    if not value:
        return None
    path = Path(value)
    return require_usable(Library(path, read_version(path)))


def loaded_library() -> Library:
    """Return the library that Dr.Jit has loaded. A variant must be active."""
    import drjit

    version = tuple(int(part) for part in drjit.detail.llvm_version())
    path = Path(os.environ.get(VARIABLE) or "libLLVM of the system")
    maps = Path("/proc/self/maps")
    if maps.exists():
        files = {line.split()[-1] for line in maps.read_text().splitlines() if "libLLVM" in line}
        # Our own check may have opened another library, of another version: the version is part of the file's name.
        named = [file for file in files if f".so.{version[0]}" in file or f"LLVM-{version[0]}" in file]
        path = Path(min(named or files, default=str(path)))
    return Library(path, (version[0], version[1], version[2]))


def reload_plugins(old_variant: str | None, new_variant: str) -> None:
    """Register our plugins under the variant that became active: Mitsuba calls this, and knows plugins per variant."""
    importlib.reload(sys.modules["tracer.plugins"])


def activate(variant: str | None = None) -> str:
    """Make Mitsuba ready to render and return the name of the variant.

    ``variant``: a name of ``mi.variants()`` that begins with ``llvm_`` or ``cuda_``. None keeps the variant that is
    active, and sets ``llvm_ad_rgb`` if there is none. The plugins of tracer are registered, too. Raises BackendError,
    before anything is rendered, when the variant does not exist or cannot run wavefronts, when there is no usable LLVM,
    or, for a CUDA variant, no GPU.

    Example::

        import tracer

        tracer.activate()
        import mitsuba as mi

        adaptive = mi.load_dict({"type": "adaptive", "nested": {"type": "path"}})
        picture = mi.render(mi.load_file("scene.xml"), integrator=adaptive, spp=64)
    """
    named_library()
    import mitsuba as mi

    chosen = variant or mi.variant() or DEFAULT_VARIANT
    if chosen not in mi.variants():
        raise BackendError(f"There is no Mitsuba variant '{chosen}'; there are {', '.join(mi.variants())}.")
    if not chosen.startswith(("llvm_", "cuda_")):
        raise BackendError(f"Variant '{chosen}' renders one ray at a time; use one that starts with 'llvm_'.")
    if mi.variant() != chosen:
        previous = mi.variant()
        try:
            mi.set_variant(chosen)
        except ImportError as error:
            if previous is not None:
                mi.set_variant(previous)  # the failed call leaves no variant active
            raise BackendError(why_not(chosen, error)) from None
    if chosen.startswith("llvm_"):
        require_usable(loaded_library())  # not the named library, if something imported Dr.Jit first
    importlib.import_module("tracer.plugins")
    return chosen


def why_not(variant: str, error: Exception) -> str:
    """Return a sentence about a variant that Mitsuba could not start: what is missing and what to do."""
    import mitsuba as mi

    reason = " ".join(str(error).split()).rstrip(".")
    if variant.startswith("llvm_"):
        return f"Mitsuba could not start variant '{variant}' ({reason}): {REMEDY}."
    alternative = DEFAULT_VARIANT.replace("rgb", variant.rpartition("_ad_")[2])
    alternative = alternative if alternative in mi.variants() else DEFAULT_VARIANT
    missing = f"its driver has none to offer ({reason})" if has_cuda_driver() else "that driver is not installed"
    return (
        f"Variant '{variant}' needs an NVIDIA GPU with its driver, and {missing}; "
        f"see what 'nvidia-smi' says, or render on the processor with the variant '{alternative}'."
    )


def has_cuda_driver() -> bool:
    """Return whether a library of NVIDIA's driver loads."""
    for name in ("libcuda.so.1", "libcuda.so", "nvcuda.dll"):
        with contextlib.suppress(OSError):
            ctypes.CDLL(name)
            return True
    return False


def processor() -> str:
    """Return the name of the processor, or of the GPU of a CUDA variant, for a table that names its machine."""
    import mitsuba as mi

    files, key = [Path("/proc/cpuinfo")], "model name"
    if (mi.variant() or "").startswith("cuda_"):
        files, key = sorted(Path("/proc/driver/nvidia/gpus").glob("*/information")), "Model:"
    for line in (line for file in files if file.exists() for line in file.read_text().splitlines()):
        if line.startswith(key):
            return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def thread_count() -> int:
    """Return the number of threads that Dr.Jit renders with."""
    import drjit

    return int(drjit.thread_count())
