"""What a study measures: scenes x methods x budgets x seeds, as a TOML file or from Python."""

from __future__ import annotations

import glob
import itertools
import tomllib
from dataclasses import dataclass
from importlib.resources import files as package_files
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, ValidationError, field_validator

from tracer import criteria
from tracer.core.suggest import unknown
from tracer.errors import SettingsError
from tracer.settings import Settings, explain
from tracer.study.methods import Setting
from tracer.study.toml_location import Location, Origin

NAME = r"^[A-Za-z0-9][\w.+() -]*$"
"""Pattern that the names of studies, scenes and methods must match, as folders are named after them."""
STOCK_KEYS = {"name", "sampler", "objective", "denoise"}
"""Keys that a method by plain ``mi.render`` may have; its ``objective`` says by which error it is compared."""
ORACLE_KEYS = {"name", "oracle", "objective"}
"""Keys that a method by an oracle may have."""
NO_BOUND = 2**24
"""Most samples of a pixel that an oracle may allocate: so many that this never limits an allocation."""


class PlanPart(BaseModel):
    """Base of all parts of a plan: unknown keys are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class ScenePlan(PlanPart):
    """One scene, or all scenes whose files match a pattern."""

    path: str | None = Field(None, min_length=1)
    """Scene file, relative to the plan's ``folder``; a pattern such as "*/scene.xml" stands for all matching files."""
    bundled: str | None = None
    """Name of a scene that comes with tracer, or "*" for all of them; given instead of ``path``."""
    name: str | None = Field(None, pattern=NAME)
    """Name of the scene. None: the name of the file, or of its folder where the file is just ``scene.xml``."""
    size: int | tuple[int, int] | None = None
    """Width in pixels, or [width, height]. None: the plan's ``size``."""
    sensor: int = Field(0, ge=0)
    """Number of the sensor in the scene, from 0."""
    integrator: str | None = None
    """Plugin that takes the place of the scene's integrator."""


class MethodPlan(PlanPart):
    """One way to render: our loop with a ``criterion``, plain ``mi.render`` with a ``sampler``, or an ``oracle``."""

    name: str = Field(pattern=NAME)
    criterion: str | None = None
    """Name of the criterion in ``tracer.criteria`` that says where samples go; "uniform" gives every pixel the same."""
    sampler: str | None = None
    """Plugin that takes the place of the scene's sampler under ``mi.render``."""
    oracle: Literal["samples", "time"] | None = None
    """The best allocation there is, from the error of every pixel measured beforehand: of the samples of the budget, or
    of the time that these samples take when uniform."""
    objective: str = "relative"
    exposure: float = 0.0
    pilot_spp: int | None = None
    min_spp: int | None = None
    max_spp: int | None = None
    cost: Literal["none", "root", "work"] = "root"
    block: int = 1
    guide: bool | None = False
    """As for ``tracer.render``, but unless it is asked for, lights are chosen as Mitsuba does: methods differ in what
    they are named for and in nothing else. "auto", or None: learned where it may pay, as by default of
    ``tracer.render``."""
    unbiased: bool = False
    denoise: bool = False
    """Whether the picture is denoised before it is scored: by our denoising, or for ``mi.render`` by Open Image Denoise
    with the albedo and normal of Mitsuba's ``aov``."""

    @field_validator("guide", mode="before")
    @classmethod
    def automatic_guide(cls, guide: Any) -> Any:
        """Return None for "auto": TOML has no word for None."""
        return None if guide == "auto" else guide

    def settings(self) -> dict[str, Any]:
        """Return the keyword arguments of ``tracer.render`` that make it render by this method."""
        keywords = self.model_dump(exclude={"name", "sampler", "oracle", "denoise"})
        return (
            keywords if self.oracle is None else keywords | {"criterion": "uniform", "min_spp": 1, "max_spp": NO_BOUND}
        )


@dataclass(frozen=True)
class Budget:
    """How much a method may spend."""

    kind: Literal["spp", "seconds"]
    amount: float

    @property
    def label(self) -> str:
        """Name of the budget in messages, tables and file names, for example "64 spp"."""
        return f"{self.amount:.12g} {'spp' if self.kind == 'spp' else 's'}"


@dataclass(frozen=True)
class Scene:
    """A scene file that was found, and what it is rendered with."""

    name: str
    setting: Setting
    location: Location
    """Where its entry stands in the plan."""


