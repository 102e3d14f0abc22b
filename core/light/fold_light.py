"""The light beside folds, which changes within a few cells where paper bends sharply or a crease is a little off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ..arrays import Array
from ..numeric.image import gaussian_mean

Cells = NDArray[np.bool_]
Values = NDArray[np.float32]

# Values without a figure are choices; no measurement of them is recorded.
# A fold is where the normal turns by this much, degrees, within a window of this many cells; its light reaches this
# many cells fully, and fades out over as many more.
_TURN, _WINDOW, _REACH = 10.0, 7, 10
_CENTRE = 0.7  # of the largest turn nearby: where the fold itself is
# Logarithm of light: beside a fold of the set XII, paper grows darker by 0.09 from cell to cell at most, and by 0.33 in
# all. What differs by less than the last is noise.
_STEP, _DARKEST, _SHADED = 0.1, 0.5, 0.03
# Correlation of the light with the distance from the fold: shading deepens towards it, print does not. Shading has 0.7
# and more, tinted rows of a table beside a fold less than 0.2.
_DEEPENS = 0.5
# Between letters paper looks darker than it is: nothing is done where up to this share of the surroundings, within a
# standard deviation (cells), is even paper, and everything from twice as much on.
_PRINTED, _AROUND = 0.25, 2.0
_SMOOTH = (3.0, 1.5, 0.75)  # cells, standard deviations, from coarse to fine
_LEAST_SHARE = 0.03
_CROSS = ndimage.generate_binary_structure(2, 1)


def light_at_folds(rest: Array, share: Values, known: Cells, blank: Cells, normals: Array) -> Values:
    """The part of the light on blank paper beside folds that is finer than the rest of the model.

    Parameters
    ----------
    rest : (h, w, 3) array
        Logarithm of linear light of the even cells, less the model's.
    share : (h, w) float32 array
        Of each cell's pixels that are even.
    known : (h, w) bool array
        Which cells are even.
    blank : (h, w) bool array
        Which of them are blank paper.
    normals : (h, w, 3) array
        The sheet's normals there; zero off the sheet.

    Returns
    -------
    (h, w, 3) float32 array
        What is added to the model's logarithm of light; 0 away from folds and in print.
    """
    turn = _turn(normals)
    folds = turn > _TURN
    if not folds.any():
        return np.zeros(rest.shape, np.float32)
    near = np.clip(2 - ndimage.distance_transform_edt(~folds) / _REACH, 0, 1)
    centre = folds & (turn > _CENTRE * ndimage.maximum_filter(turn, 2 * _WINDOW))
    light = np.where(known, rest.mean(axis=-1), -np.inf)
    paper = _joined(light, blank, known & (near > 0))
    paper &= ~_print(light, paper & (near > 0), ndimage.distance_transform_edt(~centre))
    weight = (share * paper).astype(np.float32)
    paper_share, _ = gaussian_mean(weight, np.linalg.norm(normals, axis=-1) > 0, _AROUND)
    clear = np.clip((paper_share - _PRINTED) / _PRINTED, 0, 1)
    part = (near * clear)[..., None].astype(np.float32)
    fine = np.zeros(rest.shape, np.float32)
    for sigma in _SMOOTH:
        left = np.where(paper[..., None], rest - fine, 0).astype(np.float32)
        fine += part * gaussian_mean(left, weight, sigma, _LEAST_SHARE)[0]
    return fine


def _turn(normals: Array) -> Array:
    """By how many degrees the normal turns around each cell (h, w); 0 near the sheet's edge."""
    inside = ndimage.minimum_filter(np.linalg.norm(normals, axis=-1) > 0, _WINDOW)
    mean = ndimage.uniform_filter(normals, (_WINDOW, _WINDOW, 1))
    # the mean normal of two plane halves that meet at an angle is as long as the cosine of half of it
    return np.where(inside, 2 * np.degrees(np.arccos(np.clip(np.linalg.norm(mean, axis=-1), 0, 1))), 0)


def _joined(light: Array, blank: Cells, joinable: Cells) -> Cells:
    """Blank paper and the cells that grow darker from it step by step."""
    paper, level = blank.copy(), np.where(blank, light, -np.inf)
    joinable = joinable & (light > -_DARKEST)
    for _ in range(2 * _REACH):
        joined = joinable & ~paper & (light > ndimage.maximum_filter(level, footprint=_CROSS) - _STEP)
        if not joined.any():
            break
        paper |= joined
        level[joined] = light[joined]
    return paper


def _print(light: Array, paper: Cells, away: Array) -> Cells:
    """Which dark cells do not deepen towards the fold, from which they are ``away`` (h, w), and so are print."""
    label, _ = ndimage.label(paper & (light < -_SHADED), np.ones((3, 3)))
    print_ = np.zeros(label.shape, bool)
    for number, box in enumerate(ndimage.find_objects(label), 1):
        own = label[box] == number
        values, distance = light[box][own], away[box][own]
        spread = values.std() * distance.std()
        deepens = ((values - values.mean()) * (distance - distance.mean())).mean() / spread if spread > 0 else 0.0
        print_[box] |= own & (deepens < _DEEPENS)
    return print_
