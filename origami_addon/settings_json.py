"""Settings dataclasses to JSON and back; one sentence reports whatever does not fit."""

from __future__ import annotations

import dataclasses
import difflib
import json
import sys
import types
import typing
from pathlib import Path
from typing import Any

from ..core.errors import UsageError
from ..core.setting import word_today
from .files.json_files import parsed_json
from .settings import RunSettings

_LONGEST_SHOWN = 40  # letters of a name or value in a sentence


def to_json(settings: Any) -> dict[str, Any]:
    """A settings dataclass as values that `json` can write."""
    return typing.cast(dict[str, Any], json.loads(as_text(settings)))


def as_text(settings: Any) -> str:
    """A settings dataclass as the text of a settings file."""
    return json.dumps(dataclasses.asdict(settings), indent=2)


def from_json(content: Any, base: RunSettings | None = None) -> RunSettings:
    """Settings from parsed JSON; missing ones stay as in ``base``, or at their defaults.

    Raises
    ------
    UsageError
        If a name is unknown or a value has the wrong type.
    """
    return typing.cast(RunSettings, merged(base or RunSettings(), content))


def read_settings(path: Path) -> RunSettings:
    """Settings from a JSON file: a settings file, or the report of another run.

    Raises
    ------
    UsageError
        If the file cannot be read or does not hold settings.
    """
    content = read_json(path, "settings")
    if isinstance(content, dict) and "settings" in content:
        content = content["settings"]
    try:
        return from_json(content)
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None


def read_json(path: Path, what: str) -> Any:
    """The parsed content of a JSON file that holds ``what``.

    Raises
    ------
    UsageError
        If it cannot be read or is not JSON.
    """
    try:
        return parsed_json(path)
    except OSError as error:
        raise UsageError(f"The {what} file {path} cannot be read ({error.strerror}); check the path.") from error
    except ValueError as error:
        raise UsageError(f"The {what} file {path} is not valid JSON ({error}); fix the file there.") from error


def merged(base: Any, content: Any, place: str = "") -> Any:
    """A dataclass with its values from parsed JSON.

    Raises
    ------
    UsageError
        If a name is unknown or a value has the wrong type.
    """
    if not isinstance(content, dict):
        raise UsageError(f"{place or 'the settings'} must be an object {{...}}, not {shown(content)}.")
    hints = typing.get_type_hints(type(base))
    changes = {}
    for name, value in content.items():
        where = f"{place}.{name}" if place else name
        if name not in hints:
            near = difflib.get_close_matches(name[:_LONGEST_SHOWN], hints, 1)
            hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(hints)}."
            raise UsageError(f"There is no setting {where[:_LONGEST_SHOWN]}; {hint}")
        current = getattr(base, name)
        if dataclasses.is_dataclass(current):
            changes[name] = merged(current, value, where)
        else:
            changes[name] = _convert(hints[name], word_today(type(base), name, value), where)
    return dataclasses.replace(base, **changes)


def _convert(hint: Any, value: Any, where: str) -> Any:
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin in (types.UnionType, typing.Union):
        if value is None and type(None) in arguments:
            return None
        return _convert(_option_for(arguments, value), value, where)
    if origin is typing.Literal:
        if value not in arguments:
            raise UsageError(f"{where} must be one of {', '.join(map(str, arguments))}, not {shown(value)}.")
        return value
    if origin is tuple:
        return _convert_list(arguments, value, where)
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max
    if hint is float and is_number:
        return float(value)
    if hint is int and is_number and value == int(value):
        return int(value)
    if (hint is bool and isinstance(value, bool)) or (hint is str and isinstance(value, str) and "\0" not in value):
        return value
    kind = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}[hint]
    raise UsageError(f"{where} must be {kind}, not {shown(value)}.")


def _option_for(arguments: tuple[Any, ...], value: Any) -> Any:
    """Which of a setting's types a value has: a word has its own, everything else the first."""
    words = [option for option in arguments if typing.get_origin(option) is typing.Literal]
    if words and isinstance(value, str):
        return words[0]
    return next(option for option in arguments if option is not type(None))


def _convert_list(arguments: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise UsageError(f"{where} must be a list [...], not {shown(value)}.")
    if arguments[-1] is Ellipsis:
        arguments = (arguments[0],) * len(value)
    if len(value) != len(arguments):
        raise UsageError(f"{where} must have {len(arguments)} values, not {len(value)}.")
    return tuple(
        _convert(hint, item, f"{where}[{index}]")
        for index, (hint, item) in enumerate(zip(arguments, value, strict=True))
    )


def shown(value: Any) -> str:
    """A value for a sentence: as JSON, shortened if it is long."""
    text = json.dumps(value)
    return text if len(text) <= _LONGEST_SHOWN else text[: _LONGEST_SHOWN - 3] + "..."
