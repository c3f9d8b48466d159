"""Files of results: what is documented is what is written."""

import json
import re
from pathlib import Path

import numpy as np

from study.page.conftest import made_up
from tracer.study.tables import HEADINGS, bounds, cells, markdown
from tracer.study.write import as_csv, conditions, finite, numbers

SCHEMA = (Path(__file__).parents[2] / "docs" / "reference" / "studies.md").read_text().split("## results.json")[1]


def column(line, k):
    """Return a cell of a line of a Markdown table, "" of any other line."""
    return line.split("|")[k + 1] if line.startswith("|") else ""


def documented(key):
    """Return the names in the line of the schema that ``key`` is in."""
    line = next(line for line in SCHEMA.splitlines() if f"`{key}`" in column(line, 0))
    return re.findall(r"`(\w+)`", line)


def test_the_schema_is_documented():
    results, _ = made_up(2, 2)
    record = finite({**conditions(results), **numbers(results)})
    json.dumps(record, allow_nan=False)
    first_column = [name for line in SCHEMA.splitlines() for name in re.findall(r"`(\w+)`", column(line, 0))]
    assert set(first_column) == set(record)
    scores = set(record["rows"][0]["scores"])
    assert scores <= set(re.findall(r"`(\w+)`", SCHEMA))
    assert set(documented("scenes")) - {"scenes"} == set(record["scenes"][0])
    assert set(documented("means")) | {"budget", "method"} == set(record["means"][0]) | {"means"}
    assert set(documented("rows")) | {"scene", "budget", "method"} == set(record["rows"][0]) | {"rows"}
    assert (set(documented("cells")) - {"cells"}) | scores == set(record["cells"][0])
    assert set(documented("failures")) - {"failures"} == set(record["failures"][0])


def test_csv_has_a_line_a_cell():
    results, _ = made_up(1, 2)
    lines = as_csv(results).splitlines()
    assert len(lines) == 1 + 2 * 2 * 2
    assert lines[0].startswith("scene,method,budget,seed,spp,samples,seconds")


def test_tables():
    results, _ = made_up(2, 6)
    rows, means = results.tables()
    assert all(len(cells(row)) == len(HEADINGS) for row in rows)
    fused = next(mean for mean in means if (mean.method, mean.budget) == ("fused", "64 spp"))
    assert np.isclose(fused.gain_samples.mean, 4)  # half the error of uniform
    assert np.isclose(fused.gain_time.mean, 4 / 2)  # in twice the time, errors falling as 1 / time
    gain = next(row for row in rows if (row.scene, row.method, row.budget) == ("scene 0", "fused", "64 spp"))
    assert np.isclose(gain.gain_trimmed_time.mean, gain.gain_trimmed.mean / 2)
    text = markdown(results)
    at_equal_time = text.partition("## Gains at equal time, 64 spp")[2].partition("##")[0]
    assert f"| scene 0 | {bounds(gain.gain_time)}, {bounds(gain.gain_trimmed_time)} |" in at_equal_time
    for heading in (
        "## Gains, 16 spp",
        "## Gains, 64 spp",
        "## Seconds, 64 spp",
        "## References",
        "## Failed",
        "## All",
    ):
        assert heading in text
    assert "| scene 1 | 256 x 192 | 8192 | 1e-06 | 1e-06 | NO (p = 0.3) |" in text
    assert "| scene 0 | 64 spp | stock c | 0.000292° |" in text


def test_nothing_that_json_does_not_know():
    assert finite({"a": [float("nan"), (1.0, float("inf"))]}) == {"a": [None, [1.0, None]]}
