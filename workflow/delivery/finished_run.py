"""A document's folder, as a finished run leaves it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.errors import UsageError
from ...origami_addon.files.json_files import parsed_json
from ...origami_addon.files.links import real
from ...origami_addon.files.marker import REPORT


@dataclass(frozen=True)
class InputPhoto:
    """A photo of a run.

    Attributes
    ----------
    name : str
        As the run calls it, which is also its name in ``map.npz``.
    path : Path
        Where it was when the run read it.
    size : (width, height)
        Pixels as stored.
    sha256 : str
        Of its content.
    """

    name: str
    path: Path
    size: tuple[int, int]
    sha256: str


@dataclass(frozen=True)
class FinishedRun:
    """The results of a run of one sheet.

    Attributes
    ----------
    folder : Path
    report : dict
        The content of its ``report.json``.
    """

    folder: Path
    report: dict[str, Any]

    @property
    def title(self) -> str:
        """The name of the folder."""
        return real(self.folder).name

    @property
    def photos(self) -> dict[str, InputPhoto]:
        """The photos by their names."""
        found = [entry for entry in self.report["inputs"] if "width" in entry]
        return {
            each["name"]: InputPhoto(each["name"], Path(each["path"]), (each["width"], each["height"]), each["sha256"])
            for each in found
        }

    def figure(self, name: str) -> Any:
        """A figure of the report by its name, from the last step that has it; None if there is none."""
        found = [stage["figures"][name] for stage in self.report["stages"] if name in stage["figures"]]
        return found[-1] if found else None

    def hash_of(self, name: str) -> str:
        """The SHA-256 of a file of the run, by its report."""
        return str(self.report["outputs"].get(name, {}).get("sha256", ""))

    def file(self, name: str) -> Path:
        """The path of a file of the run.

        Raises
        ------
        UsageError
            If it is not there.
        """
        path = self.folder / name
        if not path.is_file():
            raise UsageError(f"{self.folder} holds no {name}; run rectify.py with -o {self.folder} --resume.")
        return path


def finished_run(folder: Path) -> FinishedRun:
    """The results in a folder.

    Raises
    ------
    UsageError
        If no run of one sheet has finished there.
    """
    try:
        report = parsed_json(folder / REPORT)
    except FileNotFoundError:
        raise UsageError(
            f"{folder} holds no {REPORT}, so no run has finished there; run rectify.py with -o {folder} first."
        ) from None
    except NotADirectoryError:
        raise UsageError(f"{folder} is a file; name the folder of a document's results.") from None
    except ValueError as error:
        raise UsageError(f"{folder / REPORT} cannot be read ({error}); run rectify.py again with --resume.") from None
    if not isinstance(report, dict) or not {"inputs", "stages", "outputs"} <= report.keys():
        raise UsageError(f"{folder / REPORT} is not a report of Origami; name the folder of a document's results.")
    if report.get("sheets"):
        named = " and ".join(str(folder / each["folder"]) for each in report["sheets"] if not each["failure"])
        raise UsageError(f"{folder} holds several sheets; name the folder of one of them: {named}.")
    return FinishedRun(folder, report)
