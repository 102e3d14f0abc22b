"""Drawings of the page in true size: the UV layout and the crease pattern."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.arrays import Array
from ...core.creases.crease_pattern import assignments, crease_pattern, fold_angles
from ...core.numeric.triangles import directed_edges
from ...core.sheet import FlatMap, Sheet
from ..files.atomic import replacing

# Margin on each side, as a share of the page's longer side.
_MARGIN = 0.02
# Without a true size, the longer side is drawn as long as that of A4: this share of it counts as a millimetre.
_MILLIMETRE = 1 / 297
_PEN = 0.35  # mm
_HAIRLINE = 0.0005  # width of the mesh's lines, as a share of the page's longer side: .15 mm on A4
# Letter of the FOLD format: name of the layer, colour, dashes in mm. The usual notation of origami.
_CREASES = {
    "M": ("mountain", "#f00", (7.0, 1.5, 0.7, 1.5)),
    "V": ("valley", "#00f", (4.0, 2.0)),
    "F": ("open", "#888", ()),
    "U": ("unassigned", "#888", (0.7, 1.5)),
}


def write_uv_layout(path: Path, sheet: Sheet, flat: FlatMap) -> None:
    """Write the flat mesh as SVG, in mm where known: triangles grey, creases red, the paper's edge black."""
    line = _HAIRLINE * max(flat.width, flat.height)
    edges = np.unique(np.sort(directed_edges(sheet.triangles)), axis=0)
    mesh = "".join(_svg_line(flat.uv[edge]) for edge in edges)
    creases = "".join(_svg_line(flat.uv[ridge]) for ridge in sheet.ridges)
    edge_of_paper = _svg_line(flat.uv[sheet.boundary]) + "Z"
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {_frame(flat)} fill="none" stroke-linejoin="round">',
        f'<path id="page" d="M0 0H{flat.width:g}V{flat.height:g}H0Z" stroke="#88f" stroke-width="{line:g}"/>',
        f'<path id="mesh" d="{mesh}" stroke="#aaa" stroke-width="{line:g}"/>',
        f'<path id="ridges" d="{creases}" stroke="#d00" stroke-width="{3 * line:g}"/>',
        f'<path id="boundary" d="{edge_of_paper}" stroke="#000" stroke-width="{2 * line:g}"/>',
    ]
    _write(path, lines)


def write_crease_svg(path: Path, sheet: Sheet, flat: FlatMap) -> None:
    """Write the crease pattern as SVG, in mm where known, with a layer for each kind of line.

    The paper's edge is black, mountains are red dashes and dots, valleys blue dashes; unfolded creases are grey.
    Each crease is named after its fold angle.
    """
    pattern = crease_pattern(sheet, flat)
    angles = fold_angles(pattern, sheet, flat)
    kinds, segments = np.array(assignments(pattern, angles)), pattern.vertices[pattern.edges]
    millimetre = 1.0 if flat.unit == "mm" else max(flat.width, flat.height) * _MILLIMETRE
    pen = f'stroke-width="{_PEN * millimetre:g}"'
    lines = [
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'{_frame(flat)} fill="none">',
        '<g id="paper" inkscape:groupmode="layer" inkscape:label="paper">',
        *(_line(ends, f'stroke="#000" {pen} stroke-linecap="round"') for ends in segments[kinds == "B"]),
        "</g>",
    ]
    for kind, (name, color, dashes) in _CREASES.items():
        pattern_of_dashes = " ".join(f"{dash * millimetre:g}" for dash in dashes) or "none"
        look = f'stroke="{color}" {pen} stroke-dasharray="{pattern_of_dashes}"'
        found = np.flatnonzero(kinds == kind)
        if len(found):
            lines.append(f'<g id="{name}" inkscape:groupmode="layer" inkscape:label="{name}">')
            lines += [_line(segments[edge], look, _title(name, angles[edge])) for edge in found]
            lines.append("</g>")
    _write(path, lines)


def _frame(flat: FlatMap) -> str:
    """Size of a drawing of the page with a margin around it."""
    margin = _MARGIN * max(flat.width, flat.height)
    width, height = flat.width + 2 * margin, flat.height + 2 * margin
    size = f'width="{width:g}mm" height="{height:g}mm"' if flat.unit == "mm" else 'width="100%"'
    return f'{size} viewBox="{-margin:g} {-margin:g} {width:g} {height:g}"'


def _title(name: str, angle: float) -> str:
    return f"<title>{name}, {abs(angle):.0f}°</title>" if angle and np.isfinite(angle) else f"<title>{name}</title>"


def _line(ends: Array, look: str, content: str = "") -> str:
    (x1, y1), (x2, y2) = ends
    return f'<line x1="{x1:.6g}" y1="{y1:.6g}" x2="{x2:.6g}" y2="{y2:.6g}" {look}>{content}</line>'


def _write(path: Path, lines: list[str]) -> None:
    with replacing(path) as temporary:
        temporary.write_text("\n".join([*lines, "</svg>\n"]), encoding="utf-8")


def _svg_line(points: Array) -> str:
    return "M" + "L".join(f"{x:.6g} {y:.6g}" for x, y in points)
