"""All that is claimed of views, measured and drawn in one folder: rate, searches, convergence, molecules, pictures."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, get_args

import drjit as dr
import numpy as np

from benchmarks.viewpoint.minimum_cover import fewest_views
from benchmarks.viewpoint.page import to_markdown
from tracer.core.backend import activate
from tracer.core.sphere import evenly, icosphere
from tracer.io import atomic
from tracer.viewpoint import fast, measures, plots
from tracer.viewpoint.cover import Rule, cover
from tracer.viewpoint.direction_measure import stand
from tracer.viewpoint.item_buffer import MOST_RAYS, Rays, projected_areas, trace
from tracer.viewpoint.reports.best import best
from tracer.viewpoint.reports.complexity_map import complexity_map, view_from
from tracer.viewpoint.reports.context import Desk, Told
from tracer.viewpoint.reports.cover import cover_report
from tracer.viewpoint.reports.measure import measure
from tracer.viewpoint.reports.tour import tour
from tracer.viewpoint.search import Found, Valued, exhaustive_search, paper_search
from tracer.viewpoint.source import Crystal, Opened, open_source
from tracer.viewpoint.survey import survey

FILES = ("results.md", "results.json")
MESHES = {
    "bunny.ply": (0.0, 1.0, 0.0),
    "spot.obj": (0.0, 1.0, 0.0),
    "suzanne.ply": (0.0, 0.0, 1.0),
    "teapot.ply": (0.0, 0.0, 1.0),
}
"""And what is upwards in each."""
CRYSTALS = ("C-Graphite.cif", "C-Diamond.cif", "NaCl-Halite.cif")
MOLECULES = ("C60-buckminsterfullerene.cml", "PCBM.cml")
RATE_SIDE, RATE_LEVEL = 640, 3
"""The protocol of the survey: 642 views of 640 x 640."""
SEARCH_SIDE, SEARCH_LEVEL = 96, 2
SHOWN_MEASURES = ("entropy", "mutual_information", "silhouette_length", "visible_saliency")
"""Of the sheets of pictures."""
QUALITY = 0.5
"""Share of its largest area at which a face is shown well, in view sets."""
COVER_SIDE = 256
"""Rays along each side of a view of view sets."""
TRUTH_SIDE = 2048
"""And of one whose entropy the fast estimate is compared with."""
NUMBERS_OF_RAYS = (100, 400, 1600, 6400, 25600, 102400)
FEW_SURFACES = "spheres_and_rods.xml"
"""What the fast estimate is shown on, beside a mesh of many faces."""
SEEDS = 20


def everything(public: Path, scenes: Path, folder: Path, told: Told) -> list[str]:
    """Write ``FILES`` and pictures; ``public`` has the folders ``meshes`` and ``molecules``. Return the headings."""
    activate()
    opened = {path: replace(open_source(public / "meshes" / path), up=up) for path, up in MESHES.items()}
    opened |= {path.name: open_source(path, "shape") for path in sorted(scenes.glob("*.xml"))}
    opened |= {path.parent.name: open_source(path, "shape") for path in sorted(public.glob("scenes/*/scene.xml"))}
    sections: dict[str, Any] = {}
    parts: list[tuple[str, Callable[[], Any]]] = [
        ("Rate", lambda: rate(opened["bunny.ply"])),
        ("Searches", lambda: searches(opened, folder, told)),
        ("View sets", lambda: view_sets(opened, told)),
        ("Convergence of the fast estimate", lambda: convergence(opened, folder)),
        ("Molecules", lambda: molecules(public / "molecules", folder, told)),
        ("Pictures", lambda: pictures(opened, folder, told)),
    ]
    for k, (heading, part) in enumerate(parts):
        if told(heading, k, len(parts)) is False:
            raise KeyboardInterrupt
        sections[heading] = part()
    atomic.write_text(folder / "results.json", json.dumps(sections, indent=1) + "\n")
    atomic.write_text(folder / "results.md", to_markdown(sections))
    return list(sections)


def rate(opened: Opened) -> dict[str, Any]:
    """Return seconds and rays per second of the item buffer, and of nothing but intersections of the same rays."""
    subject, place = opened.subject, stand(opened.subject)
    views, rays = place.viewpoints(icosphere(RATE_LEVEL)[0]), Rays(side=RATE_SIDE)
    size = max(1, MOST_RAYS // rays.count(place.lens))

    def item_buffer() -> None:
        for _ in projected_areas(subject, views, place.lens, rays):
            pass

    def intersections() -> None:
        for first in range(0, len(views), size):
            found = trace(subject, views[first : first + size], place.lens, rays, first, 0, rays.count(place.lens))
            dr.eval(found.hit, found.depth)
            dr.sync_thread()

    seconds = {"item buffer": [], "intersections only": []}  # type: dict[str, list[float]]
    for _ in range(3):
        for name, run in (("item buffer", item_buffer), ("intersections only", intersections)):
            start = time.perf_counter()
            run()
            seconds[name].append(time.perf_counter() - start)
    count = len(views) * rays.count(place.lens)
    shortest = {name: min(times[1:]) for name, times in seconds.items()}  # the first compiles
    return {
        "what": f"{len(views)} views of {RATE_SIDE} x {RATE_SIDE} of bunny.ply, {subject.count} faces",
        "seconds": shortest,
        "million rays per second": {name: count / each / 1e6 for name, each in shortest.items()},
        "share of the rate of intersections": shortest["intersections only"] / shortest["item buffer"],
    }


def searches(opened: dict[str, Opened], folder: Path, told: Told) -> list[dict[str, Any]]:
    """Return for each subject and measure what the searches reach: 0 the worst view of 162, 1 the best known."""
    rows = []
    ways: dict[str, Callable[[Valued], Found]] = {
        "paper": paper_search,
        "octants": partial(paper_search, all_octants=True),
        "exhaustive": partial(exhaustive_search, level=SEARCH_LEVEL),
    }
    for file, one in opened.items():
        desk = desk_of(one, folder, told, SEARCH_SIDE)
        for name in measures.names():
            needs = set(measures.get(name).needs)
            if {"vertices", "saliency"} & needs and not len(one.subject.mesh.triangles):
                continue
            told(f"searches: {file}, {name}", 1, 6)
            gauge = desk.gauge(name)
            all_around = gauge.better(icosphere(SEARCH_LEVEL)[0])
            found, views = {}, {}
            for search, run in ways.items():
                before = gauge.evaluations
                found[search] = run(gauge.better)
                views[search] = gauge.evaluations - before
            most = max(float(all_around.max()), *(each.value for each in found.values()))
            finite = all_around[np.isfinite(all_around)]
            span = most - float(finite.min()) if len(finite) else 0.0
            reached = {k: (each.value - most) / span + 1 if span > 0 else 1.0 for k, each in found.items()}
            rows.append({"subject": file, "measure": name, "reached": reached, "views": views})
    return rows


def view_sets(opened: dict[str, Opened], told: Told) -> list[dict[str, Any]]:
    """Return how many views each greedy rule takes, and the fewest that there can be."""
    rows = []
    for file, enough in itertools.product(("teapot.ply", "spot.obj"), (0.9, 0.95)):
        told(f"view sets: {file}", 2, 6)
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


def convergence(opened: dict[str, Opened], folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the error of the entropy from random rays, and how often its interval holds it, by subject."""
    found = {file: errors(opened[file]) for file in (FEW_SURFACES, "bunny.ply")}
    drawn = plots.figure(4.2 * len(found), 3.6)
    for axis, (file, rows) in zip(drawn.subplots(1, len(found)), found.items(), strict=True):
        for name, style in (("error", "o-"), ("uncorrected", "s:"), ("standard error", "k--")):
            axis.loglog([row["rays"] for row in rows], [row[name] for row in rows], style, label=name)
        axis.set_title(file, fontsize=9)
        axis.set_xlabel("random rays")
        axis.set_ylabel("entropy, bits (RMS)")
        axis.legend()
    plots.save(drawn, folder / "convergence.png")
    return found


