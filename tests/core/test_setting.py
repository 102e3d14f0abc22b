"""Settings are declared once, with all texts for the command line, the window and the manual."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import pytest
from origami.core.errors import UsageError
from origami.core.setting import (
    Choice,
    check_ranges,
    declaration,
    declarations,
    declarations_within,
    group_of_settings,
    setting,
)
from origami.origami_addon.settings import RunSettings
from origami.origami_addon.stages import STAGES


@dataclass(frozen=True)
class Inner:
    size: float | None = setting(None, "how large", least=0.5, most=2e6, without="as large as it is")
    kind: Literal["one", "other"] = setting(
        "one", "which", choices={"one": Choice("A", "a"), "other": Choice("B", "b")}
    )


@dataclass(frozen=True)
class Outer:
    inner: Inner = group_of_settings(Inner, "what is inside", stage="first")
    number: int | Literal["all"] = setting(
        3, "how many", option="--number N", least=1, most=9, choices={"all": Choice("All", "each")}
    )
    flag: bool = setting(True, "whether", option="--flag")
    corners: tuple[float, ...] | None = setting(None, "where")


def test_what_the_field_itself_says_is_not_declared_again() -> None:
    kinds = {each.name: (each.kind, each.default, each.words) for each in declarations(Outer)[1:]}
    assert kinds == {"number": (int, 3, ("all",)), "flag": (bool, True, ()), "corners": (tuple, None, ())}
    assert declarations(Outer)[0].is_group
    assert [(path, each.stage) for path, each in declarations_within(Outer)][:3] == [
        (("inner", "size"), "first"),
        (("inner", "kind"), "first"),
        (("number",), ""),
    ]
    assert (declaration(Outer, "number").flag, declaration(Outer, "number").value_name) == ("--number", "N")


def test_texts_on_values() -> None:
    texts = {each.name: each.values_text for _, each in declarations_within(Outer)}
    assert texts == {
        "size": "0.5 to 2000000, without it: as large as it is",
        "kind": "default: one",
        "number": "1 to 9, default: 3",
        "flag": "default: yes",
        "corners": "",
    }


def test_words_that_are_not_explained() -> None:
    @dataclass(frozen=True)
    class Wrong:
        kind: Literal["one", "other"] = setting("one", "which", choices={"one": Choice("A", "a")})

    with pytest.raises(AssertionError, match="kind may be"):
        declarations(Wrong)


def test_ranges() -> None:
    check_ranges(Outer())
    for good in (Outer(Inner(0.5)), Outer(Inner(2e6)), Outer(number=9), Outer(number="all")):
        check_ranges(good)
    with pytest.raises(UsageError, match=r"size must lie between 0\.5 and 2000000, not be 0\.4; change it"):
        check_ranges(Outer(Inner(0.4)))
    with pytest.raises(UsageError, match="number must be all, or a number from 1 to 9, not 10; change it"):
        check_ranges(Outer(number=10))


@pytest.mark.parametrize("path", [path for path, each in declarations_within(RunSettings) if each.kind in (int, float)])
def test_a_run_has_no_number_without_a_range(path: tuple[str, ...]) -> None:
    (each,) = (each for name, each in declarations_within(RunSettings) if name == path)
    assert each.least is not None and each.most is not None

    def check(value: float) -> None:
        changed = {path[-1]: value}
        check_ranges(
            replace(RunSettings(), **{path[0]: replace(getattr(RunSettings(), path[0]), **changed)})
            if len(path) > 1
            else replace(RunSettings(), **changed)
        )

    check(each.least)
    check(each.most)
    for value in (each.least - 1e-5, each.most + 1):
        with pytest.raises(UsageError, match=f"{path[-1]} must "):
            check(value)


def test_texts_are_as_all_who_show_them_expect() -> None:
    every = [*declarations(RunSettings), *(each for _, each in declarations_within(RunSettings))]
    texts = [text for each in every for text in (each.help, *(choice.help for choice in each.choices.values()))]
    for text in [*texts, *(each.without for each in every)]:
        assert text == text.strip() and not text.endswith(".") and "|" not in text
        assert text[:1] == text[:1].lower()
    assert all(texts)
    flags = [each.flag for _, each in declarations_within(RunSettings) if each.option]
    assert len(flags) == len({*flags}) and all(flag.startswith("--") for flag in flags)
    assert {each.stage for each in declarations(RunSettings)} == {*STAGES}
