"""The manual is complete: F1 finds a page for everything, and the pages name and quote what exists."""

from __future__ import annotations

import ast
import importlib.util
import re
from pathlib import Path
from urllib.parse import unquote, urlparse

import pytest

DEVELOPERS = "architecture"
# The settings that panels show; other properties in the groups are only stored.
SHOWN_GROUPS = (
    "OrigamiSfmSettings",
    "OrigamiSurfaceSettings",
    "OrigamiFlattenSettings",
    "OrigamiPageSettings",
    "OrigamiImageSettings",
    "OrigamiScene",
)
SHOWN = {("OrigamiSettings", "colmap_model"), ("OrigamiSettings", "reference"), ("OrigamiPhoto", "use")}
NOT_SHOWN = {("OrigamiImageSettings", "bake")}  # of the command line
# Operators called by another one; and one behind several buttons, each with its own text.
WITHOUT_BUTTON = (
    "origami.write_files",
    "origami.lay_other_photos",
    "origami.add_crease",
    "origami.unwrap_mesh",
    "origami.take_sheet",
    "origami.rectify_next",
)
OF_SEVERAL_BUTTONS = "origami.run_stage"
CHECKED_ERRORS = ("UnusablePhotos", "StepFailed", "UnusableMesh")


@pytest.fixture(scope="module")
def pages(root: Path) -> dict[str, str]:
    """The text of each page by its name."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in sorted((root / "docs").glob("*.md"))}
    del texts[DEVELOPERS]
    return texts


def slug(heading: str) -> str:
    """The name of a section in a link."""
    return re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-")


def sections(text: str) -> dict[str, str]:
    """The sections of a page, each with its subsections."""
    lines = text.splitlines()
    heads = [(n, len(line) - len(line.lstrip("#")), line) for n, line in enumerate(lines) if re.match(r"#+ ", line)]
    found = {}
    for place, (start, level, line) in enumerate(heads):
        end = next((n for n, other, _ in heads[place + 1 :] if other <= level), len(lines))
        found[slug(line)] = "\n".join(lines[start:end])
    assert len(found) == len(heads)
    return found


def names_in(text: str) -> set[str]:
    """Bold texts, which are names of buttons and settings."""
    return set(re.findall(r"\*\*([^*\n]+(?:\n[^*\n]+)?)\*\*", text))


def manual_text(pages: dict[str, str], rna_id: str) -> str:
    """The text that F1 opens, by Blender's own search."""
    from bl_operators.wm import WM_OT_doc_view_manual

    url = urlparse(WM_OT_doc_view_manual._lookup_rna_url(rna_id, verbose=False))
    path = Path(unquote(url.path))
    assert url.scheme == "file" and path.is_file()
    return sections(pages[path.stem])[url.fragment] if url.fragment else pages[path.stem]


def groups() -> list[type]:
    from origami.origami_addon.scene import properties

    return list(properties.CLASSES)


def operators() -> list[type]:
    import bpy
    from origami.origami_addon import addon

    return [each for each in addon.CLASSES if issubclass(each, bpy.types.Operator)]


def test_f1_over_a_button_opens_the_section_that_names_it(add_on, pages):
    for each in operators():
        text = manual_text(pages, f"bpy.ops.{each.bl_idname}")
        if each.bl_idname not in (*WITHOUT_BUTTON, OF_SEVERAL_BUTTONS):
            assert each.bl_label in names_in(text), each.bl_idname


def test_f1_over_a_setting_opens_the_section_that_names_it(add_on, pages):
    for each in groups():
        for key, shown in each.bl_rna.properties.items():
            if key not in each.__annotations__:
                continue
            text = manual_text(pages, f"bpy.types.{each.__name__}.{key}")
            place = each.__name__, key
            if (each.__name__ in SHOWN_GROUPS or place in SHOWN) and place not in NOT_SHOWN:
                assert shown.name in names_in(text), place


