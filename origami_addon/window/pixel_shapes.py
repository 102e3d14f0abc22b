"""Lines, squares and texts in pixels of a view, for handlers that draw over it."""

from __future__ import annotations

from collections.abc import Sequence

from mathutils import Vector

Color = tuple[float, float, float, float]
DARK: Color = (0.0, 0.0, 0.0, 0.8)
_SHADOW = 5  # Blender's largest blur of a text's shadow


def draw_line(places: Sequence[Vector], width: float, color: Color) -> None:
    """A line through places in the view."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", color)
    batch_for_shader(shader, "LINE_STRIP", {"pos": [place.to_3d() for place in places]}).draw(shader)


def draw_square(middle: Vector, half: float, color: Color) -> None:
    """A filled square of twice ``half`` pixels."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    corners = [(middle.x + x * half, middle.y + y * half, 0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", color)
    batch_for_shader(shader, "TRIS", {"pos": corners}, indices=[(0, 1, 2), (0, 2, 3)]).draw(shader)


def draw_text(place: Vector, text: str, size: float, color: Color) -> None:
    """A text whose lower edge is in the middle over a place, readable on paper and on the view's background."""
    import blf

    blf.size(0, size)
    width, _ = blf.dimensions(0, text)
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, _SHADOW, *DARK)
    blf.color(0, *color)
    blf.position(0, place.x - width / 2, place.y, 0)
    blf.draw(0, text)
    blf.disable(0, blf.SHADOW)
