"""Named studies: what is there after every scene."""

import json

import pytest

from conftest import LIT
from tracer.errors import SettingsError
from tracer.study.named import find_study, run_study


def test_numbers_are_written_after_every_scene(scene_file, tmp_path):
    scenes = [scene_file(LIT, "one.xml"), scene_file(LIT, "two.xml")]
    told = []

    def stop_in_the_second(text, done, total):
        told.append(text)
        return not text.startswith("two")

    with pytest.raises(KeyboardInterrupt):
        run_study("samplers", scenes, tmp_path, [4], 2, 8, stop_in_the_second)
    record = json.loads((tmp_path / "samplers.json").read_text())
    assert {error["scene"] for error in record["errors"]} == {"one"}
    assert len(record["errors"]) == 3
    assert "8 pixels wide, 2 seeds from 0" in (tmp_path / "samplers.md").read_text()
    table = run_study("samplers", scenes, tmp_path, [4], 2, 8)
    assert "| two |" in table
    assert table in (tmp_path / "samplers.md").read_text()


def test_mistakes():
    with pytest.raises(SettingsError, match="did you mean 'samplers'"):
        find_study("sampler", [64])
    with pytest.raises(SettingsError, match="takes one --spp"):
        find_study("overhead", [64, 16])
