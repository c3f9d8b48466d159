"""How many paths to learn from: as many as pay for the picture that is then drawn.

Time is counted in paths, so that it does not depend on how busy the machine is.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

LOOK_SHARE, LARGEST_LOOK_SHARE = 0.0075, 0.02
"""Part of the samples of a picture that are drawn to find out whether there is anything to learn; in a small picture up
to the second part."""
LEAST_LOOK_PATHS, MOST_LOOK_PATHS = 1 << 14, 1 << 18
"""Bounds on the number of these paths, half of which judge and half of which teach. A small picture has fewer."""
LEAST_PATHS, MOST_PATHS = 1 << 10, 1 << 20
"""Fewest and most paths that teach."""
LEAST_PIXELS, LONGEST_BLOCK = 256, 64
"""Fewest pixels that judge, and most samples of each of their two sequences."""
MORE = 4
"""Learning goes on with this many times as many paths."""
FIXED_COST, FIRST_COST = 1 << 18, 1 << 20
"""Number of paths that take as long as the part of learning that does not depend on their number, and as that which a
program does once for each scene, such as to compile it."""
LEARNING_COST = 1.5
"""Number of paths that take as long as one from which is learned."""
DEARER = 1.2
"""How many times as long a path is taken to take whose lights are chosen by a table; it was 1.05 to 1.25 times."""
WORTH_A_LOOK = 1.01
"""Factor by which the variance must be expected to fall after a first look for more paths to be drawn."""
WORTH_MORE = 1.1
"""Factor by which variance times time must be expected to fall for learning to go on after that."""
MANY_LIGHTS, HOPE, HOPE_FOR_MANY = 8, 1.3, 3.0
"""Factor by which the variance may be hoped to fall before anything is known, in general, and with so many lights."""
CAUTION = 1.0
"""How many standard errors are taken off the gain of few lights before it is believed. With many lights more is lost
where a true gain is not believed than where a false one is."""


def look_paths(total: int) -> int:
    """Return with how many paths a picture of ``total`` paths is first looked at."""
    least = min(LEAST_LOOK_PATHS, int(LARGEST_LOOK_SHARE * total))
    return min(max(int(LOOK_SHARE * total), least), MOST_LOOK_PATHS)


def block_length(judge_paths: int, spp: int) -> int:
    """Return how many samples each of the two sequences of a pixel has that judges: as many as the picture has, but no
    more than leaves enough pixels. It is a power of two, as sequences are then most even."""
    longest = max(min(judge_paths // (2 * LEAST_PIXELS), spp, LONGEST_BLOCK), 1)
    return 1 << (longest.bit_length() - 1)


def is_worth_a_look(total: int, light_count: int) -> bool:
    """Return whether a picture of ``total`` paths may gain from a look at which of the lights matter where."""
    hope = HOPE if light_count < MANY_LIGHTS else HOPE_FOR_MANY
    return light_count > 0 and pays(hope, total, 2 * look_paths(total))


def pays(gain: float, total: int, taught: float = 0) -> bool:
    """Return whether a picture of ``total`` paths is better for its time if the variance falls ``gain``-fold.

    ``taught``: paths from which must be learned first.
    """
    learning = LEARNING_COST * taught + FIXED_COST if taught else 0
    return gain * total > DEARER * total + learning


@dataclass
class LearningCurve:
    """How much of the variance of a picture is left with what was learned, as a part of what it was before."""

    left: list[tuple[int, float]] = field(default_factory=list)
    """Each time that something was learned, from how many paths, and what is left."""
    foretold: list[float] = field(default_factory=list)
    """For each time, what the paths that taught say that is left."""
    doubt: float = 0.0
    """Relative standard error of what is left."""
    most_paths: int = MOST_PATHS
    """Most paths that teach."""

    def add(self, path_count: int, foretold: float, measured: float, doubt: float) -> None:
        """Take in that something was learned from ``path_count`` paths.

        ``foretold``: what these say that is left; ``measured``, ``doubt``: what is left with what was learned the time
        before, and its relative standard error. The first time nothing was learned before.
        """
        left = foretold
        if self.left:
            self.left[-1] = self.left[-1][0], measured
            left = measured * min(foretold / self.foretold[-1], 1.0)
        self.left.append((path_count, left))
        self.foretold.append(foretold)
        self.doubt = doubt

    def gain(self) -> float:
        """Return by which factor the variance is expected to fall."""
        return 1 / max(self.left[-1][1], 1e-3)

    def believed_gain(self, light_count: int) -> float:
        """Return by which factor the variance is believed to fall."""
        caution = CAUTION if light_count < MANY_LIGHTS else 0.0
        return float(np.exp(-caution * self.doubt)) * self.gain()

    def further_paths(self, total: int) -> int:
        """Return from how many more paths to learn before a picture of ``total`` paths.

        The part that more paths would take away is expected to be inverse to their number.
        """
        path_count, left = self.left[-1]
        if len(self.left) == 1:  # as many again show whether what was foretold is true
            return min(path_count, self.most_paths - path_count) if left * WORTH_A_LOOK < 1 else 0
        more = min(MORE * path_count, self.most_paths)
        count_before, left_before = self.left[-2]
        expected = left - (left_before - left) * (1 - path_count / more) / (path_count / count_before - 1)
        goes_on = expected * (total + LEARNING_COST * more) * WORTH_MORE < left * (total + LEARNING_COST * path_count)
        may_pay = expected * DEARER < 1
        return max(more - path_count, 0) if goes_on and may_pay else 0
