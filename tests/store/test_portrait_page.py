import numpy as np
import pytest

from caricli.errors import OutputError
from caricli.io.image import write_png
from caricli.io.strict_json import write_json
from caricli.store.portrait_page import check_page, doubt_of_head, portrait_heads, write_page


@pytest.fixture
def home(tmp_path):
    """A folder with the head ours, made of a picture elsewhere, of which only its report is there."""
    (tmp_path / "elsewhere").mkdir()
    write_png(tmp_path / "elsewhere" / "ours.png", np.full((9, 9, 3), 80, np.uint8))
    write_json(report_of(tmp_path / "home", "ours"), report(tmp_path))
    return tmp_path / "home"


def report_of(home, name):
    """Where the report of a head is, in a folder that is there."""
    (home / name).mkdir(parents=True)
    return home / name / "portrait.json"


def report(folder):
    """What a run says that was given a picture in a folder."""
    return {"command": "portrait", "inputs": {str(folder / "elsewhere" / "ours.png"): "0" * 64}}


def page_of(home, pictures=(), failures=None):
    """Write the page of a folder, and return it."""
    failures = failures or {}
    names = {path: path.stem for path in (*pictures, *failures)}
    write_page(home, portrait_heads(home, names, failures), True, pictures)
    return (home / "index.html").read_text("utf-8")


@pytest.mark.parametrize("text", ["{}", '{"inputs": {}}', "[]", "{", '{"command": "evaluate portrait", "inputs": {}}'])
def test_folders_of_something_else_are_left_off_the_page(home, text):
    report_of(home, "other").write_text(text)
    page = page_of(home)
    assert "1 of 1 finished" in page and "ours" in page and "other" not in page


@pytest.mark.parametrize("text", ["{}", "[]", "{", '{"faces": []}', '{"faces": [{"doubt": 1, "spread": "a"}, 2]}'])
def test_reports_that_somebody_changed_leave_their_cells_empty(home, text):
    for name in ("landmarks-regions", "refined"):
        (home / "ours" / f"{name}.json").write_text(text)
    row = 'ours</a></td><td></td><td></td><td></td><td></td><td class="failed"></td>'
    assert row in page_of(home)
    assert row.removesuffix("</td>") + "no face</td>" in page_of(home, (), {home / "ours.png": "no face"})


def test_a_page_of_earlier_heads_is_written_anew_and_another_is_not(home):
    assert "1 of 1 finished" in page_of(home)
    write_json(report_of(home, "more"), report(home.parent))
    write_page(home, portrait_heads(home, {}, {}), False, ())
    page = home / "index.html"
    assert "2 of 2 finished" in page.read_text("utf-8")
    page.write_text("mine")
    for act in (lambda: check_page(home, False, ()), lambda: write_page(home, [], False, ())):
        with pytest.raises(OutputError, match="index.html exists; give --overwrite"):
            act()
    assert page.read_text() == "mine"


def test_a_name_need_not_be_utf8(home):
    write_json(report_of(home, "n\udcff"), report(home.parent))
    page = page_of(home, [home.parent / "elsewhere" / "n\udcff.png"], {home / "m\udcff.png": "m\udcff: no face"})
    assert page.count("m\\udcff: no face") == 2
    assert '<a href="#n%FF">n\\udcff</a>' in page and '<h2 id="m%FF">m\\udcff</h2>' in page


def test_numbers_in_names_are_counted_whatever_digits_they_have(home):
    names = ["10²", "9²", "٣", "x²"]
    pictures = {home / f"{name}.png": name for name in names}
    heads = portrait_heads(home, pictures, dict.fromkeys(pictures, "no face"))
    assert [head.name for head in heads] == ["٣", "9²", "10²", "ours", "x²"]


def test_no_path_leads_out_of_the_folder_but_to_what_was_given(home):
    copy = home / "thumbnails" / "ours" / "picture.jpg"
    page = page_of(home)
    assert "picture.jpg" not in page and not copy.exists()
    for pictures in ([home.parent / "elsewhere" / "ours.png"], ()):  # another run keeps what the page has
        page = page_of(home, pictures)
        assert "thumbnails/ours/picture.jpg" in page and copy.is_file()


def test_the_doubt_of_a_head_is_that_of_the_face_that_was_taken(tmp_path):
    large = {"doubt": "its score is 0.50", "spread": 0.05}
    small = {"doubt": None, "spread": 0.02}
    path = tmp_path / "landmarks-regions.json"
    for faces, doubt in (([large], large["doubt"]), ([large, small], None), ([large, large], large["doubt"])):
        write_json(path, {"faces": faces})
        assert doubt_of_head(tmp_path) == doubt
