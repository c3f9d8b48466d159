"""Who lacks an optional package is told in one sentence which part of tracer brings it, before any work is done."""

import sys

import pytest

from tracer.core.extras import require_package
from tracer.errors import MissingPackageError
from tracer.study.page.build import require_page_packages
from tracer.viewpoint.atom_source import Shown
from tracer.viewpoint.films import require_film_maker
from tracer.viewpoint.source import open_source

WATER = "3\nwater\nO 0 0 0\nH 0 0.76 0.59\nH 0 -0.76 0.59\n"


def test_a_package_that_is_there_is_imported():
    assert require_package("json", "json", "This test", "test") is sys.modules["json"]


@pytest.mark.parametrize(
    ("module", "needs_it", "purpose", "extra"),
    [
        ("jinja2", require_page_packages, "The page of a study needs Jinja2", "study"),
        ("PIL.Image", lambda: require_film_maker("tour.webp"), "The film 'tour.webp' needs Pillow", "view"),
        ("av", lambda: require_film_maker("tour.mp4"), "The film 'tour.mp4' needs av", "view"),
    ],
)
def test_a_package_that_is_missing_is_named_with_its_extra(monkeypatch, module, needs_it, purpose, extra):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingPackageError) as raised:
        needs_it()
    assert str(raised.value).startswith(f"{purpose}; install it")
    assert str(raised.value).endswith(f'pip install ".[{extra}]".')


def test_a_molecule_without_ase(monkeypatch, tmp_path):
    path = tmp_path / "water.xyz"
    path.write_text(WATER)
    monkeypatch.setitem(sys.modules, "ase", None)
    with pytest.raises(MissingPackageError, match=r"water\.xyz' is a molecule, and reading it needs ase; install it"):
        open_source(path, None, Shown())
