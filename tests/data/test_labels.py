import unicodedata

import numpy as np
import pytest

from caricli.data.attributes import measure_attributes
from caricli.data.dataset import read_dataset
from caricli.data.import_dataset import import_dataset
from caricli.data.labels import read_labels
from caricli.errors import InputError

RENE = "Ren\u00e9"
PARTY = "f\u00eate"
"""In NFC; another program may write the accent as a letter of its own."""


def table_of(path, *lines):
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def other_form(text):
    other = unicodedata.normalize("NFD", text)
    assert other != text
    return other


def test_the_own_columns_of_a_table_are_told_in_any_capitals(tmp_path):
    rows = ["a.obj,anna,smile,2,1.5", "b.obj,anna,neutral,1,0", "c.obj,bob,neutral,1,0"]
    table = table_of(tmp_path / "l.csv", "File,IDENTITY,Expression,Level,BigNose", *rows)
    labels = read_labels(table, ["a.obj", "b.obj", "c.obj"])
    assert labels.names.tolist() == ["BigNose"] and labels.people == ["anna", "bob"]
    assert labels.shown[0].expression == "smile" and labels.shown[0].level == 2


def test_an_own_column_in_two_spellings_is_there_twice(tmp_path):
    for twice in ("identity", "file"):
        table = table_of(tmp_path / "l.csv", f"file,{twice.capitalize()},{twice}", "a.obj,1,2", "b.obj,1,2")
        with pytest.raises(InputError, match="l.csv: expected a CSV with a column 'file' and no column twice"):
            read_labels(table, ["a.obj", "b.obj"])
    # Labels that differ by their capitals are the user's own.
    table = table_of(tmp_path / "l.csv", "file,nose,Nose", "a.obj,1,2", "b.obj,1,2")
    assert read_labels(table, ["a.obj", "b.obj"]).names.tolist() == ["nose", "Nose"]


def test_a_name_in_two_unicode_forms_or_with_blanks_around_is_one():
    files = [f"{RENE}.obj", f"{other_form(RENE)}__{other_form(PARTY)}.obj", f"{RENE} __{PARTY}.obj"]
    labels = read_labels(None, [*files, f" {RENE}__neutral__ 2 .obj", "bob .obj", "bob__smile.obj"])
    assert labels.people == [RENE, "bob"] and labels.expressions == ["neutral", PARTY, "smile"]
    with pytest.raises(InputError, match="expected people of one spelling"):
        read_labels(None, [f"{RENE}.obj", f"{other_form(RENE.upper())}__smile.obj"])
    with pytest.raises(InputError, match="expected a name such as"):
        read_labels(None, [" __smile.obj"])


def test_a_table_may_write_names_in_another_form_than_the_files(tmp_path):
    rows = [f"{other_form(RENE)}.obj,{RENE},1", f"b.obj,{other_form(RENE)},2", "c.obj,bob,3"]
    labels = read_labels(table_of(tmp_path / "l.csv", "file,identity,Nose", *rows), [f"{RENE}.obj", " b.obj", "c.obj"])
    assert labels.people == [RENE, "bob"] and labels.values[:, 0].tolist() == [1, 2, 3]
    rows.append(f"{RENE}.obj,{RENE},1")
    with pytest.raises(InputError, match="line 5: .* comes twice"):
        read_labels(table_of(tmp_path / "l.csv", "file,identity,Nose", *rows), [f"{RENE}.obj", "b.obj", "c.obj"])


def test_a_dataset_keeps_the_names_that_files_have(barrels, tmp_path):
    folder, _, annotation = barrels
    names = [f"{other_form(RENE)}.obj", f"{RENE}__smile.obj"]
    for path, name in zip(sorted(folder.iterdir()), names, strict=False):
        path.rename(folder / name)
    (tmp_path / "out").mkdir()
    assert import_dataset(folder, tmp_path / "out", annotation).people == 11
    data = read_dataset(tmp_path / "out")
    rows = [data.factors["file"].tolist().index(name) for name in names]
    assert len(np.unique(data.identity[rows])) == 1


@pytest.mark.parametrize(
    ("name", "meant"),
    [("identiti", "identity"), ("Indentity", "identity"), ("expresion", "expression"), ("levels", "level")],
)
def test_a_misspelt_column_is_asked_about(tmp_path, name, meant):
    table = table_of(tmp_path / "l.csv", f"file,{name},Nose", "a.obj,1,2", "b.obj,2,3")
    labels = read_labels(table, ["a.obj", "b.obj"])
    assert labels.notes == (f"column {name!r} is taken for a label (is {meant} meant?)",)
    table = table_of(tmp_path / "l.csv", f"file,Nose,{name}", "a.obj,1,2", "b.obj,1,anna")
    said = rf"l.csv: line 3: expected a number in the label column '{name}' \(is {meant} meant\?\), found 'anna'"
    with pytest.raises(InputError, match=said):
        read_labels(table, ["a.obj", "b.obj"])


def test_usual_labels_are_not_asked_about(head_template, tmp_path):
    usual = [*measure_attributes(head_template.vertices, head_template, 1.0, 0.5, True)]
    names = [*usual, "smile", "profile", "density", "expressive", "intensity", "identification", "Smile level"]
    table = table_of(tmp_path / "l.csv", ",".join(["file", *names]), ",".join(["a.obj", *"1" * len(names)]))
    labels = read_labels(table, ["a.obj"])
    assert labels.names.tolist() == names and labels.notes == ()


def test_what_is_no_label_is_refused_with_its_column(tmp_path):
    for cell, said in (
        ("big", "expected a number in the label column 'Nose', found 'big'"),
        ("1e39", "expected finite labels of single precision, found 1e39 for 'Nose'"),
        ("1,5", "expected a number in the label column 'Nose', found '1,5'"),
    ):
        table = table_of(tmp_path / "l.csv", "file,Mouth,Nose", f'a.obj,1,"{cell}"')
        with pytest.raises(InputError, match=f"l.csv: line 2: {said}$"):
            read_labels(table, ["a.obj"])


def test_a_table_may_have_semicolons_and_fractions_with_commas(tmp_path):
    table = table_of(tmp_path / "l.csv", "file;identity;Nose;Mouth", "a,b.obj;Li, Anna;1,5;.25", "c.obj;bob;-2;1")
    labels = read_labels(table, ["a,b.obj", "c.obj"])
    assert labels.people == ["Li, Anna", "bob"] and labels.values.tolist() == [[1.5, 0.25], [-2, 1]]
    with pytest.raises(InputError, match="line 2: expected 2 columns, found 1"):
        read_labels(table_of(tmp_path / "l.csv", "file;Nose", "a.obj,1"), ["a.obj"])
