"""Bad settings, drawn lines and options: each ends with the right exit code and a sentence that says why."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import USED

HIT = "\x1b[31mred\n\u202e"
DEEP = "[" * 100000
LONG_NUMBER = "1" + "0" * 400
LONGER_NUMBER = "9" * 5000
# The content of a settings file, and words of the sentence about it.
SETTINGS = [
    ("", "not valid JSON"),
    ("\0", "not valid JSON"),
    ("\ufeff{}", "not valid JSON"),
    (DEEP, "nests too deep"),
    ('{"sfm":' * 100000, "nests too deep"),
    ("null", "must be an object"),
    ("3", "must be an object"),
    ('"text"', "must be an object"),
    ("[{}]", "must be an object"),
    ("NaN", "must be an object"),
    ('{"settings": 3}', "must be an object"),
    ('{"settings": {"settings": {}}}', "There is no setting settings"),
    ('{"sfm": []}', "sfm must be an object"),
    ('{"sfm": null}', "sfm must be an object"),
    (f'{{"sfm": {{"seed": {LONG_NUMBER}}}}}', "whole number"),
    (f'{{"sfm": {{"seed": {LONGER_NUMBER}}}}}', "not valid JSON"),
    (f'{{"sfm": {{"seed": -{LONG_NUMBER}}}}}', "whole number"),
    ('{"sfm": {"seed": 1e400}}', "whole number"),
    ('{"sfm": {"seed": NaN}}', "whole number"),
    ('{"sfm": {"seed": -Infinity}}', "whole number"),
    ('{"sfm": {"seed": true}}', "whole number"),
    ('{"sfm": {"seed": "1"}}', "whole number"),
    ('{"sfm": {"seed": 1.5}}', "whole number"),
    ('{"sfm": {"seed": null}}', "whole number"),
    ('{"sfm": {"seed": -1}}', "must lie between"),
    ('{"sfm": {"threads": 1e9}}', "must lie between"),
    ('{"sfm": {"threads": 0}}', "must lie between"),
    (f'{{"surface": {{"smoothness": {LONG_NUMBER}}}}}', "must be a number"),
    ('{"surface": {"smoothness": NaN}}', "must be a number"),
    ('{"surface": {"smoothness": -1}}', "must lie between"),
    ('{"surface": {"method": 3}}', "must be one of"),
    ('{"surface": {"method": ["developable"]}}', "must be one of"),
    ('{"surface": {"method": {}}}', "must be one of"),
    ('{"surface": {"method": null}}', "must be one of"),
    ('{"page": {"paper_size_mm": 5}}', "must be a list"),
    ('{"page": {"paper_size_mm": [1e400, 2]}}', "must be a number"),
    (f'{{"page": {{"paper_size_mm": [{LONG_NUMBER}, 2]}}}}', "must be a number"),
    ('{"page": {"paper_size_mm": [-1, 2]}}', "between 5 and 5000 mm"),
    ('{"page": {"paper_size_mm": [0, 0]}}', "between 5 and 5000 mm"),
    ('{"sheet": 0}', "sheet"),
    ('{"sheet": "none"}', "sheet"),
    ('{"sheet": 1e30}', "sheet"),
    ('{"outline": 3}', "must be a list"),
    ('{"outline": [3]}', "must be a list"),
    ('{"reference": "a", "outline": [[NaN, 0], [1, 0], [1, 1]]}', "must be a number"),
    (f'{{"reference": "a", "outline": [[{LONG_NUMBER}, 0], [1, 0], [1, 1]]}}', "must be a number"),
    ('{"reference": "a", "outline": [[1e308, 0], [-1e308, 0], [0, 1e308]]}', "would leave any photo"),
    ('{"colmap_model": "a\\u0000b"}', "must be a text"),
    ('{"reference": "a\\u0000b"}', "must be a text"),
    ('{"reference": "\\ud800"}', "choose one of"),
    ('{"reference": ""}', "choose one of"),
    (json.dumps({"reference": HIT}), r"\\x1b\[31mred\\n\\u202e"),
    (json.dumps({HIT: 1}), r"\\x1b\[31mred\\n\\u202e"),
    (json.dumps({"x" * 100000: 1}), "There is no setting"),
    (json.dumps({"colmap_model": "x" * 5000}), "holds no COLMAP model|File name too long"),
]


@pytest.mark.parametrize(("content", "words"), SETTINGS, ids=range(len(SETTINGS)))
def test_a_settings_file(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, content: str, words: str
) -> None:
    (tmp_path / "settings.json").write_text(content, encoding="utf-8")
    code, said = ends(good, "-o", tmp_path / "out", "--settings", tmp_path / "settings.json")
    assert code == 2 or ("COLMAP" in said and code == 4), said
    assert re.search(words, said), said
    assert len(said) < 6000
    assert "\x1b" not in said


# The content of a file with an outline or creases, and words of the sentences about it as either; none if it is used.
DRAWN = [
    ("", "not valid JSON", "not valid JSON"),
    (DEEP, "nests too deep", "nests too deep"),
    ("{}", "must hold a list", "must hold a list"),
    ("null", "", ""),
    ("3", "must be a list", "must be a list"),
    ('"x"', "must be a list", "must be a list"),
    ("[]", "at least three corners", ""),
    ("[[0, 0]]", "at least three corners", "must have 4 values"),
    ('[["a", "b"], [1, 2], [3, 4]]', "must be a number", "must have 4 values"),
    ("[[0, 0, 0], [1, 1, 1], [2, 0, 0]]", "must have 2 values", "must have 4 values"),
    ("[[NaN, 0, 1, 1], [9, 0, 1, 1]]", "must have 2 values", "must be a number"),
    (f"[[{LONG_NUMBER}, 0, 0, 0]]", "must have 2 values", "must be a number"),
    ('{"reference": "\\u0000", "outline": [], "creases": []}', "belongs to the photo", "belongs to the photo"),
    ('{"reference": 3, "outline": [], "creases": []}', "must hold a list", "must hold a list"),
    ("[[0, 0], [1e300, 0], [0, 1e300]]", "would leave any photo", "must have 4 values"),
    ("[[-5, 0], [50, 0], [0, 50]]", "leaves the photo", "must have 4 values"),
    ("[[5, 5], [50, 5], [5, 5], [50, 50]]", "crosses or touches itself", "must have 4 values"),
    ("[[1, 1, 1, 1]]", "must have 2 values", "has no length"),
    ("[[1, 1, 1e9, 1]]", "must have 2 values", "would leave any photo"),
]


@pytest.mark.parametrize("option", ["--outline", "--creases"])
@pytest.mark.parametrize(("content", "of_outline", "of_creases"), DRAWN, ids=range(len(DRAWN)))
def test_an_outline_or_creases(
    ends: Callable[..., tuple[int, str]],
    good: Path,
    tmp_path: Path,
    content: str,
    of_outline: str,
    of_creases: str,
    option: str,
) -> None:
    words = of_outline if option == "--outline" else of_creases
    (tmp_path / "drawn.json").write_text(content, encoding="utf-8")
    code, said = ends(good, "-o", tmp_path / "out", "--reference", "1.png", option, tmp_path / "drawn.json")
    assert code == (2 if words else 5)
    assert (words or USED) in said


OPTIONS = [
    (["--dpi", "1e400"], "dpi"),
    (["--dpi", "nan", "--paper", "A4"], "dpi"),
    (["--dpi", "-5", "--paper", "A4"], "dpi"),
    (["--dpi", "0", "--paper", "A4"], "dpi"),
    (["--dpi", "1" + 400 * "0", "--paper", "A4"], "dpi"),
    (["--dpi", 5000 * "9", "--paper", "A4"], "dpi"),
    (["--dpi", "300"], "needs the paper's size"),
    (["--dpi", ""], "dpi"),
    (["--threads", "0"], "threads"),
    (["--threads", "1.5"], "threads"),
    (["--threads", 5000 * "9"], "threads"),
    (["--seed", "-1"], "seed"),
    (["--seed", "x"], "seed"),
    (["--paper", "0x0"], "between 5 and 5000 mm"),
    (["--paper", "1e9x1e9"], "WIDTHxHEIGHT"),
    (["--paper", "9" * 400], "between 5 and 5000 mm"),
    (["--paper", "nan"], "WIDTHxHEIGHT"),
    (["--paper", "\n"], "WIDTHxHEIGHT"),
    (["--paper", HIT], "WIDTHxHEIGHT"),
    (["--sheet", "0"], "sheet"),
    (["--sheet", "-1"], "sheet"),
    (["--sheet", "x"], "sheet"),
    (["--surface", "magic"], "surface"),
    (["--grid", "x"], "unrecognized"),
    (["--reference", "nowhere.jpg"], "choose one of"),
    (["--reference", HIT], r"\\x1b\[31mred"),
    (["--reference", "."], "choose one of"),
    (["--reference", "/"], "choose one of"),
    (["--colmap-model", "nowhere"], "holds no COLMAP model"),
    (["--outline", "nowhere.json"], "check the path"),
    (["--creases", "."], "directory"),
    (["--settings", "nowhere.json"], "check the path"),
    (["--settings", os.devnull], "not a file"),
    (["--settings", "."], "directory"),
    (["--settings", "x" * 300], "too long|check the path"),
    (["--outline", os.devnull], "not a file"),
    (["--texture-from", "nowhere"], "no file or folder nowhere"),
    (["--texture-from", os.devnull], "not a photo"),
    (["--resume", "--force"], "not allowed"),
    (["--nothing"], "unrecognized"),
    (["-o", ""], "No folder for the results"),
]


@pytest.mark.parametrize(("options", "words"), OPTIONS, ids=range(len(OPTIONS)))
def test_options(
    ends: Callable[..., tuple[int, str]], good: Path, tmp_path: Path, options: list[str], words: str
) -> None:
    code, said = ends(good, "-o", tmp_path / "out", *options)
    assert code == (4 if "--colmap-model" in options else 2)
    assert re.search(words, said.rpartition("error: ")[2]), said
    assert "\x1b" not in said