class Plan(PlanPart):
    """What a study measures. Every field may stand in the TOML file under the same name."""

    name: str = Field(pattern=NAME)
    about: str = ""
    """A sentence or two for the head of the page."""
    folder: str | None = None
    """Folder in which scenes are looked for. None: the folder of the TOML file, or the working folder."""
    size: int | tuple[int, int] | None = None
    """Width in pixels (the aspect is kept) or [width, height]. None: the size of the scene's film."""
    spp: list[int] = []
    """Budgets in samples per pixel."""
    seconds: list[float] = []
    """Budgets in seconds."""
    seeds: int = Field(5, ge=1, le=2**16)
    """Number of seeds, each of which gives one picture of every scene, method and budget."""
    first_seed: int = Field(0, ge=0, lt=2**32 - 2**16)
    criteria: list[str] = []
    """Python files with criteria that do not come with tracer; relative paths start at the folder of the TOML file."""
    metrics: list[str] = []
    """Python files with metrics, functions of a picture and its reference; paths as for ``criteria``."""
    baseline: str | None = None
    """Method that the others are compared with. None: the method named "uniform" if there is one, else the first."""
    reference_spp: int = Field(65536, ge=16)
    """Most samples per pixel of a reference."""
    page_size: int | None = Field(None, ge=16)
    """Most pixels across of the pictures on the page: larger ones are averaged over squares of pixels."""
    scenes: list[ScenePlan] = Field(min_length=1)
    methods: list[MethodPlan] = Field(min_length=1)

    _origin: Origin = PrivateAttr(default=Origin())
    _base: Path | None = PrivateAttr(default=None)

    @property
    def origin(self) -> Origin:
        """Where the plan comes from: an error names the place of a mistake in it."""
        return self._origin

    @property
    def base(self) -> Path:
        """Folder that relative paths of Python files start at."""
        return self._base or Path()

    @property
    def budgets(self) -> list[Budget]:
        """All budgets, those in samples first."""
        return [*(Budget("spp", spp) for spp in self.spp), *(Budget("seconds", seconds) for seconds in self.seconds)]

    @property
    def all_seeds(self) -> range:
        """The seeds of every method and budget."""
        return range(self.first_seed, self.first_seed + self.seeds)

    @property
    def compared_with(self) -> str:
        """Name of the baseline."""
        names = [method.name for method in self.methods]
        return self.baseline or ("uniform" if "uniform" in names else names[0])

    def find_scenes(self) -> list[Scene]:
        """Return all scenes. Raises SettingsError for a pattern that matches no file, or two scenes of one name."""
        scenes = [scene for k, entry in enumerate(self.scenes) for scene in self.matching(entry, ("scenes", k))]
        for first, second in itertools.combinations(scenes, 2):
            if first.name == second.name:
                message = f"two scenes are named '{second.name}'; give one of them another name"
                raise self.origin.fault(message, second.location)
        return scenes

    def matching(self, entry: ScenePlan, location: Location) -> list[Scene]:
        """Return the scenes that an entry stands for. Raises SettingsError if there are none, or many but one name."""
        pattern = entry.path or f"{entry.bundled}.xml"
        folder = self.scene_folder if entry.path else Path(str(package_files("tracer.scenes")))
        target = folder / pattern
        paths = [target] if target.is_file() else sorted(map(Path, glob.glob(str(target), recursive=True)))
        paths = [path for path in paths if path.is_file()]
        key = "path" if entry.path else "bundled"
        if not paths:
            message = f"there is no scene file '{target}'"
            if entry.bundled:
                message = unknown("bundled scene", entry.bundled, sorted(path.stem for path in folder.glob("*.xml")))
            raise self.origin.fault(message, (*location, key), getattr(entry, key))
        if entry.name is not None and len(paths) > 1:
            raise self.origin.fault(f"'{pattern}' finds {len(paths)} scenes, so it cannot have one name", location)
        size = self.size if entry.size is None else entry.size
        return [
            Scene(entry.name or scene_name(path), Setting(path, entry.sensor, entry.integrator, size), location)
            for path in paths
        ]

    @property
    def scene_folder(self) -> Path:
        """Folder that relative paths of scene files start at."""
        return self.base if self.folder is None else self.base / self.folder


def scene_name(path: Path) -> str:
    """Return the name of a scene: that of its file, or of its folder where the file is just ``scene.xml``."""
    return path.resolve().parent.name if path.stem == "scene" else path.stem


