"""Plans: what is in them, and a mistake told with its line."""

from pathlib import Path

import pytest

from tracer.errors import SettingsError
from tracer.settings import Settings
from tracer.study.bundled import find_plan, names
from tracer.study.plan import Budget, MethodPlan, make_plan, parse_plan, read_plan
from tracer.study.toml_location import Origin, find_line

PLAN = """\
name = "mine"            # line 1
size = 32
spp = [
  8,
  16,
]
seconds = [0.5]
seeds = 2

[[scenes]]
bundled = "thin_rods"    # line 11

[[scenes]]
path = "rooms/*.xml"     # line 14

[[methods]]
name = "uniform"         # line 17
criterion = "uniform"

[[methods]]
name = "wide"
criterion = "fused"      # line 22
min_spp = 2

[[methods]]
name = "stock"           # line 26
sampler = "multijitter"
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "rooms").mkdir()
    for name in ("a", "b"):
        (tmp_path / "rooms" / f"{name}.xml").write_text("<scene version='3.0.0'/>")
    return tmp_path


def parsed(text, folder):
    return parse_plan(text, Origin("mine.toml", text), folder, None)


def test_a_plan(folder):
    (folder / "mine.toml").write_text(PLAN)
    plan = read_plan(folder / "mine.toml")
    scenes = plan.find_scenes()
    assert [scene.name for scene in scenes] == ["thin_rods", "a", "b"]
    assert {scene.setting.size for scene in scenes} == {32}
    assert scenes[1].setting.source == folder / "rooms" / "a.xml"
    assert plan.budgets == [Budget("spp", 8), Budget("spp", 16), Budget("seconds", 0.5)]
    assert [budget.label for budget in plan.budgets] == ["8 spp", "16 spp", "0.5 s"]
    assert plan.compared_with == "uniform"
    assert plan.methods[1].settings()["min_spp"] == 2


MISTAKES = [
    ("  16,", "  0,", 5, "a budget must be above 0 (was 0)"),
    ("[0.5]", "[-1]", 7, "a budget must be above 0 (was -1)"),
    ("  16,", "  1.5,", 5, "spp: input should be a valid integer"),
    ("  16,", "  8,", 4, "the budget 8 is there twice"),
    ("[0.5]", "[inf]", 7, "a budget must be above 0 (was inf)"),
    ("seeds = 2", "seeds = 2\nfirst_seed = 4294967296", 9, "first_seed: input should be less than"),
    ("rooms/*.xml", "/**b/*.xml", 14, "there is no scene file"),
    ("rooms/*.xml", "", 14, "path: string should have at least 1 character"),
    ("seeds = 2", "seeds = 0", 8, "seeds: input should be greater"),
    ("seeds = 2", "sedes = 2", 8, "did you mean 'seeds'?"),
    ('"thin_rods"', '"thin_rod"', 11, "did you mean 'thin_rods'?"),
    ("rooms/", "roms/", 14, "there is no scene file"),
    ("path =", "pth =", 14, "did you mean 'path'?"),
    ('path = "rooms/*.xml"', 'path = "rooms/*.xml"\nname = "one"', 13, "finds 2 scenes"),
    ('path = "rooms/*.xml"', "", 13, "needs either a path"),
    ('"wide"', '"uniform"', 21, "two methods are named 'uniform'"),
    ('"fused"', '"fusd"', 22, "there is no criterion 'fusd', did you mean 'fused'?"),
    ("min_spp = 2", "min_spp = 9", 23, "min_spp (9) must not exceed spp (8)"),
    ("min_spp = 2", "min_sp = 2", 23, "did you mean 'min_spp'?"),
    ("min_spp = 2", 'objective = "nice"', 23, "there is no objective 'nice'"),
    ('sampler = "multijitter"', 'criterion = "fused"\nsampler = "stratified"', 25, "either a criterion"),
    ('sampler = "multijitter"', 'sampler = "stratified"\nblock = 2', 28, "has no setting 'block'"),
    ("seeds = 2", 'baseline = "best"', 8, "there is no method 'best'"),
    ('name = "wide"', 'name = "../wide"', 21, "name: string should match"),
]


@pytest.mark.parametrize(("before", "after", "line", "message"), MISTAKES)
def test_a_mistake_is_told_with_its_line(folder, before, after, line, message):
    text = PLAN.replace(before, after, 1)
    assert text != PLAN
    with pytest.raises(SettingsError) as caught:
        parsed(text, folder).find_scenes()
    assert str(caught.value).startswith(f"mine.toml, line {line}: ")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_mistakes_without_a_line(folder):
    with pytest.raises(SettingsError, match=r"mine.toml is not TOML.*line 1"):
        parsed("name = x", folder)
    with pytest.raises(SettingsError, match=r"^mine.toml: the setting 'name' is missing\.$"):
        parsed(PLAN.replace('name = "mine"', "", 1), folder)
    start, end = PLAN.index("spp = ["), PLAN.index("seeds")
    with pytest.raises(SettingsError, match=r"^mine.toml: there is no budget"):
        parsed(PLAN[:start] + PLAN[end:], folder)
    with pytest.raises(SettingsError, match=r"^methods\.0\.criterion: there is no criterion 'no'"):
        make_plan(
            {
                "name": "x",
                "spp": [4],
                "scenes": [{"bundled": "*"}],
                "methods": [{"name": "a", "criterion": "no"}],
            }
        )
    with pytest.raises(SettingsError, match=r"Cannot read '.*no.toml'"):
        read_plan(folder / "no.toml")


def test_two_scenes_of_one_name(folder):
    (folder / "a.xml").write_text("<scene version='3.0.0'/>")
    text = PLAN.replace("[[methods]]", '[[scenes]]\npath = "a.xml"\n\n[[methods]]', 1)
    with pytest.raises(SettingsError, match=r"line 16: two scenes are named 'a'"):
        parsed(text, folder).find_scenes()


def test_lines():
    text = '[a]\nb.c = 1\n"d e" = [\n 1,\n 10, # ten\n]\n[[f]]\n[[f]]\ng = 2 # f\n'
    assert find_line(text, ("a", "b", "c")) == 2
    assert find_line(text, ("a", "d e", 1), 10) == 5
    assert find_line(text, ("a", "d e", 0), 1) == 4
    assert find_line(text, ("f", 1, "g")) == 9
    assert find_line(text, ("f", 0, "g")) == 7
    assert find_line(text, ("a", "missing")) == 1
    assert find_line(text, ("missing",)) is None


def test_studies_that_come_along():
    assert {"smoke", "standard", "public"} <= set(names())
    for name in names():
        plan = find_plan(name, Path())
        assert plan.name == name
        assert plan.compared_with == ("mi.render + OIDN" if name == "denoise" else "uniform")
    assert len(find_plan("standard").find_scenes()) == 11
    with pytest.raises(SettingsError, match="did you mean 'standard'"):
        find_plan("standrd")
    with pytest.raises(SettingsError, match="needs the folder of its scenes"):
        find_plan("public")
    with pytest.raises(SettingsError, match="There is no folder 'nowhere'"):
        find_plan("public", Path("nowhere"))


def test_budgets_in_seconds_keep_to_the_bounds_of_a_method():
    values = {"name": "x", "seconds": [1.0], "scenes": [{"bundled": "*"}]}
    for bounds in ({"min_spp": 128}, {"max_spp": 8}, {"pilot_spp": 40}):
        make_plan({**values, "methods": [{"name": "a", "criterion": "fused", **bounds}]})
    with pytest.raises(SettingsError, match="min_spp"):
        make_plan({**values, "methods": [{"name": "a", "criterion": "fused", "min_spp": 9, "max_spp": 8}]})


def test_a_method_of_a_study_is_what_a_render_with_the_same_words_is():
    plain = MethodPlan(name="x", criterion="fused").settings()
    assert plain.pop("guide") is False  # criteria are compared with each other, and with uniform samples
    for name, value in plain.items():
        assert value == Settings.model_fields[name].get_default(call_default_factory=True), name
    assert MethodPlan(name="x", criterion="fused", guide="auto").settings()["guide"] is None
    for name in names():
        methods = [method.model_dump_json(exclude={"name"}) for method in find_plan(name, Path()).methods]
        assert len(set(methods)) == len(methods)
