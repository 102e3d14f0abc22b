"""Words from hOCR, as PAGE XML on the page and in the photos."""

from __future__ import annotations

import os
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from origami.core.errors import StepFailed
from origami.workflow.delivery.finished_run import finished_run
from origami.workflow.delivery.hocr import Block, Line, Word, read_hocr, without_words, words_of
from origami.workflow.delivery.on_photos import write_words_in_photos
from origami.workflow.delivery.page_in_photos import page_in_photos
from origami.workflow.delivery.page_xml import NAMESPACE, write_page_xml

PAGE = f"{{{NAMESPACE}}}"
HOCR = """<?xml version="1.0" encoding="UTF-8"?>
<html xmlns="http://www.w3.org/1999/xhtml"><body>
<div class='ocr_page' id='page_1' title='image "/tmp/a b.png"; bbox 0 0 320 400; ppageno 0; scan_res 51 51'>
 <div class='ocr_carea' id='block_1_1' title="bbox 10 20 100 60"><p class='ocr_par' id='par_1_1'>
  <span class='ocr_line' id='line_1_1' title="bbox 10 20 100 40; baseline 0.1 -4; x_size 20">
   <span class='ocrx_word' id='word_1_1' title='bbox 10 20 40 40; x_wconf 91'><strong>Tom</strong></span>
   <span class='ocrx_word' id='word_1_2' title='bbox 50 18 110 40; x_wconf 80'>&amp;</span>
   <span class='ocrx_word' id='word_1_3' title='bbox 80 20 90 40; x_wconf 10'> </span></span>
  <span class='ocr_caption' id='line_1_2' title="bbox 10 44 60 60">
   <span class='ocrx_word' id='word_1_4' title='bbox 10 44 60 60; x_wconf 100'>Jerry</span></span></p></div>
 <div class='ocr_carea' id='block_1_2' title="bbox 0 0 320 400">
  <span class='ocr_line' id='line_1_3' title="bbox 0 0 320 400; baseline 0 0">
   <span class='ocrx_word' id='word_1_5' title='bbox 0 0 320 400; x_wconf 95'> </span></span></div>
</div></body></html>
"""


@pytest.fixture
def hocr(tmp_path: Path) -> Path:
    path = tmp_path / "page.hocr"
    path.write_text(HOCR, encoding="utf-8")
    return path


def outline(element: ElementTree.Element, name: str = "Coords") -> np.ndarray:
    points = element.find(f"{PAGE}{name}").attrib["points"]
    assert re.fullmatch(r"([0-9]+,[0-9]+ )+([0-9]+,[0-9]+)", points)
    return np.array([point.split(",") for point in points.split()], int)


def test_words_have_the_pixels_of_the_page_and_empty_ones_are_left_out(hocr):
    (block,) = read_hocr(hocr, (640, 800))
    first, second = block.lines
    assert [(word.text, word.box, word.confidence) for word in first.words] == [
        ("Tom", (20, 40, 80, 80), 0.91),
        ("&", (100, 36, 220, 80), 0.8),
    ]
    assert block.text == "Tom &\nJerry"
    np.testing.assert_allclose(first.baseline, [[20, 72], [200, 90]])
    assert second.baseline is None
    # PAGE wants words inside their line, and lines inside their block.
    assert first.box == (20, 36, 220, 80)
    assert block.box == (20, 36, 220, 120)


@pytest.mark.parametrize(
    "damage", [("bbox 0 0 320 400; pp", "pp"), ("x_wconf 91", ""), ("</html>", ""), (HOCR, "<a/>")]
)
def test_an_hocr_file_of_another_form_is_reported(hocr, damage):
    hocr.write_text(HOCR.replace(*damage), encoding="utf-8")
    with pytest.raises(StepFailed, match="an hOCR file of another form"):
        read_hocr(hocr, (640, 800))


