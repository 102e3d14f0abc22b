"""How far a page is from its flat original, by the protocol of the paper's section 4.2.

All lengths are pixels with the original scaled to 1000 px height. Points are matched by SIFT and then matched again
near the places that their neighbours predict, because the ratio test alone fails on repeated text. The local metric is
a dense optical flow (DIS, whereas the paper used SIFT-flow) after the affine registration, counted on print only: on
blank paper flow is noise.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from ..core.flat.distortion import apply_affine, fit_affine, fit_similarity
from ..core.numeric.image import sample_bilinear
from .transforms import displacement
from .waves import Waves, waves

Image = NDArray[np.uint8]
Array = NDArray[np.float64]

HEIGHT = 1000
BINS = 8
# Straight edges of the original from this length on are its rules, px.
_SHORTEST_RULE = 100.0
# Profiles across a rule reach so far to both sides, and are averaged along it over so much, px.
_PROFILE, _ALONG = 6, 5
_ROUNDS = 8
# The page shows the rule where its profile correlates with the original's at least this much.
_ALIKE = 0.8


class NoMatch(Exception):
    """The page shows too little of the original to be measured."""


@dataclass(frozen=True)
class Features:
    """Positions (N, 2) in pixels and unit descriptors (N, 128) whose distance is Hellinger's."""

    points: Array
    descriptors: NDArray[np.float32]


def find_features(image: Image) -> Features:
    keys, descriptors = cv2.SIFT_create(12000, contrastThreshold=0.02).detectAndCompute(_grey(image), None)
    if descriptors is None or len(keys) < 50:
        raise NoMatch("fewer than 50 features in the image")
    descriptors = np.sqrt(descriptors / (descriptors.sum(1, keepdims=True) + 1e-9))
    return Features(np.array([key.pt for key in keys]) + 0.5, descriptors)


def match(page: Features, original: Features) -> tuple[Array, Array]:
    """Matched positions, page (M, 2) and original (M, 2)."""
    nearest = cv2.BFMatcher(cv2.NORM_L2).knnMatch(page.descriptors, original.descriptors, k=2)
    pairs = np.array([(a.queryIdx, a.trainIdx) for a, b in nearest if a.distance < 0.8 * b.distance])
    if len(pairs) < 30:
        raise NoMatch(f"only {len(pairs)} features of the page match the original")
    here, there = page.points[pairs[:, 0]], original.points[pairs[:, 1]]
    _, agree = cv2.estimateAffine2D(
        here, there, method=cv2.RANSAC, ransacReprojThreshold=15, maxIters=5000, confidence=0.999
    )
    agree = agree.ravel().astype(bool)
    if agree.sum() < 30:
        raise NoMatch(f"only {int(agree.sum())} matches agree on an affine map")
    here, there = _keep_neighbourly(here[agree], there[agree], 3.0)
    for gate, limit in ((16, 2.5), (10, 2.0)):
        more_here, more_there = _match_near_prediction(here, there, page, original, gate)
        if len(more_here) < max(30, len(here) / 2):
            break
        here, there = _keep_neighbourly(more_here, more_there, limit)
    return here, there


def _keep_neighbourly(here: Array, there: Array, limit: float) -> tuple[Array, Array]:
    """Only the matches whose displacement, after the affine, is within ``limit`` px of their ten neighbours' median."""
    affine = fit_affine(here, there)
    residual = there - apply_affine(affine, here)
    neighbours = cKDTree(there).query(there, k=min(11, len(there)))[1][:, 1:]
    keep = np.linalg.norm(residual - np.median(residual[neighbours], axis=1), axis=1) < limit
    return here[keep], there[keep]


def _match_near_prediction(
    here: Array, there: Array, page: Features, original: Features, gate: float
) -> tuple[Array, Array]:
    affine = fit_affine(here, there)
    residual = there - apply_affine(affine, here)
    distance, nearest = cKDTree(here).query(page.points, k=min(8, len(here)))
    weight = 1 / (distance**2 + 30**2)
    local = (weight[..., None] * residual[nearest]).sum(1) / weight.sum(1)[:, None]
    predicted = apply_affine(affine, page.points) + local
    best: dict[int, tuple[float, int]] = {}
    for i, candidates in enumerate(cKDTree(original.points).query_ball_point(predicted, gate)):
        if not candidates:
            continue
        away = np.sqrt(np.maximum(2 - 2 * (original.descriptors[candidates] @ page.descriptors[i]), 0))
        first, *rest = np.argsort(away)
        if away[first] >= 0.75:
            continue
        apart = rest and np.linalg.norm(original.points[candidates[first]] - original.points[candidates[rest[0]]]) >= 1
        if apart and away[first] >= 0.85 * away[rest[0]]:
            continue
        target = candidates[first]
        if target not in best or away[first] < best[target][0]:
            best[target] = (float(away[first]), i)
    matched_here = np.array([i for _, i in best.values()], int)
    return page.points[matched_here], original.points[np.array(list(best), int)]


