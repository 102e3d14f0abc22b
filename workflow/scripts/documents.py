"""The documents of a batch: the folders in a folder, or the rows of a table."""

from __future__ import annotations

import csv
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from options import BatchError, split_options

COLUMNS = ("folder", "document", "paper", "dpi", "kind", "options", "languages")
# The columns that the configuration gives to all documents whose own cell is empty.
COMMON = ("paper", "dpi", "kind", "options", "languages")
# Names in the folder for the results that are not documents.
_TAKEN = ("summary.csv", "summary.html", "iiif", ".snakemake", ".batch-lock")
_LONGEST_NAME = 200  # bytes; file systems take 255, and temporary files need some
# Control characters, those that change the writing direction, halves of characters, and separators of lines.
_ESCAPED = ("Cc", "Cf", "Cs", "Zl", "Zp")


@dataclass(frozen=True)
class Document:
    """One document.

    Attributes
    ----------
    name : str
        Of its folder of results.
    folder : Path
        With its photos.
    paper, dpi, kind, languages : str
        Empty if not given.
    options : dict of str to list of str
        The other options of the command line, for each rule that reads them.
    files : dict of str to list of Path
        The files and folders that these options name, for each rule.
    recursive : bool
        Whether photos in folders inside the folder count.
    """

    name: str
    folder: Path
    paper: str = ""
    dpi: str = ""
    kind: str = ""
    languages: str = ""
    options: Mapping[str, list[str]] = field(default_factory=dict)
    files: Mapping[str, list[Path]] = field(default_factory=dict)
    recursive: bool = False

    def arguments(self, rule: str) -> list[str]:
        """The options of the command line on which the result of a rule depends."""
        given = [f"--kind={self.kind}"] if self.kind else []
        for name in ("place", "sheet", "page"):
            given += self.options.get(name, [])
            if name == rule:
                break
        if rule == "page":
            given += [f"--{name}={value}" for name in ("paper", "dpi") if (value := getattr(self, name))]
        return given

    def photos(self) -> list[str]:
        """The files that may be photos and that the workflow can follow by name."""
        return [str(path) for path in self._files() if _is_plain(str(path))]

    def others(self) -> list[tuple[str, int, int]]:
        """The files that may be photos and whose names the workflow cannot follow, with their times and sizes."""
        unplain = [path for path in self._files() if not _is_plain(str(path))]
        return [(ascii(path.name), path.stat().st_mtime_ns, path.stat().st_size) for path in unplain]

    def megabytes(self) -> float:
        """The size of these files together."""
        return sum(path.stat().st_size for path in self._files()) / 1e6

    def _files(self) -> list[Path]:
        """The files in the folder; none if it cannot be read, which the run itself reports."""
        found = self.folder.rglob("*") if self.recursive else self.folder.glob("*")
        try:
            return sorted(
                path
                for path in found
                if path.is_file() and not any(part.startswith(".") for part in path.relative_to(self.folder).parts)
            )
        except OSError:
            return []

    def inputs(self, rule: str) -> list[str]:
        """The files that the options of a rule name; those that are missing are reported by the run."""
        return [str(path) for path in self.files.get(rule, []) if path.is_file() and _is_plain(str(path))]


def read_documents(source: Path, out: Path, common: Mapping[str, Any]) -> dict[str, Document]:
    """The documents by name.

    Parameters
    ----------
    source : Path
        A folder whose folders are documents, or a table as CSV.
    out : Path
        The folder for the results, which is no document if it lies in ``source``.
    common : mapping
        Values for the cells that are empty, by the names in `COMMON`.

    Raises
    ------
    BatchError
        With a sentence that says what to correct.
    """
    if source.is_dir():
        rows: Iterable[dict[str, str]] = _rows_of_folder(source, out)
        base = source
    elif source.is_file():
        rows, base = _rows_of_table(source), source.parent
    else:
        raise BatchError(f"There is no folder or table {source}; check the path.")
    try:
        documents = [_document(row, base, common) for row in rows]
    except OSError as error:
        raise BatchError(f"{source} cannot be read ({error.strerror}); check its permissions.") from error
    if not documents:
        raise BatchError(f"{source} names no document; put each document's photos into a folder of its own there.")
    _check_names(documents, source)
    return {document.name: document for document in documents}


