"""The page of ``tracer view report``, as Markdown."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np


def to_markdown(sections: dict[str, Any]) -> str:
    """Return the page."""
    speed = sections["Rate"]
    lines = [
        "# Views",
        "",
        "## Rate",
        "",
        f"{speed['what']}:",
        "",
        "| | seconds | million rays per second |",
        "|---|---|---|",
    ]
    for name, seconds in speed["seconds"].items():
        lines.append(f"| {name} | {seconds:.2f} | {speed['million rays per second'][name]:.1f} |")
    share = speed["share of the rate of intersections"]
    lines += ["", f"The item buffer has {100 * share:.0f} % of the rate of intersections alone.", ""]
    lines += ["## Searches", "", *search_table(sections["Searches"]), ""]
    lines += ["## View sets", "", *cover_table(sections["View sets"]), ""]
    found = sections["Convergence of the fast estimate"]
    lines += ["## Convergence of the fast estimate", "", "Entropy with background, 12 views; the scene by shapes:", ""]
    lines += [
        "| | random rays | error, bits | uncorrected | standard error | within 1.96 of them | surfaces hit once |"
    ]
    lines += ["|---|---|---|---|---|---|---|"]
    for subject, rows in found.items():
        for row in rows:
            values = [f"{row[name]:.3f}" for name in ("error", "uncorrected", "standard error")]
            shares = [f"{100 * row[name]:.0f} %" for name in ("within 1.96 standard errors", "seen once")]
            lines.append(f"| {subject} | {row['rays']} | {' | '.join(values + shares)} |")
    lines += ["", "![error against rays](convergence.png)", "", "## Molecules", ""]
    lines += ["| file | atoms | entropy wanted | search | view | bits | views |", "|---|---|---|---|---|---|---|"]
    for row in sections["Molecules"]:
        lines += [
            f"| {row['file']} | {row['atoms']} | {row['good']} | {' | '.join(line[:4])} |" for line in row["lines"]
        ]
    lines += ["", *(f"![{row['file']}]({Path(row['file']).stem}/best.png)" for row in sections["Molecules"]), ""]
    lines += ["## Pictures", ""]
    shown = {"measures": "best_and_worst.png", "tour": "tour.webp", "cover": "views.png", "map": "map.png"}
    lines += [f"![{name}]({name}/{shown[name.split('-')[0]]})" for name in sections["Pictures"]]
    return "\n".join([*lines, ""])


def search_table(rows: list[dict[str, Any]]) -> list[str]:
    """Return a table by measure, means over subjects."""
    subjects = list(dict.fromkeys(row["subject"] for row in rows))
    lines = [
        f"Value reached over {len(subjects)} subjects ({', '.join(subjects)}), as a share of the way from the worst of "
        "162 views to the best view that any search knows: mean (least). Behind it the mean number of views measured.",
        "",
        "| measure | paper | from all octants | exhaustive |",
        "|---|---|---|---|",
    ]
    for name in [*dict.fromkeys(row["measure"] for row in rows), None]:
        chosen = [row for row in rows if name in (None, row["measure"])]
        cells = []
        for search in ("paper", "octants", "exhaustive"):
            reached = np.array([row["reached"][search] for row in chosen])
            views = np.mean([row["views"][search] for row in chosen])
            cells.append(f"{reached.mean():.2f} ({reached.min():.2f}), {views:.0f}")
        lines.append(f"| {name or '**all**'} | {' | '.join(cells)} |")
    return lines


def cover_table(rows: list[dict[str, Any]]) -> list[str]:
    """Return a table of the sizes of view sets."""
    lines = [
        "Views, of 162, that show a share of the area well: chosen one by one by each rule, and the fewest that there "
        "can be, by integer programming within a minute.",
        "",
        "| mesh | share | entropy | area | divergence | fewest |",
        "|---|---|---|---|---|---|",
    ]
    for row in rows:
        exact, least = row["found exactly"], row["least"]
        fewest = str(least) if exact == least else f"{least} to {exact}" if exact else f"at least {least}"
        counts = " | ".join(str(row[rule]) for rule in ("entropy", "area", "divergence"))
        lines.append(f"| {row['subject']} | {100 * row['enough']:.0f} % | {counts} | {fewest} |")
    return lines
