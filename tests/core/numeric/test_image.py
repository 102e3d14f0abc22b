from __future__ import annotations

import numpy as np
import pytest
from origami.core.numeric.image import (
    gaussian_mean,
    gradient_magnitude,
    linear_light,
    perceptual,
    sample_bilinear,
    sharpness,
    shrink,
)
from scipy import ndimage


@pytest.mark.parametrize(("dtype", "top"), [(np.uint8, 255), (np.uint16, 65535)])
def test_linear_light_decodes_srgb_in_either_depth(dtype, top):
    photo = np.zeros((1, 2, 3), dtype)
    photo[0, 0] = [0, top // 5, top]
    linear = linear_light(photo)
    assert linear.dtype == np.float32
    assert np.allclose(linear[0, 0], [0, ((0.2 + 0.055) / 1.055) ** 2.4, 1], atol=1e-6)
    assert (linear[0, 1] == 0).all()


def test_linear_light_is_straight_in_the_dark_and_grey_gets_three_channels():
    linear = linear_light(np.array([[10, 255]], np.uint8))
    assert linear.shape == (1, 2, 3)
    assert np.allclose(linear[0, 0], 10 / 255 / 12.92)
    assert np.allclose(linear[0, 1], 1)


@pytest.mark.parametrize("photo", [np.zeros((2, 2, 3)), np.zeros(5, np.uint8)])
def test_linear_light_refuses_what_is_no_photo(photo):
    with pytest.raises(ValueError, match="uint8 or uint16"):
        linear_light(photo)


def test_shrink_is_the_mean_of_blocks_without_the_rest():
    image = np.arange(5 * 7, dtype=np.float32).reshape(5, 7)
    assert shrink(image, 2).tolist() == [[4, 6, 8], [18, 20, 22]]
    assert np.array_equal(shrink(image, 1), image)
    assert shrink(np.zeros((9, 6, 3), np.uint8), 3).shape == (3, 2, 3)


@pytest.mark.parametrize("channels", [(), (3,)])
def test_gaussian_mean_leaves_out_what_is_not_known(channels):
    known = np.zeros((20, 30), bool)
    known[5:15, 5:20] = True
    values = np.full((20, 30, *channels), np.nan, np.float32)
    values[known] = 7
    mean, share = gaussian_mean(values, known, 1.5)
    assert mean.dtype == share.dtype == np.float32
    np.testing.assert_allclose(mean[4:16, 4:21], 7, rtol=1e-5)
    assert share[10, 12] == pytest.approx(1, abs=1e-2)
    assert share[0, 29] == 0
    assert (mean[0, 29] == 0).all()


def test_gaussian_mean_by_weight_is_the_ratio_of_two_convolutions():
    random = np.random.default_rng(2)
    values, weight = random.random((2, 12, 17))
    mean, share = gaussian_mean(values, weight, 2.0, mode="constant")
    smooth = ndimage.gaussian_filter(weight, 2.0, mode="constant")
    np.testing.assert_allclose(share, smooth)
    np.testing.assert_allclose(mean, ndimage.gaussian_filter(values * weight, 2.0, mode="constant") / smooth)


def test_perceptual_of_white_black_grey_and_red():
    lab = perceptual(np.array([[1, 1, 1], [0, 0, 0], [0.125, 0.125, 0.125], [1, 0, 0]], np.float32))
    assert np.allclose(lab[:3], [[100, 0, 0], [0, 0, 0], [50, 0, 0]], atol=1e-2)
    # the published Oklab of the sRGB primary
    assert np.allclose(lab[3], [62.80, 22.49, 12.58], atol=0.01)


def test_gradient_of_a_ramp_adds_up_over_directions_and_channels():
    y, x = np.mgrid[:40, :40].astype(np.float32)
    image = np.stack([3 * x, 4 * y, np.zeros_like(x)], axis=2)
    assert np.allclose(gradient_magnitude(image, 1.0)[10:-10, 10:-10], 5, atol=1e-3)
    assert (gradient_magnitude(np.ones((8, 9, 3), np.float32), 2.0) < 1e-6).all()


def test_bilinear_sampling_between_pixel_centres_and_outside():
    image = np.array([[[0.0], [10.0]], [[20.0], [30.0]]], np.float32)
    pixels = np.array([[[0.5, 0.5], [1.0, 0.5]], [[1.0, 1.0], [0.75, 1.5]]])
    assert np.allclose(sample_bilinear(image, pixels)[..., 0], [[0, 5], [15, 22.5]])
    beyond = np.array([[-5.0, -5.0], [9.0, 0.0], [0.2, 9.0], [9.0, 9.0]])
    assert sample_bilinear(image, beyond)[:, 0].tolist() == [0, 10, 20, 30]
    assert sample_bilinear(np.full((1, 1, 2), 7, np.float32), beyond[:1]).tolist() == [[7, 7]]


def test_sharpness_falls_with_blur_and_depends_on_neither_contrast_nor_places_outside():
    image = np.random.default_rng(0).normal(size=(120, 120)).astype(np.float32)
    pixels = np.array([[40.0, 60.0], [80.0, 60.0]])
    blurred = [sharpness(ndimage.gaussian_filter(image, sigma), pixels) for sigma in (0.6, 1.0, 2.0)]
    assert blurred[0] > 1.2 * blurred[1] > 1.2**2 * blurred[2] > 0
    outside = np.vstack([pixels, [[-3.0, 5.0], [500.0, 5.0]]])
    assert sharpness(7 * image, outside) == pytest.approx(sharpness(image, pixels), rel=1e-4)


def test_sharpness_looks_only_near_the_places():
    image = np.random.default_rng(0).normal(size=(80, 200)).astype(np.float32)
    half = np.where(np.arange(200) < 100, image, ndimage.gaussian_filter(image, 2.0)).astype(np.float32)
    sharp, soft = sharpness(half, np.array([[30.0, 40.0]])), sharpness(half, np.array([[170.0, 40.0]]))
    assert sharp == pytest.approx(sharpness(image, np.array([[30.0, 40.0]])), rel=1e-3)
    assert soft < 0.5 * sharp
    assert sharpness(image, np.array([[-100.0, -100.0]])) == 0.0
