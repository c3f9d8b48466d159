"""A library that would abort the process is refused before anything renders."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import PATIENCE
from tracer.core import backend
from tracer.errors import BackendError


def run_info(folder, **environment):
    return subprocess.run(
        [sys.executable, "-m", "tracer", "info"],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )


@pytest.mark.parametrize("kind", ["missing", "folder", "not LLVM"])
def test_forced_library_that_cannot_be_used_is_one_sentence(kind, tmp_path):
    other = next(Path(sys.prefix).rglob("_ctypes*.so"), None) or Path(sys.modules["_ctypes"].__file__)
    path = {"missing": tmp_path / "libLLVM.so", "folder": tmp_path, "not LLVM": other}[kind]
    result = run_info(tmp_path, DRJIT_LIBLLVM_PATH=str(path))
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert str(path) in result.stderr
    assert "install version 17 or newer" in result.stderr


@pytest.mark.parametrize(("version", "usable"), [((14, 0, 6), False), ((16, 0, 6), False), ((17, 0, 0), True)])
def test_versions_that_abort_are_refused(version, usable):
    library = backend.Library(Path("libLLVM.so"), version)
    if usable:
        assert backend.require_usable(library) is library
    else:
        with pytest.raises(BackendError, match="too old and would abort"):
            backend.require_usable(library)


def test_version_read_from_the_file_is_the_one_that_drjit_loaded():
    loaded = backend.loaded_library()
    assert backend.read_version(loaded.path) == loaded.version
    assert loaded.version[0] >= backend.MINIMUM_LLVM


def test_the_packaged_library_is_used_unless_the_user_names_another(monkeypatch):
    packaged = backend.packaged_library()
    if packaged is None:
        pytest.skip("no packaged LLVM on this system")
    monkeypatch.delenv(backend.VARIABLE, raising=False)
    backend.point_to_library()
    assert os.environ[backend.VARIABLE] == str(packaged)
    monkeypatch.setenv(backend.VARIABLE, "mine.so")
    backend.point_to_library()
    assert os.environ[backend.VARIABLE] == "mine.so"


@pytest.mark.parametrize(("variant", "message"), [("llvm_nope", "There is no"), ("scalar_rgb", "one ray at a time")])
def test_unusable_variants(variant, message):
    with pytest.raises(BackendError, match=message):
        backend.activate(variant)


CUDA = ["cuda_ad_rgb", "cuda_ad_mono", "cuda_ad_mono_polarized", "cuda_ad_spectral", "cuda_ad_spectral_polarized"]


@pytest.mark.parametrize("variant", CUDA)
def test_cuda_without_a_gpu_says_what_is_missing(variant):
    import drjit as dr
    import mitsuba as mi

    backend.activate("llvm_ad_rgb")
    if dr.has_backend(dr.JitBackend.CUDA):
        pytest.skip("there is a GPU")
    with pytest.raises(BackendError, match=f"^Variant '{variant}' needs an NVIDIA GPU with its driver, and ") as raised:
        backend.activate(variant)
    assert str(raised.value).endswith(f"render on the processor with the variant '{variant.replace('cuda', 'llvm')}'.")
    assert "LLVM" not in str(raised.value)
    assert mi.variant() == "llvm_ad_rgb"  # as before


@pytest.mark.parametrize(
    ("variant", "driver", "expected"),
    [
        ("cuda_ad_rgb", False, "and that driver is not installed; see what 'nvidia-smi' says"),
        ("cuda_ad_rgb", True, r"and its driver has none to offer \(no luck\); see"),
        ("llvm_ad_rgb", True, r"could not start variant 'llvm_ad_rgb' \(no luck\): install version 17 or newer"),
    ],
)
def test_a_variant_that_does_not_start_says_what_to_do(monkeypatch, variant, driver, expected):
    monkeypatch.setattr(backend, "has_cuda_driver", lambda: driver)
    assert re.search(expected, backend.why_not(variant, ImportError("no\n luck.")))
