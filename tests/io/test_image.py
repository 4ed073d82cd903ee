import io
import struct
import warnings
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image, ImageCms

from caricli.errors import InputError, OutputError
from caricli.io import image as image_module
from caricli.io.image import png_bytes, read_image, write_png

GRADIENT = np.arange(5 * 7 * 3, dtype=np.uint8).reshape(5, 7, 3)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(image=arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9), st.just(3))))
def test_round_trip(tmp_path_factory, image):
    path = tmp_path_factory.mktemp("image") / "a.png"
    write_png(path, image)
    np.testing.assert_array_equal(read_image(path), image)


@pytest.mark.parametrize("kind", ["PNG", "BMP", "TIFF", "WEBP"])
def test_formats(tmp_path, kind):
    Image.fromarray(GRADIENT).save(tmp_path / "a", kind, **({"lossless": True} if kind == "WEBP" else {}))
    image = read_image(tmp_path / "a")
    np.testing.assert_array_equal(image, GRADIENT)
    assert image.dtype == np.uint8 and image.flags.writeable


@pytest.mark.parametrize("kind", ["JPEG", "GIF"])
def test_lossy_formats(tmp_path, kind):
    Image.new("RGB", (7, 5), (200, 100, 50)).save(tmp_path / "a", kind)
    image = read_image(tmp_path / "a")
    assert image.shape == (5, 7, 3)
    np.testing.assert_allclose(image, np.broadcast_to([200, 100, 50], (5, 7, 3)), atol=4)


def test_exif_orientation_is_applied(tmp_path):
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(GRADIENT).save(tmp_path / "a.png", exif=exif)
    np.testing.assert_array_equal(read_image(tmp_path / "a.png"), np.rot90(GRADIENT, -1))


def test_transparent_pixels_are_white(tmp_path):
    image = np.zeros((2, 2, 4), np.uint8)
    image[0, 0] = [10, 20, 30, 255]
    write_png(tmp_path / "a.png", image)
    assert read_image(tmp_path / "a.png").tolist() == [[[10, 20, 30], [255] * 3], [[255] * 3, [255] * 3]]


@pytest.mark.parametrize("mode", ["1", "L", "P", "LA", "CMYK", "I;16", "F"])
def test_other_modes_become_rgb(tmp_path, mode):
    grey = np.tile(np.array([0, 255], np.uint8), (2, 1))
    if mode == "I;16":
        source = Image.fromarray(grey.astype(np.uint16) * 257)
    else:
        source = Image.fromarray(grey).convert(mode)
    source.save(tmp_path / "a", "TIFF")
    assert read_image(tmp_path / "a").tolist() == [[[0] * 3, [255] * 3]] * 2


def test_greys_of_16_bits_are_scaled_and_rounded(tmp_path):
    values = np.array([[0, 128, 129, 257 * 200, 257 * 200 + 129, 65535]], np.uint16)
    Image.fromarray(values).save(tmp_path / "a.png")
    assert read_image(tmp_path / "a.png")[0, :, 0].tolist() == [0, 0, 1, 200, 201, 255]


@pytest.mark.parametrize("most", [1, 255, 65535])
def test_fractions_are_levels_of_grey_by_how_far_they_go(tmp_path, most):
    values = np.array([[-0.01, 0, 0.2, 0.6, 1, 1.02]], np.float32) * most
    Image.fromarray(values).save(tmp_path / "a.tif")
    assert read_image(tmp_path / "a.tif")[0, :, 0].tolist() == [0, 0, 51, 153, 255, 255]


@pytest.mark.parametrize("most", [255, 65535])
def test_integers_of_32_bits_are_levels_of_grey_by_how_far_they_go(tmp_path, most):
    values = np.array([[0, 0.2, 0.6, 1]]) * most
    Image.fromarray(values.astype(np.int32)).save(tmp_path / "a.tif")
    assert read_image(tmp_path / "a.tif")[0, :, 0].tolist() == [0, 51, 153, 255]


@pytest.mark.parametrize(("dtype", "most"), [(np.int32, 65536), (np.float32, 300_000)])
def test_greys_without_a_white_are_refused(tmp_path, dtype, most):
    Image.fromarray(np.array([[0, most]], dtype)).save(tmp_path / "a.tif")
    with pytest.raises(InputError, match=f"a.tif: expected greys up to 1, 255 or 65535, found {most:g}"):
        read_image(tmp_path / "a.tif")


def test_a_transparent_grey_of_16_bits_is_white(tmp_path):
    values = np.array([[0, 257 * 65, 257 * 66]], np.uint16)
    Image.fromarray(values).save(tmp_path / "a.png", transparency=257 * 65)
    assert read_image(tmp_path / "a.png")[0, :, 0].tolist() == [0, 255, 66]


def png_claiming(width, height):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    size = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


@pytest.mark.parametrize("side", [8001, 100_000])
def test_size_is_checked_before_decoding(tmp_path, monkeypatch, side):
    (tmp_path / "a.png").write_bytes(png_claiming(side, side))
    monkeypatch.setattr(Image.Image, "load", lambda self: pytest.fail("it was decoded"))
    with warnings.catch_warnings(), pytest.raises(InputError, match="a.png: expected"):
        warnings.simplefilter("error")
        read_image(tmp_path / "a.png")


def test_the_cap_counts_pixels(tmp_path, monkeypatch):
    write_png(tmp_path / "a.png", GRADIENT)
    monkeypatch.setattr(image_module, "MAX_IMAGE_PIXELS", 34)
    with pytest.raises(InputError, match="at most 34 pixels, found 7 x 5"):
        read_image(tmp_path / "a.png")
    monkeypatch.setattr(image_module, "MAX_IMAGE_PIXELS", 35)
    assert read_image(tmp_path / "a.png").shape == (5, 7, 3)


