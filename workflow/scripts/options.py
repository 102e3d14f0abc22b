"""The options of a document, split by the rule that reads them, so that a new resolution places no photo again."""

from __future__ import annotations

import shlex
from pathlib import Path

# The options of `headless/rectify.py` that a table may give, by the first rule on whose result they bear.
RULE_OF_OPTION = {
    "place": ("--match-size", "--seed", "--colmap-model", "--settings", "--recursive"),
    "sheet": (
        *("--reference", "--sheet", "--outline", "--creases", "--surface", "--grid-rows", "--smoothness", "--unwrap"),
        *("--ridge-rows", "--no-ridge-rows", "--boundary-rows", "--no-boundary-rows"),
    ),
    "page": (
        *("--paper", "--turn", "--dpi", "--image", "--light", "--colour", "--bake", "--no-bake", "--texture-from"),
    ),
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
    """The batch cannot begin; the message is a sentence that says what to mend."""


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
    rule_of = {option: rule for rule, names in RULE_OF_OPTION.items() for option in names}
    options: dict[str, list[str]] = {}
    files: dict[str, list[Path]] = {}
    given: list[list[str]] = []
    for word in words:
        if word.startswith("--"):
            given.append(word.split("=", 1))
        elif given and len(given[-1]) == 1:
            given[-1].append(word)
        else:
            raise BatchError(f"{word!r} is no option; options begin with --, and each has at most one value.")
    for flag, *value in given:
        if flag in _TAKEN:
            raise BatchError(f"{flag} is not for a batch; {_TAKEN[flag]}.")
        if flag not in rule_of:
            raise BatchError(f"there is no option {flag} for a batch; there are {', '.join(sorted(rule_of))}.")
        if flag == "--sheet" and value == ["all"]:
            raise BatchError(
                "--sheet all makes several pages of one document; give the table a row for each sheet, with --sheet 1, "
                "--sheet 2 and so on, the same folder, and its own name in the column document."
            )
        if flag in _NAMING_FILES and value:
            path = (base / value[0]).absolute()
            files.setdefault(rule_of[flag], []).append(path)
            value = [str(path)]
        options.setdefault(rule_of[flag], []).append("=".join([flag, *value]))
    return options, files, "--recursive" in options.get("place", [])
