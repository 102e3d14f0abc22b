"""Measure how the page of all photos heals glare, shadows, hands and motion blur on generated scenes.

    OMP_NUM_THREADS=1 .venv/bin/python benchmarks/tabletops/heal.py --seeds 4500-4523

Tuned on the seeds 4000 to 4023. The cameras are the true ones, and the sheet is wrong by a smooth 0.15 % of its length,
so that the print of other photos is displaced from that of the reference. About 30 s per scene.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time
from pathlib import Path

import numpy as np
from scipy import ndimage

sys.path[0] = str(Path(__file__).resolve().parent.parent)

from run import load_checkout, seeds_of  # noqa: E402

# Of the sheet's longer side, root mean square.
_SURFACE_ERROR = 0.0015
# Difference of L*, as a mean over 9 x 9 pixels, above which a place counts as blemished, and below which as healed.
_BLEMISHED, _HEALED = 4.0, 3.0
_MODULES = ("page.single_photo", "page.warp", "fusion.fusion")
_HEADING = "seed kind      blemished error before after elsewhere  within 3 L*  CPU s plain fused  burnt"


def geometry(scene, random):
    """The sheet, slightly wrong as after a reconstruction, its flat map, and the cameras."""
    camera, sheet = (importlib.import_module(f"origami.core.{name}") for name in ("camera", "sheet"))
    shapes = importlib.import_module("origami.benchmarks.tabletops.shapes")
    width, height = scene.sheet.width, scene.sheet.height
    longest = max(width, height)
    columns, rows = (max(20, round(60 * side / longest)) for side in (width, height))
    u, v = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    flat = np.stack([u, v], -1).reshape(-1, 2)
    vertices = shapes.in_space(scene.sheet.facets, flat)
    error = ndimage.gaussian_filter(random.standard_normal(u.shape), 6, mode="nearest")
    vertices[:, 2] += (error * _SURFACE_ERROR * longest / error.std()).ravel()
    index = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]))
    triangles = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])
    mesh = sheet.Sheet(vertices, triangles, (), np.concatenate([index[:-1, 0], index[-1, :-1]]))
    cameras = [
        camera.Camera(
            f"{n:02d}", v.width, v.height, v.focal_length, v.middle, np.array([v.k1, 0.0]), v.rotation, v.translation
        )
        for n, v in enumerate(scene.views)
    ]
    return mesh, sheet.FlatMap(flat, width, height, "mm", 1.0), cameras


def photos_of(scene, painted, reference, kind, random):
    """All photos, with a blemish of the kind in the reference and, except for reflections, in one or two others."""
    blemished = importlib.import_module("origami.benchmarks.tabletops.blemished")
    spoilt = list(painted)
    if kind != "clean":
        spoil = blemished.spoil(kind, scene, reference, random)
        others = [index for index in range(len(painted)) if index != reference]
        chosen = random.choice(others, 1 if kind == "motion" else min(2, max(len(others) - 3, 1)), replace=False)
        for index in range(len(painted)) if kind in ("glare", "gloss") else (reference, *chosen):
            spoilt[index] = spoil(painted[index], int(index))
    return [blemished.developed(scene, index, picture) for index, picture in enumerate(spoilt)]


def measure(seed):
    """One row for each kind of blemish."""
    single_photo, warp, fusion = (importlib.import_module(f"origami.core.{n}") for n in _MODULES)
    scenes, blemished = (importlib.import_module(f"origami.benchmarks.tabletops.{n}") for n in ("scene", "blemished"))
    scene, random = scenes.make(seed), np.random.default_rng([seed, 91])
    mesh, flat, cameras = geometry(scene, random)
    usable = [index for index in blemished.sharp(scene) if index not in scene.cut_off]
    reference = int(min(usable, key=lambda index: scene.views[index].rotation[2, 2]))
    painted = [blemished.painted(scene, index) for index in range(len(cameras))]
    density = warp.native_size(mesh, flat, cameras[reference])
    size = (round(flat.width * density), round(flat.height * density))
    for kind in ("clean", *blemished.KINDS):
        photos = photos_of(scene, painted, reference, kind, random)
        begun = time.process_time()
        page = single_photo.page_of_photo(mesh, flat, cameras, photos.__getitem__, reference, size).image
        plain = time.process_time() - begun
        fused = fusion.fuse_page(mesh, flat, cameras, photos.__getitem__, reference, size)
        fusing = time.process_time() - begun - plain
        plain_light, fused_light = (smooth_lightness(each) for each in (page, fused.texture.image))
        if kind == "clean":
            clean = plain_light, fused_light
        before, after = (np.abs(each - clean[0]) for each in (plain_light, fused_light))
        spoilt = ndimage.binary_opening(before > _BLEMISHED, iterations=3)
        elsewhere = np.abs(fused_light - clean[1])[~ndimage.binary_dilation(spoilt, iterations=12)]
        within = (after[spoilt] < _HEALED).mean() if spoilt.any() else np.nan
        errors = [each[spoilt].mean() if spoilt.any() else np.nan for each in (before, after)]
        print(
            f"{seed} {kind:9} {spoilt.mean():9.3f} {errors[0]:12.1f} {errors[1]:5.1f} {elsewhere.mean():9.2f} "
            f"{within:12.2f} {plain:12.2f} {fusing:5.2f}  {fused.burnt_share:.3f}",
            flush=True,
        )


def smooth_lightness(image):
    """L* (0 to 100), mean over 9 x 9 pixels: print that is displaced by a pixel does not count."""
    linear = importlib.import_module("origami.core.numeric.image").linear_light(image)
    luminance = ndimage.uniform_filter(linear @ np.array([0.2126, 0.7152, 0.0722], np.float32), 9)
    return 116 * np.cbrt(luminance) - 16


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=seeds_of, required=True, help="for example 4500-4523")
    seeds = parser.parse_args().seeds
    load_checkout()
    print(_HEADING)
    for each_seed in seeds:
        measure(each_seed)
