"""COLMAP models for tests, changed in a process of their own: Blender does not survive pycolmap in its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Literal

_SCRIPT = """
import sys
import numpy as np, pycolmap
model = pycolmap.Reconstruction(sys.argv[1])
{change}
model.write_{form}(sys.argv[2])
"""


def write_changed_model(
    source: Path, target: Path, change: str = "", *values: object, form: Literal["binary", "text"] = "binary"
) -> Path:
    """Read a COLMAP model, change it, and write it into a folder, which is created if missing.

    Parameters
    ----------
    source, target : Path
    change : str
        Python statements about ``model``, a `pycolmap.Reconstruction`; ``sys.argv[3:]`` are the ``values``.
    values : object
    form : {"binary", "text"}
    """
    target.mkdir(exist_ok=True)
    subprocess.run(
        [sys.executable, "-c", _SCRIPT.format(change=change, form=form), *map(str, (source, target, *values))],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        check=True,
    )
    return target
