"""The manifest of pages in tiles: python workflow/scripts/iiif_manifest.py OUT/iiif --url https://example.org/iiif

`workflow/delivery/iiif_manifest.py` is the command; this file only finds it.
"""

from __future__ import annotations

import importlib
import runpy
import sys
from pathlib import Path

if __name__ == "__main__":
    runpy.run_path(str(Path(__file__).resolve().parents[2] / "headless" / "checkout.py"))["load_checkout"]()
    sys.exit(importlib.import_module("origami.workflow.delivery.iiif_manifest").main(sys.argv[1:]))
