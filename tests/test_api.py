"""What a script gives: numbers of any kind work, and a mistake is one sentence for who calls from Python."""

import inspect
import re
import typing

import mitsuba as mi
import numpy as np
import pytest

import tracer
from tracer import criteria
from tracer.criteria import registry
from tracer.errors import BackendError, OutputError, SettingsError

PARAMETERS = dict(inspect.signature(tracer.render).parameters)
HELP = inspect.getdoc(tracer.render)


def test_public_names_are_all_that_is_listed():
    assert dir(tracer) == sorted(tracer.__all__)
    assert all(hasattr(tracer, name) for name in dir(tracer))
    assert re.match(r"\d+\.\d+", tracer.__version__)


@pytest.mark.parametrize("name", tracer.Settings.model_fields)
def test_every_setting_is_a_keyword_of_the_same_type(name):
    """``render`` lists the settings by hand, for editors and for its help, and must not differ from them."""
    parameter = PARAMETERS[name]
    assert (parameter.kind, parameter.default) == (inspect.Parameter.KEYWORD_ONLY, None)
    if name in ("criterion", "objective", "importance", "shape_weights"):  # names, and more than a setting holds
        return
    types = typing.get_type_hints(tracer.render)[name]
    setting = tracer.Settings.model_fields[name].annotation
    assert set(typing.get_args(types)) == {type(None), *(typing.get_args(setting | None))}


def test_objectives_are_those_there_are():
    from tracer.image.objective import OBJECTIVES

    (values, _) = typing.get_args(typing.get_type_hints(tracer.render)["objective"])
    assert set(typing.get_args(values)) == set(OBJECTIVES)


@pytest.mark.parametrize("name", [name for name in PARAMETERS if name != "unknown"])
def test_the_help_explains_every_keyword(name):
    entry = re.search(rf"^    (?:\w+, )?{name}(?:, \w+)?: (.*?)(?=^    \w|^\S|\Z)", HELP, re.DOTALL | re.MULTILINE)
    assert entry, name
    field = tracer.Settings.model_fields.get(name)
    if field is not None and isinstance(field.default, str | float | bool) and name != "spp":
        quoted = f'"{field.default}"' if isinstance(field.default, str) else f"{field.default:g}"
        stated = re.search(r"Default: (.*?)\.\s*$", entry[1])[1]
        assert stated in (quoted, str(field.default)), entry[1]


def test_samples_of_the_scene_are_drawn_where_nothing_says_when_to_stop(cornell):
    scene = cornell()
    for count, expected in ((7, 7), (4, 64)):  # 4 is what Mitsuba takes where a scene says nothing
        scene["sensor"]["sampler"] = {"type": "independent", "sample_count": count}
        assert tracer.render(scene, criterion="uniform").samples.mean() == expected
    scene["sensor"]["sampler"]["sample_count"] = 7
    assert tracer.render(scene, spp=3).samples.mean() == 3
    assert tracer.render(scene, noise=0.5).report.settings.spp == 4096
    scene["integrator"] = {"type": "adaptive", "spp": 5, "nested": {"type": "path"}}
    assert tracer.render(scene).samples.mean() == 5


