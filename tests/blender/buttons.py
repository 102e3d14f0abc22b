"""What the tab shows now, as the panels draw it: its buttons and its settings.

The panels draw into a recorder instead of a layout, so that new buttons and settings are found too, and what fails
while a panel is drawn is an ordinary exception.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy


@dataclass(frozen=True)
class Button:
    """A button: an operator of the add-on by its name, and the properties that the panel gives it."""

    operator: str
    properties: dict[str, Any]

    def __str__(self) -> str:
        given = ", ".join(f"{name}={value!r}" for name, value in self.properties.items())
        return f"{self.operator}({given})"

    @property
    def call(self) -> Any:
        """The operator."""
        return getattr(bpy.ops.origami, self.operator)

    def is_enabled(self) -> bool:
        """Whether the button is not grey."""
        return bool(self.call.poll())


@dataclass(frozen=True)
class Setting:
    """A setting: a property of some data."""

    owner: Any
    name: str

    @property
    def declared(self) -> Any:
        """Its declaration."""
        return self.owner.bl_rna.properties[self.name]

    def __str__(self) -> str:
        return f"{self.owner.bl_rna.identifier}.{self.name}"


@dataclass
class _Recorder:
    """Stands for a layout and everything in it."""

    buttons: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    settings: list[Setting] = field(default_factory=list)

    def operator(self, name: str, **_: Any) -> Any:
        properties: dict[str, Any] = {}
        self.buttons.append((name, properties))
        return _Properties(properties)

    def prop(self, owner: Any, name: str, **_: Any) -> None:
        self.settings.append(Setting(owner, name))

    def prop_search(self, owner: Any, name: str, *_: Any, **__: Any) -> None:
        self.prop(owner, name)

    def template_list(self, kind: str, _: str, owner: Any, items: str, at: Any, active: str, **__: Any) -> None:
        self.prop(at, active)
        for item in getattr(owner, items):
            getattr(bpy.types, kind).draw_item(None, bpy.context, self, owner, item, 0, at, active)

    def menu(self, name: str, **_: Any) -> None:
        drawn = getattr(bpy.types, name)
        drawn.draw(_Drawn(self), bpy.context)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *_, **__: self

    def __setattr__(self, name: str, value: Any) -> None:
        if name in ("buttons", "settings"):
            object.__setattr__(self, name, value)


class _Properties:
    def __init__(self, properties: dict[str, Any]) -> None:
        object.__setattr__(self, "given", properties)

    def __setattr__(self, name: str, value: Any) -> None:
        self.given[name] = value


@dataclass
class _Drawn:
    layout: _Recorder


def shown(panels: Any) -> tuple[list[Button], list[Setting]]:
    """The buttons, grey ones too, and the settings of the tab with all its steps open.

    Parameters
    ----------
    panels : module
        The add-on's `window.panels`.
    """
    recorder = _Recorder()
    for kind in (panels.MainPanel, *panels.STEP_PANELS):
        if not hasattr(kind, "poll") or kind.poll(bpy.context):
            panel = object.__new__(kind)
            panel.layout = recorder
            if hasattr(panel, "draw_header_preset"):
                panel.draw_header_preset(bpy.context)
            panel.draw(bpy.context)
    own = [Button(name.removeprefix("origami."), given) for name, given in recorder.buttons if "origami." in name]
    return own, recorder.settings