def test_f1_over_what_an_operator_asks_opens_the_section_that_names_it(add_on, pages):
    asked = {
        "add_photos": ("Kind", "New Document", "Subfolders", "Rectify at Once"),
        "export": ("Files", "Depth"),
        "unwrap_developable": ("Method", "Straighten", "Straighten Sides"),
    }
    for name, settings in asked.items():
        assert set(settings) <= names_in(manual_text(pages, f"bpy.ops.origami.{name}"))


def test_the_map_names_nothing_that_is_gone(add_on):
    from origami.origami_addon.window import manual

    assert set(manual._OPERATORS) == {each.bl_idname.partition(".")[2] for each in operators()}
    known = {each.__name__ for each in groups()} | {"ORIGAMI_MT_presets"}
    assert {name.partition(".")[0] for name in manual._TYPES} == known
    for each in groups():
        named = {name.partition(".")[2] for name in manual._TYPES if name.startswith(f"{each.__name__}.")}
        assert named - {"*"} <= set(each.__annotations__)


def test_where_the_pages_lie(tmp_path):
    from origami.origami_addon.window.manual import manual_map

    docs = tmp_path / "with space" / "docs"
    built = docs.parent / "out" / "docs"
    for folder in (docs, built):
        folder.mkdir(parents=True)

    def page_of(operator: str) -> str:
        prefix, places = manual_map(docs.parent)
        return prefix + dict(places)[f"bpy.ops.origami.{operator}"]

    (docs / "index.md").touch()
    assert page_of("turn_page") == f"{docs.as_uri()}/page.md#turn-the-page"
    (built / "index.html").touch()
    assert page_of("turn_page") == f"{built.as_uri()}/page.html#turn-the-page"
    (docs / "index.html").touch()
    assert page_of("turn_page") == f"{docs.as_uri()}/page.html#turn-the-page"
    assert "with%20space" in page_of("turn_page")


def shown_names(root: Path) -> set[str]:
    """All texts that a user can read on a button, beside a setting or in a list of choices."""
    import bpy
    from origami.origami_addon import addon
    from origami.origami_addon.export.outputs import KINDS
    from origami.origami_addon.presets import PRESETS

    names = {preset.label for preset in PRESETS.values()}
    names |= {kind.label for kind in KINDS.values()}
    names |= {getattr(each, "bl_label", "") for each in addon.CLASSES}
    called = [getattr(bpy.ops.origami, each.bl_idname.partition(".")[2]).get_rna_type() for each in operators()]
    for rna in (*called, *(each.bl_rna for each in groups())):
        for shown in rna.properties:
            names |= {shown.name, *(item.name for item in getattr(shown, "enum_items_static", ()))}
    for panels in ("main_panel.py", "step_panels.py"):
        tree = ast.parse((root / "origami_addon" / "window" / panels).read_text(encoding="utf-8"))
        names |= {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and node.value}
    return names


def test_every_name_in_the_pages_is_in_the_software(add_on, pages, root):
    known = shown_names(root)
    for page, text in pages.items():
        unknown = {name for name in names_in(text) if " ".join(name.split()) not in known}
        assert not unknown, f"{page}: {unknown}"


def sentences(root: Path) -> list[str]:
    """All texts in the source, with … for inserted values."""
    found = []
    for folder in ("core", "origami_addon"):
        for path in (root / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.JoinedStr | ast.Constant):
                    found.append(text_of(node))
    return found


