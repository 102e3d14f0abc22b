"""Sphinx's configuration for the manual (`make docs`); Origami itself does not need it."""

import tomllib
from pathlib import Path

here = Path(__file__).resolve().parent
manifest = tomllib.loads((here.parent / "blender_manifest.toml").read_text(encoding="utf-8"))

project = manifest["name"]
author = manifest["maintainer"]
release = version = manifest["version"]
project_copyright = manifest["maintainer"]

extensions = ["myst_parser"]
myst_heading_anchors = 3  # makes links to sections work as in plain Markdown
myst_enable_extensions = ["colon_fence"]
exclude_patterns = ["architecture.md"]  # for developers, beside the source

html_theme = "furo"
html_title = f"{project} {version}"
html_copy_source = False
html_use_index = False
html_show_sphinx = False
html_show_copyright = False
