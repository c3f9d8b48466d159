"""The page of the benchmark of views, as Markdown."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import harness
from benchmarks.viewpoint.lit import WAYS
from tracer.study.tables import markdown_table

Rows = list[dict[str, Any]]
"""Rows of a table, as plain values by name."""
SHOWN = {"measures": "best_and_worst.png", "tour": "tour.webp", "cover": "views.png", "map": "map.png"}
"""File name of the picture that is shown of a folder, by the first word of the folder's name."""

CONTENT = ("entropy", "dark", "burnt out")
"""What is said of a picture, see ``benchmarks.viewpoint.lit.content``."""
SAME = 0.02
"""Entropies that differ by at most this, in bits, are about the same."""


def to_page(sections: dict[str, Any]) -> str:
    """Return the results as Markdown."""
    molecules = sections["Molecules"]
    texts = {
        "Rate": rate(sections["Rate"]),
        "Searches": searches(sections["Searches"]),
        "View sets": view_sets(sections["View sets"]),
        "Convergence of the fast estimate": f"""
Entropy with background, 12 views; the scene by shapes:

{convergence_table(sections["Convergence of the fast estimate"])}
![error against rays](convergence.png)""",
        "Light": lit_views(sections["Light"]),
        "Molecules": f"{molecule_table(molecules)}\n"
        + "\n".join(f"![{row['file']}]({Path(row['file']).stem}/best.png)" for row in molecules),
        "Pictures": "\n".join(f"![{name}]({name}/{SHOWN[name.split('-')[0]]})" for name in sections["Pictures"]),
        "Large files": large_files(sections["Large files"]),
    }
    return harness.page("Views", "", texts)


def rate(numbers: dict[str, Any]) -> str:
    """Return the section on the speed of the item buffer."""
    per_second, share = numbers["million rays per second"], numbers["share of the rate of intersections"]
    lines = [[name, f"{seconds:.2f}", f"{per_second[name]:.1f}"] for name, seconds in numbers["seconds"].items()]
    return f"""
{numbers["what"]}:

{markdown_table(["", "seconds", "million rays per second"], lines)}
The item buffer has {100 * share:.0f} % of the rate of intersections alone."""


def searches(rows: Rows) -> str:
    """Return the section on how near searches come to the best view, by measure, with means over subjects."""
    subjects = list(dict.fromkeys(row["subject"] for row in rows))
    names = dict.fromkeys(row["measure"] for row in rows)
    lines = [
        *([name, *reached_cells([row for row in rows if row["measure"] == name])] for name in names),
        ["**all**", *reached_cells(rows)],
    ]
    return f"""
Value reached over {len(subjects)} subjects ({", ".join(subjects)}), as a share of the way from the worst of \
162 views to the best view that any search knows: mean (least). Behind it the mean number of views measured.

{markdown_table(["measure", "paper", "from all octants", "exhaustive"], lines)}"""


def reached_cells(rows: Rows) -> list[str]:
    """Return a cell for each search: mean and smallest value that it reached, and mean number of views."""
    cells = []
    for search in ("paper", "octants", "exhaustive"):
        reached = np.array([row["reached"][search] for row in rows])
        views = np.mean([row["views"][search] for row in rows])
        cells.append(f"{reached.mean():.2f} ({reached.min():.2f}), {views:.0f}")
    return cells


def view_sets(rows: Rows) -> str:
    """Return the section on the sizes of view sets."""
    lines = []
    for row in rows:
        size, bound = row["found exactly"], row["least"]  # 0: no set was found in time
        fewest = f"at least {bound}" if not size else str(bound) if size == bound else f"{bound} to {size}"
        counts = [str(row[rule]) for rule in ("entropy", "area", "divergence")]
        lines.append([row["subject"], f"{100 * row['enough']:.0f} %", *counts, fewest])
    return f"""
Views, of 162, that show a share of the area well: chosen one by one by each rule, and the fewest that there can be, \
by integer programming within a minute.

{markdown_table(["mesh", "share", "entropy", "area", "divergence", "fewest"], lines)}"""


def convergence_table(subjects: dict[str, Rows]) -> str:
    """Return a table of the errors of the fast estimate by number of rays."""
    headings = ["", "random rays", "error, bits", "uncorrected", "standard error"]
    headings += ["within 1.96 of them", "surfaces hit once"]
    lines = [
        [
            subject,
            str(row["rays"]),
            *(f"{row[name]:.3f}" for name in ("error", "uncorrected", "standard error")),
            *(f"{100 * row[name]:.0f} %" for name in ("within 1.96 standard errors", "seen once")),
        ]
        for subject, rows in subjects.items()
        for row in rows
    ]
    return markdown_table(headings, lines)


def lit_views(rows: Rows) -> str:
    """Return the section on light as a part of complexity."""
    if not rows:
        return "\nThere was no scene with a light."
    gains = [row["light"]["entropy"] - row["geometry"]["entropy"] for row in rows]
    better, worse = sum(gain > SAME for gain in gains), sum(gain < -SAME for gain in gains)
    outlier = int(np.argmax(np.abs(gains)))
    others = [row for number, row in enumerate(rows) if number != outlier] or rows
    means = [
        {"scene": name, **{way: {key: np.mean([row[way][key] for row in some]) for key in CONTENT} for way in WAYS}}
        for name, some in (("**mean**", rows), (f"**mean without {rows[outlier]['scene']}**", others))
    ]
    lines = [
        [
            row["scene"],
            *(f"{row[way]['entropy']:z.2f}" for way in WAYS),
            *(f"{100 * row[way][key]:.0f} %" for key in CONTENT[1:] for way in WAYS),
        ]
        for row in [*rows, *means]
    ]
    headings = ["scene", *(f"{unit}, {way}" for unit in ("bits", *CONTENT[1:]) for way in WAYS)]
    return f"""
The view with the greatest entropy of shapes, where every shape counts the same (geometry), and where each of its \
sides counts as well as the scene's own light shows it (light). Its picture, in that light, is judged by \
something else: the entropy of the histogram of luminance, in bits, and the shares of dark and of burnt-out pixels. \
By light the picture has the greater entropy, by more than {SAME:g} bits, on {better} of {len(rows)} scenes, and the \
smaller on {worse}.

{markdown_table(headings, lines)}
![The pictures of both ways](light.png)"""


def molecule_table(rows: Rows) -> str:
    """Return a table of the best views of molecules by each search."""
    headings = ["file", "atoms", "entropy wanted", "search", "view", "bits", "views"]
    lines = [[row["file"], str(row["atoms"]), row["good"], *line[:4]] for row in rows for line in row["lines"]]
    return markdown_table(headings, lines)


def large_files(rows: Rows) -> str:
    """Return the section on seconds and memory of commands on large files."""
    lines = [
        [
            f"{row['file']}, {row['megabytes']:.0f} MB",
            row["size"],
            f"`tracer {row['command']}`",
            f"{row['seconds']:.0f}",
            f"{row['gigabytes']:.1f}",
        ]
        for row in rows
    ]
    return f"""
Each command in a process of its own, on {harness.machine()}: seconds of all processors, and the most memory at any \
time.

{markdown_table(["file", "", "command", "seconds", "GB"], lines, right_aligned=True)}"""
