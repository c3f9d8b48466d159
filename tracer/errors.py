"""Every error a person can act on. The message is one sentence: what, where, what to do."""

from __future__ import annotations


class TracerError(Exception):
    """Base class: catch it to catch all of ours. ``exit_code`` is what the command line returns."""

    exit_code = 2


class BackendError(TracerError):
    """No LLVM, an LLVM that would abort the process, or a Mitsuba variant that cannot be used."""


class MissingPackageError(TracerError):
    """A package of an optional part that is not installed."""


class SceneError(TracerError):
    """A scene that is missing, does not load, or has nothing to render."""


class SettingsError(TracerError):
    """A setting out of range, or a name that does not exist."""


class OutputError(TracerError):
    """A place where the result cannot be written, or must not be."""


class WriteError(OutputError):
    """A file that could not be written when it was made, as on a full disk."""

    exit_code = 5


class PendingWriteError(OutputError):
    """A file that somebody else had begun to write, and that could not be finished."""


class CheckpointError(TracerError):
    """A checkpoint that is missing, damaged, or of another render."""


class ClusterError(TracerError):
    """A cluster that is not there, not any more, or not made of the same as the client."""

    exit_code = 4


class SceneMissingError(ClusterError):
    """A worker that does not have the scene."""


class BudgetError(TracerError):
    """Bounds on the samples per pixel that no allocation can meet."""


class StudyError(TracerError):
    """A study in which something could not be measured; the rest was."""

    exit_code = 1


class ScoreError(TracerError, ValueError):
    """Pictures that cannot be read, or cannot be compared; a ValueError too, as arrays that do not fit raise."""


class LayerError(ScoreError):
    """A layer that a picture does not have."""


class DenoiseError(TracerError):
    """Pictures that cannot be denoised, or a denoiser that is not installed."""