def read_plan(path: Path, folder: Path | None = None) -> Plan:
    """Return the plan in a TOML file; ``folder`` replaces the folder it names.

    Raises SettingsError, with the line, for a file that cannot be read or has a mistake. ``make_plan``, which is given
    the same as a dictionary, has an example.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"Cannot read '{path}': {getattr(error, 'strerror', None) or error}.") from None
    return parse_plan(text, Origin(path.name, text), path.resolve().parent, folder)


def parse_plan(text: str, origin: Origin, base: Path, folder: Path | None) -> Plan:
    """Return the plan that a TOML text describes. Raises SettingsError with the line.

    ``base``: folder that relative paths start at; ``folder``, if given, replaces the folder that the text names.
    """
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SettingsError(f"{origin.name} is not TOML: {error}.") from None
    if folder is not None:
        values["folder"] = str(folder.resolve())
    return make_plan(values, origin, base)


def make_plan(values: dict[str, Any], origin: Origin | None = None, base: Path | None = None) -> Plan:
    """Return a plan with these values, checked as far as is possible without opening scenes.

    ``values``: what a study's TOML file would have, as a dictionary. ``origin``: what messages say of where they come
    from; None: they name the key alone. ``base``: folder that relative paths start at; None: the working folder. Raises
    SettingsError, in one sentence, for a mistake in the values.

    Example::

        from tracer.study.plan import make_plan

        methods = [{"name": name, "criterion": name} for name in ("uniform", "fused")]
        plan = make_plan({"name": "mine", "spp": [16, 64], "scenes": [{"bundled": "*"}], "methods": methods})
        [scene.name for scene in plan.find_scenes()]
    """
    origin = origin or Origin()
    try:
        plan = Plan(**values)
    except ValidationError as error:
        # A misspelt name is both unknown and missing: the line of the misspelling helps more.
        detail = min(error.errors(), key=lambda candidate: candidate["type"] != "extra_forbidden")
        location = tuple(part for part in detail["loc"] if part not in ("int", "tuple[int, int]"))
        name = next((part for part in reversed(location) if isinstance(part, str)), "")
        message = explain({**detail, "loc": (name,)}, fields_at(location))
        raise origin.fault(message, location, detail.get("input")) from None
    plan._origin, plan._base = origin, base
    import_criteria(plan)
    check_plan(plan)
    return plan


def import_criteria(plan: Plan) -> None:
    """Run the Python files with criteria that a plan names. Raises SettingsError for one that is missing or fails."""
    for k, name in enumerate(plan.criteria):
        path = plan.base / name
        if not path.is_file():
            raise plan.origin.fault(f"there is no file '{path}'", ("criteria", k), name)
        try:
            criteria.import_file(path)
        except SettingsError as error:
            raise plan.origin.fault(str(error), ("criteria", k), name) from None


def fields_at(location: Location) -> list[str]:
    """Return the names of the fields that the plan, or its table of a scene or method, has at ``location``."""
    models: dict[str, type[PlanPart]] = {"scenes": ScenePlan, "methods": MethodPlan}
    return list((models.get(str(location[0]), Plan) if len(location) > 1 else Plan).model_fields)


def check_plan(plan: Plan) -> None:
    """Raise SettingsError for a mistake that no field shows by itself."""
    fault = plan.origin.fault
    names = [method.name for method in plan.methods]
    for k, entry in enumerate(plan.scenes):
        if (entry.path is None) == (entry.bundled is None):
            raise fault("a scene needs either a path or the name of a bundled scene", ("scenes", k))
    if not plan.budgets:
        raise fault("there is no budget; add spp = [16, 64] or seconds = [1, 10]")
    for kind, amounts in (("spp", plan.spp), ("seconds", plan.seconds)):
        for k, amount in enumerate(amounts):
            if not 0 < amount < float("inf"):
                raise fault(f"a budget must be above 0 (was {amount:g})", (kind, k), f"{amount:g}")
            if amount in amounts[:k]:
                raise fault(f"the budget {amount:g} is there twice", (kind, k), f"{amount:g}")
    for k, method in enumerate(plan.methods):
        if method.name in names[:k]:
            raise fault(f"two methods are named '{method.name}'; give one of them another name", ("methods", k, "name"))
        check_method(plan, method, ("methods", k))
    if plan.baseline is not None and plan.baseline not in names:
        raise fault(unknown("method", plan.baseline, names), ("baseline",))


def check_method(plan: Plan, method: MethodPlan, location: Location) -> None:
    """Raise SettingsError for a method that cannot render with every budget."""
    fault = plan.origin.fault
    if sum(choice is not None for choice in (method.criterion, method.sampler, method.oracle)) != 1:
        raise fault(
            f"method '{method.name}' needs either a criterion (ours), a sampler (plain mi.render) or an oracle",
            location,
        )
    if method.oracle is not None and method.model_fields_set - ORACLE_KEYS:
        unknown_key = min(method.model_fields_set - ORACLE_KEYS)
        raise fault(f"an oracle (method '{method.name}') has no setting '{unknown_key}'", (*location, unknown_key))
    if method.sampler is not None:
        wrong_key = next((key for key in method.model_fields_set - STOCK_KEYS), None)
        if wrong_key is not None:
            raise fault(
                f"plain mi.render (method '{method.name}') has no setting '{wrong_key}'", (*location, wrong_key)
            )
        return
    # Samples for a budget in seconds keep within the method's bounds: settings are checked with a number within them.
    allowed_spp = method.max_spp or max(3 * (method.pilot_spp or 1), method.min_spp or 1, 64)
    for spp in plan.spp or [allowed_spp]:
        try:
            Settings(spp=spp, **method.settings())
        except ValidationError as error:
            detail = error.errors()[0]
            message = explain(detail)
            key = next((name for name in method.model_fields_set if name in message), "")
            raise fault(message, (*location, key)) from None
