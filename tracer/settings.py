"""What a person can choose about a render, checked before anything is traced."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator
from pydantic_core import PydanticCustomError

from tracer import criteria
from tracer.core.plain_values import plain
from tracer.core.suggest import did_you_mean, known
from tracer.errors import SettingsError
from tracer.image.objective import OBJECTIVES

MOST_PILOT_RAYS = 16
"""Most pilot rays per pixel: more would tell nothing new."""
UNBIASED_SHARE = 32
"""In an unbiased render, samples that decide and are then thrown away are drawn in two rounds of spp / UNBIASED_SHARE.
Where that is less than one sample they cost more than they gain: the render is uniform, unless pilot_spp is set."""


MOST_SPP = 2**24
"""Most mean samples per pixel that a person may ask for."""
OPEN_SPP = {"noise": 4096, "time": 65536}
"""Bound on the mean samples per pixel where only a noise target, or only a time, is given."""
MOST_WEIGHT = 1e6
"""Largest weight of a shape: beyond it float32 would lose the importance of everything else."""


class Settings(BaseModel):
    """Settings of a render, checked: keywords of ``tracer.render``, with defaults. A result's report has those it used.

    The parameters of the plugin ``adaptive`` have the same names. ``tracer.render`` raises SettingsError for values
    that are out of range; this class itself raises ``pydantic.ValidationError``.

    Example:

    >>> import tracer
    >>> tracer.Settings(noise=0.05).spp  # beside a noise target it is a bound
    4096
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    spp: int = Field(64, ge=1, le=MOST_SPP)
    """Mean samples per pixel: the budget, pilot included. With ``noise`` or ``time`` a bound: 4096 or 65536 if None."""
    noise: float | None = Field(None, gt=0, le=1e6)
    """Stop when ``noise_share`` of the pixels are estimated to be off by at most this: by this part of their brightness
    if the objective is relative (see ``tracer.adaptive.convergence``)."""
    noise_share: float = Field(0.95, gt=0, lt=1)
    """Share of the pixels for which ``noise`` is to hold."""
    time: float | None = Field(None, gt=0, le=1e9)
    """Stop in time to be done after this many seconds, start-up included. Every pixel gets a sample in any case."""
    seed: int = Field(0, ge=0, lt=2**32)
    """Seed of all random numbers; the same seed gives the same picture."""
    criterion: str = "fused"
    """Rule that decides where samples go, a name of ``tracer.criteria``; "uniform" gives all pixels the same."""
    objective: str = "relative"
    """Which error is to be minimised: absolute, relative or display. Relative suits the eye, which sees ratios, and
    pictures of high dynamic range, whose exposure is chosen later; display suits pictures whose exposure is known."""
    exposure: float = Field(0.0, ge=-64, le=64)
    """Stops by which the picture will be brightened before it is looked at: what is too dark or clips needs less. The
    noise target of every objective is that of the brightened picture."""
    pilot_spp: int | None = Field(None, ge=1)
    """Pilot rays per pixel, and samples per pixel of the first round. None: 4, or 2 to 8 when unbiased; criteria that
    share out samples by deviation begin with 8 samples, see ``tracer.adaptive.schedule``."""
    min_spp: int | None = Field(None, ge=1)
    """Least samples of any pixel. None: an eighth of spp."""
    max_spp: int | None = Field(None, ge=1)
    """Most samples of any pixel. None: 32 times spp."""
    cost: Literal["none", "root", "work"] = "root"
    """What the allocation takes a sample to cost: the same everywhere (none), so that most is gained with the same
    number of samples; the work of its path (work, see ``tracer.sampling.work``), so that most is gained in the same
    time, where errors fall as 1 / n; or the root of that (root), which is between both. ``tracer study rules`` compares
    them."""
    importance: str | None = None
    """Image file whose values multiply the importance of each pixel: a mask or weights, scaled to the picture."""
    shape_weights: dict[str, float] = Field(default_factory=dict)
    """Factors of the importance where shapes are seen, by ``tracer.scene.shape_names``; or "lamp=4, floor=0.5"."""
    block: int = Field(1, ge=1, le=64)
    """Side in pixels of the squares over which the complexity of IDs is measured."""

    guide: bool | None = None
    """Whether to learn which lights matter where before the first sample, in scenes with the integrator ``path``. None:
    where it may pay, and little is lost if it does not; and where the scene asks for the integrator ``guided``."""
    unbiased: bool = False
    """Whether the samples that decide are left out of the picture; they count towards spp in any case."""

    @model_validator(mode="before")
    @classmethod
    def open_ended(cls, values: Any) -> Any:
        """Set the bound of OPEN_SPP if a noise target or a time, but no number of samples, is given."""
        if isinstance(values, dict) and values.get("spp") is None:
            limit = next((name for name in OPEN_SPP if values.get(name) is not None), None)
            values = {name: value for name, value in values.items() if name != "spp"}
            return {**values, "spp": OPEN_SPP[limit]} if limit else values
        return values

    @field_validator("spp", "noise", "noise_share", "time", "seed", "exposure", "block", mode="before")
    @classmethod
    def number_is_no_switch(cls, value: Any) -> Any:
        """Reject True and False, which Python takes for 1 and 0."""
        if isinstance(plain(value), bool):
            raise PydanticCustomError("switch", "write a number")
        return value

    @field_validator("pilot_spp", "min_spp", "max_spp", mode="before")
    @classmethod
    def bound_is_no_switch(cls, value: Any) -> Any:
        """Reject True and False for a number that may be None."""
        return cls.number_is_no_switch(value)

    @field_validator("shape_weights", mode="before")
    @classmethod
    def weights_from_text(cls, value: Any) -> Any:
        """Read weights from text such as "lamp=4, floor=0.5" or from a dictionary; shapes may be given by number."""
        if isinstance(value, Mapping):
            return {str(plain(name)): weight for name, weight in value.items()}
        if not isinstance(value, str):
            return value
        pairs = [entry.rpartition("=") for entry in value.split(",") if entry.strip()]
        if not all(name.strip() for name, _, _ in pairs):
            raise ValueError(f'shape_weights: write "lamp=4, floor=0.5" (was {value!r})')
        return {name.strip(): weight.strip() for name, _, weight in pairs}

    @field_validator("shape_weights")
    @classmethod
    def weights_are_weights(cls, weights: dict[str, float]) -> dict[str, float]:
        """Reject a weight that is negative, too large, or not a number."""
        for name, weight in weights.items():
            if not 0 <= weight <= MOST_WEIGHT:
                raise ValueError(f"shape_weights: the weight of '{name}' must be 0 to {MOST_WEIGHT:g} (was {weight:g})")
        return weights

    @field_validator("criterion")
    @classmethod
    def known_criterion(cls, name: str) -> str:
        """Reject a criterion that is not registered."""
        return name if criteria.is_function(name) else known(name, "criterion", criteria.names())

    @field_validator("objective")
    @classmethod
    def known_objective(cls, name: str) -> str:
        """Reject an objective that does not exist."""
        return known(name, "objective", list(OBJECTIVES))

    @model_validator(mode="after")
    def bounds_hold(self) -> Settings:
        """Reject bounds that no allocation of the budget can meet."""
        if self.min_spp is not None and self.min_spp > self.spp:
            raise ValueError(f"min_spp ({self.min_spp}) must not exceed spp ({self.spp})")
        if self.max_spp is not None and self.max_spp < self.spp:
            raise ValueError(f"max_spp ({self.max_spp}) must not be below spp ({self.spp})")
        if self.pilot_spp is not None and self.pilot_spp > self.spp:
            raise ValueError(f"pilot_spp ({self.pilot_spp}) must not exceed spp ({self.spp})")
        if self.unbiased and self.is_open:
            name = "noise" if self.noise is not None else "time"
            raise ValueError(f"{name} cannot be combined with unbiased, which must know its samples beforehand")
        if self.noise is not None and self.noise >= 1 and self.objective != "absolute":
            quantity = "what a screen shows" if self.objective == "display" else "the brightness"
            raise ValueError(f"noise must be below 1, as it is a part of {quantity}: 0.05 is 5 % (was {self.noise:g})")
        spp_left = self.spp - 2 * self.pilot_samples
        if self.unbiased and not self.too_small and self.min_spp is not None and self.min_spp > spp_left:
            raise ValueError(
                f"min_spp ({self.min_spp}) must not exceed the {spp_left} of {self.spp} spp left when unbiased"
            )
        return self

    @property
    def is_open(self) -> bool:
        """Whether a noise target or a time may end the render before its samples are spent."""
        return self.noise is not None or self.time is not None

    @property
    def pilot_samples(self) -> int:
        """Samples per pixel of the first round of a criterion that learns from radiance."""
        if self.unbiased:
            return self.pilot_spp or min(max(self.spp // UNBIASED_SHARE, 2), 8)
        return self.pilot_spp or min(self.spp, 4)

    @property
    def too_small(self) -> bool:
        """Whether the budget leaves nothing to decide after the first samples, from which a criterion learns."""
        if self.unbiased:
            return self.spp < UNBIASED_SHARE if self.pilot_spp is None else self.spp <= 2 * self.pilot_samples
        return self.spp < 2 * self.pilot_samples

    @property
    def pilot_rays(self) -> int:
        """Pilot rays per pixel, 2 to MOST_PILOT_RAYS: a single ray hits only one thing, and so shows no difference."""
        return min(max(self.pilot_spp or 4, 2), MOST_PILOT_RAYS)

    @property
    def least_samples(self) -> int:
        """Least samples of any pixel."""
        return self.min_spp or max(1, self.spp // 8)

    @property
    def most_samples(self) -> int:
        """Most samples of any pixel."""
        return self.max_spp or 32 * self.spp


def make_settings(**values: Any) -> Settings:
    """Return checked settings. Raises SettingsError with one sentence that names the setting."""
    try:
        return Settings(**values)
    except ValidationError as error:
        raise SettingsError(in_one_sentence(error)) from None


def in_one_sentence(error: ValidationError, fields: list[str] | None = None) -> str:
    """Return all of pydantic's complaints as one sentence; ``fields``: as for ``explain``."""
    text = "; ".join(explain(detail, fields) for detail in error.errors())
    return text if text.endswith("?") else f"{text}."


def check_settings(**values: Any) -> None:
    """Check settings that may lack spp and objective; what depends on these is checked when they are known.

    Raises SettingsError.
    """
    if "spp" not in values:
        lower_bounds = [values.get(name) for name in ("min_spp", "pilot_spp")]
        values["spp"] = max([1, *(int(text) for bound in lower_bounds if (text := str(bound)).isdecimal())])
        values["unbiased"] = False
    values.setdefault("objective", "absolute")  # the scene may set another; with this one any noise target is valid
    make_settings(**values)


def explain(detail: Any, fields: list[str] | None = None) -> str:
    """Return one of pydantic's complaints as a clause that names the setting, the rule and the value.

    ``fields``: the names that exist; None: those of Settings.
    """
    name = ".".join(str(part) for part in detail["loc"])
    if detail["type"] == "missing":
        return f"the setting '{name}' is missing"
    if detail["type"] == "extra_forbidden":
        known_names = list(Settings.model_fields) if fields is None else fields
        return f"there is no setting '{name}'{did_you_mean(name, known_names, otherwise='')}"
    message = detail["msg"].removeprefix("Value error, ")
    if detail["type"] == "value_error":
        return message
    return f"{name}: {message[0].lower()}{message[1:]} (was {detail['input']!r})"