@pytest.mark.parametrize(
    "given",
    [
        {"size": np.int64(12)},
        {"size": np.array(12)},
        {"size": (np.int32(12), np.uint8(8))},
        {"size": [12, 8]},
        {"crop": (np.int64(1), 2, np.uint16(12), 8)},
        {"size": 12, "spp": np.int64(2), "seed": np.uint32(0), "sensor": np.int64(0), "block": np.int8(1)},
        {"size": 12, "checkpoint_every": np.float32(5), "memory_limit": np.int64(16)},
    ],
)
def test_numbers_of_numpy_are_numbers(cornell, given):
    size = {name: 12 for name in given if name == "size"} or {"crop": (1, 2, 12, 8)}
    expected = tracer.render(cornell(), **{"spp": 2, **size})
    assert np.array_equal(tracer.render(cornell(), **{"spp": 2, **given}).image, expected.image)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"size": True}, r"size: write a whole number \(was True\)"),
        ({"size": 12.5}, r"size: write a whole number \(was 12\.5\)"),
        ({"size": (12,)}, "size: write 2 whole numbers"),
        ({"crop": (1, 2, 3)}, "crop: write 4 whole numbers"),
        ({"sensor": "all"}, r"sensor: write a whole number \(was 'all'\)"),
        ({"sensor": np.int64(3)}, "There is no sensor 3: the scene has 1"),
        ({"progress": True}, "progress: give a function .* \\(was True\\)"),
        ({"spp": True}, r"spp: write a number \(was True\)"),
        ({"noise": 5}, r"noise must be below 1, as it is a part of the brightness: 0\.05 is 5 % \(was 5\)"),
        ({"noise": 2, "objective": "display"}, "part of what a screen shows"),
        ({"spp_max": 4}, r"no setting 'spp_max', did you mean 'max_spp'\?$"),
        ({"memory": 4}, r"no setting 'memory', did you mean 'memory_limit'\?$"),
        ({"memory_limit": "much"}, r"memory_limit: write GiB, more than 0 \(was 'much'\)"),
        ({"checkpoint_every": -1}, "checkpoint_every: write seconds"),
        ({"define": ["a=1"]}, "define: write"),
        ({"resume": True}, "name the checkpoint with checkpoint="),
        ({"importance": [["a"]]}, "importance: must be an image of numbers, not list"),
        ({"criterion": 3}, r"criterion: input should be a valid string \(was 3\)"),
        ({"criterion": lambda evidence: 3, "spp": 16}, r"importance >= 0 .* shape \(16, 24\) \(was int\)"),
        ({"criterion": lambda evidence: np.ones(4), "spp": 16}, r"\(was of shape \(4,\)\)"),
        ({"criterion": lambda evidence: -evidence.wanted, "spp": 16}, "384 of them not >= 0"),
        ({"criterion": lambda evidence: evidence.wanted, "checkpoint": "no.ckpt"}, "cannot tell one function"),
    ],
)
def test_a_mistake_is_one_sentence(cornell, given, message):
    with pytest.raises(SettingsError, match=message) as caught:
        tracer.render(cornell(), **{"spp": 2, **given})
    assert "\n" not in str(caught.value)
    assert "--" not in str(caught.value)


def test_absolute_noise_may_be_any():
    assert tracer.Settings(noise=5, objective="absolute").noise == 5


def test_a_checkpoint_that_exists_is_kept_or_replaced(cornell, tmp_path):
    path = tmp_path / "state.ckpt"
    path.write_text("mine")
    with pytest.raises(OutputError, match=r"exists; choose another name, or overwrite=True to replace it\.$"):
        tracer.render(cornell(), spp=2, checkpoint=path)
    assert path.read_text() == "mine"
    tracer.render(cornell(), spp=2, checkpoint=path, overwrite=True)
    assert tracer.render(cornell(), spp=2, checkpoint=path, resume=True).report.complete


def test_a_criterion_may_be_a_function(cornell):
    def right_half(evidence):
        assert evidence.statistics is not None
        return np.arange(evidence.wanted.shape[1]) * np.ones(evidence.wanted.shape) >= 12

    result = tracer.render(cornell(), spp=32, criterion=right_half)
    assert result.samples[:, 12:].mean() > 3 * result.samples[:, :12].mean()
    assert result.report.settings.criterion.endswith("right_half")
    assert not any("right_half" in name for name in criteria.names())


def test_a_registered_function_is_the_criterion_of_that_name(cornell):
    function = criteria.get("variance").importance
    by_function, by_name = (tracer.render(cornell(), spp=16, criterion=given) for given in (function, "variance"))
    assert by_function.report.settings.criterion == "variance"
    assert np.array_equal(by_function.image, by_name.image)


FILE = """import numpy as np

from tracer.criteria import criterion


@criterion("left_half", needs_radiance=True)
def left_half(evidence):
    return np.where(np.arange(evidence.wanted.shape[1]) < 12, 1.0, 0.0) * np.ones(evidence.wanted.shape)
"""


@pytest.fixture
def criterion_file(tmp_path, monkeypatch):
    """Write a file that defines a criterion, and forget the criterion afterwards."""
    criteria.names()
    monkeypatch.setattr(registry, "registered", dict(registry.registered))
    monkeypatch.setattr(registry, "files", {})

    def write(text=FILE):
        path = tmp_path / "left.py"
        path.write_text(text)
        return path

    return write


