"""Structure from motion in a separate process: pycolmap can crash or be killed without taking Blender down.

It is started by path: ``python worker.py request.json``. It writes JSON lines to stdout (``{"progress": 0.4, "text":
"..."}``) and a sign of life every few seconds, exits when stdin closes (its parent is gone), and writes ``model.npz``
and then ``result.json``, each atomically, into the folder of the request. It imports `pycolmap_worker` from its own
folder, and nothing else of the package.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from pycolmap_worker.load import load
from pycolmap_worker.look_closer import look_closer
from pycolmap_worker.messages import end_with_parent, show_life
from pycolmap_worker.on_page import place_on_page
from pycolmap_worker.place import place, place_with_own_lenses


def main(path: Path) -> None:
    end_with_parent()
    show_life()
    request = json.loads(path.read_text(encoding="utf-8"))
    what = {
        "place": place,
        "own_lenses": place_with_own_lenses,
        "look_closer": look_closer,
        "place_on_page": place_on_page,
        "load": load,
    }
    what[request["do"]](request, path.parent)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
