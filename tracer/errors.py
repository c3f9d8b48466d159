"""Errors that a person can act on. Every message is one sentence: what is wrong, where, and what to do.

Example::

    import tracer

    try:
        tracer.render("scene.xml", spp=-1)
    except tracer.errors.SettingsError as error:
        print(error)  # spp: input should be greater than or equal to 1 (was -1).
    except tracer.errors.TracerError as error:
        raise SystemExit(error.exit_code)
"""

from __future__ import annotations


class TracerError(Exception):
    """Base class of all errors of tracer. ``exit_code`` is what the command returns when it ends with the error."""

    exit_code = 2
    """Exit status of the command."""


class BackendError(TracerError):
    """There is no LLVM, the LLVM would abort the process, or the Mitsuba variant cannot be used."""


class MissingPackageError(TracerError):
    """A package that only an optional part needs is not installed."""


class SceneError(TracerError):
    """A scene is missing, does not load, or has nothing to render."""


class SettingsError(TracerError):
    """A setting is out of range, or a name does not exist."""


class OutputError(TracerError):
    """A result cannot be written to a place, or must not be."""


class WriteError(OutputError):
    """A file could not be written when it was made, as on a full disk."""

    exit_code = 5


class PendingWriteError(OutputError):
    """A file that somebody else had begun to write could not be finished."""


class CheckpointError(TracerError):
    """A checkpoint is missing, damaged, or of another render."""


class ClusterError(TracerError):
    """A cluster cannot be reached, is lost, or its workers run other versions than the client."""

    exit_code = 4


class SceneMissingError(ClusterError):
    """A worker does not have the scene."""


class BudgetError(TracerError):
    """No allocation can meet the bounds on the samples per pixel."""


class StudyError(TracerError):
    """Some of a study could not be measured; the rest was."""

    exit_code = 1


class ScoreError(TracerError, ValueError):
    """Pictures cannot be read or compared. It is a ValueError too, like errors of arrays whose shapes do not match."""


class LayerError(ScoreError):
    """A picture does not have a layer."""


class DenoiseError(TracerError):
    """A picture cannot be denoised, or no denoiser is installed."""
