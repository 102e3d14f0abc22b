"""A METS workspace of a finished page: python workflow/scripts/handover.py OUT/DOCUMENT

`workflow/delivery/handover.py` is the command; this file only finds it.
"""

from __future__ import annotations

import importlib
import runpy
import sys
from pathlib import Path

if __name__ == "__main__":
    runpy.run_path(str(Path(__file__).resolve().parents[2] / "headless" / "checkout.py"))["load_checkout"]()
    sys.exit(importlib.import_module("origami.workflow.delivery.handover").main(sys.argv[1:]))