def test_no_side_is_longer_than_opencv_reads(tmp_path):
    write_png(tmp_path / "a.png", np.zeros((2, 32_001, 3), np.uint8))
    with pytest.raises(InputError, match="at most 32000 pixels wide and high, found 32001 x 2"):
        read_image(tmp_path / "a.png")


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "BMP", "GIF"])
def test_truncated(tmp_path, kind):
    stream = io.BytesIO()
    rng = np.random.default_rng(0)
    Image.fromarray(rng.integers(0, 256, (40, 40, 3), np.uint8)).save(stream, kind)
    (tmp_path / "a").write_bytes(stream.getvalue()[: len(stream.getvalue()) // 2])
    with pytest.raises(InputError, match="a: expected an image, found a damaged one"):
        read_image(tmp_path / "a")


@pytest.mark.parametrize("packing", ["tiff_lzw", "tiff_deflate"])
def test_libtiff_says_nothing_of_its_own(tmp_path, capfd, packing):
    stream = io.BytesIO()
    noise = np.random.default_rng(0).integers(0, 256, (40, 40, 3), np.uint8)
    Image.fromarray(noise).save(stream, "TIFF", compression=packing)
    data = bytearray(stream.getvalue())
    data[20:400] = b"\xff" * 380
    (tmp_path / "a.tif").write_bytes(data)
    with pytest.raises(InputError, match="a.tif: expected an image, found a damaged one"):
        read_image(tmp_path / "a.tif")
    assert capfd.readouterr().err == ""


def test_other_files_are_named(tmp_path):
    for data, found in [(b"<html></html>", "an HTML or XML page"), (b"hello", "another kind of file")]:
        (tmp_path / "a.png").write_bytes(data)
        with pytest.raises(InputError, match=f"expected a PNG, JPEG, .* found {found}"):
            read_image(tmp_path / "a.png")


@pytest.mark.parametrize(
    "image", [GRADIENT.astype(float), GRADIENT[:, :, 0], GRADIENT[:, :, :2], GRADIENT[:0], GRADIENT.astype(np.int16)]
)
def test_writing_refuses(tmp_path, image):
    with pytest.raises(OutputError, match=r"expected an image \(H,W,3\|4\) uint8"):
        write_png(tmp_path / "a.png", image)
    assert not (tmp_path / "a.png").exists()


def test_a_picture_is_packed_once(tmp_path, monkeypatch):
    image = np.random.default_rng(3).integers(0, 255, (40, 30, 3)).astype(np.uint8)
    write_png(tmp_path / "first.png", image)
    monkeypatch.setattr("PIL.Image.fromarray", None)
    assert png_bytes(image.copy()) == (tmp_path / "first.png").read_bytes()
    with pytest.raises(TypeError):
        png_bytes(image.reshape(30, 40, 3))
    with pytest.raises(TypeError):
        png_bytes(255 - image)


def test_what_another_thread_puts_in_the_place_of_a_picture_takes_it_from_nobody(monkeypatch):
    class Crowded(dict):
        def __setitem__(self, key, packed):
            super().__setitem__("another", packed)

    monkeypatch.setattr(image_module, "_packed", Crowded())
    np.testing.assert_array_equal(np.array(Image.open(io.BytesIO(png_bytes(GRADIENT)))), GRADIENT)


def profile_with_red_and_green_exchanged(name):
    """An ICC profile of RGB whose first channel is sRGB's green, and its second red."""
    profile = bytearray(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())
    for entry in range(132, 132 + 12 * int.from_bytes(profile[128:132], "big"), 12):
        tag = bytes(profile[entry : entry + 4])
        profile[entry : entry + 4] = {b"rXYZ": b"gXYZ", b"gXYZ": b"rXYZ"}.get(tag, tag)
    return bytes(profile).replace("sRGB".encode("utf-16-be"), name.encode("utf-16-be"))


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "P"])
def test_colours_are_those_of_an_embedded_profile(tmp_path, mode):
    other = profile_with_red_and_green_exchanged("Swap")
    source = Image.new("RGB", (3, 2), (204, 51, 0)).convert(mode)
    source.save(tmp_path / "a.png", icc_profile=other)
    assert np.abs(read_image(tmp_path / "a.png").astype(int) - [51, 204, 0]).max() <= 1
    source.save(tmp_path / "a.png", icc_profile=profile_with_red_and_green_exchanged("sRGB"))
    assert read_image(tmp_path / "a.png")[0, 0].tolist() == [204, 51, 0]
    source.save(tmp_path / "a.png", icc_profile=other[:200])
    assert read_image(tmp_path / "a.png")[0, 0].tolist() == [204, 51, 0]


def test_transparent_pixels_stay_so_whatever_their_profile(tmp_path):
    image = np.zeros((2, 2, 4), np.uint8)
    image[0, 0] = [204, 51, 0, 255]
    profile = profile_with_red_and_green_exchanged("Swap")
    Image.fromarray(image).save(tmp_path / "a.png", icc_profile=profile)
    colours = read_image(tmp_path / "a.png").astype(int)
    assert np.abs(colours[0, 0] - [51, 204, 0]).max() <= 1 and (colours[1] == 255).all()


def test_a_grey_keeps_its_levels_whatever_its_profile(tmp_path):
    grey = Image.fromarray(np.arange(0, 250, 10, dtype=np.uint8).reshape(5, 5))
    grey.save(tmp_path / "a.png", icc_profile=profile_with_red_and_green_exchanged("Swap"))
    np.testing.assert_array_equal(read_image(tmp_path / "a.png")[..., 0], np.asarray(grey))
