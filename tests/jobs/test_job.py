"""A job: names of frames and sensors, configurations, and mistakes in either."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracer.errors import OutputError, SettingsError
from tracer.jobs.job import check_frames, check_outputs, frame_numbers, make_job, pictures_of, put_number


def job(configuration=None, **given):
    return make_job({"scene": "a/scene.xml", "output": "b/out.exr"} | given, configuration)


@pytest.mark.parametrize(
    ("text", "numbers"), [("3", [3]), ("1-4", [1, 2, 3, 4]), ("1-8:3", [1, 4, 7]), ("9, 2-3", [9, 2, 3])]
)
def test_frames(text, numbers):
    assert frame_numbers(text) == numbers


@pytest.mark.parametrize("text", ["", "a", "3-1", "1-", "1-4:0", "-3", "1,,2"])
def test_what_is_no_list_of_frames(text):
    with pytest.raises(SettingsError, match="frames: write"):
        job(frames=text)


@given(st.integers(0, 10**6), st.integers(1, 6))
def test_a_number_has_as_many_digits_as_marks(number, digits):
    name = put_number(f"picture#1.{'#' * digits}.xml", number)
    assert name == f"picture#1.{number:0{digits}}.xml"


def test_every_picture_has_a_name_of_its_own():
    assert [str(picture.output) for picture in pictures_of(job(), 3)] == ["b/out.exr"]
    assert [str(picture.output) for picture in pictures_of(job(sensor=["all"]), 3)] == [
        f"b/out-{k}.exr" for k in range(3)
    ]
    both = list(pictures_of(job(sensor=["0", "2"], frames="7-8", output="b/o.##.exr", checkpoint="c.ckpt"), 3))
    assert [str(picture.output) for picture in both] == ["b/o.07-0.exr", "b/o.07-2.exr", "b/o.08-0.exr", "b/o.08-2.exr"]
    assert [str(picture.checkpoint) for picture in both][:2] == ["c.0007-0.ckpt", "c.0007-2.ckpt"]
    assert [picture.define for picture in both][::2] == [{"frame": "7"}, {"frame": "8"}]
    files = list(pictures_of(job(scene="a/s.####.xml", frames="12"), 1))
    assert (str(files[0].scene), str(files[0].output), files[0].define) == ("a/s.0012.xml", "b/out.0012.exr", {})


def test_every_frame_may_be_in_a_folder_of_its_own(tmp_path):
    (frame,) = pictures_of(job(scene="a/####/s.xml", frames="12"), 1)
    assert (str(frame.scene), str(frame.output), frame.define) == ("a/0012/s.xml", "b/out.0012.exr", {})
    (tmp_path / "C#").mkdir()
    scene = tmp_path / "C#" / "s.xml"
    scene.write_text("<scene>$frame</scene>")  # a file that exists is meant as it is written
    (frame,) = pictures_of(job(scene=scene, frames="12"), 1)
    assert (frame.scene, frame.define) == (scene, {"frame": "12"})


def test_a_configuration_gives_what_the_command_line_does_not(tmp_path):
    path = tmp_path / "render.toml"
    path.write_text(
        'spp = 256\nnoise = 0.02\nsensor = [0, 1]\ncrop = [1, 2, 3, 4]\nimportance = "mask.exr"\ncheckpoint-every = 5\n'
        "[shape_weights]\nlamp = 4\n[define]\nlight = 3\n"
    )
    found = job(path, spp=16)
    assert found.settings["spp"] == 16
    assert found.settings["noise"] == 0.02
    assert found.settings["shape_weights"] == {"lamp": 4}
    assert found.settings["importance"] == str(tmp_path / "mask.exr")
    assert (found.sensor, found.crop, found.define, found.checkpoint_every) == ((0, 1), (1, 2, 3, 4), {"light": "3"}, 5)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("sp = 3", "there is no option 'sp', did you mean 'spp'"),
        ("spp = ", "is no TOML"),
        ('scene = "b.xml"', "there is no option 'scene'"),
        ("crop = 3", "crop: write x,y,width,height"),
        ('crop = "1,2,3"', "crop: write x,y,width,height"),
        ('sensor = "x"', "sensor"),
        ('define = ["x"]', "define: write name=value"),
        ("define = [1]", "define: write name=value"),
        ("define = 1", "define: write name=value"),
        ("memory = -1", "memory: input should be greater than 0"),
    ],
)
def test_mistakes_in_a_configuration(tmp_path, text, message):
    path = tmp_path / "render.toml"
    path.write_text(text)
    with pytest.raises(SettingsError, match=message) as raised:
        job(path)
    assert "\n" not in str(raised.value)


def test_a_configuration_that_is_not_there():
    with pytest.raises(SettingsError, match=r"Cannot read 'no\.toml'"):
        job(Path("no.toml"))


def test_frames_that_would_all_be_the_same(tmp_path):
    scene = tmp_path / "scene.xml"
    scene.write_text("<scene/>")
    with pytest.raises(SettingsError, match="the same in every frame"):
        check_frames(job(scene=scene, frames="1-2"))
    scene.write_text('<scene><float name="x" value="$frame"/></scene>')
    check_frames(job(scene=scene, frames="1-2"))


@pytest.mark.parametrize("twice", [{"sensor": ["0", "1", "0"]}, {"frames": "3,4,3"}])
def test_no_picture_is_written_over_by_another(tmp_path, twice):
    repeated = job(output=str(tmp_path / "out.exr"), **twice)
    with pytest.raises(OutputError, match="would be written more than once"):
        check_outputs(list(pictures_of(repeated, 2)), repeated)


def test_outputs_are_checked_before_the_first(tmp_path):
    (tmp_path / "out.0002.exr").write_text("mine")
    wanted = job(output=tmp_path / "out.####.exr", frames="1-3")
    with pytest.raises(OutputError, match=r"out\.0002\.exr' exists"):
        check_outputs(list(pictures_of(wanted, 1)), wanted)
