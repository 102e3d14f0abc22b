"""The options of a document, split by the rule that reads them, so that a new resolution places no photo again."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

# The rule for each option of `headless/rectify.py` that a table may give: the first one whose result it affects. Those
# of settings follow from their declarations (`docs/tables.py` writes the file).
_SCHEMAS = Path(__file__).resolve().parent.parent / "schemas"
RULE_OF_OPTION: dict[str, str] = {
    **json.loads((_SCHEMAS / "rule_of_option.json").read_text(encoding="utf-8")),
    "--settings": "place",
    "--recursive": "place",
    "--texture-from": "page",
}
# Those that the workflow gives itself, and what to do instead.
_TAKEN = {
    "--threads": "set threads in the configuration",
    "--kind": "use the column kind",
    "--output": "set out in the configuration",
    "--resume": "leave it out: a batch always goes on from what it has",
    "--force": "leave it out: delete the document's folder to begin again",
    "--stop-after": "leave it out: each rule stops after its own stage",
}
_NAMING_FILES = ("--colmap-model", "--settings", "--outline", "--creases", "--texture-from")


class BatchError(Exception):
    """The batch cannot begin; the message is a sentence that says what to correct."""


def split_options(text: str, base: Path) -> tuple[dict[str, list[str]], dict[str, list[Path]], bool]:
    """The options of the command line in ``text``.

    Parameters
    ----------
    text : str
        As one would type them.
    base : Path
        Where the paths of files in them begin.

    Returns
    -------
    options : dict of str to list of str
        For each rule, each option with its value as one word.
    files : dict of str to list of Path
        For each rule, the files and folders that they name.
    recursive : bool

    Raises
    ------
    BatchError
    """
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise BatchError(f"{text!r} has a quotation mark too few; close it.") from error
    options: dict[str, list[str]] = {}
    files: dict[str, list[Path]] = {}
    given: list[list[str]] = []
    for word in words:
        if word.startswith("--"):
            given.append(word.split("=", 1))
        elif given and len(given[-1]) == 1:
            given[-1].append(word)
        else:
            raise BatchError(f"{word!r} is not an option; options begin with --, and each has at most one value.")
    for flag, *value in given:
        if flag in _TAKEN:
            raise BatchError(f"{flag} is not for a batch; {_TAKEN[flag]}.")
        if flag not in RULE_OF_OPTION:
            raise BatchError(f"there is no option {flag} for a batch; there are {', '.join(sorted(RULE_OF_OPTION))}.")
        if flag == "--sheet" and value == ["all"]:
            raise BatchError(
                "--sheet all makes several pages of one document; give the table a row for each sheet, with --sheet 1, "
                "--sheet 2 and so on, the same folder, and its own name in the column document."
            )
        if flag in _NAMING_FILES and value:
            path = (base / value[0]).absolute()
            files.setdefault(RULE_OF_OPTION[flag], []).append(path)
            value = [str(path)]
        options.setdefault(RULE_OF_OPTION[flag], []).append("=".join([flag, *value]))
    return options, files, "--recursive" in options.get("place", [])
