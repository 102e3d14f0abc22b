"""The types of failures: every message is a sentence for the user that names the next step."""

from __future__ import annotations


class OrigamiError(Exception):
    """Base of all failures that are reported to the user.

    Attributes
    ----------
    exit_code : int
        The command line's.
    warnings : tuple of str
        The run's warnings before it failed, which often give the reason.
    """

    exit_code = 3
    warnings: tuple[str, ...] = ()


class UsageError(OrigamiError):
    """An option, a path or a settings file is wrong."""

    exit_code = 2


class UnusablePhotos(OrigamiError):
    """The photos (or the COLMAP model given with them) are unusable; others are needed."""

    exit_code = 4


class UnusableMesh(OrigamiError):
    """A mesh cannot be flattened as it is; seams are missing, or it has to be repaired."""

    exit_code = 4


class StepFailed(OrigamiError):
    """The photos seem to be fine, but a step could not finish."""

    exit_code = 5


class Cancelled(OrigamiError):
    """The user stopped the run at a safe point."""

    exit_code = 130
