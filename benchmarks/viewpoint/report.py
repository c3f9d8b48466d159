"""Measure and draw everything about views: rate, searches, view sets, convergence, molecules, pictures, large files."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, get_args

import drjit as dr
import numpy as np

from benchmarks import harness
from benchmarks.harness import Announce
from benchmarks.viewpoint import large
from benchmarks.viewpoint.lit import lit_views
from benchmarks.viewpoint.minimum_cover import fewest_views
from benchmarks.viewpoint.page import to_page
from tracer.core.sphere import evenly, icosphere
from tracer.progress import StepCallback
from tracer.viewpoint import fast, measures
from tracer.viewpoint.atom_source import Shown
from tracer.viewpoint.cover import Rule, cover
from tracer.viewpoint.direction_measure import stand
from tracer.viewpoint.item_buffer import MOST_RAYS, Rays, projected_areas, trace
from tracer.viewpoint.opened import Opened
from tracer.viewpoint.reports.best import best
from tracer.viewpoint.reports.complexity_map import complexity_map, view_from
from tracer.viewpoint.reports.context import ViewContext
from tracer.viewpoint.reports.cover import cover_report
from tracer.viewpoint.reports.measure import measure
from tracer.viewpoint.reports.tour import Film, tour
from tracer.viewpoint.search import Found, Valued, exhaustive_search, paper_search
from tracer.viewpoint.source import Counted, open_source
from tracer.viewpoint.survey import survey

FILES = (harness.PAGE, harness.NUMBERS)
"""Names of the files that this benchmark writes, beside folders of pictures."""
MESHES = {
    "bunny.ply": (0.0, 1.0, 0.0),
    "spot.obj": (0.0, 1.0, 0.0),
    "suzanne.ply": (0.0, 0.0, 1.0),
    "teapot.ply": (0.0, 0.0, 1.0),
}
"""Upward direction of each mesh, by the name of its file."""
CRYSTALS = ("C-Graphite.cif", "C-Diamond.cif", "NaCl-Halite.cif")
"""Files of the crystals that are measured."""
MOLECULES = ("C60-buckminsterfullerene.cml", "PCBM.cml")
"""Files of the molecules that are measured."""
RATE_SIDE, RATE_LEVEL = 640, 3
"""Rays along each side of a view, and level of the view sphere, for the rate: the survey has 642 views of 640 x 640."""
SEARCH_SIDE, SEARCH_LEVEL = 96, 2
"""Rays along each side of a view, and level of the view sphere, for searches."""
SHOWN_MEASURES = ("entropy", "mutual_information", "silhouette_length", "visible_saliency")
"""Measures that the sheet of pictures shows."""
COVERED, ENOUGH = ("teapot.ply", "spot.obj"), (0.9, 0.95)
"""Meshes of view sets, and the shares of the area that the view sets show well."""
QUALITY = 0.5
"""Share of its largest projected area above which a face is shown well, in view sets."""
COVER_SIDE = 256
"""Rays along each side of a view, for view sets."""
TRUTH_SIDE = 2048
"""Rays along each side of a view, for the entropy that the fast estimate is compared with."""
NUMBERS_OF_RAYS = (100, 400, 1600, 6400, 25600, 102400)
"""Numbers of random rays of the fast estimate."""
FEW_SURFACES = "spheres_and_rods.xml"
"""Scene of few surfaces for the fast estimate, beside a mesh of many faces."""
SEEDS = 20
"""Number of seeds of the fast estimate."""


def report(folder: Path, progress: StepCallback, public: Path, resume: bool = False) -> None:
    """Measure everything, and write ``FILES`` and pictures; ``public`` has the folders ``meshes`` and ``molecules``.

    Scenes in the folder ``scenes`` of ``public`` are searched too. ``resume``: keep the sections that the folder has,
    and measure those that it lacks. Raises KeyboardInterrupt if ``progress`` stops it.
    """
    opened = {path: replace(open_source(public / "meshes" / path), up=up) for path, up in MESHES.items()}
    scenes = {path.name: path for path in harness.bundled_scenes()}
    scenes |= {path.parent.name: path for path in sorted(public.glob("scenes/*/scene.xml"))}
    opened |= {name: open_source(path, Counted("shape")) for name, path in scenes.items()}
    lit = {name: path for name, path in scenes.items() if opened[name].subject.scene.emitters()}
    pairs = measured_pairs(opened)
    drawings = [name for name, (file, _) in DRAWINGS.items() if file in opened]
    kept = harness.measured_before(folder, resume)
    parts: dict[str, tuple[int, Callable[[Announce], Any]]] = {
        "Rate": (1, lambda announce: rate(opened["bunny.ply"], announce)),
        "Searches": (len(pairs), lambda announce: searches(opened, pairs, folder, announce)),
        "View sets": (len(COVERED) * len(ENOUGH), lambda announce: view_sets(opened, announce)),
        "Convergence of the fast estimate": (1, lambda announce: convergence(opened, folder, announce)),
        "Light": (len(lit), lambda announce: lit_views(lit, folder, announce)),
        "Molecules": (len(CRYSTALS + MOLECULES), lambda announce: molecules(public / "molecules", folder, announce)),
        "Pictures": (len(drawings), lambda announce: pictures(opened, folder, announce)),
        "Large files": (large.step_count(), lambda announce: large.large_files(public / "molecules", announce)),
    }
    announce = harness.StepCounter(progress, sum(steps for name, (steps, _) in parts.items() if name not in kept))
    sections = {name: kept[name] if name in kept else part(announce) for name, (_, part) in parts.items()}
    harness.write(folder, sections, to_page(sections))


def rate(opened: Opened, announce: Announce) -> dict[str, Any]:
    """Return seconds and rays per second of the item buffer, and of the intersections alone of the same rays."""
    announce("rate")
    subject, place = opened.subject, stand(opened.subject)
    views, rays = place.viewpoints(icosphere(RATE_LEVEL)[0]), Rays(side=RATE_SIDE)
    batch_size = max(1, MOST_RAYS // rays.count(place.lens))

    def item_buffer() -> None:
        for _ in projected_areas(subject, views, place.lens, rays):
            pass

    def intersections() -> None:
        for first in range(0, len(views), batch_size):
            batch = trace(
                subject, views[first : first + batch_size], place.lens, rays, first, 0, rays.count(place.lens)
            )
            dr.eval(batch.hit, batch.depth)
            dr.sync_thread()

    seconds = {"item buffer": [], "intersections only": []}  # type: dict[str, list[float]]
    for _ in range(3):
        for name, run in (("item buffer", item_buffer), ("intersections only", intersections)):
            start = time.perf_counter()
            run()
            seconds[name].append(time.perf_counter() - start)
    count = len(views) * rays.count(place.lens)
    shortest = {name: min(times[1:]) for name, times in seconds.items()}  # the first run compiles
    return {
        "what": f"{len(views)} views of {RATE_SIDE} x {RATE_SIDE} of bunny.ply, {subject.count} faces",
        "seconds": shortest,
        "million rays per second": {name: count / duration / 1e6 for name, duration in shortest.items()},
        "share of the rate of intersections": shortest["intersections only"] / shortest["item buffer"],
    }


def measured_pairs(opened: dict[str, Opened]) -> list[tuple[str, str]]:
    """Return all pairs of a subject and a measure that it allows: some measures need a mesh."""
    return [
        (file, name)
        for file, source in opened.items()
        for name in measures.names()
        if len(source.subject.mesh.triangles) or not {"vertices", "saliency"} & set(measures.get(name).needs)
    ]


def searches(
    opened: dict[str, Opened], pairs: list[tuple[str, str]], folder: Path, announce: Announce
) -> list[dict[str, Any]]:
    """Return what each search reaches, by subject and measure: 0 is the worst of 162 views, 1 the best known view."""
    rows = []
    search_functions: dict[str, Callable[[Valued], Found]] = {
        "paper": paper_search,
        "octants": partial(paper_search, all_octants=True),
        "exhaustive": partial(exhaustive_search, level=SEARCH_LEVEL),
    }
    for file, name in pairs:
        announce(f"searches: {file}, {name}")
        gauge = context_of(opened[file], folder, SEARCH_SIDE).gauge(name)
        values_around = gauge.better(icosphere(SEARCH_LEVEL)[0])
        best, views = {}, {}
        for search, run in search_functions.items():
            evaluations_before = gauge.evaluations
            best[search] = run(gauge.better).value
            views[search] = gauge.evaluations - evaluations_before
        best_value = max(float(values_around.max()), *best.values())
        finite_values = values_around[np.isfinite(values_around)]
        span = best_value - float(finite_values.min()) if len(finite_values) else 0.0
        reached = {search: (value - best_value) / span + 1 if span > 0 else 1.0 for search, value in best.items()}
        rows.append({"subject": file, "measure": name, "reached": reached, "views": views})
    return rows


def view_sets(opened: dict[str, Opened], announce: Announce) -> list[dict[str, Any]]:
    """Return the number of views that each greedy rule takes, and the smallest number possible."""
    rows = []
    for file, enough in itertools.product(COVERED, ENOUGH):
        announce(f"view sets: {file}, {100 * enough:g} %")
        subject, place = opened[file].subject, stand(opened[file].subject)
        views, rays = place.viewpoints(icosphere(2)[0]), Rays(side=COVER_SIDE)
        areas = np.concatenate([batch.areas for batch in projected_areas(subject, views, place.lens, rays)])
        shown = (areas >= QUALITY * areas.max(axis=0)) & (areas > 0)
        exact = fewest_views(shown, subject.areas, enough)
        sizes = {
            rule: len(cover(subject, views, place.lens, rays, QUALITY, rule, enough=enough).chosen)
            for rule in get_args(Rule)
        }
        rows.append(
            {
                "subject": file,
                "faces": subject.count,
                "enough": enough,
                **sizes,
                "found exactly": len(exact.chosen),
                "least": exact.least,
            }
        )
    return rows


def convergence(opened: dict[str, Opened], folder: Path, announce: Announce) -> dict[str, list[dict[str, Any]]]:
    """Return the error of the entropy from random rays, and how often its interval holds the truth, by subject."""
    announce("convergence")
    tables = {file: errors(opened[file]) for file in (FEW_SURFACES, "bunny.ply")}
    with harness.figure(folder / "convergence.png", 4.2 * len(tables), 3.6) as figure:
        for axis, (file, rows) in zip(figure.subplots(1, len(tables)), tables.items(), strict=True):
            for name, style in (("error", "o-"), ("uncorrected", "s:"), ("standard error", "k--")):
                axis.loglog([row["rays"] for row in rows], [row[name] for row in rows], style, label=name)
            axis.set_title(file, fontsize=9)
            axis.set_xlabel("random rays")
            axis.set_ylabel("entropy, bits (RMS)")
            axis.legend()
    return tables


def errors(opened: Opened) -> list[dict[str, Any]]:
    """Return the errors of a subject's entropy for each number of rays."""
    subject, place = opened.subject, stand(opened.subject)
    views = place.viewpoints(evenly(12))
    truth = survey(subject, views, place.lens, Rays(side=TRUTH_SIDE), ["entropy"])["entropy"]
    rows = []
    for rays in NUMBERS_OF_RAYS:
        estimates = [fast.estimate_entropy(subject, views, place.lens, rays, seed) for seed in range(SEEDS)]
        error = np.array([estimate.entropy - truth for estimate in estimates])
        stderr = np.array([estimate.stderr for estimate in estimates])
        uncorrected = np.array([estimate.uncorrected - truth for estimate in estimates])
        rows.append(
            {
                "rays": rays,
                "error": float(np.sqrt(np.mean(error**2))),
                "uncorrected": float(np.sqrt(np.mean(uncorrected**2))),
                "standard error": float(np.sqrt(np.mean(stderr**2))),
                "within 1.96 standard errors": float(np.mean(np.abs(error) < 1.96 * stderr)),
                "seen once": float(np.mean([estimate.once for estimate in estimates])),
            }
        )
    return rows


