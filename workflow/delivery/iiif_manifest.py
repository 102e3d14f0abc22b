"""The command `iiif_manifest`: what viewers read first, for all pages that have been cut into tiles."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote, urlsplit

from ...core.errors import UsageError
from ...origami_addon.files.atomic import write_text_at_once
from ...origami_addon.files.links import real
from ...origami_addon.files.marker import claim
from ...origami_addon.files.results_folder import keep_off_others
from ...origami_addon.system_errors import unwritable_as_failure
from .command import exit_code_of
from .iiif_tiles import TILE, tiles_in

MANIFEST, INFO = "manifest.json", "info.json"
_OWNER = "iiif"  # in the marker of the folder


def main(argv: Sequence[str]) -> int:
    """Run with the given arguments and return the exit code; never raises."""
    return exit_code_of(lambda: _manifest(argv))


def _manifest(argv: Sequence[str]) -> None:
    parser = argparse.ArgumentParser(
        prog="iiif_manifest.py",
        description="Write IIIF/manifest.json with all pages in the folder, and each page's info.json. Run it again "
        "with another address when the folder moves: the tiles stay as they are.",
        allow_abbrev=False,
    )
    parser.add_argument("iiif", metavar="IIIF", type=Path, help="the folder that iiif_tiles.py has filled")
    parser.add_argument(
        "--url",
        required=True,
        help="the address at which a web server shows this folder, such as https://example.org/letters/iiif",
    )
    arguments = parser.parse_args(argv)
    write_manifest(arguments.iiif, arguments.url)


def write_manifest(iiif: Path, url: str) -> None:
    """Write the manifest of a folder of tiles, and an info.json for each page.

    Raises
    ------
    UsageError
    """
    address = urlsplit(url)
    if (
        any(letter.isspace() for letter in url)
        or address.scheme not in ("http", "https")
        or not address.netloc
        or address.query
        or address.fragment
    ):
        raise UsageError(f"{url} is not the address of a folder; write it as https://example.org/letters/iiif.")
    url = url.rstrip("/")
    pages = tiles_in(iiif)
    with unwritable_as_failure(iiif):
        keep_off_others(iiif, [MANIFEST], _OWNER)
        claim(iiif, [MANIFEST], _OWNER)
        for name, page in pages.items():
            _write(iiif / name / INFO, _image_information(f"{url}/{quote(name)}", page))
        title = real(iiif).parent.name
        canvases = [_canvas(f"{url}/{quote(name)}", page) for name, page in pages.items()]
        _write(iiif / MANIFEST, _presentation(f"{url}/{MANIFEST}", title, canvases))


def _write(path: Path, content: dict[str, Any]) -> None:
    write_text_at_once(path, json.dumps(content, indent=1, ensure_ascii=False) + "\n")


def _image_information(address: str, page: dict[str, Any]) -> dict[str, Any]:
    """The answer of IIIF's Image API 3 about a page."""
    width, height = page["width"], page["height"]
    return {
        "@context": "http://iiif.io/api/image/3/context.json",
        "id": address,
        "type": "ImageService3",
        "protocol": "http://iiif.io/api/image",
        "profile": "level0",
        "width": width,
        "height": height,
        "sizes": [{"width": across, "height": down} for across, down in page["sizes"]],
        "tiles": [{"width": TILE, "scaleFactors": page["factors"]}],
    }


def _canvas(address: str, page: dict[str, Any]) -> dict[str, Any]:
    """A page in a manifest of IIIF's Presentation API 3."""
    size = {"width": page["width"], "height": page["height"]}
    service = [{"id": address, "type": "ImageService3", "profile": "level0"}]
    picture = {"type": "Image", "format": "image/jpeg", "service": service}
    across, down = page["sizes"][0]
    whole = picture | {"id": f"{address}/full/max/0/default.jpg"} | size
    small = picture | {"id": f"{address}/full/{across},{down}/0/default.jpg", "width": across, "height": down}
    painted = {
        "id": f"{address}/canvas/painting",
        "type": "Annotation",
        "motivation": "painting",
        "body": whole,
        "target": f"{address}/canvas",
    }
    return {
        "id": f"{address}/canvas",
        "type": "Canvas",
        "label": {"none": [page["title"]]},
        **size,
        "thumbnail": [small],
        "items": [{"id": f"{address}/canvas/page", "type": "AnnotationPage", "items": [painted]}],
    }


def _presentation(address: str, title: str, canvases: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "@context": "http://iiif.io/api/presentation/3/context.json",
        "id": address,
        "type": "Manifest",
        "label": {"none": [title]},
        "behavior": ["individuals"],
        "items": canvases,
    }
