"""The benchmark of guiding, with everything made small."""

import json

import pytest

from benchmarks.guiding import light_counts, report


def row(scene="a", value=1.5):
    return {"scene": scene, "slots": 3, "factors": {name: [value, value + 1] for name in report.COLUMNS}}


def rectangle_row(scene="c"):
    gains = {"variance": {"solid angle": [0.75, 1.5], "cosine": [1.25, 1.75]}, "time": {"solid angle": 2, "cosine": 1}}
    return {"scene": scene, "rectangles": 5, "gains": gains}


def light_count_row(count, seconds):
    times = {"learning_seconds": 0.5, "path_seconds": [seconds], "guided_seconds": [9.0, seconds * 1.5, 0.1]}
    return {"kind": "point", "lights": count, "gain": 2.0, "scene_bytes": 1e6, "guided_bytes": 3e6, **times}


def page_of(*rows, rectangles=(), light_counts=()):
    return report.to_page({"noise": list(rows), "rectangles": list(rectangles), "light counts": list(light_counts)})


def test_a_line_has_the_mean_of_the_seeds():
    page = page_of(row(), row("b", 3.5))
    assert "| a | 3 | 2.00 | 2.00 | 2.00 | 2.00 | 2.00 | 2.00 |" in page
    assert "| **geometric mean** |  | **2.83** |" in page


def test_gains_of_rectangles_are_shared_out_over_time():
    page = page_of(row(), rectangles=[rectangle_row()])
    assert "| c | 5 | 0.75 | 1.50 | 1.25 | 1.75 | 2.00 | 1.00 | 0.75 | 1.75 |" in page


def test_seconds_are_compared_with_those_of_few_lights():
    page = page_of(row(), light_counts=[light_count_row(10, 1.0), light_count_row(1000, 1.2)])
    assert "| point | 1000 | 1.20 (1.20) | 1.80 (1.20) | 0.50 | 2.0 | 1 | 3 |" in page


@pytest.mark.slow
def test_every_scene_with_paths_has_a_line(tmp_path, monkeypatch):
    for name, value in {"SIZE": 12, "PATHS": 1 << 11, "SEEDS": (1,), "RECTANGLE_SIZE": 8}.items():
        monkeypatch.setattr(report, name, value)
    for module, name, value in (
        (report, "KINDS", ("point",)),
        (report, "COUNTS", (10, 20)),
        (light_counts, "COUNTS", (10, 20)),
        (light_counts, "SIZE", (32, 24)),
    ):
        monkeypatch.setattr(module, name, value)
    ours = report.openers(tmp_path)
    kept = ("even_noise", "many_lights", "lamp_and_sky", "window_interior")
    monkeypatch.setattr(report, "openers", lambda public: {name: ours[name] for name in kept})
    steps = []
    report.report(tmp_path, lambda *step: steps.append(step), tmp_path)
    of_scenes = [f"{name}: {part}" for part in ("noise", "rectangles") for name in kept]
    of_counts = ["10 point lights", "20 point lights", "point lights: in turn"]
    assert [step[0] for step in steps] == of_scenes + of_counts
    numbers = json.loads((tmp_path / "results.json").read_text())
    assert [measured["scene"] for measured in numbers["noise"]] == list(kept)
    assert all(min(values) >= 1 for measured in numbers["noise"] for values in measured["factors"].values())
    assert [measured["scene"] for measured in numbers["rectangles"]] == ["window_interior"]
    assert [(measured["kind"], measured["lights"]) for measured in numbers["light counts"]] == [
        ("point", 10),
        ("point", 20),
    ]
    assert report.to_page(numbers) == (tmp_path / "results.md").read_text()
    numbers["noise"][0]["slots"] = 99
    (tmp_path / "results.json").write_text(json.dumps({"noise": numbers["noise"], "light counts": []}))
    report.report(tmp_path, lambda *_: True, tmp_path, resume=True)
    again = json.loads((tmp_path / "results.json").read_text())
    assert again["noise"] == numbers["noise"]
    assert again["rectangles"][0]["gains"]["variance"] == numbers["rectangles"][0]["gains"]["variance"]