def _grey(image: Image) -> Image:
    return cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image


def _smooth(image: Image) -> Image:
    return cv2.GaussianBlur(_grey(image), (0, 0), 1.0)


def even_contrast(image: Image) -> Image:
    """The image smooth, grey, and with the same contrast everywhere: (h, w) uint8."""
    values = _smooth(image).astype(np.float32)
    mean = cv2.GaussianBlur(values, (0, 0), 12)
    deviation = np.sqrt(cv2.GaussianBlur((values - mean) ** 2, (0, 0), 12))
    return np.clip((values - mean) / (deviation + 8) * 45 + 128, 0, 255).astype(np.uint8)


def _printed(original: Image) -> NDArray[np.bool_]:
    """Where the original has structure in two directions: the structure tensor's smaller eigenvalue."""
    grey = _smooth(original).astype(np.float32)
    gx, gy = cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)
    xx, yy, xy = (cv2.GaussianBlur(product, (0, 0), 5) for product in (gx * gx, gy * gy, gx * gy))
    return (xx + yy) / 2 - np.sqrt(((xx - yy) / 2) ** 2 + xy**2) > 15**2


@dataclass(frozen=True)
class Registered:
    """A page laid on its original by an affine map.

    Attributes
    ----------
    original, page : (h, w) uint8 array
        Grey and even in contrast.
    covered : (h, w) bool array
        Where the page lies.
    flow : (h, w, 2) array
        From the original's pixels to where the page has them, px.
    agrees : (h, w) bool array
        Where the flow there and back again returns.
    """

    original: Image
    page: Image
    covered: NDArray[np.bool_]
    flow: NDArray[np.float32]
    agrees: NDArray[np.bool_]


def register(original: Image, page: Image, affine: Array) -> Registered:
    """Lay a page on its original, which is `HEIGHT` px high; ``affine`` (2, 3) takes the page's pixels to it."""
    height, width = original.shape[:2]
    pixels = affine.copy()
    pixels[:, 2] += pixels[:, :2] @ [0.5, 0.5] - 0.5  # OpenCV counts from pixel centres
    scale = np.sqrt(abs(np.linalg.det(affine[:, :2])))
    blurred = cv2.GaussianBlur(page, (0, 0), max(0.3, 0.5 * np.sqrt(max(1 / scale**2 - 1, 0.01))))
    warped = cv2.warpAffine(blurred, pixels, (width, height), flags=cv2.INTER_CUBIC)
    covered = cv2.warpAffine(np.full(page.shape[:2], 255, np.uint8), pixels, (width, height)) > 254
    covered &= cv2.morphologyEx((_grey(warped) > 0).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((15, 15))) > 0
    covered = cv2.erode(covered.astype(np.uint8), np.ones((9, 9))) > 0
    here, there = even_contrast(original), even_contrast(warped)
    flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    flow.setFinestScale(1)
    forth, back = flow.calc(here, there, None), flow.calc(there, here, None)
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    loop = forth + cv2.remap(back, x + forth[..., 0], y + forth[..., 1], cv2.INTER_LINEAR)
    return Registered(here, there, covered, forth, np.linalg.norm(loop, axis=2) < 1)


def find_rules(original: Image) -> Array:
    """Ends (K, 2, 2) of the straight edges of an original that is `HEIGHT` px high: rules, frames, sides of pictures.

    By Grompone von Gioi's line segment detector. Pixels with the centre of the first one at (0, 0).
    """
    found = cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD).detect(_grey(original))[0]
    ends = np.zeros((0, 2, 2)) if found is None else found.reshape(-1, 2, 2).astype(float)
    return ends[np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) >= _SHORTEST_RULE]


def waves_of_rules(registered: Registered, rules: Array) -> Waves:
    """Displacement of the page across each rule (K, 2, 2), px.

    The rule's profile in the original is found again in the page, by Lucas and Kanade's method in one dimension, from
    where the flow has it: the flow itself is too smooth, for beside a rule there is often nothing to follow.
    """
    return waves(_across_rule(registered, start, end) for start, end in rules)


