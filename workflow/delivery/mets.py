"""Writes the METS file of a workspace of one page, as OCR-D describes it."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from ...origami_addon.files.content_hash import sha256_of
from .xml_text import xml_text

METS, XLINK, MODS = "http://www.loc.gov/METS/", "http://www.w3.org/1999/xlink", "http://www.loc.gov/mods/v3"
_PAGE_ID = "PHYS_0001"


@dataclass(frozen=True)
class WorkspaceFile:
    """A file of the workspace.

    Attributes
    ----------
    group : str
        The USE of its file group; each has one file, whose id is `id`.
    path : str
        From the folder of the METS file.
    media_type : str
    """

    group: str
    path: str
    media_type: str

    @property
    def id(self) -> str:
        """Its id in the METS file."""
        return id_in(self.group)


def id_in(group: str) -> str:
    """The id of the one file of a group."""
    return f"{group}_0001"


def write_mets(path: Path, identifier: str, title: str, files: Sequence[WorkspaceFile]) -> None:
    """Write the METS file beside the workspace's files, whose sizes and hashes it has.

    Parameters
    ----------
    path : Path
    identifier : str
        A URN: OCR-D wants one in each workspace.
    title : str
        The document's name.
    files : sequence of WorkspaceFile

    Raises
    ------
    OSError
    """
    for prefix, namespace in (("mets", METS), ("xlink", XLINK), ("mods", MODS)):
        ElementTree.register_namespace(prefix, namespace)
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    root = ElementTree.Element(f"{{{METS}}}mets")
    agent = _inside(
        _inside(root, "metsHdr", CREATEDATE=now), "agent", ROLE="CREATOR", TYPE="OTHER", OTHERTYPE="SOFTWARE"
    )
    _inside(agent, "name").text = "Origami"
    described = _inside(_inside(root, "dmdSec", ID="DMDLOG_0001"), "mdWrap", MDTYPE="MODS")
    mods = ElementTree.SubElement(_inside(described, "xmlData"), f"{{{MODS}}}mods")
    ElementTree.SubElement(mods, f"{{{MODS}}}identifier", type="urn").text = identifier
    titles = ElementTree.SubElement(mods, f"{{{MODS}}}titleInfo")
    ElementTree.SubElement(titles, f"{{{MODS}}}title").text = xml_text(title)
    section = _inside(root, "fileSec")
    pages = _inside(_inside(root, "structMap", TYPE="PHYSICAL"), "div", ID="PHYS_0000", TYPE="physSequence")
    page = _inside(pages, "div", ID=_PAGE_ID, ORDER="1", TYPE="page", DMDID="DMDLOG_0001")
    for each in files:
        here = path.parent / each.path
        file = _inside(
            _inside(section, "fileGrp", USE=each.group),
            "file",
            ID=each.id,
            MIMETYPE=each.media_type,
            SIZE=str(here.stat().st_size),
            CHECKSUM=sha256_of(here),
            CHECKSUMTYPE="SHA-256",
        )
        place = _inside(file, "FLocat", LOCTYPE="OTHER", OTHERLOCTYPE="FILE")
        place.set(f"{{{XLINK}}}href", each.path)
        _inside(page, "fptr", FILEID=each.id)
    tree = ElementTree.ElementTree(root)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)


def _inside(parent: ElementTree.Element, name: str, **attributes: str) -> ElementTree.Element:
    return ElementTree.SubElement(parent, f"{{{METS}}}{name}", attributes)