def test_page_xml_has_the_words_in_order(hocr, tmp_path):
    blocks = read_hocr(hocr, (640, 800))
    write_page_xml(tmp_path / "page.xml", blocks, "../page <1>.tif", (640, 800))
    page = ElementTree.parse(tmp_path / "page.xml").getroot().find(f"{PAGE}Page")
    assert page.attrib == {"imageFilename": "../page <1>.tif", "imageWidth": "640", "imageHeight": "800"}
    (region,) = page.iter(f"{PAGE}TextRegion")
    assert [each.tag.removeprefix(PAGE) for each in region] == ["Coords", "TextLine", "TextLine", "TextEquiv"]
    texts = [each.text for each in region.iter(f"{PAGE}Unicode")]
    assert texts == ["Tom", "&", "Tom &", "Jerry", "Jerry", "Tom &\nJerry"]
    (word, *_) = region.iter(f"{PAGE}Word")
    assert outline(word).tolist() == [[20, 40], [80, 40], [80, 80], [20, 80]]
    line = region.find(f"{PAGE}TextLine")
    assert outline(line, "Baseline").tolist() == [[20, 72], [200, 90]]


def test_a_page_without_words(tmp_path):
    write_page_xml(tmp_path / "page.xml", [], "page.tif", (640, 800))
    assert len(ElementTree.parse(tmp_path / "page.xml").getroot().find(f"{PAGE}Page")) == 0


def test_names_that_xml_cannot_hold(tmp_path):
    """POSIX allows nearly any bytes in names."""
    names = os.fsdecode(b"a\x01\xff\n<&\"'") + "\u00a0\U0001f4c4"
    write_page_xml(tmp_path / "page.xml", [], names, (640, 800), comment=names)
    root = ElementTree.parse(tmp_path / "page.xml").getroot()
    assert root.find(f"{PAGE}Page").attrib["imageFilename"] == "a\ufffd\ufffd\n<&\"'\u00a0\U0001f4c4"
    assert root.findtext(f"{PAGE}Metadata/{PAGE}Comments") == "a\ufffd\ufffd\n<&\"'\u00a0\U0001f4c4"


def test_words_are_left_out_with_what_is_then_empty(hocr):
    blocks = read_hocr(hocr, (640, 800))
    (block,) = without_words(blocks, {"word_1_4"})
    assert [word.id for word in words_of([block])] == ["word_1_1", "word_1_2"]
    assert len(block.lines) == 1
    assert without_words(blocks, {"word_1_1", "word_1_2", "word_1_4"}) == []


def test_photos_have_the_words_that_they_show(case, run_folder, tmp_path):
    words = [Word("above", "above", (100, 100, 300, 140), 1), Word("below", "below", (60, 600, 260, 640), 1)]
    lines = [Line(f"line_{word.id}", word.box, None, [word]) for word in words]
    block = Block("block", (60, 100, 300, 640), lines)
    page = page_in_photos(finished_run(run_folder))
    found = write_words_in_photos(tmp_path, page, [block])
    assert [(each.photo, each.shown) for each in found] == [("Foto ü 0.jpg", 2), ("Foto ü 1.jpg", 2), ("steep.jpg", 1)]
    (hidden,) = found[2].hidden
    for index, each in enumerate(found):
        root = ElementTree.parse(tmp_path / each.file).getroot()
        comment = root.findtext(f"{PAGE}Metadata/{PAGE}Comments")
        assert comment.startswith(f"{each.shown} of the page's 2 words")
        in_photo = {word.attrib["id"]: outline(word) for word in root.iter(f"{PAGE}Word")}
        assert in_photo.keys() == {"above", "below"} - set(each.hidden)
        for word in words:
            if word.id in in_photo:
                x0, y0, x1, y1 = word.box
                columns, rows = np.array([x0, x1 - 1, x1 - 1, x0]), np.array([y0, y0, y1 - 1, y1 - 1])
                corners = page.view(index).places(columns, rows).pixels - 0.5
                distances = np.linalg.norm(corners[:, None] - in_photo[word.id][None], axis=2)
                assert distances.min(axis=1).max() < 0.75  # rounded to whole pixels
    assert hidden in ("above", "below")
