"""What is asked of a session is checked before the work."""

from pathlib import Path

import pytest

from conftest import small_scene
from tracer.core.wording import speaking_to_command_line
from tracer.errors import OutputError, SettingsError
from tracer.scene.fingerprint import fingerprint
from tracer.scene.loaded import LoadedScene
from tracer.scene.view import open_scene
from tracer.session.request import (
    CheckpointFile,
    PictureFile,
    Request,
    check_files,
    checkpoint_file,
    scene_hash_of,
)


def test_there_is_nothing_to_resume_from_without_a_checkpoint():
    assert checkpoint_file(None, 60.0, False, False) is None
    path = Path("state.ckpt")
    assert checkpoint_file(path, 5.0, True, False) == CheckpointFile(path, 5.0, resume=True, overwrite=False)
    with pytest.raises(SettingsError, match="name the checkpoint with checkpoint=FILE"):
        checkpoint_file(None, 60.0, True, False)
    with speaking_to_command_line(), pytest.raises(SettingsError, match="with --checkpoint FILE"):
        checkpoint_file(None, 60.0, True, False)


@pytest.mark.parametrize("there", ["out.exr", "state.ckpt"])
@pytest.mark.parametrize(("resume", "overwrite"), [(False, False), (True, False), (False, True)])
def test_files_that_are_there_are_kept_unless_that_is_said(tmp_path, there, resume, overwrite):
    (tmp_path / there).touch()
    checkpoint = CheckpointFile(tmp_path / "state.ckpt", resume=resume, overwrite=overwrite)
    request = Request({}, checkpoint=checkpoint, picture=PictureFile(tmp_path / "out.exr", overwrite))
    if resume or overwrite:
        check_files(request)
    else:
        with pytest.raises(OutputError, match=f"{there}' exists"):
            check_files(request)


def test_scenes_are_hashed_where_somebody_asks(tmp_path):
    scene = small_scene()
    assert scene_hash_of(Request(scene)) == ""
    asked = Request(scene, checkpoint=CheckpointFile(tmp_path / "state.ckpt"))
    assert scene_hash_of(asked) == fingerprint(scene)
    with open_scene(scene) as view:
        assert scene_hash_of(Request(view, checkpoint=asked.checkpoint)) == fingerprint(view.scene)
    assert scene_hash_of(Request(LoadedScene(Path("a.xml"), {}, "abc", None))) == "abc"
