"""Presets: settings for each kind of document."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from .paper_size import PAPER_SIZES_MM
from .scene.settings_group import settings_from, settings_to_json
from .settings import RunSettings
from .settings_json import from_json


@dataclass(frozen=True)
class Preset:
    """A named set of settings; the others have their defaults, except the page's, which stay.

    Attributes
    ----------
    label, description : str
    content : dict
        As in a settings file.
    """

    label: str
    description: str
    content: dict[str, Any] = field(default_factory=dict)


UNKNOWN = "sheet"  # the kind without assumptions: every setting has the command line's default

PRESETS = {
    UNKNOWN: Preset(
        "Any Sheet",
        "Paper or a book's page of unknown size: the page gets its true shape only",
        {"page": {"paper_size_mm": None}},
    ),
    "draft": Preset(
        "Draft",
        "A quick look: small photos for matching, a coarse surface",
        {"sfm": {"max_image_size": 1200, "max_features": 4096}, "surface": {"grid_rows": 50}},
    ),
    "letter": Preset(
        "A4 Letter or Form",
        "A sheet of A4, folded or crumpled",
        {"page": {"paper_size_mm": list(PAPER_SIZES_MM["A4"])}},
    ),
    "us_letter": Preset(
        "US Letter or Form",
        "A sheet of US Letter, folded or crumpled",
        {"page": {"paper_size_mm": list(PAPER_SIZES_MM["Letter"])}},
    ),
    "receipt": Preset(
        "Receipt",
        "A strip 80 mm wide, of any length; a finer surface",
        {"page": {"paper_size_mm": [80, None]}, "surface": {"grid_rows": 120}},
    ),
    "archive": Preset(
        "Archive",
        "For archiving: large photos for matching, a fine surface, one thread; a second run gives the same result, "
        "bit for bit",
        {"sfm": {"max_image_size": 3000, "max_features": 16384, "threads": 1}, "surface": {"grid_rows": 120}},
    ),
}


def apply_preset(group: Any, name: str) -> None:
    """Set a document's settings to a preset; its page, reference photo and COLMAP model stay unless the preset says so.

    Parameters
    ----------
    group : OrigamiSettings
    name : str
        One of `PRESETS`.
    """
    now = from_json(settings_to_json(group))
    kept = replace(RunSettings(), page=now.page, image=now.image, reference=now.reference)
    colmap_model = group.colmap_model
    settings_from(group, from_json(PRESETS[name].content, kept))
    group.colmap_model = colmap_model
