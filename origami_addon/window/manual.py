"""F1 over a button or a setting opens the manual's page about it.

An installed extension contains the manual as web pages; a checkout has them once `make docs` has run, and until then
their source.
"""

from __future__ import annotations

from pathlib import Path

import bpy

from ..scene.declared import shown_settings
from ..settings import RunSettings
from ..stages import about

_ROOT = Path(__file__).resolve().parents[2]
# Possible folders of the manual, best first, and the endings of its pages there.
_FOLDERS = (("docs", ".html"), ("out/docs", ".html"), ("docs", ".md"))

# Page and section of every operator and every group of properties, or of single properties if a group is split.
_OPERATORS = {
    "add_crease": "editing#creases",
    "add_folders": "photos#several-documents",
    "add_other_light": "page#another-light",
    "add_photos": "photos#add-photos",
    "apply_page_frame": "page#cut-the-page-by-hand",
    "apply_preset": "photos#kind-of-document",
    "cancel": "quick_start#stop-or-cancel",
    "choose_crease": "editing#creases",
    "clear_work": "preferences#kept-results",
    "compare_methods": "unwrap#compare",
    "delete_document": "photos#several-documents",
    "draw_crease": "editing#creases",
    "drop_crease": "editing#creases",
    "duplicate_document": "photos#several-documents",
    "edit_outline": "editing#outline",
    "edit_page_frame": "page#cut-the-page-by-hand",
    "export": "export#files",
    "export_settings": "export#settings-for-the-command-line",
    "find_photos": "photos#find-moved-photos",
    "lay_other_photos": "page#another-light",
    "leave_queue": "photos#several-documents",
    "look_through": "photos#look-through-a-photo",
    "paint_ridges": "editing#creases",
    "pick_sheet": "sheet#take-another-sheet",
    "rebuild_sheet": "editing#creases",
    "rectify": "quick_start#rectify",
    "rectify_all": "photos#several-documents",
    "rectify_next": "photos#several-documents",
    "remove_photo": "photos#leave-a-photo-out",
    "resume_queue": "photos#several-documents",
    "run_stage": "editing#which-step-to-run",
    "show_as": "page#look",
    "show_sheet": "unwrap#look",
    "start_folders": "photos#several-documents",
    "stop": "quick_start#stop-or-cancel",
    "take_sheet": "sheet#take-another-sheet",
    "turn_page": "page#turn-the-page",
    "unwrap_developable": "unwrap_developable#settings",
    "unwrap_mesh": "unwrap_developable#settings",
    "write_files": "export#files",
}
_TYPES = {
    "ORIGAMI_MT_presets": "photos#kind-of-document",
    "OrigamiDocument.title": "photos#several-documents",
    "OrigamiDocument.*": "photos#the-list",
    "OrigamiImageSettings.bake": "command_line#bake",
    "OrigamiFolder.*": "photos#several-documents",
    "OrigamiPhoto.*": "photos#leave-a-photo-out",
    "OrigamiScene.document": "photos#several-documents",
    "OrigamiScene.place": "photos#several-documents",
    "OrigamiScene.show_creases": "surface#look",
    "OrigamiScene.show_errors": "placement#look",
    "OrigamiStage.*": "editing#which-step-to-run",
    **{
        f"Origami{each.kind.__name__}.*" if each.is_group else f"OrigamiSettings.{each.name}": (
            f"{about(each.stage).manual}#settings"
        )
        for each in shown_settings(RunSettings)
    },
    "OrigamiSettings.*": "index",
}


def manual_map(root: Path = _ROOT) -> tuple[str, tuple[tuple[str, str], ...]]:
    """The manual's folder as a URL, and for each name or pattern of operators or settings the page in it."""
    folder, ending = next((root / name, end) for name, end in _FOLDERS if (root / name / f"index{end}").is_file())
    places = {
        **{f"bpy.ops.origami.{name}": place for name, place in _OPERATORS.items()},
        **{f"bpy.types.{name}": place for name, place in _TYPES.items()},
    }
    # Blender asks in lower case.
    return f"{folder.as_uri()}/", tuple((name.lower(), _page(place, ending)) for name, place in places.items())


def _page(place: str, ending: str) -> str:
    page, hash_sign, section = place.partition("#")
    return f"{page}{ending}{hash_sign}{section}"


def register() -> None:
    """Let F1 find the pages."""
    bpy.utils.register_manual_map(manual_map)


def unregister() -> None:
    """Undo `register`."""
    bpy.utils.unregister_manual_map(manual_map)
