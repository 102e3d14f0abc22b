"""Measure how glare, shadows, hands and motion blur are healed on generated scenes, and that clean pages stay.

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
# Difference, in levels of 255 and as a mean over 9 x 9 pixels, above which a place counts as blemished.
_BLEMISHED = 8.0
_HEADING = "seed kind    blemished healed error before after  healed elsewhere  CPU s plain heal  reported"


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
    healing, render, warp = (importlib.import_module(f"origami.core.page.{n}") for n in ("healing", "render", "warp"))
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
        page = render.render_page(mesh, flat, cameras, photos.__getitem__, reference, size)
        plain = time.process_time() - begun
        healed, blemishes = healing.heal_page(page, mesh, flat, cameras, photos.__getitem__, reference)
        healing_time = time.process_time() - begun - plain
        if kind == "clean":
            truth = page.image.astype(np.float32)
        before, after = (np.abs(each.image - truth).mean(axis=2) for each in (page, healed))
        true = ndimage.binary_opening(ndimage.uniform_filter(before, 9) > _BLEMISHED, iterations=3)
        taken = ndimage.binary_closing(healed.photo != page.photo, iterations=3)
        elsewhere = (taken & ~ndimage.binary_dilation(true, iterations=12)).mean()
        area = max(true.sum(), 1)
        shares = ", ".join(f"{each.kind} {each.share:.3f} ({each.healed_share:.3f})" for each in blemishes)
        print(
            f"{seed} {kind:7} {true.mean():9.3f} {(true & taken).sum() / area:6.2f} {before[true].sum() / area:12.1f} "
            f"{after[true].sum() / area:5.1f} {elsewhere:17.4f} {plain:12.2f} {healing_time:4.2f}  {shares}",
            flush=True,
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=seeds_of, required=True, help="for example 4500-4523")
    seeds = parser.parse_args().seeds
    load_checkout()
    print(_HEADING)
    for each_seed in seeds:
        measure(each_seed)