def _rows_of_folder(source: Path, out: Path) -> Iterator[dict[str, str]]:
    for path in sorted(source.iterdir()):
        if path.is_dir() and not path.name.startswith(".") and path.resolve() != out.resolve():
            yield {"folder": path.name}


def _rows_of_table(table: Path) -> Iterator[dict[str, str]]:
    try:
        text = table.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise BatchError(f"The table {table} cannot be read as UTF-8 ({error}); save it as CSV UTF-8.") from error
    head = text.split("\n", 1)[0]
    reader = csv.DictReader(text.splitlines(), delimiter=max(",;\t", key=head.count), strict=True)
    names = [(name or "").strip().lower() for name in reader.fieldnames or []]
    unknown = [name for name in names if name not in COLUMNS]
    if "folder" not in names or unknown or len(set(names)) < len(names):
        what = (
            f"the column {unknown[0]!r}" if unknown else "a column twice" if "folder" in names else "no column folder"
        )
        raise BatchError(f"The table {table} has {what}; its first line names columns of these: {', '.join(COLUMNS)}.")
    try:
        for cells in reader:
            if None in cells or None in cells.values():
                raise BatchError(
                    f"Line {reader.line_num} of {table} does not have {len(names)} cells like the first line; put a "
                    "cell that holds a comma or a semicolon in quotes."
                )
            row = dict(zip(names, (str(cell).strip() for cell in cells.values())))
            if any(row.values()):
                if not row["folder"]:
                    raise BatchError(f"Line {reader.line_num} of {table} names no folder; fill in its cell.")
                yield row
    except csv.Error as error:
        raise BatchError(f"Line {reader.line_num} of {table} is not CSV ({error}); correct it there.") from error


def _document(row: Mapping[str, str], base: Path, common: Mapping[str, Any]) -> Document:
    # As text, because Path takes away nothing of "..", and a folder such as "-x" becomes no option.
    folder = (base / row["folder"]).absolute()
    name = row.get("document") or folder.name
    values = {key: row.get(key) or _as_text(common.get(key)) for key in COMMON}
    try:
        options, files, recursive = split_options(values.pop("options"), base)
    except BatchError as error:
        raise BatchError(f"The options of {name}: {error}") from error
    return Document(escaped(name), folder, options=options, files=files, recursive=recursive, **values)


def _as_text(value: Any) -> str:
    return "" if value is None else str(value).strip()


def escaped(name: str) -> str:
    """A document's name as the name of a folder: what no path of a workflow may hold becomes %XX, byte by byte."""
    text = "".join(
        "".join(f"%{byte:02X}" for byte in letter.encode("utf-8", "surrogateescape"))
        if letter in "{}/\\" or unicodedata.category(letter) in _ESCAPED
        else letter
        for letter in name
    )
    return text.strip(" ") if text.strip(" ") == text else text.replace(" ", "%20")


def _is_plain(path: str) -> bool:
    """Whether the workflow can follow a file of this name, in which a brace is a wildcard; the run takes any name."""
    return not any(letter in "{}" or unicodedata.category(letter) in _ESCAPED for letter in path)


def _check_names(documents: Iterable[Document], source: Path) -> None:
    documents = list(documents)
    for name, count in Counter(document.name.casefold() for document in documents).items():
        same = [document for document in documents if document.name.casefold() == name]
        if count > 1:
            places = " and ".join(str(document.folder) for document in same[:2])
            raise BatchError(
                f"{count} documents in {source} have the name {same[0].name} ({places}); rename one, or give each "
                "another name in the table's column document."
            )
        if name in _TAKEN or name in (".", "..") or len(name.encode()) > _LONGEST_NAME:
            raise BatchError(
                f"No folder of results can have the name {same[0].name[:80]}; rename {same[0].folder}, or give it "
                "another name in the table's column document."
            )
