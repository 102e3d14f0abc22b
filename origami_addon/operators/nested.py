"""An operator that starts another one."""

from __future__ import annotations

import re
from typing import Any

import bpy

# What Blender puts before a sentence: the operator whose `poll` refuses, or the kind of report, in the user's language.
_BEFORE = re.compile(r"\A(Operator bpy\.ops\.\S+\.poll\(\) |[^:\n]+: )")
_FAULT = "Traceback"


def start(operator: bpy.types.Operator, other: Any, **properties: Any) -> bool:
    """Start another operator the way that the first one was: by a user, who works on meanwhile, or by a script.

    What it fails with is told by the one that starts it.

    Parameters
    ----------
    operator : bpy.types.Operator
        The one that starts the other.
    other : callable of ``bpy.ops``
    **properties
        Of the other.

    Returns
    -------
    bool
        Whether the other runs or has finished.
    """
    try:
        outcome = other("INVOKE_DEFAULT" if operator.options.is_invoke else "EXEC_DEFAULT", **properties)
    except RuntimeError as error:
        if _FAULT in str(error):
            raise
        operator.report({"ERROR"}, _BEFORE.sub("", str(error).strip()))
        return False
    return not outcome & {"CANCELLED"}
