"""All that a render needs to go on from where it is: what a checkpoint keeps."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracer.adaptive.convergence import NoiseMeter
from tracer.film.bias import UnbiasedMean, mean_at_the_end
from tracer.film.estimate import Estimate, Statistics
from tracer.film.features import Features
from tracer.guiding.table import LightChances
from tracer.report import Round
from tracer.settings import Settings

Arrays = dict[str, NDArray]
SUMS = re.compile(r"(estimate|held_out)\.\d+")
"""Names of the arrays of an estimate, whose shapes it knows itself."""


@dataclass
class State:
    """A render between two passes."""

    estimate: Estimate
    generator: np.random.Generator
    """Rounds counts at random."""
    drawn: NDArray[np.uint32]
    """(grid): samples of each pixel after the last whole round, those held out not counted."""
    allocation: NDArray[np.uint32] | None = None
    """(grid): the same after the round that is under way; None between rounds."""
    done: int = 0
    """Samples drawn in all."""
    before: Statistics | None = None
    """What was known when the last round was decided."""
    held_out: Estimate | None = None
    """Samples that decided and are kept out of the picture."""
    held_out_samples: int = 0
    looked: bool = False
    """Whether pilot rays were traced; as they are keyed, they can be traced again."""
    importance: NDArray[np.float32] | None = None
    """(grid): by which the last round was decided."""
    unbiased: UnbiasedMean | None = None
    """Of all rounds before the last; None where samples that decide are not in the picture, or none decide."""
    chance: NDArray[np.float32] | None = None
    """(grid): with which each pixel had a sample in the last round; None where that was not left to chance."""
    meter: NoiseMeter = field(default_factory=NoiseMeter)
    features: Features | None = None
    """What is seen in each pixel, so that a merge, which has no scene, can be denoised; None without a checkpoint."""
    guide: LightChances | None = None
    """By which lights are chosen; None: as Mitsuba does."""
    guided: bool = False
    """Whether the integrator ``guided`` draws, if only because it has looked for something to learn."""
    rounds: list[Round] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @classmethod
    def beginning(cls, empty: Estimate, settings: Settings) -> State:
        """Return the state before the first sample."""
        generator = np.random.default_rng(np.random.SeedSequence([settings.seed, 1]))
        return cls(empty, generator, np.zeros(empty.view.grid, np.uint32))

    def plan_anew(self, total: int) -> None:
        """Give up the round that is under way if it would end beyond ``total`` samples; those drawn of it stay."""
        if self.allocation is None or self.held_out is not None:
            return
        if int(self.allocation.sum(dtype=np.int64)) > total:
            self.drawn, self.allocation, self.chance = self.estimate.drawn(), None, None

    def unbiased_mean(self, known: Statistics) -> UnbiasedMean | None:
        """Return the mean of each pixel without the bias of deciding; ``known``: of all samples there are."""
        if self.unbiased is None:
            return None
        return mean_at_the_end(self.unbiased, self.before, known, self.chance, is_whole=self.allocation is None)

    def pack(self) -> tuple[Arrays, dict[str, Any]]:
        """Return arrays by name, and the rest as plain values for JSON."""
        arrays: Arrays = {"drawn": self.drawn}
        optional = {"allocation": self.allocation, "importance": self.importance, "chance": self.chance}
        optional |= {"meter.image": self.meter.image, "meter.count": self.meter.count}
        arrays |= {name: array for name, array in optional.items() if array is not None}
        if self.before is not None:
            arrays |= {f"before.{name}": array for name, array in vars(self.before).items()}
        if self.features is not None:
            arrays |= packed_features(self.features)
        if self.guide is not None:
            arrays |= {f"guide.{name}": array for name, array in self.guide.pack().items()}
        if self.unbiased is not None:
            arrays |= {f"unbiased.{name}": array for name, array in vars(self.unbiased).items()}
        for name, estimate in (("estimate", self.estimate), ("held_out", self.held_out)):
            if estimate is not None:
                arrays |= {f"{name}.{k}": array for k, array in enumerate(estimate.state())}
        plain = {name: getattr(self, name) for name in ("done", "held_out_samples", "looked", "guided", "notes")}
        plain |= {
            "factor": self.meter.factor,
            "scale": self.meter.scale,
            "rounds": [asdict(finished_round) for finished_round in self.rounds],
        }
        return arrays, {**plain, "generator": self.generator.bit_generator.state}

    def unpack(self, arrays: Arrays, plain: dict[str, Any], new: Estimate) -> None:
        """Take over what was packed; ``new``: an empty estimate for samples held out. Raises ValueError, KeyError."""
        require_shapes(arrays, new)
        self.estimate.restore(numbered_arrays(arrays, "estimate"))
        if "held_out.0" in arrays:
            new.restore(numbered_arrays(arrays, "held_out"))
            self.held_out = new
        for name in ("done", "held_out_samples", "looked", "guided", "notes"):
            if type(plain[name]) is not type(getattr(self, name)):
                raise ValueError(f"{name} is of another kind")
            setattr(self, name, plain[name])
        self.drawn, self.allocation = arrays["drawn"], arrays.get("allocation")
        self.importance, self.chance = arrays.get("importance"), arrays.get("chance")
        self.before, self.unbiased = before_of(arrays), unbiased_of(arrays)
        self.features = features_of(arrays)
        self.guide = LightChances.unpack(part_of(arrays, "guide.")) if "guide.row" in arrays else None
        self.meter = NoiseMeter(arrays.get("meter.image"), arrays.get("meter.count"), plain["factor"], plain["scale"])
        self.rounds = [Round(**fields) for fields in plain["rounds"]]
        self.generator.bit_generator.state = plain["generator"]


PICTURE_LIKE = ("mean", "variance", "total", "meter.image")
"""Ends of the names of arrays that have a value for each channel; others have one for each pixel."""


def require_shapes(arrays: Arrays, estimate: Estimate) -> None:
    """Raise ValueError if arrays of a state, but for sums, are not of the picture of ``estimate``, or are no counts."""
    frame, kinds = estimate.view, {"moments": estimate.moments, "peaks": estimate.peaks}
    for name, array in arrays.items():
        if SUMS.match(name) or name.startswith("guide."):
            continue
        expected = tuple(frame.size if name.startswith(("meter.", "features.")) else frame.grid)
        if name.startswith("features."):
            expected += () if name.endswith("depth") else (3,)
        elif name.endswith(PICTURE_LIKE):
            expected += (len(frame.channels),)
        elif name.startswith("before.") and (kind := name.removeprefix("before.")) in kinds:
            expected += (kinds[kind],)
        if array.shape != expected:
            raise ValueError("these arrays are of another picture")
        if name in ("drawn", "allocation") and array.dtype != np.uint32:
            raise ValueError("these are no counts")


def before_of(arrays: Arrays) -> Statistics | None:
    """Return what was known when the last round was decided."""
    fields = part_of(arrays, "before.")
    return Statistics(**fields) if fields else None


def unbiased_of(arrays: Arrays) -> UnbiasedMean | None:
    """Return the unbiased mean of all rounds before the last."""
    fields = part_of(arrays, "unbiased.")
    return UnbiasedMean(**fields) if fields else None


def packed_features(features: Features) -> Arrays:
    """Return the arrays of features by name."""
    return {f"features.{name}": array for name, array in vars(features).items()}


def features_of(arrays: Arrays) -> Features | None:
    """Return the features among the arrays of a state."""
    fields = part_of(arrays, "features.")
    return Features(**fields) if fields else None


def part_of(arrays: Arrays, prefix: str) -> Arrays:
    """Return the arrays whose names begin with ``prefix``, without it."""
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}


def numbered_arrays(arrays: Arrays, name: str) -> list[NDArray]:
    """Return the arrays ``name.0``, ``name.1``, ... in order."""
    pieces: list[NDArray] = []
    while f"{name}.{len(pieces)}" in arrays:
        pieces.append(arrays[f"{name}.{len(pieces)}"])
    return pieces
