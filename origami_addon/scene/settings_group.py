"""Blender's properties for a document's settings, which are those of `settings.py`."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import EnumProperty, FloatProperty

from ...core.flat.flatten import FlattenSettings
from ...core.placing.result import SfmSettings
from ...core.setting import declaration
from ...core.surface.surface_settings import SurfaceSettings
from ..paper_size import PAPER_SIZES_MM
from ..settings import ImageSettings, PageSettings, RunSettings
from .declared import properties_of, sentence, shown_settings

NO_PAPER, OTHER_PAPER = "none", "other"

_PAPER = declaration(PageSettings, "paper_size_mm")
_PAPERS = [
    (NO_PAPER, "Unknown", sentence(_PAPER.without)),
    *((name, name, f"{width:g} x {height:g} mm") for name, (width, height) in PAPER_SIZES_MM.items()),
    (OTHER_PAPER, "Other", "Type the width and, if known, the height"),
]


class OrigamiSfmSettings(bpy.types.PropertyGroup):
    """How the photos are placed."""

    __annotations__ = properties_of(SfmSettings)


class OrigamiSurfaceSettings(bpy.types.PropertyGroup):
    """How the surface is reconstructed."""

    __annotations__ = properties_of(SurfaceSettings)


class OrigamiFlattenSettings(bpy.types.PropertyGroup):
    """How the sheet is unwrapped."""

    __annotations__ = properties_of(FlattenSettings)


class OrigamiPageSettings(bpy.types.PropertyGroup):
    """Size and orientation of the page."""

    __annotations__ = {
        "paper": EnumProperty(name=_PAPER.label, description=sentence(_PAPER.help), items=_PAPERS, default=NO_PAPER),
        "width": FloatProperty(
            name="Width (mm)",
            description="Of the paper, in millimetres",
            default=80.0,
            min=_PAPER.least,
            max=_PAPER.most,
            precision=1,
        ),
        "height": FloatProperty(
            name="Height (mm)",
            description="Of the paper, in millimetres; 0 if the sheet determines it, as for a receipt",
            default=0.0,
            min=0.0,
            max=_PAPER.most,
            precision=1,
        ),
        **properties_of(PageSettings),
    }


class OrigamiImageSettings(bpy.types.PropertyGroup):
    """The page image."""

    __annotations__ = properties_of(ImageSettings)


_GROUPS = {
    SfmSettings: OrigamiSfmSettings,
    SurfaceSettings: OrigamiSurfaceSettings,
    FlattenSettings: OrigamiFlattenSettings,
    PageSettings: OrigamiPageSettings,
    ImageSettings: OrigamiImageSettings,
}


class OrigamiSettings(bpy.types.PropertyGroup):
    """All settings of a document."""

    __annotations__ = properties_of(RunSettings, _GROUPS)


SETTINGS_CLASSES = (*_GROUPS.values(), OrigamiSettings)  # in the order in which Blender must learn of them


def settings_to_json(group: Any) -> dict[str, Any]:
    """The settings in a property group, in the form that `settings_json.from_json` reads."""
    content = _values(group, RunSettings)
    page = group.page
    size: tuple[float, float | None] | None = None
    if page.paper == OTHER_PAPER:
        size = (_exact(page.width), _exact(page.height) or None)
    elif page.paper != NO_PAPER:
        size = PAPER_SIZES_MM[page.paper]
    content["page"][_PAPER.name] = None if size is None else list(size)
    content["colmap_model"] = bpy.path.abspath(group.colmap_model) or None
    return content


def _values(group: Any, settings: type) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for each in shown_settings(settings):
        value = getattr(group, each.name)
        if each.is_group:
            values[each.name] = _values(value, each.kind)
        elif each.choices and not value:  # the choice of an older file that is gone
            values[each.name] = each.default
        else:
            values[each.name] = None if each.default is None and not value else _exact(value)
    return values


def _exact(value: Any) -> Any:
    """The number that the user typed: Blender only keeps single precision."""
    return float(f"{value:.6g}") if isinstance(value, float) else value


def settings_from(group: Any, settings: RunSettings) -> None:
    """Set a property group to ``settings``; an outline, which is an object, is not part of it."""
    assert settings.sheet != "all"  # each of them has its own document
    _set_values(group, settings)
    size = settings.page.paper_size_mm
    named = next((name for name, known in PAPER_SIZES_MM.items() if size in (known, known[::-1])), OTHER_PAPER)
    group.page.paper = NO_PAPER if size is None else named
    if size is not None:
        group.page.width, group.page.height = size[0], size[1] or 0


def _set_values(group: Any, settings: Any) -> None:
    for each in shown_settings(type(settings)):
        value = getattr(settings, each.name)
        if each.is_group:
            _set_values(getattr(group, each.name), value)
        else:
            setattr(group, each.name, each.kind() if value is None else value)
