import json
import struct
import zlib

import numpy as np
import pytest
from PIL import Image, PngImagePlugin

from caricli.errors import InputError
from caricli.io.parsing import CELEBAMASK_HQ, SCHEMA, names_labels, read_parsing, write_parsing
from caricli.io.strict_json import write_json
from caricli.structures.parsing import Region

LABELS = np.arange(35, dtype=np.uint8).reshape(5, 7) % 19


def test_celebamask_hq_is_numbered_as_published():
    published = (
        "skin nose eye_g l_eye r_eye l_brow r_brow l_ear r_ear mouth u_lip l_lip hair hat ear_r neck_l neck cloth"
    ).split()
    ours = {
        "eye_g": "eye_glasses", "l_eye": "eye_left", "r_eye": "eye_right", "l_brow": "brow_left",
        "r_brow": "brow_right", "l_ear": "ear_left", "r_ear": "ear_right", "u_lip": "upper_lip",
        "l_lip": "lower_lip", "ear_r": "earring", "neck_l": "necklace",
    }  # fmt: skip
    expected = {"background": 0} | {ours.get(name, name): number for number, name in enumerate(published, 1)}
    assert expected == CELEBAMASK_HQ


@pytest.mark.parametrize("mode", ["L", "P", "1"])
def test_numbers_are_read_as_they_are_stored(mode, tmp_path):
    image = Image.fromarray(LABELS)
    if mode == "P":
        image = Image.fromarray(LABELS, "P")
        # Colours that a viewer shows are no numbers.
        image.putpalette(np.random.default_rng(0).integers(0, 256, 768).tolist())
    elif mode == "1":
        image = Image.fromarray((LABELS > 9).astype(np.uint8) * 255).convert("1")
    image.save(tmp_path / "a.png")
    labels, legend = read_parsing(tmp_path / "a.png")
    assert labels.dtype == np.uint8 and legend == CELEBAMASK_HQ and not names_labels(tmp_path / "a.png")
    np.testing.assert_array_equal(labels, LABELS > 9 if mode == "1" else LABELS)


def test_a_label_map_that_tells_its_labels_is_read_alone(tmp_path):
    """As one is that was moved without its JSON; the JSON still goes first."""
    path = tmp_path / "moved.png"
    write_parsing(path, np.full((2, 3), 7, np.uint8), Region)
    labels, names = read_parsing(path)
    assert (labels == 7).all() and names_labels(path)
    assert names == {region.name.lower(): region.value for region in Region}
    path.with_suffix(".json").write_text(json.dumps({"schema": SCHEMA, "labels": {"hair": 7}}))
    assert read_parsing(path)[1] == {"hair": 7}


@pytest.mark.parametrize("text", ["no JSON", "{}", '{"schema": "caricli.parsing/1", "labels": {"skin": 256}}'])
def test_labels_that_a_picture_tells_amiss_are_refused(text, tmp_path):
    path = tmp_path / "labels.png"
    own = PngImagePlugin.PngInfo()
    own.add_text(SCHEMA, text)
    Image.fromarray(np.zeros((2, 2), np.uint8)).save(path, pnginfo=own)
    with pytest.raises(InputError, match="labels.png: "):
        read_parsing(path)


def test_the_legend_beside_it_goes_first(tmp_path):
    Image.fromarray(LABELS).save(tmp_path / "a.png")
    write_json(tmp_path / "a.json", {"schema": SCHEMA, "labels": {"skin": 1, "eye_left": 17}})
    assert names_labels(tmp_path / "a.png")
    assert read_parsing(tmp_path / "a.png")[1] == {"skin": 1, "eye_left": 17}
    # Who changes what was read changes nothing for the next one.
    (tmp_path / "a.json").unlink()
    read_parsing(tmp_path / "a.png")[1]["skin"] = 99
    assert read_parsing(tmp_path / "a.png")[1]["skin"] == 1


@pytest.mark.parametrize(
    "legend",
    [
        [],
        {"skin": 1},
        {"schema": "caricli.face/1", "labels": {"skin": 1}},
        {"schema": SCHEMA},
        {"schema": SCHEMA, "labels": ["skin"]},
        {"schema": SCHEMA, "labels": {"skin": 256}},
        {"schema": SCHEMA, "labels": {"skin": -1}},
        {"schema": SCHEMA, "labels": {"skin": 1.5}},
        {"schema": SCHEMA, "labels": {"skin": True}},
        {"schema": SCHEMA, "labels": {"skin": "1"}},
    ],
)
def test_a_malformed_legend_is_refused(legend, tmp_path):
    Image.fromarray(LABELS).save(tmp_path / "a.png")
    write_json(tmp_path / "a.json", legend)
    with pytest.raises(InputError, match=r"a\.json: expected schema 'caricli\.parsing/1' and labels from 0 to 255"):
        read_parsing(tmp_path / "a.png")


def test_a_legend_that_is_no_json_is_refused(tmp_path):
    Image.fromarray(LABELS).save(tmp_path / "a.png")
    (tmp_path / "a.json").write_text("{'skin': 1}")
    with pytest.raises(InputError, match=r"a\.json: line 1, column 2: expected strict JSON"):
        read_parsing(tmp_path / "a.png")


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "LA"])
def test_greys_of_a_painting_program_are_numbers(mode, tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(LABELS).convert(mode).save(path)
    np.testing.assert_array_equal(read_parsing(path)[0], LABELS)


@pytest.mark.parametrize("mode", ["RGB", "RGBA", "I;16", "LA"])
def test_pictures_of_other_modes_are_refused(mode, tmp_path):
    image = Image.fromarray(LABELS.astype(np.uint16)) if mode == "I;16" else Image.fromarray(LABELS).convert(mode)
    if mode != "I;16":
        # A little colour, or a little that is clear.
        other = np.array(image)
        other[0, 0, -1] = 7
        image = Image.fromarray(other)
    image.save(tmp_path / "a.png")
    with pytest.raises(InputError, match="expected a PNG of label numbers, one byte a pixel or grey, found 7 x 5 of m"):
        read_parsing(tmp_path / "a.png")


def claiming(width, height):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    data = chunk(b"IDAT", zlib.compress(b"\0" * 9))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + data + chunk(b"IEND", b"")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("side", [100_000, 10_000, 8001])
def test_pixel_bombs_are_refused_before_they_are_decoded(side, tmp_path):
    (tmp_path / "a.png").write_bytes(claiming(side, side))
    with pytest.raises(InputError, match="a.png: expected (a PNG of label numbers|at most 64000000 pixels)") as refused:
        read_parsing(tmp_path / "a.png")
    assert "decompression bomb" in str(refused.value) or f"found {side} x {side}" in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("content", [b"", b"hello", claiming(7, 5)[:60]])
def test_other_files_are_refused(content, tmp_path):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.png: expected ") as refused:
        read_parsing(tmp_path / "a.png")
    assert "\n" not in str(refused.value)


def test_a_jpeg_is_no_label_map(tmp_path):
    Image.fromarray(LABELS).save(tmp_path / "a.png", "JPEG")
    with pytest.raises(InputError, match="expected a PNG of label numbers, found another kind of file"):
        read_parsing(tmp_path / "a.png")
