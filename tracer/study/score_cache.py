"""Scores that were computed before, kept in a file."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from tracer.image import metrics, objective
from tracer.image.metrics import Scores
from tracer.io import atomic
from tracer.study.reference import Reference
from tracer.study.source_hash import hash_of


class ScoreBook:
    """Scores by picture and reference, kept in a file, as computing them takes longer than reading the pictures."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.code = hash_of([Path(metrics.__file__), Path(objective.__file__)])
        self.last: tuple[Reference, str] | None = None
        self.known: dict[str, Any] = {}
        if path.exists():
            try:
                self.known = json.loads(path.read_text())
            except ValueError:  # damaged: its scores are computed again
                self.known = {}

    def scores(self, image: Any, reference: Reference) -> Scores:
        """Return the scores of a picture, (H, W, 3), computed if they are not kept."""
        name = f"{hash_of_pixels(image)} {self.identity(reference)} {self.code}"
        if name not in self.known:
            self.known[name] = asdict(metrics.all_scores(image, reference.image))
        return Scores(**self.known[name])

    def identity(self, reference: Reference) -> str:
        """Return a hash of the pixels of a reference."""
        if self.last is None or self.last[0] is not reference:
            self.last = (reference, hash_of_pixels(reference.image))
        return self.last[1]

    def save(self) -> None:
        """Write all scores to the file."""
        atomic.write_text(self.path, json.dumps(self.known, indent=0))


def hash_of_pixels(image: Any) -> str:
    """Return a hash of the values of an array."""
    return hashlib.sha256(np.ascontiguousarray(image).tobytes()).hexdigest()[:16]
