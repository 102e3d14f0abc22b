"""The stages of a document in their order: what the panel shows, a job runs and a whole run goes through."""

from __future__ import annotations

from typing import Literal, get_args

Stage = Literal["place", "find", "surface", "unwrap", "lay_out"]
STAGES: tuple[Stage, ...] = get_args(Stage)
PAGE = "page"  # the stage after those, whose result is a picture
