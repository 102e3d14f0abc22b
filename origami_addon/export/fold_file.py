"""The crease pattern in FOLD, the JSON format of origami software."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.creases.crease_pattern import assignments, crease_pattern, fold_angles, in_space
from ...core.numeric.triangles import areas, signed_areas
from ...core.sheet import FlatMap, Sheet
from ..files.atomic import replacing
from ..report import version
from ..scene.document_frame import document_frame
from ..scene.sheet_mesh import transform

_SPECIFICATION = 1.2


def write_fold(path: Path, sheet: Sheet, flat: FlatMap) -> None:
    """Write the crease pattern with its fold angles and, as a second frame, its folded form.

    x points right, y up and, in the folded form, z towards the reader; in mm if the size is known.
    """
    pattern = crease_pattern(sheet, flat)
    angles = fold_angles(pattern, sheet, flat)
    letters = assignments(pattern, angles)
    on_page = pattern.vertices * (1, -1) + (0, flat.height)
    frame = document_frame(sheet, flat)
    folded = transform(frame, in_space(sheet, flat, pattern.vertices))
    # of the same area as the page, whether its size is known or not
    in_document = areas(transform(frame, sheet.vertices), sheet.triangles).sum()
    folded *= np.sqrt(np.abs(signed_areas(flat.uv, sheet.triangles)).sum() / in_document)
    surface = ["manifold", "orientable", "noCuts", "joins" if "J" in letters else "noJoins"]
    content = {
        "file_spec": _SPECIFICATION,
        "file_creator": f"Origami {version()}",
        "file_classes": ["singleModel"],
        "frame_title": "crease pattern",
        "frame_classes": ["creasePattern"],
        "frame_attributes": ["2D", *surface],
        "frame_unit": "mm" if flat.unit == "mm" else "unit",
        "vertices_coords": _rounded(on_page),
        "edges_vertices": pattern.edges.tolist(),
        "edges_assignment": letters,
        "edges_foldAngle": _rounded(np.nan_to_num(angles)),
        "faces_vertices": [face.tolist() for face in pattern.faces],
        "file_frames": [
            {
                "frame_title": "folded form",
                "frame_classes": ["foldedForm"],
                "frame_attributes": ["3D", *surface],
                "frame_parent": 0,
                "frame_inherit": True,
                "vertices_coords": _rounded(folded),
            }
        ],
    }
    lines = [f"{json.dumps(name)}: {json.dumps(value)}" for name, value in content.items()]
    with replacing(path) as temporary:
        temporary.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def _rounded(values: Array) -> Any:
    """As lists, with significant digits only."""
    return np.vectorize(lambda value: float(f"{value:.7g}"))(values).tolist()
