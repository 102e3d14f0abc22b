"""The default's page in each light, and the page of the reference photo alone, beside the flat original."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from ..origami_addon import steps
from ..origami_addon.files.image_files import to_eight_bits
from ..origami_addon.report import Report
from ..origami_addon.settings import ImageSettings, RunSettings
from ..origami_addon.state import Found, LaidOut, Surfaced, Unwrapped, extended
from .cells import Placed, failure
from .light import own_unevenness
from .photo_set import PhotoSet
from .photo_sets import WHOLE_SET
from .scorer import Figures, Scorer
from .tables import Row

# The pages that are compared; the last one is untouched.
PAGES = {
    "paper": ImageSettings(),
    "white": ImageSettings(light="white"),
    "as photographed": ImageSettings(light="as-photographed"),
    "reference photo, as photographed": ImageSettings(source="reference", light="as-photographed"),
}


def run(photo_set: PhotoSet, work: Path, pages: Path, scorer: Scorer, say: Callable[[str], None]) -> list[Row]:
    """One row for each of `PAGES`.

    Parameters
    ----------
    photo_set : PhotoSet
    work : Path
        The work folder of the set's ordinary run, whose results are reused.
    pages : Path
        Folder for the page images.
    scorer : Scorer
    say : callable
        Takes a sentence about the progress.
    """
    say(f"{photo_set.name}: the light of its page")
    row: Row = {"set": photo_set.name}
    try:
        placed = Placed.of(photo_set, work)
        state = _laid_out(placed, work)
    except Exception as why:  # the set fails as a whole
        return [row | {"page": WHOLE_SET} | failure(why)]
    rows, own = [], own_unevenness(photo_set.original)
    pages.mkdir(parents=True, exist_ok=True)
    for name, settings in PAGES.items():
        say(f"{photo_set.name}: {name}")
        report = Report({})
        found = row | {"page": name}
        try:
            page = steps.make_page(state, _with(placed, work, report, settings))
            image = np.ascontiguousarray(to_eight_bits(page.texture.image)[..., ::-1])
            cv2.imwrite(str(pages / f"{name.replace(', ', ' ').replace(' ', '_')}.png"), image)
            found |= {"own_unevenness": own} | _shown(scorer.light(photo_set.original, image))
        except Exception as why:  # a page that cannot be scored is a result
            found |= failure(why)
        found |= {"figures": report.stages[-1]["figures"]} if report.stages else {}
        rows.append(found)
    return rows


def _with(placed: Placed, work: Path, report: Report, image: ImageSettings | None = None) -> steps.Work:
    settings = RunSettings() if image is None else replace(RunSettings(), image=image)
    return steps.Work(placed.photos, work, settings, report)


def _laid_out(placed: Placed, work: Path) -> LaidOut:
    """The default's flat map."""
    default = _with(placed, work, Report({}))
    found = Found(placed.model, placed.region)
    cameras, sheet = steps.build_surface(found, default)
    surfaced = extended(found, Surfaced, cameras=cameras, sheet=sheet)
    unwrapped = extended(surfaced, Unwrapped, uv=steps.unwrap_sheet(sheet, default))
    return extended(unwrapped, LaidOut, flat=steps.lay_out_page(unwrapped, default))


def _shown(score: Figures) -> Row:
    """The figures of a page's light that the table shows, in one level."""
    return {
        "unevenness": score["unevenness_L"],
        "delta_e": score["delta_e"]["mean"],
        "delta_e_p95": score["delta_e"]["p95"],
        "paper_lightness": score["paper_L"][0],
        "paper_chroma": score["chroma_paper"][0],
        "original_chroma": score["chroma_paper"][1],
        "mtf_eighth": score["mtf"]["1/8"],
        "mtf_quarter": score["mtf"]["1/4"],
        "noise": score["noise_L"],
        "psnr": score["psnr"],
        "ssim": score["ssim"],
    }
