"""Lines, squares and texts in pixels of a view, for handlers that draw over it."""

from __future__ import annotations

from collections.abc import Sequence

from mathutils import Vector

Color = tuple[float, float, float, float]
DARK: Color = (0.0, 0.0, 0.0, 1.0)  # print behind it must not show through
_AROUND = 0.4  # of a text's size: the margin of its box


def draw_line(places: Sequence[Vector], width: float, color: Color) -> None:
    """A line through places in the view."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    gpu.state.blend_set("ALPHA")
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", color)
    batch_for_shader(shader, "LINE_STRIP", {"pos": [place.to_3d() for place in places]}).draw(shader)
    gpu.state.blend_set("NONE")


def draw_square(middle: Vector, half: float, color: Color) -> None:
    """A filled square of twice ``half`` pixels."""
    _draw_box(middle.x - half, middle.y - half, middle.x + half, middle.y + half, color)


def draw_text(place: Vector, text: str, size: float, color: Color) -> None:
    """A text on a dark box whose lower edge is in the middle over a place: readable on print, too."""
    import blf

    blf.size(0, size)
    width, height = blf.dimensions(0, text)
    left, around = place.x - width / 2, _AROUND * size
    _draw_box(left - around, place.y, left + width + around, place.y + height + 2 * around, DARK)
    blf.color(0, *color)
    blf.position(0, left, place.y + around, 0)
    blf.draw(0, text)


def _draw_box(left: float, low: float, right: float, high: float, color: Color) -> None:
    import gpu
    from gpu_extras.batch import batch_for_shader

    corners = [(left, low, 0), (right, low, 0), (right, high, 0), (left, high, 0)]
    gpu.state.blend_set("ALPHA")
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", color)
    batch_for_shader(shader, "TRIS", {"pos": corners}, indices=[(0, 1, 2), (0, 2, 3)]).draw(shader)
    gpu.state.blend_set("NONE")
