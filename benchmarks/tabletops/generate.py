"""Generate photos of sheets on tables, with the exact outline of the sheet in every photo.

    .venv/bin/python benchmarks/tabletops/generate.py --seeds 0-59 --out DIR

A seed gives the same folder every time: photos/, truth.json and contact.jpg. The benchmark measures on the seeds 0 to
59; tune on others, 1000 to 1059, so that the figures tell what happens on tables nobody has tuned for. Sixty seeds in a
row have each kind of table four times, and each kind of sheet eight or nine times.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from tabletops import photo as photos  # noqa: E402
from tabletops import scene as scenes  # noqa: E402

SIZE = (1600, 1200)
# Height of a photo in the contact sheet.
_CONTACT = 300


def write(seed: int, folder: Path, size: tuple[int, int] = SIZE) -> None:
    """Make the scene of a seed and write it into ``folder``, which then holds nothing else."""
    scene = scenes.make(seed, size)
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "photos").mkdir(parents=True)
    random = np.random.default_rng([seed, 7])
    quality, has_exif = int(random.integers(80, 96)), bool(random.random() < 0.5)
    told, small = [], []
    for index, view in enumerate(scene.views):
        taken = photos.take(scene, index)
        image = Image.fromarray(taken.pixels)
        name = f"{index:02d}.jpg"
        exif = {"exif": _exif(view.focal_length, max(size), index)} if has_exif else {}
        image.save(folder / "photos" / name, quality=quality, **exif)
        small.append(image.resize((round(_CONTACT * view.width / view.height), _CONTACT)))
        told.append(
            {
                "file": name,
                "width": view.width,
                "height": view.height,
                "focal_length": view.focal_length,
                "k1": view.k1,
                "rotation": view.rotation.tolist(),
                "translation": view.translation.tolist(),
                "outline": taken.outline.round(3).tolist(),
                "corners": view.project(_corners(scene)).round(3).tolist(),
                "cut_off": index in scene.cut_off,
                "hand_on_sheet": taken.hand_on_sheet,
            }
        )
    truth = {
        "seed": seed,
        "table": scene.table_kind,
        "sheet": scene.sheet.kind,
        "paper": scene.paper_kind,
        "layout": scene.layout,
        "page_mm": [scene.sheet.width, scene.sheet.height],
        "clutter": scene.clutter,
        "on_the_sheet": scene.overlapping,
        "facets": [
            {"flat": f.flat.tolist(), "rotation": f.rotation.tolist(), "origin": f.origin.tolist()}
            for f in scene.sheet.facets
        ],
        "photos": told,
    }
    (folder / "truth.json").write_text(json.dumps(truth), encoding="utf-8")
    _contact_sheet(small).save(folder / "contact.jpg", quality=88)


def _corners(scene: scenes.Scene) -> np.ndarray:
    from tabletops.shapes import in_space, page_corners

    return in_space(scene.sheet.facets, page_corners(scene.sheet.width, scene.sheet.height))


def _exif(focal_length: float, long_side: int, index: int) -> Image.Exif:
    exif = Image.Exif()
    exif[0x010F], exif[0x0110] = "Acme", "Pocket 5"
    camera = exif.get_ifd(0x8769)
    in_35mm = focal_length * 36 / long_side
    camera[0x920A] = round(in_35mm * 0.155, 2)
    camera[0xA405] = round(in_35mm)
    camera[0x9003] = f"2024:05:11 10:20:{index:02d}"
    return exif


def _contact_sheet(small: list[Image.Image]) -> Image.Image:
    columns = (len(small) + 1) // 2
    rows = [small[:columns], small[columns:]]
    width = max(sum(image.width for image in row) for row in rows)
    sheet = Image.new("RGB", (width, _CONTACT * 2))
    for number, row in enumerate(rows):
        left = 0
        for image in row:
            sheet.paste(image, (left, number * _CONTACT))
            left += image.width
    return sheet


def seeds_of(text: str) -> list[int]:
    """``0-3,7`` as 0, 1, 2, 3, 7."""
    parts = [part.split("-") for part in text.split(",")]
    return [seed for part in parts for seed in range(int(part[0]), int(part[-1]) + 1)]


def main(arguments: argparse.Namespace) -> None:
    for seed in arguments.seeds:
        begun = time.perf_counter()
        write(seed, arguments.out / f"{seed:04d}")
        table, sheet = scenes.kinds(seed)
        print(f"{seed:04d}: {sheet} on {table}, {time.perf_counter() - begun:.1f} s", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=seeds_of, required=True, help="for example 0-59 or 3,7")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="each scene gets a folder in it")
    main(parser.parse_args())
