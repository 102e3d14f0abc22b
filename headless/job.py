"""One job of the add-on, in a separate Blender; `origami_addon/jobs/process.py` starts it with the job's folder."""

from __future__ import annotations

import os
import runpy
import sys
from pathlib import Path

if __name__ == "__main__":
    module = runpy.run_path(str(Path(__file__).with_name("rectify.py")))["module"]
    code = module("origami_addon.jobs.worker").main(Path(sys.argv[-1]))
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # everything is written, and Blender 4.5 as a module does not always exit on its own