def test_a_criterion_may_be_a_file_or_an_object(cornell, criterion_file, tmp_path):
    path = criterion_file()
    by_file = tracer.render(cornell(), spp=32, criterion=path, checkpoint=tmp_path / "state.ckpt")
    assert by_file.samples[:, :12].mean() > 3 * by_file.samples[:, 12:].mean()
    assert by_file.report.settings.criterion == "left_half"
    text = tracer.render(cornell(), spp=32, criterion=str(path))
    own = criteria.Criterion("fused", criteria.get("left_half").importance, needs_radiance=True, spends="share")
    by_object = tracer.render(cornell(), spp=32, criterion=own)
    assert np.array_equal(by_file.image, text.image)
    assert np.array_equal(by_file.image, by_object.image)
    assert by_object.report.settings.criterion == "criterion fused"
    assert criteria.get("fused").is_built_in


@pytest.mark.parametrize(
    ("code", "message"),
    [
        (FILE.replace("import criterion", "import kriterion"), r"left\.py', line 3: ImportError: cannot import name"),
        (FILE.replace("):\n", ")\n"), r"left\.py', line 7: SyntaxError: expected ':'\.$"),
        (FILE.replace('"left_half"', '"fused"'), r"line 6: ValueError: there is a criterion 'fused' already"),
        (FILE.replace("shape)", "size)"), r"line 8: ValueError: operands could not be broadcast"),
        (FILE.replace("    return np", "    return nq"), r"left\.py', line 8: NameError: name 'nq' is not defined\.$"),
        (
            FILE.replace("@criterion", "# criterion"),
            r"defines no criterion: write @tracer\.criteria\.criterion\(\"left",
        ),
        (FILE + FILE[FILE.index("@") :].replace('"left', '"right'), "defines 2 criteria, left_half, right_half"),
    ],
)
def test_a_mistake_in_a_file_is_one_sentence(cornell, criterion_file, code, message):
    with pytest.raises(SettingsError, match=message) as caught:
        tracer.render(cornell(), spp=32, criterion=criterion_file(code))
    assert "\n" not in str(caught.value)


def test_a_file_that_was_changed_is_read_anew(cornell, criterion_file):
    tracer.render(cornell(), spp=32, criterion=criterion_file())
    changed = FILE.replace("1.0, 0.0", "0.00, 1.0").replace('"left_half"', '"right_half"')
    result = tracer.render(cornell(), spp=32, criterion=criterion_file(changed))
    assert result.samples[:, 12:].mean() > 3 * result.samples[:, :12].mean()
    assert "left_half" not in criteria.names()


def test_a_scaled_importance_is_noted_once(cornell, tmp_path):
    path = tmp_path / "state.ckpt"
    for resume in (False, True):
        notes = tracer.render(cornell(), spp=2, importance=np.ones((5, 7)), checkpoint=path, resume=resume).report.notes
        assert len(set(notes)) == len(notes)
        scaled = [note for note in notes if "importance" in note]
        assert scaled == ["The importance is 7 x 5 pixels and the picture 24 x 16: it was scaled."]
    assert not any(
        "scaled" in note for note in tracer.render(cornell(), spp=2, importance=np.ones((16, 24))).report.notes
    )


def test_a_scene_without_an_emitter_says_so_once(cornell):
    scene = cornell()
    del scene["light"]
    notes = tracer.render(scene, spp=16).report.notes
    assert sum("no emitter" in note for note in notes) == 1
    assert not any("no emitter" in note for note in tracer.render(scene, spp=2, integrator="depth").report.notes)
    assert not any("no emitter" in note for note in tracer.render(cornell(), spp=2).report.notes)


def test_what_another_variant_has_loaded_is_refused(cornell):
    try:
        tracer.activate("llvm_ad_mono")
        other, integrator = mi.load_dict(cornell()), mi.load_dict({"type": "path"})
        sensor = other.sensors()[0]
    finally:
        tracer.activate("llvm_ad_rgb")
    for what, scene, given in (
        ("scene", other, {}),
        ("integrator", cornell(), {"integrator": integrator}),
        ("sensor", cornell(), {"sensor": sensor}),
    ):
        with pytest.raises(BackendError, match=f"The {what} was loaded under the variant 'llvm_ad_mono'"):
            tracer.render(scene, spp=1, **given)
