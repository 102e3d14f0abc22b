"""The command `iiif_tiles`: a page cut into tiles, as IIIF's Image API asks of a folder without a program behind it."""

from __future__ import annotations

import argparse
import json
import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...core.errors import UsageError
from ...origami_addon.files.atomic import WRITING
from ...origami_addon.files.links import is_link, real
from ...origami_addon.files.marker import claim, foreign, owners
from ...origami_addon.system_errors import unwritable_as_failure
from .command import exit_code_of
from .finished_run import FinishedRun, finished_run
from .pictures import opened, written

# What the tiles are of; `iiif_manifest` reads it. It is written last.
TILES = "tiles.json"
_OWNER = "iiif"  # in the marker of a folder of tiles
TILE = 512  # pixels, as viewers ask for by themselves
_QUALITY = 88  # of the JPEG files: on the example, text at 100 % looks like the TIFF's


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code; never raises."""
    return exit_code_of(lambda: _tiles(argv))


def _tiles(argv: Sequence[str]) -> None:
    parser = argparse.ArgumentParser(
        prog="iiif_tiles.py",
        description="Cut a finished page into tiles for IIIF: IIIF/NAME, with the name of the document's folder. Then "
        "run iiif_manifest.py on IIIF.",
        allow_abbrev=False,
    )
    parser.add_argument("document", metavar="DOCUMENT", type=Path, help="the folder of a finished run of rectify.py")
    parser.add_argument("iiif", metavar="IIIF", type=Path, help="the folder for the tiles of all documents")
    arguments = parser.parse_args(argv)
    write_tiles(finished_run(arguments.document), arguments.iiif)


def write_tiles(run: FinishedRun, iiif: Path) -> None:
    """Write the folder of a page's tiles, or leave it if it is of this page already.

    Raises
    ------
    UsageError, StepFailed
    """
    picture, name = run.file("page.tif"), run.title
    with unwritable_as_failure(iiif):
        iiif.mkdir(parents=True, exist_ok=True)
    # From here, so that all may move together.
    document = Path(os.path.relpath(real(run.folder), real(iiif))).as_posix()
    claimed = {"document": document, "of_page": run.hash_of("page.tif"), "tile": TILE, "quality": _QUALITY}
    target = iiif / name
    _keep_off_others(target, document)
    if _content(target).items() >= claimed.items():
        return
    with unwritable_as_failure(iiif):
        new = Path(tempfile.mkdtemp(prefix=WRITING, dir=iiif))
    try:
        size, factors, sizes = _cut(picture, new / name)
        content = claimed | {"title": name, "width": size[0], "height": size[1], "factors": factors, "sizes": sizes}
        (new / name / TILES).write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        with unwritable_as_failure(iiif):
            claim(new / name, [TILES], _OWNER)
            if target.exists():
                os.replace(target, new / "before")
            os.replace(new / name, target)
    finally:
        shutil.rmtree(new, ignore_errors=True)


def _keep_off_others(target: Path, document: str) -> None:
    """Refuse to replace anything but the document's earlier folder of tiles, or an empty folder.

    Raises
    ------
    UsageError
    """
    if not os.path.lexists(target):
        return
    if is_link(target) or not target.is_dir() or (any(target.iterdir()) and owners(target, []) is None):
        raise UsageError(foreign(target.parent, target.name))
    other = _content(target).get("document", document)
    if other != document:
        raise UsageError(
            f"{target} holds the tiles of another document, {target.parent / other}, which has the same name; choose "
            f"another folder for the tiles, or delete {target} if that document is gone."
        )


def _cut(picture: Path, to: Path) -> tuple[tuple[int, int], list[int], list[list[int]]]:
    """Write the tiles, and the whole page in full size and at each reduction.

    Returns
    -------
    size : (width, height)
    factors : list of int
        By which the page is reduced.
    sizes : list of [width, height]
        Of the whole page when reduced, from the smallest on; of a page that needs no tiles, its own size.

    Raises
    ------
    UsageError, StepFailed
    """
    image = opened(picture)
    if image.get_typeof("icc-profile-data"):
        # Browsers show tiles without looking for a profile in each.
        image = image.icc_transform("srgb", embedded=True, depth=8)
    if image.format != "uchar":
        image = image.cast("uchar", shift=True)
    how = {"Q": _QUALITY, "keep": "none"}
    suffix = f".jpg[Q={_QUALITY},keep=none]"
    written(image.dzsave, str(to), layout="iiif3", tile_size=TILE, overlap=0, suffix=suffix)
    (to / "info.json").unlink()  # `iiif_manifest` writes it, when the address is known
    factors, sizes = [1], list[list[int]]()
    while max(image.width, image.height) > TILE * factors[-1]:
        factors.append(2 * factors[-1])
        reduced = image.shrink(factors[-1], factors[-1], ceil=True)
        sizes.insert(0, [reduced.width, reduced.height])
        # libvips has written the smallest, which is one tile. OpenSeadragon takes the sizes for those of the levels,
        # so none may be missing.
        written(reduced.jpegsave, str(_whole(to, f"{reduced.width},{reduced.height}")), **how)
    written(image.jpegsave, str(_whole(to, "max")), **how)
    return (image.width, image.height), factors, sizes or [[image.width, image.height]]


def _whole(to: Path, size: str) -> Path:
    """Where the whole page of this size belongs; its folder is made."""
    folder = to / "full" / size / "0"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / "default.jpg"


def _content(folder: Path) -> dict[str, Any]:
    """The content of the file that describes a folder's tiles; empty if there is none."""
    try:
        content = json.loads((folder / TILES).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def tiles_in(iiif: Path) -> dict[str, dict[str, Any]]:
    """The pages in a folder of tiles, by the names of their folders, in order.

    Raises
    ------
    UsageError
        If there are none.
    """
    folders = sorted(path for path in iiif.iterdir() if path.is_dir()) if iiif.is_dir() else []
    pages = {path.name: _content(path) for path in folders}
    finished = {name: content for name, content in pages.items() if content and not name.startswith(WRITING)}
    if not finished:
        raise UsageError(f"{iiif} holds no page in tiles; run iiif_tiles.py first.")
    return finished
