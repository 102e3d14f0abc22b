"""Declare each setting once, as a field of a settings dataclass.

The range check, the command line's option, the property and its place in Blender's panel, and the row in the manual's
table all follow from the declaration.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from .errors import UsageError

# Names for the value of an option that is a path.
FOLDER, FILE = "DIR", "FILE"
_DECLARED = "setting"


@dataclass(frozen=True)
class Choice:
    """One of the words that a setting accepts.

    Attributes
    ----------
    label : str
        Its name in the window.
    help : str
    """

    label: str
    help: str


@dataclass(frozen=True)
class Setting:
    """The declaration of a setting. Texts begin in lower case and end without a full stop.

    Attributes
    ----------
    help : str
        What it is.
    label : str
        Its name in the window; empty if the window has something other than a property for it.
    option : str
        On the command line, with the name of its value: ``--grid-rows N``. Empty if it is not an option.
    typed : str
        How to write its value on the command line, if that is not obvious.
    least, most : float or None
        Range of a number.
    usual : (float or None, float or None)
        Range of the window's slider; None for the end of the whole range.
    unit : {"", "pixels", "mm", "dpi"}
    choices : mapping of str to Choice
        All words that it accepts.
    formerly : mapping of str to str
        Words of older files, and the words that replaced them.
    without : str
        What happens if it is None.
    stage : str
        The first stage of a document that it changes; a setting inside a group takes the group's.
    in_panel : bool
        Whether the window shows it.
    only_with : (name, word) or None
        It only counts if the setting of that name, in the same group, has that value.
    name, default, kind, words : str, object, type, tuple of str
        Taken from the field itself. The kind is bool, int, float, str or tuple, or a dataclass for a group of settings,
        which has no default. The words are all accepted values, or the accepted alternatives to a number.
    """

    help: str
    label: str = ""
    option: str = ""
    typed: str = ""
    least: float | None = None
    most: float | None = None
    usual: tuple[float | None, float | None] = (None, None)
    unit: str = ""
    choices: Mapping[str, Choice] = dataclasses.field(default_factory=dict)
    formerly: Mapping[str, str] = dataclasses.field(default_factory=dict)
    without: str = ""
    stage: str = ""
    in_panel: bool = True
    only_with: tuple[str, str] | None = None
    name: str = ""
    default: Any = None
    kind: type = str
    words: tuple[str, ...] = ()

    @property
    def flag(self) -> str:
        """The option without its value."""
        return self.option.partition(" ")[0]

    @property
    def value_name(self) -> str:
        """The name of the option's value."""
        return self.option.partition(" ")[2]

    @property
    def values_text(self) -> str:
        """Its range and its default, or what happens without it."""
        if self.default is None:
            texts = [f"without it: {self.without}"] if self.without else []
        elif self.kind is bool:
            texts = ["default: yes" if self.default else "default: no"]
        else:
            texts = [f"default: {self.default if self.kind is str else _number(self.default)}"]
        if self.kind in (int, float) and self.least is not None and self.most is not None:
            texts.insert(0, f"{_number(self.least)} to {_number(self.most)}")
        return ", ".join(texts)

    @property
    def is_group(self) -> bool:
        """Whether it is a dataclass of settings itself."""
        return dataclasses.is_dataclass(self.kind)


def setting(default: Any, help: str, **declared: Any) -> Any:
    """A field of a settings dataclass; the keywords are attributes of `Setting`."""
    return dataclasses.field(default=default, metadata={_DECLARED: Setting(help, **declared)})


def group_of_settings(settings: type, help: str, **declared: Any) -> Any:
    """A field that holds a settings dataclass; the keywords are attributes of `Setting`."""
    return dataclasses.field(default_factory=settings, metadata={_DECLARED: Setting(help, **declared)})


@cache
def declarations(settings: type) -> tuple[Setting, ...]:
    """The declarations of a settings dataclass, in their order."""
    hints = typing.get_type_hints(settings)
    found = []
    for each in dataclasses.fields(settings):
        kind, words = _kind_of(hints[each.name])
        declared = dataclasses.replace(
            each.metadata[_DECLARED], name=each.name, default=each.default, kind=kind, words=words
        )
        assert tuple(declared.choices) == words, f"{each.name} may be {words}, its choices {[*declared.choices]}"
        found.append(declared)
    return tuple(found)


def declaration(settings: type, name: str) -> Setting:
    """The declaration of one setting."""
    return next(each for each in declarations(settings) if each.name == name)


def word_today(settings: type, name: str, value: Any) -> Any:
    """The value of a field, or what replaced it if it is a word of older files."""
    metadata = next(each.metadata for each in dataclasses.fields(settings) if each.name == name)
    return metadata[_DECLARED].formerly.get(value, value) if _DECLARED in metadata and isinstance(value, str) else value


def declarations_within(settings: type) -> Iterator[tuple[tuple[str, ...], Setting]]:
    """All single settings, including those inside groups, each with the path of names to it and its stage."""
    for each in declarations(settings):
        if each.is_group:
            for path, inner in declarations_within(each.kind):
                yield (each.name, *path), dataclasses.replace(inner, stage=each.stage)
        else:
            yield (each.name,), each


def check_ranges(settings: Any) -> None:
    """Check that all numbers are within their ranges.

    Raises
    ------
    UsageError
        If one is not; the message is one sentence about the first.
    """
    kind: type = type(settings)
    for each in declarations(kind):
        value = getattr(settings, each.name)
        if each.is_group:
            check_ranges(value)
        elif each.least is None or each.most is None or each.kind is tuple or value is None or value in each.words:
            continue
        elif not each.least <= value <= each.most:
            least, most = _number(each.least), _number(each.most)
            allowed = f"lie between {least} and {most}, not be"
            if each.words:
                allowed = f"be {', '.join(each.words)}, or a number from {least} to {most}, not"
            raise UsageError(f"{each.name} must {allowed} {_number(value)}; change it.")


def _number(value: float) -> str:
    return f"{value:.10g}"


def _kind_of(hint: Any) -> tuple[type, tuple[str, ...]]:
    """The type of a setting's values, and the words among them."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Literal:
        return str, arguments
    if origin is tuple:
        return tuple, ()
    if origin in (types.UnionType, typing.Union):
        options = [_kind_of(option) for option in arguments if option is not type(None)]
        return options[0][0], tuple(word for _, words in options for word in words)
    return hint, ()
