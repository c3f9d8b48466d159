"""A job: one scene file and all pictures to be rendered of it, by frames and sensors."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from tracer import criteria
from tracer.core.own_code import FILE_ENDING
from tracer.core.suggest import did_you_mean
from tracer.errors import OutputError, SettingsError
from tracer.io import atomic
from tracer.scene.loaded import LoadedScene
from tracer.session.request import EVERY_SECONDS, PictureFile, Request, checkpoint_file
from tracer.session.shards import parse_part
from tracer.settings import Settings, in_one_sentence

NUMBER = "#"
"""In the path of a scene or the name of a picture, a run of this sign stands for the number of the frame, with at least
as many digits."""


class Job(BaseModel):
    """What is rendered and how, and the files to write.

    The names of the fields are those of the options on the command line and of the entries of a configuration file.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    scene: Path
    """Scene file, whose name may hold the number of the frame."""
    output: Path | None = None
    """Picture to write; it may be left out if the checkpoint of a part is written."""
    sensor: tuple[int, ...] | Literal["all"] = (0,)
    """Numbers of the scene's sensors."""
    size: int | None = Field(None, ge=1)
    """Width of the picture in pixels, instead of the scene's; the aspect is kept."""
    crop: tuple[int, int, int, int] | None = None
    """x, y, width and height in pixels of the part of the picture that is rendered."""
    integrator: str | None = None
    """Name of the plugin to use instead of the scene's integrator."""
    variant: str | None = None
    """Variant of Mitsuba."""
    define: dict[str, str] = Field(default_factory=dict)
    """Values of the scene's $parameters, by their names."""
    frames: str | None = None
    """Numbers of the frames: "1-24" for all of a range, "1-24:2" for every other one, "3,7" for single ones."""
    checkpoint: Path | None = None
    """File that keeps the state of the session."""
    checkpoint_every: float = Field(EVERY_SECONDS, ge=0)
    """Seconds between two writes of the checkpoint."""
    resume: bool = False
    """Whether the session goes on from the checkpoint, if there is one."""
    overwrite: bool = False
    """Whether existing files are replaced."""
    features: bool = False
    """Whether layers of albedo, normal, depth and shapes are written too."""
    denoise: bool = False
    """Whether the noise is taken out of the picture; the noisy one is then a layer of its own."""
    layers: Literal["all", "rgb"] = "all"
    """What an EXR holds: all layers, or the picture alone in linear sRGB, so that it can be read as a texture or an
    environment."""
    live: Path | None = None
    """PNG that shows the picture while it renders."""
    tev: str | None = None
    """host:port of a tev viewer that shows the picture while it renders."""
    memory: float | None = Field(None, gt=0)
    """Largest amount of memory to use, in GiB."""
    workers: int | None = Field(None, ge=1, le=1024)
    """Number of worker processes on this machine that draw samples."""
    part: str | None = None
    """Part of the samples to render: "3/8" is the third of eight parts."""
    scheduler: str | None = None
    """Address of a Dask scheduler whose workers draw samples, or the file in which the scheduler has left it."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """Fields of ``tracer.settings.Settings`` that are given; the others keep their defaults."""

    @field_validator("sensor", mode="before")
    @classmethod
    def one_or_several(cls, value: Any) -> Any:
        """Accept a single number or a list of numbers, as integers or as text, and "all"."""
        values = value if isinstance(value, list | tuple) else [value]
        if "all" in values:
            return "all"
        if values and all(str(entry).isdecimal() for entry in values):
            return values
        raise ValueError(f'sensor: write numbers from 0, or "all" (was {", ".join(map(repr, values))})')

    @field_validator("crop", mode="before")
    @classmethod
    def crop_from_text(cls, value: Any) -> Any:
        """Read "x,y,width,height"."""
        parts = value.split(",") if isinstance(value, str) else value
        if isinstance(parts, list | tuple) and len(parts) == 4:
            return parts
        raise ValueError(f"crop: write x,y,width,height in pixels (was {value!r})")

    @field_validator("define", mode="before")
    @classmethod
    def define_from_text(cls, value: Any) -> Any:
        """Read "name=value" entries."""
        if isinstance(value, dict):
            return {name: str(text) for name, text in value.items()}
        if not (isinstance(value, list | tuple) and all(isinstance(entry, str) for entry in value)):
            raise ValueError(f"define: write name=value (was {value!r})")
        pairs = [entry.partition("=") for entry in value]
        if not all(name and sign for name, sign, _ in pairs):
            raise ValueError(f"define: write name=value (was {', '.join(value)!r})")
        return {name: text for name, _, text in pairs}

    @field_validator("part")
    @classmethod
    def part_is_one(cls, value: str | None) -> str | None:
        """Reject a text that is not of the form "3/8"."""
        if value is not None:
            parse_part(value)
        return value

    @model_validator(mode="after")
    def makes_something(self) -> Job:
        """Reject a job that would write nothing, or features into a file without layers."""
        if self.output is None and (self.part is None or self.checkpoint is None):
            raise ValueError("nothing would be written: name a picture with -o, or a checkpoint for a part")
        if self.features and self.layers == "rgb":
            raise ValueError("features are layers of their own, which layers = rgb leaves out: choose one of them")
        return self

    @field_validator("frames")
    @classmethod
    def frames_are_numbers(cls, value: str | None) -> str | None:
        """Reject a text that is not a list of frames."""
        if value is not None:
            frame_numbers(value)
        return value


@dataclass(frozen=True)
class JobPicture:
    """A single picture of a job."""

    scene: Path
    define: dict[str, str]
    sensor: int
    output: Path | None
    checkpoint: Path | None
    live: Path | None

    @property
    def name(self) -> str:
        """Name of the picture in messages: the file that is written."""
        return str(self.output or self.checkpoint)


def frame_numbers(text: str) -> list[int]:
    """Return the numbers of "1-24", "1-24:2" or "3,7". Raises ValueError."""
    numbers: list[int] = []
    for entry in text.split(","):
        match = re.fullmatch(r"\s*(\d+)(?:-(\d+)(?::(\d+))?)?\s*", entry)
        if not match or match[3] == "0" or (match[2] and int(match[2]) < int(match[1])):
            raise ValueError(f'frames: write "1-24", "1-24:2" or "3,7" (was {text!r})')
        numbers += range(int(match[1]), int(match[2] or match[1]) + 1, int(match[3] or 1))
    return numbers


def make_job(given: dict[str, Any], configuration: Path | None = None) -> Job:
    """Return a checked job from the options of the command line; a TOML file gives the options that it leaves out.

    Paths in the configuration are relative to its folder. Without an output, the picture is written into the working
    folder under the name of the scene, as Mitsuba does. Raises SettingsError with one sentence.
    """
    job_fields = [name for name in Job.model_fields if name != "settings"]
    option_names = [*job_fields, *Settings.model_fields]
    values = {} if configuration is None else read_configuration(configuration, option_names)
    values |= {name: value for name, value in given.items() if value is not None}
    if "part" not in values and "scene" in values:  # a part is for a merge, which writes the picture
        values.setdefault("output", Path(f"{Path(values['scene']).stem}.exr"))
    if "criterion" in values:
        values["criterion"] = criteria.name_of(values["criterion"])
    settings = {name: value for name, value in values.items() if name in Settings.model_fields}
    try:
        return Job(**{name: values[name] for name in job_fields if name in values}, settings=settings)
    except ValidationError as error:
        raise SettingsError(in_one_sentence(error, option_names)) from None


FILES = ("importance", "checkpoint", "live")
"""Options whose values are paths, relative to the folder of the configuration that holds them."""


def read_configuration(path: Path, option_names: list[str]) -> dict[str, Any]:
    """Return the options in a TOML file by name, with "_" for "-". Raises SettingsError.

    ``option_names``: names of all options that exist.
    """
    try:
        values = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SettingsError(f"Cannot read '{path}': {error.strerror}.") from None
    except ValueError as error:
        raise SettingsError(f"'{path}' is no TOML: {error}.") from None
    values = {name.replace("-", "_"): value for name, value in values.items()}
    for name in values:
        if name not in option_names or name in ("scene", "output"):
            raise SettingsError(f"'{path}': there is no option '{name}'{did_you_mean(name, option_names)}")
    return {
        name: str(path.parent / value) if isinstance(value, str) and is_path(name, value) else value
        for name, value in values.items()
    }


def is_path(name: str, text: str) -> bool:
    """Return whether the value of an option in a configuration is a path."""
    return name in FILES or (name == "criterion" and text.endswith(FILE_ENDING))


def pictures_of(job: Job, sensors: int) -> Iterator[JobPicture]:
    """Yield the pictures of a job, frame by frame; ``sensors`` is the number of sensors of the scene."""
    chosen_sensors = tuple(range(sensors)) if job.sensor == "all" else job.sensor
    for frame in [None] if job.frames is None else frame_numbers(job.frames):
        define = job.define
        if frame is not None and not is_numbered(job.scene):
            define = {"frame": str(frame), **define}
        for sensor in chosen_sensors:
            label = f"-{sensor}" if len(chosen_sensors) > 1 else ""

            def named(path: Path | None, frame: int | None = frame, label: str = label) -> Path | None:
                return None if path is None else path.with_name(numbered(path, frame, label))

            files_of = [named(path) for path in (job.output, job.checkpoint, job.live)]
            yield JobPicture(frame_file(job.scene, frame), define, sensor, *files_of)


def request_for(job: Job, picture: JobPicture, scene: LoadedScene) -> Request:
    """Return the request to a session for a single picture. Raises SettingsError."""
    origin = job.model_dump(mode="json", exclude={"settings", "overwrite", "resume"}, exclude_none=True)
    return Request(
        scene,
        job.settings,
        sensor=picture.sensor,
        integrator=job.integrator,
        size=job.size,
        crop=job.crop,
        part=None if job.part is None else parse_part(job.part),
        features=job.features,
        denoise=job.denoise,
        memory_limit=job.memory,
        checkpoint=checkpoint_file(picture.checkpoint, job.checkpoint_every, job.resume, job.overwrite),
        picture=None if picture.output is None else PictureFile(picture.output, job.overwrite, job.layers, origin),
    )


def is_numbered(scene: Path) -> bool:
    """Return whether the path of a scene has "####" for the number of the frame, in its name or that of a folder."""
    return NUMBER in str(scene) and not scene.is_file()


def frame_file(scene: Path, number: int | None) -> Path:
    """Return the scene file of a frame: exporters write every frame into a file, or into a folder, of its own."""
    if number is None or not is_numbered(scene):
        return scene
    return Path(put_number(str(scene), number))


def numbered(path: Path, number: int | None, label: str) -> str:
    """Return the name of a file for a frame and a sensor.

    The number of the frame replaces "####" in the name, or else is added to the stem; ``label`` of the sensor follows.
    """
    stem = path.stem
    if number is not None:
        stem = put_number(stem if NUMBER in stem else f"{stem}.####", number)
    return f"{stem}{label}{path.suffix}"


def put_number(name: str, number: int) -> str:
    """Return ``name`` with its last run of "#" replaced by the number, with at least as many digits as the run."""
    return re.sub(rf"({NUMBER}+)(?!.*{NUMBER})", lambda match: str(number).zfill(len(match[0])), name)


def check_frames(job: Job) -> None:
    """Raise SettingsError if the frames of a job would all be the same picture."""
    if job.frames is None or is_numbered(job.scene) or not job.scene.is_file():
        return
    if b"$frame" not in job.scene.read_bytes():
        raise SettingsError(
            f"'{job.scene}' is the same in every frame: use $frame in it, or name files as scene.####.xml."
        )


def check_outputs(pictures: list[JobPicture], job: Job) -> None:
    """Raise OutputError if any file of a job cannot be written, before the first picture is rendered."""
    paths = [path for picture in pictures for path in (picture.output, picture.checkpoint) if path is not None]
    repeated = next((path for path, count in Counter(paths).items() if count > 1), None)
    if repeated is not None:
        raise OutputError(f"'{repeated}' would be written more than once; name every frame and every sensor once.")
    for picture in pictures:
        if picture.output is not None:
            atomic.check_output(picture.output, job.overwrite or job.resume)
        if picture.checkpoint is not None:
            atomic.check_output(picture.checkpoint, job.overwrite or job.resume, suffixes=())
        if picture.live is not None:
            atomic.check_output(picture.live, overwrite=True, suffixes=(".png",))
