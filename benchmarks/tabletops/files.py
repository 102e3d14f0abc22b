"""A scene as a folder of files: photos/, truth.json and contact.jpg."""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from . import changed
from . import photo as photos
from . import scene as scenes
from .cameras import LENSES
from .shapes import Array, in_space, page_corners

SIZE = (1600, 1200)
# Height of a photo in the contact sheet.
_CONTACT = 300


def write(seed: int, folder: Path, size: tuple[int, int] = SIZE, change: str = "", lens: str = "") -> None:
    """Make the scene of a seed and write it into ``folder``, which then holds nothing else.

    Parameters
    ----------
    seed : int
    folder : Path
        It appears only once it is complete.
    size : (long side, short side)
        Of the photos, in pixels.
    change : str
        One of `changed.CHANGES` if the later photos are to show the sheet moved or bent.
    lens : str
        One of `cameras.LENSES` if the photos are to have what a single term of distortion cannot describe.
    """
    made = scenes.make(seed, size)
    if lens:
        made.views = LENSES[lens](made.views, np.random.default_rng([seed, 11]))
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent) as unfinished:
        scene = Path(unfinished) / "scene"
        scene.mkdir()
        _write(made, scene, change)
        shutil.rmtree(folder, ignore_errors=True)
        scene.replace(folder)


def _write(scene: scenes.Scene, folder: Path, change: str) -> None:
    seed = scene.seed
    states = [scene] * len(scene.views)
    second = changed.change(scene, change) if change else None
    if second is not None:
        states[second.first_photo :] = [second.scene] * (len(scene.views) - second.first_photo)
    (folder / "photos").mkdir()
    random = np.random.default_rng([seed, 7])
    quality, has_exif = int(random.integers(80, 96)), bool(random.random() < 0.5)
    described, small = [], []
    for index, (view, state) in enumerate(zip(scene.views, states, strict=True)):
        taken = photos.take(state, index)
        image = Image.fromarray(taken.pixels)
        name = f"{index:02d}.jpg"
        exif = {"exif": _exif(view.focal_length, max(view.width, view.height), index)} if has_exif else {}
        image.save(folder / "photos" / name, quality=quality, **exif)
        small.append(image.resize((round(_CONTACT * view.width / view.height), _CONTACT)))
        described.append(
            {
                "file": name,
                "width": view.width,
                "height": view.height,
                "focal_length": view.focal_length,
                "k1": view.k1,
                "k2": view.k2,
                "off_middle": list(view.off_middle),
                "decentering": list(view.decentering),
                "row_shift": list(view.row_shift),
                "rotation": view.rotation.tolist(),
                "translation": view.translation.tolist(),
                "outline": taken.outline.round(3).tolist(),
                "corners": view.project(_corners(state)).round(3).tolist(),
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
        "photos": described,
    }
    if second is not None:
        truth["change"] = second.figures()
    (folder / "truth.json").write_text(json.dumps(truth), encoding="utf-8")
    _contact_sheet(small).save(folder / "contact.jpg", quality=88)


def _corners(scene: scenes.Scene) -> Array:
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
