"""Warnings about glare, blur and shadows in the reference photo."""

from __future__ import annotations

from collections.abc import Sequence

from ..core.page.healing import BURNT, UNLIKE, Blemish

# Share of a blemish below which the unhealed rest is only its fringe.
_ALL_BUT = 0.05

_FOUND = {
    "glare": "In {name}, {share} of the page is glare",
    "blur": "In {name}, {share} of the page is blurred",
    "shadow": "In {name}, {share} of the page is in a shadow or under something",
}
_NOTHING_BETTER = {
    "glare": "no other photo is better there; photograph it again, with the lamp farther to the side",
    "blur": "no other photo is sharper there; photograph it again and hold still",
    "shadow": "no other photo is better there; photograph it again, with nothing in the light or on the sheet",
}


def blemish_sentence(blemish: Blemish, names: Sequence[str], reference: int) -> str:
    """One sentence for the user: what is wrong in the reference photo, what replaced it, and what to do.

    Parameters
    ----------
    blemish : Blemish
    names : sequence of str
        Of the photos.
    reference : int
        Index of the reference photo.
    """
    share = _percent(blemish.share)
    if blemish.kind == BURNT:
        return (
            f"{share} of the page is burnt out in every photo that shows it: any print there is lost; photograph it "
            "again, with the lamp farther to the side or with less exposure."
        )
    if blemish.kind == UNLIKE:
        return (
            f"{share} of the page looks different in the other photos, but their print does not line up with that of "
            f"{names[reference]} there, so it stays as it is; check the page there, and the paper's edge (--outline, "
            "or Edit Outline in Blender)."
        )
    found = _FOUND[blemish.kind].format(name=names[reference], share=share)
    left = blemish.share - blemish.healed_share
    if not blemish.photos:
        return f"{found}, and {_NOTHING_BETTER[blemish.kind]}."
    others = _listed([names[index] for index in blemish.photos])
    if left <= _ALL_BUT * blemish.share:
        return f"{found}; it was taken from {others}."
    return (
        f"{found}; {_percent(blemish.healed_share)} was taken from {others}, and for {_percent(left)} "
        f"{_NOTHING_BETTER[blemish.kind]}."
    )


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.01 else f"{100 * share:.1f} %"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + f" and {names[-1]}"
