"""The frame of each command here: its outcome is the exit code, and a failure is one sentence."""

from __future__ import annotations

import signal
from collections.abc import Callable

from ...core.errors import Cancelled, OrigamiError
from ...headless.terminal import accept_every_letter, keep_quiet_at_exit, say
from ...origami_addon.system_errors import system_errors_as_failures

INTERNAL_ERROR = 3


def exit_code_of(command: Callable[[], None]) -> int:
    """Run a command and return its exit code, as `rectify.py` has them; never raises."""
    accept_every_letter()
    # An engine asks a job to stop with this signal; what is half-written then goes, as after Ctrl-C.
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with system_errors_as_failures():
            command()
        return 0
    except SystemExit as leaving:  # argparse's: 0 after --help, 2 after a wrong option
        return int(leaving.code or 0)
    except KeyboardInterrupt:
        return Cancelled.exit_code
    except OrigamiError as error:
        say(f"error: {error}")
        return error.exit_code
    except Exception as error:
        say(f"internal error: {type(error).__name__}: {error}; please report it")
        return INTERNAL_ERROR
    finally:
        signal.signal(signal.SIGTERM, before)
        keep_quiet_at_exit()
