"""The roles of a document's objects."""

from __future__ import annotations

CAMERA, POINTS, OUTLINE, SHEET, PAGE, PAGE_FRAME = "camera", "points", "outline", "sheet", "page", "page frame"
OTHER_PAGE = "other page"
ORIGIN = "origin"  # of the object that moves all others
