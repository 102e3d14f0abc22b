"""What tests do with a finished document in the window."""

from __future__ import annotations

import numpy as np
from origami.origami_addon.stages import STAGES


def draw_outline(margin: float) -> None:
    """Make the outline a rectangle with some points along its sides, inset by a distance into the reference photo."""
    from origami.origami_addon.scene.document import documents
    from origami.origami_addon.scene.outline_curve import set_outline
    from origami.origami_addon.state import Found

    (document,) = documents()
    camera = document.reached(Found).reference
    corners = np.array([[margin, margin], [1 - margin, margin], [1 - margin, 1 - margin], [margin, 1 - margin]])
    set_outline(document.object("outline"), corners * (camera.width, camera.height), camera, 1.0)


def stages(document) -> dict:
    """The last run of each stage, by its name."""
    return {stage: getattr(document.collection.origami, stage) for stage in STAGES}