def errors(opened: Opened) -> list[dict[str, Any]]:
    """Return the errors of a subject's entropy for each number of rays."""
    subject, place = opened.subject, stand(opened.subject)
    views = place.viewpoints(evenly(12))
    truth = survey(subject, views, place.lens, Rays(side=TRUTH_SIDE), ["entropy"])["entropy"]
    rows = []
    for rays in NUMBERS_OF_RAYS:
        found = [fast.estimate_entropy(subject, views, place.lens, rays, seed) for seed in range(SEEDS)]
        error = np.array([one.entropy - truth for one in found])
        stderr = np.array([one.stderr for one in found])
        rows.append(
            {
                "rays": rays,
                "error": float(np.sqrt(np.mean(error**2))),
                "uncorrected": float(np.sqrt(np.mean([(one.uncorrected - truth) ** 2 for one in found]))),
                "standard error": float(np.sqrt(np.mean(stderr**2))),
                "within 1.96 standard errors": float(np.mean(np.abs(error) < 1.96 * stderr)),
                "seen once": float(np.mean([one.once for one in found])),
            }
        )
    return rows


def molecules(public: Path, folder: Path, told: Told) -> list[dict[str, Any]]:
    """Return the best view of crystals (least entropy) and molecules (most), their pictures written."""
    rows = []
    for file in (*CRYSTALS, *MOLECULES):
        told(f"molecules: {file}", 4, 6)
        crystal = Crystal(cut=7.0, radius=0.77) if file in CRYSTALS else None
        one = open_source(public / file, crystal=crystal)
        place = folder / Path(file).stem
        place.mkdir(exist_ok=True)
        desk = desk_of(one, place, lambda *_: None, 160)
        lines = best(desk, "entropy", ["paper", "exhaustive"], 3)
        rows.append(
            {"file": file, "atoms": one.subject.count, "good": "least" if one.crystal else "most", "lines": lines}
        )
    return rows


def pictures(opened: dict[str, Opened], folder: Path, told: Told) -> list[str]:
    """Draw measures, a tour and a view set; return the names of their folders."""
    made = []

    def own_map(desk: Desk) -> None:
        view, lens = view_from(desk, 0, None)
        complexity_map(replace(desk, stand=replace(desk.stand, lens=lens)), view, "entropy", 32, 3)

    for name, file, make in (
        ("measures-bunny", "bunny.ply", lambda desk: measure(desk, SHOWN_MEASURES, 2)),
        ("tour-spot", "spot.obj", lambda desk: tour(desk, "entropy", 40, 6.0, 81, 200)),
        ("map-staircase2", "staircase2", own_map),
        ("cover-teapot", "teapot.ply", lambda desk: cover_report(desk, 2, 0.5, "entropy", None, 0.98)),
    ):
        if file not in opened:
            continue
        told(f"pictures: {name}", 5, 6)
        place = folder / name
        place.mkdir(exist_ok=True)
        make(desk_of(opened[file], place, lambda *_: None, 256))
        for frame in place.glob("frame*.png"):
            frame.unlink()  # the film has them
        made.append(name)
    return made


def desk_of(opened: Opened, folder: Path, told: Told, side: int) -> Desk:
    """Return a desk with all as the commands have it unless told otherwise."""
    place = stand(opened.subject, up=opened.up, orthographic=opened.orthographic)
    return Desk(opened, place, Rays(side=side), True, folder, told)
