"""The page as a PDF of one page in its true size (PDF 1.7, ISO 32000-1)."""

from __future__ import annotations

import hashlib
import zlib
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from ...core.page.resolution import MILLIMETRES_PER_INCH
from .atomic import replacing
from .group4 import group4
from .image_files import PageImage, encoded_jpeg, profile_of

_POINTS_PER_MILLIMETRE = 72 / MILLIMETRES_PER_INCH
_PRODUCER = "Origami"
_XMP = """\
<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>
<x:xmpmeta xmlns:x="adobe:ns:meta/">
 <rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
  <rdf:Description rdf:about="" xmlns:dc="http://purl.org/dc/elements/1.1/" xmlns:pdf="http://ns.adobe.com/pdf/1.3/">
   <dc:format>application/pdf</dc:format>
   <dc:title><rdf:Alt><rdf:li xml:lang="x-default">{title}</rdf:li></rdf:Alt></dc:title>
   <pdf:Producer>{producer}</pdf:Producer>
  </rdf:Description>
 </rdf:RDF>
</x:xmpmeta>
<?xpacket end="r"?>
"""


def write_pdf(
    path: Path,
    image: PageImage,
    dpi: float,
    size_mm: tuple[float, float],
    title: str,
    profile: bytes | None = None,
) -> None:
    """Write a PDF of one page, with a JPEG in it, or losslessly as Group 4 if the image is black and white.

    The same page always gives the same file: it has no date, and its identifier follows from its content.

    Parameters
    ----------
    path : Path
    image : (H, W, 3) or (H, W) uint8 or uint16 array, or (H, W) bool array
        As for `write_tiff`.
    dpi : float
        Pixels per inch; the JPEG has it in whole numbers.
    size_mm : (width, height)
        Of the page, which the image fills.
    title : str
        What programs show as the name of the document.
    profile : bytes, optional
        As for `write_tiff`.

    Raises
    ------
    StepFailed
        If the file could not be written.
    """
    height, width = image.shape[:2]
    across, down = (f"{length * _POINTS_PER_MILLIMETRE:.4f}" for length in size_mm)
    shown = "".join(letter for letter in title if letter.isprintable())
    xmp = _XMP.format(title=escape(shown), producer=_PRODUCER).encode()
    icc = profile_of(image, profile)
    with replacing(path) as temporary:
        if image.dtype == np.bool_:
            pixels = group4(image == 0)
            form = f"/ColorSpace /DeviceGray /BitsPerComponent 1 /Filter /CCITTFaxDecode /DecodeParms {_fax(image)}"
        else:
            pixels = encoded_jpeg(temporary, image, dpi, profile)
            form = "/ColorSpace [/ICCBased 8 0 R] /BitsPerComponent 8 /Filter /DCTDecode"
        objects = [
            b"<< /Type /Catalog /Pages 2 0 R /Metadata 6 0 R /ViewerPreferences << /DisplayDocTitle true >> >>",
            b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
            f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {across} {down}] /Contents 4 0 R "
            "/Resources << /XObject << /Page 5 0 R >> >> >>".encode(),
            _stream("", f"q {across} 0 0 {down} 0 0 cm /Page Do Q".encode()),
            _stream(f"/Type /XObject /Subtype /Image /Width {width} /Height {height} {form}", pixels),
            _stream("/Type /Metadata /Subtype /XML", xmp),
            f"<< /Title {_text(shown)} /Producer {_text(_PRODUCER)} >>".encode(),
        ]
        if icc:
            objects.append(_stream(f"/N {1 if image.ndim == 2 else 3} /Filter /FlateDecode", zlib.compress(icc)))
        temporary.write_bytes(_file(objects))


def _fax(image: PageImage) -> str:
    """How a bitmap is packed: pure two-dimensional coding, which is Group 4."""
    return f"<< /K -1 /Columns {image.shape[1]} /Rows {image.shape[0]} >>"


def _stream(entries: str, content: bytes) -> bytes:
    return f"<< {entries} /Length {len(content)} >>\nstream\n".encode() + content + b"\nendstream"


def _text(text: str) -> str:
    """A string in any script."""
    return f"<FEFF{text.encode('utf-16-be').hex().upper()}>"


def _file(objects: list[bytes]) -> bytes:
    """A file of objects, numbered from 1: the first is the catalogue, the seventh says what the document is."""
    body = b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n"  # the second line marks the file as binary
    places = []
    for number, content in enumerate(objects, 1):
        places.append(len(body))
        body += f"{number} 0 obj\n".encode() + content + b"\nendobj\n"
    table = "".join(f"{place:010} 00000 n \n" for place in places)
    name = hashlib.md5(body, usedforsecurity=False).hexdigest()
    return (
        body
        + (
            f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n{table}"
            f"trailer\n<< /Size {len(objects) + 1} /Root 1 0 R /Info 7 0 R /ID [<{name}> <{name}>] >>\n"
            f"startxref\n{len(body)}\n%%EOF\n"
        ).encode()
    )
