"""The work of each stage, one function each, which whole runs and jobs share; and writing the results.

Each function is named after the verb of its stage in `stages.py`. Slow results are kept in the work folder, so that a
second run with another resolution, for example, does not compute the surface again.
"""

from .find import find_sheet, sheets_in_view
from .lay_out import lay_out_page
from .page import make_page
from .place import place_photos
from .results import finished, write_results
from .surface import build_surface
from .unwrap import unwrap_sheet
from .work import Work

__all__ = [
    "Work",
    "build_surface",
    "find_sheet",
    "finished",
    "lay_out_page",
    "make_page",
    "place_photos",
    "sheets_in_view",
    "unwrap_sheet",
    "write_results",
]
