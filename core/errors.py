"""What can go wrong, as types: every message is a sentence for the user that names the next step."""

from __future__ import annotations


class OrigamiError(Exception):
    """Base of all failures that are told to the user.

    Attributes
    ----------
    exit_code : int
        The command line's.
    warnings : tuple of str
        What the run had warned of before it failed: often the reason.
    """

    exit_code = 3
    warnings: tuple[str, ...] = ()


class UsageError(OrigamiError):
    """An option, a path or a settings file is wrong."""

    exit_code = 2


class UnusablePhotos(OrigamiError):
    """The photos (or the COLMAP model given with them) cannot serve; others are needed."""

    exit_code = 4


class UnusableMesh(OrigamiError):
    """A mesh cannot be laid flat as it is; seams are missing, or it has to be repaired."""

    exit_code = 4


class StepFailed(OrigamiError):
    """The photos are fine as far as one can tell, but a step could not finish."""

    exit_code = 5


class Cancelled(OrigamiError):
    """The user stopped the run where giving up is safe."""

    exit_code = 130
