"""A sheet on its way from folded to flat, where its document stands."""

from __future__ import annotations

import numpy as np

from ...core.arrays import Array
from ...core.flat.unfolding import unfolded
from ...core.sheet import FlatMap, Sheet
from ...core.watch import SILENT, Watch
from .document_frame import document_frame, on_ground
from .shape_keys import BETWEEN
from .sheet_mesh import transform


def unfolding(sheet: Sheet, flat: FlatMap, watch: Watch = SILENT) -> Array:
    """The shapes (K + 1, V, 3) of the sheet that `put_unfolding` takes, in Blender's frame."""
    folded, laid = transform(document_frame(sheet, flat), sheet.vertices), on_ground(flat)
    return np.concatenate([unfolded(folded, laid, sheet.triangles, BETWEEN, watch), laid[None]])
