"""Whether samples take longer where many more lights can be chosen among: time and memory from 10 to 10 000 lights."""

from __future__ import annotations

import gc
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from tracer.core import stopwatch
from tracer.sampling.passes import PASS_SIZES
from tracer.sampling.samples import Recorded, make_sampler
from tracer.sampling.wavefront import lane_pixels, line_of
from tracer.scene.view import View, open_scene
from tracer.session.guidance import choose_by, guided_view, learn_lights
from tracer.session.memory import resident
from tracer.study.tables import markdown_table

COUNTS, KINDS = (10, 100, 1000, 10_000), ("point", "sphere")
"""Numbers of lights, and kinds of them."""
SIZE, SPP, TURNS, SEED = (256, 192), 64, 5, 970
"""Width and height of the picture, samples of each pixel, all in one pass, and number of times that they are drawn."""
FLOOR = 10.0
"""Half the side of the floor above which the lights hang in a grid."""


@dataclass(frozen=True)
class LightCountRow:
    """Results of a scene of ``lights`` lights of a kind."""

    kind: str
    lights: int
    gain: float
    """By which factor the variance falls by what was learned, as is expected after learning; 1 if nothing was."""
    learning_seconds: float
    """Seconds of the processor that learning takes, without what is done once for each scene."""
    path_seconds: list[float]
    """Seconds of the processor that the samples take with ``path``, each time that they were drawn."""
    guided_seconds: list[float]
    """The same with lights chosen by what was learned."""
    scene_bytes: float
    """Bytes of memory by which the process grew when the scene was made."""
    guided_bytes: float
    """Bytes of memory by which it grew when it learned and drew the first samples."""


def lit_floor(kind: str, light_count: int) -> Any:
    """Return a scene with a floor, four balls, and lights in a grid above it that together shine as bright as one."""
    side = int(np.ceil(np.sqrt(light_count)))
    step = 2 * FLOOR / side
    shapes: dict[str, Any] = {}
    for k in range(light_count):
        place = [(k % side + 0.5) * step - FLOOR, (k // side + 0.5) * step - FLOOR, 1.0]
        shapes[f"light{k}"] = light(kind, place, 300.0 / light_count)
    for k, (x, y) in enumerate(((-3, -2), (3, -1), (-1, 2), (4, 5))):
        shapes[f"ball{k}"] = {"type": "sphere", "center": [x, y, 0.4], "radius": 0.4}
    view = mi.ScalarTransform4f().look_at(origin=[0, -14, 8], target=[0, 0, 0], up=[0, 0, 1])
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 4},
            "sensor": {"type": "perspective", "fov": 45.0, "to_world": view, "film": film},
            "floor": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(FLOOR)},
            **shapes,
        }
    )


def light(kind: str, place: list[float], power: float) -> dict[str, Any]:
    """Return the description of a light at a place: a point or a small ball."""
    if kind == "point":
        return {"type": "point", "position": place, "intensity": power}
    radius = 0.02
    emitter = {"type": "area", "radiance": power / (np.pi * radius**2)}
    return {"type": "sphere", "center": place, "radius": radius, "emitter": emitter}


def light_count_rows(kind: str, announce: Callable[[str], None]) -> list[LightCountRow]:
    """Return a row for each of ``COUNTS``; the samples of all are drawn in turn. ``announce`` is told each step."""
    with ExitStack() as opened:
        rows: list[LightCountRow] = []
        draws: list[tuple[Callable[[], None], Callable[[], None]]] = []
        for light_count in COUNTS:
            announce(f"{light_count} {kind} lights")
            before = resident()
            scene = lit_floor(kind, light_count)
            after = resident()
            view = opened.enter_context(open_scene(scene, 0, None, SIZE))
            plain = Recorded(view, make_sampler())
            opened.callback(plain.close)
            draw(plain, view)
            between = resident()
            gain, seconds, chosen = taught(view)
            guided = Recorded(chosen, make_sampler())
            opened.callback(guided.close)
            draw(guided, view)
            grown = resident() - between
            rows.append(LightCountRow(kind, light_count, gain, seconds, [], [], after - before, grown))
            draws.append((partial(draw, plain, view), partial(draw, guided, view)))
        announce(f"{kind} lights: in turn")
        for _ in range(TURNS):
            for row, (draw_plain, draw_guided) in zip(rows, draws, strict=True):
                row.path_seconds.append(cpu_seconds(draw_plain))
                row.guided_seconds.append(cpu_seconds(draw_guided))
        del draws
        gc.collect()
    return rows


def taught(view: View) -> tuple[float, float, View]:
    """Return what is expected to be gained, the seconds that it took to learn, and a view that uses what was learned.

    It learns twice, and the second time is timed: the first compiles kernels.
    """
    chosen = guided_view(view)
    chosen = replace(chosen, integrator=mi.load_dict({"type": "guided", "max_depth": 4}))
    choose_by(chosen, None)
    for seed in (SEED, SEED + 1):
        start = stopwatch.read()
        lesson = learn_lights(chosen, SPP, seed)
        seconds = (stopwatch.read() - start).cpu
    if lesson is not None:
        choose_by(chosen, lesson.learned, lesson.plan)
    return 1.0 if lesson is None else lesson.gain, seconds, chosen


def draw(recorded: Recorded, view: View) -> None:
    """Draw as many samples in each pixel, and wait for them."""
    scale = dr.opaque(mi.Float, SPP**-0.5)
    for wavefront in line_of(np.full(view.pixel_count, SPP, np.uint32)).passes(PASS_SIZES[-1]):
        pixel, index = lane_pixels(wavefront)
        recorded(dr.opaque(mi.UInt32, SEED), pixel, index, scale)
    dr.sync_thread()


def cpu_seconds(work: Callable[[], None]) -> float:
    """Return the seconds of the processor that ``work`` takes."""
    start = stopwatch.read()
    work()
    return float((stopwatch.read() - start).cpu)


def light_counts_in_words(rows: list[dict[str, Any]]) -> str:
    """Return the section on numbers of lights as Markdown."""
    introduction = (
        f"A floor and balls, {SIZE[0]} x {SIZE[1]}, {SPP} samples per pixel, under lights of one kind that together "
        f"shine the same. Seconds of the processor to draw the samples, the median of {TURNS} turns, and in brackets "
        f"how many times those of {COUNTS[0]} lights; to learn, once kernels are compiled; by which factor the "
        "variance is expected to fall; megabytes by which the process grows with the scene, and to learn and draw."
    )
    headings = ("kind", "lights", "path", "guided", "learning", "gain", "MB, scene", "MB, learning")
    seconds = {(row["kind"], row["lights"]): row for row in rows}
    cells = []
    for (kind, light_count), row in seconds.items():
        first = seconds[kind, COUNTS[0]]
        medians = [
            f"{np.median(row[name]):.2f} ({np.median(row[name]) / np.median(first[name]):.2f})"
            for name in ("path_seconds", "guided_seconds")
        ]
        memory = [f"{row[name] / 1e6:.0f}" for name in ("scene_bytes", "guided_bytes")]
        cells.append(
            [kind, str(light_count), *medians, f"{row['learning_seconds']:.2f}", f"{row['gain']:.1f}", *memory]
        )
    return f"{introduction}\n\n{markdown_table(headings, cells)}"
