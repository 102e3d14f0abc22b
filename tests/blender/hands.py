"""Mouse, keyboard and camera of a user in front of Blender's window.

Whatever takes time is a generator that yields the seconds to wait, so Blender's main loop continues. Buttons are found
as a user finds them: the mouse moves over the sidebar until it is over the right one.
"""

from __future__ import annotations

import subprocess
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

Waits = Generator[float, None, Any]

_ROW = 8  # pixels between two looks
_LOOK_SECONDS = 0.3
_NOTICED_SECONDS = 0.3  # until Blender has handled an event
_LOADED_SECONDS = 3.0  # until a file that was opened is drawn
_COLUMNS = (0.3, 0.83, 0.1, 0.5, 0.9)  # of the sidebar's width
_ARROW = slice(28, 42)  # of the sidebar: where the headers of the steps have theirs, in pixels
_BRIGHT = 170
_BLUE = np.array([71, 114, 179])  # of the button that Return stands for
_COLORS = 255


class Hands:
    """They act on the first window.

    Parameters
    ----------
    pictures : Path
        Folder for pictures.
    steps : sequence of str
        The steps below the big button, in order.
    """

    def __init__(self, pictures: Path, steps: Sequence[str]) -> None:
        self.pictures = pictures
        self.steps = steps
        self.mouse = (0, 0)
        self._known_headers: dict[str, list[int]] = {}
        self._found_at: dict[tuple[str, str], tuple[int, int]] = {}  # where buttons were last time

    @property
    def window(self) -> Any:
        """The first window; a different one after a file was opened."""
        return bpy.context.window_manager.windows[0]

    def area(self, kind: str = "VIEW_3D") -> Any:
        """The largest area of a kind."""
        areas = [area for area in self.window.screen.areas if area.type == kind]
        return max(areas, key=lambda area: area.width * area.height)

    def region(self, kind: str, area: str = "VIEW_3D") -> Any:
        """A region of that area."""
        return next(region for region in self.area(area).regions if region.type == kind)

    def at(self, kind: str = "WINDOW", area: str = "VIEW_3D") -> Any:
        """Operators called within this block act on this region."""
        return bpy.context.temp_override(window=self.window, area=self.area(area), region=self.region(kind, area))

    def move(self, x: float, y: float) -> Waits:
        """Put the mouse somewhere; pixels from the lower left corner."""
        self.window.event_simulate(type="MOUSEMOVE", value="NOTHING", x=int(x), y=int(y))
        self.mouse = int(x), int(y)
        yield 0.05

    def over(self, kind: str = "WINDOW", area: str = "VIEW_3D") -> Waits:
        """Put the mouse into the middle of a region."""
        region = self.region(kind, area)
        yield from self.move(region.x + region.width // 2, region.y + region.height // 2)

    def open(self, path: Path | None, seconds: float = _LOADED_SECONDS) -> Waits:
        """Open a file, or begin a new one if None.

        After a click on a panel's header Blender keeps the click's handler until the next event, but has freed its
        data, and frees them once more with the window's handlers, if a script opens a file before that event. A user
        cannot do so, because opening begins with an event.
        """
        yield from self.move(*self.mouse)
        yield _NOTICED_SECONDS
        if path is None:
            bpy.ops.wm.read_homefile(app_template="")
        else:
            bpy.ops.wm.open_mainfile(filepath=str(path))
        yield seconds

    def click(self, x: float, y: float) -> Waits:
        """Click with the left button."""
        yield from self.move(x, y)
        yield 0.1
        yield from self.key("LEFTMOUSE")

    def key(self, key: str, *modifiers: str) -> Waits:
        """Press and release a key."""
        held = dict.fromkeys(modifiers, True)
        for value in ("PRESS", "RELEASE"):
            self.window.event_simulate(type=key, value=value, x=self.mouse[0], y=self.mouse[1], **held)
            yield 0.1

    def take(self, x: float, y: float) -> Waits:
        """Press the left button somewhere, and hold it."""
        yield from self.move(x, y)
        yield 0.1
        self.window.event_simulate(type="LEFTMOUSE", value="PRESS", x=self.mouse[0], y=self.mouse[1])
        yield 0.1

    def let_go(self) -> Waits:
        """Release the left button."""
        self.window.event_simulate(type="LEFTMOUSE", value="RELEASE", x=self.mouse[0], y=self.mouse[1])
        yield 0.1

    def find(self, wanted: str, area: str = "VIEW_3D") -> Waits:
        """The place of a button in the sidebar: of an operator as Python has it, or of a property by its path."""
        sidebar = self.region("UI", area)
        everywhere = (
            (sidebar.x + int(column * sidebar.width), sidebar.y + sidebar.height - down)
            for column in _COLUMNS
            for down in range(20, sidebar.height, _ROW)
        )
        yield from self.move(sidebar.x, sidebar.y)  # off the button pressed last
        known = self._found_at.get((wanted, area))
        if known is not None and (yield from self._is_at(known, wanted, area)):
            return known
        for place in everywhere:
            yield from self.move(*place)
            if wanted in self._under(area) and (yield from self._is_at(place, wanted, area)):
                self._found_at[wanted, area] = place
                return place
        raise AssertionError(f"no button {wanted} in the sidebar")

    def _is_at(self, place: tuple[int, int], wanted: str, area: str) -> Waits:
        """Whether a button is there; a busy Blender may still use the old mouse position."""
        yield from self.move(*place)
        yield _LOOK_SECONDS
        return wanted in self._under(area)

    def press(self, wanted: str, area: str = "VIEW_3D") -> Waits:
        """Click a button of the sidebar."""
        place = yield from self.find(wanted, area)
        yield from self.click(*place)
        yield 0.3

    def _under(self, area: str) -> str:
        """The action of the button under the mouse."""
        with self.at("UI", area):
            bpy.context.window_manager.clipboard = ""
            if bpy.ops.ui.copy_python_command_button.poll():
                bpy.ops.ui.copy_python_command_button()
                return str(bpy.context.window_manager.clipboard)
            return "" if bpy.context.property is None else bpy.context.property[1]

    def show_tab(self, name: str, area: str = "VIEW_3D") -> Waits:
        """Open the sidebar if it is closed and click its tab."""
        if not self.area(area).spaces.active.show_region_ui:
            yield from self.over(area=area)
            yield from self.key("N")
            yield 1.5
        sidebar = self.region("UI", area)
        for down in range(30, 400, 20):
            if sidebar.active_panel_category == name:
                return
            yield from self.click(sidebar.x + sidebar.width - 12, sidebar.y + sidebar.height - down)
            yield 0.3
        raise AssertionError(f"no tab {name}")

    def toggle(self, step: str, area: str = "VIEW_3D") -> Waits:
        """Click the header of a step; those above it must be closed."""
        sidebar = self.region("UI", area)
        headers = yield from self._headers(area)
        yield from self.click(sidebar.x + 120, headers[self.steps.index(step)])
        yield 0.8

    def _headers(self, area: str) -> Waits:
        """Where the headers of the closed steps are: they are the last with an arrow, 26 pixels apart."""
        if area not in self._known_headers:
            yield from self.over(area=area)
            yield 0.3
            sidebar = self.region("UI", area)
            shown = self.pixels(self.box(sidebar))[:, _ARROW].max(axis=(1, 2)) > _BRIGHT
            (starts,) = np.nonzero(np.diff(shown.astype(int)) == 1)
            (ends,) = np.nonzero(np.diff(shown.astype(int)) == -1)
            self._known_headers[area] = [
                sidebar.y + sidebar.height - int(middle) for middle in (starts + ends + 1)[-len(self.steps) :] / 2
            ]
        return self._known_headers[area]

    def press_blue(self, picture: str) -> Waits:
        """Click the highlighted button in a dialog, and keep a picture of it."""
        view = self.region("WINDOW")
        pixels = self.pixels(self.box(view)).astype(int)
        rows, columns = np.nonzero((np.abs(pixels - _BLUE) < 24).all(axis=2))
        # A checkbox is blue too, but small: the button has the longest row of that colour.
        row = np.bincount(rows).argmax()
        column = np.median(columns[rows == row])
        x, y = view.x + column, view.y + view.height - row
        self.picture(picture, (int(x) - 300, self.window.height - int(y) - 210, 480, 260))
        yield from self.click(x, y)

    def box(self, region: Any) -> tuple[int, int, int, int]:
        """Left, top, width and height of a region, an area or a window on the screen."""
        return region.x, self.window.height - region.y - region.height, region.width, region.height

    def pixels(self, box: tuple[int, int, int, int]) -> NDArray[np.uint8]:
        """The screen's pixels there, (height, width, 3)."""
        left, top, width, height = box
        command = ["import", "-window", "root", "-crop", f"{width}x{height}+{left}+{top}", "-depth", "8", "rgb:-"]
        done = subprocess.run(command, check=True, capture_output=True)
        return np.frombuffer(done.stdout, np.uint8).reshape(height, width, 3)

    def picture(self, name: str, box: tuple[int, int, int, int] | None = None, percent: int = 100) -> None:
        """Save the screen, or a part of it, in few colours, reduced to a percentage of its size."""
        crop = [] if box is None else ["-crop", "{2}x{3}+{0}+{1}".format(*box), "+repage"]
        subprocess.run(["import", "-window", "root", *crop, *self._reduced(name, percent)], check=True)

    def keep(self, name: str, pixels: NDArray[np.uint8], percent: int = 100) -> None:
        """Save pixels (height, width, 3) of the screen like a picture."""
        height, width = pixels.shape[:2]
        command = ["convert", "-size", f"{width}x{height}", "-depth", "8", "rgb:-", *self._reduced(name, percent)]
        subprocess.run(command, check=True, input=pixels.tobytes())

    def _reduced(self, name: str, percent: int) -> list[str]:
        return ["-resize", f"{percent}%", "+dither", "-colors", str(_COLORS), f"png8:{self.pictures / name}.png"]

    def sidebar_picture(self, name: str, area: str = "VIEW_3D") -> Waits:
        """Save a picture of the sidebar, down to its last row, without its tabs."""
        yield from self.over(area=area)
        yield 0.4
        left, top, width, height = self.box(self.region("UI", area))
        width -= 22
        shown = self.pixels((left, top, width, height)).astype(int)
        filled = np.nonzero((np.abs(shown - shown[-4, 4]) > 6).any(axis=(1, 2)))[0]
        self.picture(name, (left, top, width, min(height, int(filled[filled < height - 3].max(initial=0)) + 8)))

    def forget_places(self) -> None:
        """Forget the buttons' places, because the sidebar has changed above its steps."""
        self._known_headers.clear()