def _across_rule(registered: Registered, start: Array, end: Array) -> Array:
    """Displacement (N,) at every pixel's length of a rule; NaN where the page does not show it."""
    length = np.linalg.norm(end - start)
    normal = np.array([start[1] - end[1], end[0] - start[0]]) / length
    places = start + np.linspace(0, 1, int(length) + 1)[:, None] * (end - start) + 0.5

    def profile(image: Image, shift: Array) -> Array:
        offset = np.arange(-_PROFILE, _PROFILE + 1.0) + shift[:, None]
        values = sample_bilinear(image[..., None].astype(np.float32), places[:, None] + offset[..., None] * normal)
        return ndimage.uniform_filter1d(values[..., 0].astype(float), _ALONG, axis=0)

    shift = sample_bilinear(registered.flow, places) @ normal
    target = profile(registered.original, np.zeros_like(shift))
    for _ in range(_ROUNDS):
        shown = profile(registered.page, shift)
        slope = np.gradient(shown, axis=1)
        step = (slope * (target - shown)).sum(1) / ((slope**2).sum(1) + 1)
        shift = shift + np.clip(step, -1, 1)
    shown = profile(registered.page, shift)
    a, b = (values - values.mean(1, keepdims=True) for values in (target, shown))
    correlation = (a * b).sum(1) / np.sqrt((a**2).sum(1) * (b**2).sum(1) + 1)
    x, y = np.clip(places.astype(int), 0, np.array(registered.covered.shape)[::-1] - 1).T
    return np.where(registered.covered[y, x] & (correlation > _ALIKE), shift, np.nan)


def summary(values: Array) -> dict[str, float]:
    return {
        "mean": float(values.mean()),
        "median": float(np.median(values)),
        "p95": float(np.percentile(values, 95)),
    }


def score_page(original: Image, page: Image) -> dict[str, object]:
    """Figures of a page compared with its flat original, both as read by OpenCV.

    ``G`` is Eq. 22 of the affine over its vertical scale squared: a margin that the sheet has and the original lacks
    does not count. ``aspect_percent`` is how much too wide the page is. ``sift`` is the residual of the matches after
    the affine, ``similarity`` after a similarity, and ``dense`` the flow on print, with its ``bins`` of one pixel each.
    ``rules`` is how far the original's straight edges wave on the page.

    Raises
    ------
    NoMatch
        If the page is blank, mirrored or of something else.
    """
    width = round(HEIGHT * original.shape[1] / original.shape[0])
    fine = (int(width * 1.5), HEIGHT * 3 // 2)
    target = find_features(cv2.resize(original, fine, interpolation=cv2.INTER_CUBIC))
    target = Features(target.points * [width / fine[0], 1 / 1.5], target.descriptors)
    shrink = 2400 / max(page.shape[:2])
    if shrink < 1:
        page = cv2.resize(page, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    here, there = match(find_features(page), target)
    affine = fit_affine(here, there)
    linear = affine[:, :2]
    if np.linalg.det(linear) < 0:
        raise NoMatch("the page is mirrored")
    across, down = np.linalg.norm(np.linalg.inv(linear), axis=0)
    area = float(np.linalg.det(linear) * down**2)
    singular = np.linalg.svd(linear, compute_uv=False)
    small = cv2.resize(original, (width, HEIGHT), interpolation=cv2.INTER_AREA)
    registered, printed = register(small, page, affine), _printed(small)
    counts = registered.covered & registered.agrees & printed
    if counts.sum() < 2000:
        raise NoMatch("no dense agreement with the original")
    size = np.linalg.norm(registered.flow, axis=2)[counts]
    return {
        "G": max(area, 1 / area),
        "anisotropy": float(singular[0] / singular[1]),
        "aspect_percent": float(100 * (across / down - 1)),
        "turned_degrees": float(np.degrees(np.arctan2(linear[1, 0] - linear[0, 1], linear[0, 0] + linear[1, 1]))),
        "matches": len(here),
        "sift": summary(displacement(here, there, affine)),
        "similarity": summary(displacement(here, there, fit_similarity(here, there))),
        "dense": summary(size) | {"bins": [float(((size >= i) & (size < i + 1)).mean()) for i in range(BINS)]},
        "print_share": float(counts.mean()),
        "coverage": float((registered.covered & printed).sum() / max(printed.sum(), 1)),
        "rules": asdict(waves_of_rules(registered, find_rules(small))),
    }
