import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.image import write_png
from caricli.store.styles import load_style_book, load_style_drawings


def test_broken_and_thin_drawings_are_left_out_and_told(tmp_path):
    write_png(tmp_path / "a.png", np.full((40, 900, 3), 7, np.uint8))
    write_png(tmp_path / "b.png", np.full((1200, 1024, 3), 9, np.uint8))
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\nnothing")
    (tmp_path / "notes.txt").write_text("no picture")
    write_png(tmp_path / "thin.png", np.full((1, 30, 3), 7, np.uint8))
    pictures, notes = load_style_drawings(tmp_path)
    assert [path.name for path in pictures] == ["a.png", "b.png"]
    assert [picture.shape for picture in pictures.values()] == [(40, 900, 3), (600, 512, 3)]
    assert len(notes) == 2 and "broken.png" in notes[0] and notes[0].startswith("left out: ")
    assert notes[1].startswith("left out: ") and "thin.png: expected at least 2 pixels a side, found 30 x 1" in notes[1]


def test_none_that_can_be_read_is_an_error(tmp_path):
    with pytest.raises(InputError, match="expected a folder of drawings, found none"):
        load_style_drawings(tmp_path / "nowhere")
    (tmp_path / "broken.png").write_bytes(b"\x89PNG")
    with pytest.raises(InputError, match="no picture in it that can be read"):
        load_style_drawings(tmp_path)


def test_a_book_needs_no_drawings(monkeypatch):
    monkeypatch.setattr("caricli.store.styles.GENERATED", 3)
    book, notes = load_style_book(None, 0)
    assert len(book.drawings) == 3
    assert notes == [] and book.draw(np.random.default_rng(0)).paint(np.full((32, 32, 3), 99, np.uint8)).shape[2] == 3
