"""An operator that starts another one."""

from __future__ import annotations

import re
from typing import Any

import bpy

# Blender's prefix of a message: the operator whose `poll` refuses, or the kind of report in the user's language.
_BEFORE = re.compile(r"\A(Operator bpy\.ops\.\S+\.poll\(\) |[^:\n]+: )")
_FAULT = "Traceback"


def start(operator: bpy.types.Operator, other: Any, **properties: Any) -> bool:
    """Start another operator as the first one was started: by a user, who continues to work meanwhile, or by a script.

    The operator that starts it reports its failure.

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
