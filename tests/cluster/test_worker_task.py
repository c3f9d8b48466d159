"""Units drawn in this process, as a worker would, against the picture drawn in one piece."""

from pathlib import Path
from types import SimpleNamespace

import drjit as dr
import numpy as np
import pytest

from tracer import scenes
from tracer.cluster import worker_task
from tracer.cluster.worker_scene import close_worker_scene
from tracer.cluster.worker_setup import RoundSettings, Setup, software
from tracer.errors import ClusterError
from tracer.sampling.wavefront import Stretch
from tracer.scene.fingerprint import fingerprint
from tracer.scene.view import open_scene
from tracer.session.local_drawer import LocalDrawer

SCENE = Path(scenes.__file__).parent / "spheres_and_rods.xml"
WORK = RoundSettings(software(), None, 1 << 20, 5, 0.25)


@pytest.fixture
def setup():
    threads = dr.thread_count()
    yield Setup(str(SCENE), fingerprint(SCENE, {}), "llvm_ad_rgb", size=16)
    close_worker_scene()
    dr.set_thread_count(threads)


def rounds(pixel_count):
    """Return what two rounds draw of a picture: 3 samples everywhere, then 0 to 20 more."""
    first = np.full(pixel_count, 3, np.uint32)
    more = np.random.default_rng(1).integers(0, 20, pixel_count).astype(np.uint32)
    return [Stretch(0, 0 * first, first), Stretch(0, first, first + more)]


def drawn_here(stretches):
    with open_scene(SCENE, size=16) as view:
        drawer = LocalDrawer(view, None)
        estimate = drawer.empty()
        for each in stretches:
            for _ in drawer.draw(estimate, *(part.reshape(view.grid) for part in (each.before, each.after)), 5, 0.25):
                pass
        drawer.close()
        return estimate.state()[1:], view.pixel_count


def draw(setup, tmp_path, pixels, stretches, before=None, skip=0, work=WORK):
    parts = [each.part(*pixels) for each in stretches]
    return worker_task.draw_on_device("tcp://here", setup, (tmp_path, 2), work, before, skip, pixels, parts)


def test_units_have_the_sums_of_the_picture(setup, tmp_path):
    """A unit of some pixels in the first round, and of some of these in the second; and one of both at once."""
    with open_scene(SCENE, size=16) as view:
        stretches = rounds(view.pixel_count)
    whole, _ = drawn_here(stretches)
    first = draw(setup, tmp_path, (20, 60), stretches[:1])
    then = draw(setup, tmp_path, (30, 40), stretches[1:], before=first, skip=10)
    anew = draw(setup, tmp_path, (30, 40), stretches)
    for found in (then, anew):
        for one, other in zip(found["sums"].strip.state()[1:], whole, strict=True):
            assert np.array_equal(one, other[30:70])
        assert np.array_equal(found["statistics"].count[0], whole[0][30:70])
    assert first["report"]["samples"] == 3 * 60
    assert anew["report"]["samples"] == then["report"]["samples"] + 3 * 40 == stretches[1].after[30:70].sum()
    assert then["report"]["worker"] == "tcp://here"


def test_a_unit_keeps_to_the_scale_and_the_largest_pass_of_its_work(setup, tmp_path, monkeypatch):
    seen = []
    line = LocalDrawer.draw_line

    def watch(self, *arguments):
        seen.append((self.largest_pass, *arguments[2:4]))
        return line(self, *arguments)

    monkeypatch.setattr(LocalDrawer, "draw_line", watch)
    work = RoundSettings(software(), None, 4096, 9, 0.125)
    draw(setup, tmp_path, (0, 5), rounds(16 * 16)[:1], work=work)
    assert seen == [(4096, 9, 0.125)]


def test_nothing_that_dask_frees_is_of_dr_jits_memory(setup, tmp_path):
    """Dask would free it on its own thread, and wait there for ever now and then."""
    with open_scene(SCENE, size=16) as view:
        stretches = rounds(view.pixel_count)
    known = draw(setup, tmp_path, (0, 40), stretches)["statistics"]
    assert all(type(values) is np.ndarray and values.flags.owndata for values in vars(known).values())


def test_a_worker_of_another_version_draws_nothing(setup, monkeypatch):
    monkeypatch.setattr(worker_task, "get_worker", lambda: SimpleNamespace(address="tcp://old"))
    work = RoundSettings({**software(), "Mitsuba": "3.0"}, None, 1 << 20, 5, 0.25)
    with pytest.raises(ClusterError, match="tcp://old has Mitsuba"):
        worker_task.draw_unit(None, 0, 0, 1, [], setup=setup, settings=work)