def text_of(node: ast.expr) -> str:
    """A text in the source, with … for inserted values; empty for anything else."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) if isinstance(part, ast.Constant) else "…" for part in node.values)
    return ""


def test_a_step_that_names_an_option_names_the_button_too(root):
    """Its warnings are read in Blender as well."""
    files = (root / "origami_addon" / "feasibility.py", *(root / "origami_addon" / "steps").glob("*.py"))
    nodes = (node for file in files for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))))
    named = [text for node in nodes if re.search(r"--[a-z]", text := text_of(node))]
    assert named
    assert not [text for text in named if "Blender" not in text]


def quotes(pages: dict[str, str]) -> list[str]:
    return re.findall(r"“([^”]+)”", " ".join(pages["troubleshooting"].split()))


def pattern(quote: str) -> str:
    """A pattern that finds a quoted sentence with any inserted values."""
    return re.escape(quote).replace("…", ".*?")


def test_every_quoted_sentence_is_in_the_source(pages, root):
    everything = sentences(root)
    for quote in quotes(pages):
        assert any(re.search(pattern(quote), sentence) for sentence in everything), quote


def test_every_failure_is_explained(pages, root):
    """Messages written in one piece at `raise`; composed ones are quoted too, but not found here."""
    patterns = [pattern(quote) for quote in quotes(pages)]
    seen = 0
    for folder in ("core", "origami_addon"):
        for path in (root / folder).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if (
                    not isinstance(node, ast.Call)
                    or getattr(node.func, "id", "") not in CHECKED_ERRORS
                    or not node.args
                    or not (sentence := text_of(node.args[0])).replace("…", "").replace(".", "").strip()
                ):
                    continue
                seen += 1
                assert any(re.search(each, sentence) for each in patterns), f"{path.name}: {sentence}"
    assert seen > 30


def test_the_limits_of_quality_are_those_of_the_software(pages):
    from origami.origami_addon.window.quality import _LIMITS

    rows = [line.split("|") for line in pages["quality"].splitlines() if line.startswith("|")]
    for limit in _LIMITS:
        begin = limit.text.partition("{")[0].strip().lower()
        (row,) = (row for row in rows if row[1].strip().startswith(begin))
        for cell, value in ((row[2], limit.good), (row[3], limit.poor)):
            assert re.search(rf"\b{limit.factor * value:g}\b", cell), row


def test_tables_are_those_of_the_declarations(root):
    """If this fails, `python docs/tables.py` writes them."""
    spec = importlib.util.spec_from_file_location("tables", root / "docs" / "tables.py")
    tables = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tables)
    pages = dict(tables.written())
    assert len(pages) > 5
    for page, text in pages.items():
        assert page.read_text(encoding="utf-8") == text, page.name


def test_exit_codes_are_those_of_the_help(pages, root):
    from origami.headless.options import build_parser

    codes = re.findall(r"^  (\d+) ", build_parser().epilog, re.MULTILINE)
    lists = [
        re.findall(r"(?:^|, )(\d+) ", found)
        for text in (pages["command_line"], (root / "README.md").read_text(encoding="utf-8"))
        for found in re.findall(r"[Ee]xit codes: (0 .*? 130 stopped)", " ".join(text.split()))
    ]
    assert lists == [codes, codes]


def test_links_lead_somewhere(pages, root):
    for page, text in pages.items():
        for target in re.findall(r"(?<!!)\[[^\]]+\]\(([^)]+)\)", text):
            name, _, section = target.partition("#")
            assert name.removesuffix(".md") in pages, f"{page}: {target}"
            assert not section or section in sections(pages[name.removesuffix(".md")]), f"{page}: {target}"
    for target in re.findall(r"\]\(docs/(\w+\.md)\)", (root / "README.md").read_text(encoding="utf-8")):
        assert (root / "docs" / target).is_file()


def test_pictures_are_there_and_shown(pages, root):
    docs = root / "docs"
    shown = {target for text in pages.values() for target in re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)}
    assert not {target for target in shown if not (docs / target).is_file()}
    kinds = (".png", ".jpg", ".svg")
    there = {path.relative_to(docs).as_posix() for path in docs.rglob("*") if path.suffix in kinds}
    assert there <= shown


def test_every_page_is_in_the_table_of_contents(pages):
    listed = re.findall(r"^:::\{toctree\}\n(?::.*\n)*\n((?:\w+\n)+):::", pages["index"], re.MULTILINE)
    assert sorted(["index", *(name for block in listed for name in block.split())]) == sorted(pages)