def molecules(public: Path, folder: Path, announce: Announce) -> list[dict[str, Any]]:
    """Return the best views of crystals (least entropy) and of molecules (most entropy), and write their pictures."""
    rows = []
    for file in (*CRYSTALS, *MOLECULES):
        announce(f"molecules: {file}")
        shown = Shown(cut=7.0, radius=0.77) if file in CRYSTALS else None
        source = open_source(public / file, shown=shown)
        subject_folder = folder / Path(file).stem
        subject_folder.mkdir(exist_ok=True)
        lines = best(context_of(source, subject_folder, 160), "entropy", ["paper", "exhaustive"], 3)
        extreme = "least" if source.crystal else "most"
        rows.append({"file": file, "atoms": source.subject.count, "good": extreme, "lines": lines})
    return rows


def pictures(opened: dict[str, Opened], folder: Path, announce: Announce) -> list[str]:
    """Draw measures, a tour, a map and a view set; return the names of their folders."""
    folder_names = []
    for name, (file, draw) in DRAWINGS.items():
        if file not in opened:
            continue
        announce(f"pictures: {name}")
        picture_folder = folder / name
        picture_folder.mkdir(exist_ok=True)
        draw(context_of(opened[file], picture_folder, 256))
        for frame in picture_folder.glob("frame*.png"):
            frame.unlink()  # the film of the tour has all frames
        folder_names.append(name)
    return folder_names


def own_map(context: ViewContext) -> None:
    """Draw the complexity map of the view of the scene's own camera."""
    view, lens = view_from(context, 0, None)
    complexity_map(replace(context, stand=replace(context.stand, lens=lens)), view, "entropy", 32, 3)


DRAWINGS: dict[str, tuple[str, Callable[[ViewContext], object]]] = {
    "measures-bunny": ("bunny.ply", lambda context: measure(context, SHOWN_MEASURES, 2)),
    "tour-spot": ("spot.obj", lambda context: tour(context, "entropy", 40, 6.0, Film(71, 640))),
    "map-staircase2": ("staircase2", own_map),
    "cover-teapot": ("teapot.ply", lambda context: cover_report(context, 2, 0.5, "entropy", None, 0.98)),
}
"""For each folder of pictures, the subject that is drawn and the function that draws it."""


def context_of(opened: Opened, folder: Path, side: int) -> ViewContext:
    """Return a context with the defaults of the commands; steps within it are not shown."""
    place = stand(opened.subject, up=opened.up, orthographic=opened.orthographic)
    return ViewContext(opened, place, Rays(side=side), True, folder, lambda *_: None)
