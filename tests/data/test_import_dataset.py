import numpy as np
import pytest

from caricli.data.dataset import SPLITS, read_dataset
from caricli.data.import_dataset import ImportSettings, import_dataset
from caricli.data.labels import read_labels
from caricli.errors import CaricliError, InputError
from caricli.io import npz
from caricli.io.meshes.mesh import write_mesh
from caricli.io.meshes.obj import read_obj, write_obj
from caricli.io.strict_json import write_json
from caricli.structures import Mesh


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


def csv_of(path, header, rows):
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_order_quads_uvs_and_coordinates_are_kept(barrel, barrels, out):
    folder, shapes, annotation = barrels
    calls = []
    summary = import_dataset(folder, out, annotation, progress=lambda *numbers: calls.append(numbers))
    assert (summary.meshes, summary.people, summary.expressions, summary.unit) == (12, 12, 1, "m")
    assert calls == [(k, 12) for k in range(1, 13)]
    data = read_dataset(out)
    np.testing.assert_allclose(data.vertices, shapes, atol=1e-8)
    np.testing.assert_array_equal(data.template.polygons, barrel.mesh.polygons)
    np.testing.assert_array_equal(data.template.uv_polygons, barrel.mesh.uv_polygons)
    np.testing.assert_allclose(data.template.uvs, barrel.mesh.uvs, atol=1e-9)
    np.testing.assert_array_equal(data.template.faces, barrel.template.faces)
    np.testing.assert_allclose(data.template.vertices, shapes.mean(0), atol=1e-7)
    assert data.template.annotation.source == barrel.annotation
    assert data.attributes == () and data.measures.shape == (12, 0)
    assert data.factors["file"].tolist() == [f"scan_{k:02d}.obj" for k in range(12)]
    # The template's mesh can be written as it came.
    template = data.template
    write_obj(out / "back.obj", Mesh(template.vertices, template.polygons, template.uvs, template.uv_polygons))
    back, first = read_obj(out / "back.obj"), read_obj(folder / "scan_00.obj")
    np.testing.assert_array_equal(back.polygons, first.polygons)
    np.testing.assert_array_equal(back.uv_polygons, first.uv_polygons)
    np.testing.assert_array_equal(back.uvs, first.uvs)


def test_other_formats_come_in_where_there_is_no_obj(barrels, out, tmp_path):
    folder, shapes, annotation = barrels
    others = tmp_path / "others"
    others.mkdir()
    for path in folder.iterdir():
        write_mesh(others / f"{path.stem}.ply", read_obj(path))
    (others / "notes.txt").touch()
    assert import_dataset(others, out, annotation).meshes == 12
    data = read_dataset(out)
    np.testing.assert_allclose(data.vertices, shapes, atol=1e-7)
    assert data.factors["file"][0] == "scan_00.ply"


def test_meshes_of_other_formats_that_are_left_out_are_told(barrels, out):
    folder, _, annotation = barrels
    for number in (0, 1, 2):
        path = folder / f"scan_{number:02d}.obj"
        write_mesh(path.with_suffix(".ply"), read_obj(path))
        path.unlink()
    summary = import_dataset(folder, out, annotation)
    assert summary.meshes == 9
    assert summary.notes == (f"{folder}: took 9 .obj files, left out 3 meshes of other formats",)


def test_meshes_in_sub_folders_are_told(barrels, out):
    folder, _, annotation = barrels
    (folder / "more").mkdir()
    for number in (0, 1, 2):
        (folder / f"scan_{number:02d}.obj").rename(folder / "more" / f"{number}.obj")
    (folder / "more" / "notes.txt").touch()
    assert import_dataset(folder, out, annotation).notes == (
        f"{folder}: took 9 .obj files, left out 3 meshes in sub-folders",
    )
    for path in folder.glob("*.obj"):
        path.unlink()
    with pytest.raises(InputError, match="found 0, and 3 in sub-folders, which are not entered"):
        import_dataset(folder, out, annotation)


def test_meshes_too_large_for_one_file_are_written_into_several(barrels, out, monkeypatch):
    folder, shapes, annotation = barrels
    monkeypatch.setattr(npz, "MAX_NPZ_BYTES", 7000)
    import_dataset(folder, out, annotation)
    data = read_dataset(out)
    assert [entry["count"] for entry in data.manifest["shards"]] == [8, 4]
    np.testing.assert_allclose(data.vertices, shapes, atol=1e-8)


def test_what_lies_in_a_folder_with_too_few_meshes_of_one_format_is_told(barrels, out):
    folder, _, annotation = barrels
    others = sorted(folder.iterdir())[1:]
    for path in others:
        write_mesh(path.with_suffix(".ply"), read_obj(path))
        path.unlink()
    said = "scans: expected at least two OBJ files, or other meshes of one format and no OBJ, found 1 .obj and 11 .ply"
    with pytest.raises(InputError, match=f"{said}$"):
        import_dataset(folder, out, annotation)


def test_stl_whose_vertices_an_annotation_cannot_mean_is_refused(barrels, out):
    folder, _, annotation = barrels
    for path in list(folder.iterdir()):
        write_mesh(path.with_suffix(".stl"), read_obj(path))
        path.unlink()
    with pytest.raises(InputError, match="scans: expected OBJ, PLY, GLB or glTF files, .*, found STL$"):
        import_dataset(folder, out, annotation)


def test_meshes_that_stand_otherwise_or_are_inside_out_are_refused(barrel, barrels, out):
    folder, shapes, annotation = barrels
    outwards = barrel.mesh.faces
    by_landmarks = f"scans, by the landmarks of {annotation}: expected a head that looks .*"
    for vertices, faces, said in (
        (shapes[..., [0, 2, 1]] * [1, -1, 1], outwards, f"{by_landmarks}, found one turned by"),
        (shapes * [-1, 1, 1], outwards, f"{by_landmarks}, found its mirror image"),
        (shapes, outwards[:, ::-1], "scans: expected faces .*, found the heads inside out"),
    ):
        for number, shape in enumerate(vertices):
            write_obj(folder / f"scan_{number:02d}.obj", Mesh(shape, faces))
        with pytest.raises(InputError, match=said):
            import_dataset(folder, out, annotation)


def test_uvs_beyond_their_picture_are_told(barrel, barrels, out):
    folder, shapes, annotation = barrels
    mesh = barrel.mesh
    for number, shape in enumerate(shapes):
        write_obj(folder / f"scan_{number:02d}.obj", Mesh(shape, mesh.polygons, mesh.uvs + [3, 0], mesh.uv_polygons))
    (note,) = import_dataset(folder, out, annotation).notes
    assert note == f"{folder}: UVs from 0 to 4: texture refuses those beyond 0 to 1, but with --project-uv"


def test_without_labels_every_mesh_is_a_person_of_one_split(barrels, out):
    import_dataset(*barrels[:1], out, barrels[2])
    data = read_dataset(out)
    assert sorted(data.identity.tolist()) == list(range(12))
    assert [int(data.rows(split).sum()) for split in SPLITS] == [10, 1, 1]


def test_the_seed_decides_the_split_and_the_bytes(barrels, tmp_path):
    manifests = []
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        (tmp_path / name).mkdir()
        import_dataset(barrels[0], tmp_path / name, barrels[2], settings=ImportSettings(seed=seed))
        manifests.append((tmp_path / name / "dataset.json").read_bytes())
    assert manifests[0] == manifests[1] != manifests[2]


def test_meshes_without_uvs_and_with_other_files_beside_them(barrel, barrels, out):
    folder, shapes, annotation = barrels
    for number, shape in enumerate(shapes):
        write_obj(folder / f"scan_{number:02d}.obj", Mesh(shape, barrel.mesh.polygons, None, None))
    (folder / "notes.txt").write_text("mine")
    assert import_dataset(folder, out, annotation).meshes == 12
    assert read_dataset(out).template.uvs is None


def test_uvs_are_those_of_the_first_file_that_has_any(barrel, barrels, out):
    folder, shapes, annotation = barrels
    for number in (0, 1):
        write_obj(folder / f"scan_{number:02d}.obj", Mesh(shapes[number], barrel.mesh.polygons))
    import_dataset(folder, out, annotation)
    template = read_dataset(out).template
    np.testing.assert_allclose(template.uvs, barrel.mesh.uvs, atol=1e-9)
    np.testing.assert_array_equal(template.uv_polygons, barrel.mesh.uv_polygons)


def test_labels_and_people_come_from_the_csv(barrels, out, tmp_path):
    rows = [f"scan_{k:02d}.obj,person{k // 3},{k - 5.5},{k % 2}" for k in range(12)]
    labels = csv_of(tmp_path / "labels.csv", "file,identity,BigNose,Smile", rows[::-1])
    import_dataset(barrels[0], out, barrels[2], labels)
    data = read_dataset(out)
    assert data.attributes == ("BigNose", "Smile")
    np.testing.assert_array_equal(data.measures[:, 0], np.arange(12) - 5.5)
    np.testing.assert_array_equal(data.labels, np.stack([np.arange(12) > 5.5, np.arange(12) % 2 == 1], 1))
    np.testing.assert_array_equal(data.identity, np.arange(12) // 3)
    people = [set(data.identity[data.rows(split)].tolist()) for split in SPLITS]
    assert people[0].isdisjoint(people[1] | people[2]) and people[1].isdisjoint(people[2]) and all(people)


def test_a_csv_as_a_spreadsheet_writes_it_is_read(barrels, out, tmp_path):
    rows = "".join(f'"scan_{k:02d}.obj",{k}\r\n' for k in range(12))
    (tmp_path / "l.csv").write_bytes(("\ufefffile,Smile\r\n" + rows + "\r\n").encode())
    import_dataset(barrels[0], out, barrels[2], tmp_path / "l.csv")
    np.testing.assert_array_equal(read_dataset(out).measures[:, 0], np.arange(12))


def test_a_csv_of_people_alone_is_enough(barrels, out, tmp_path):
    labels = csv_of(tmp_path / "l.csv", "file,identity", [f"scan_{k:02d}.obj,p{k % 4}" for k in range(12)])
    import_dataset(barrels[0], out, barrels[2], labels)
    data = read_dataset(out)
    np.testing.assert_array_equal(data.identity, np.arange(12) % 4)
    assert data.attributes == ()


@pytest.mark.parametrize("columns", ["identity", "identity,expression,level"])
def test_files_of_whom_a_table_says_nothing_are_of_a_person_each(barrels, out, tmp_path, columns):
    rest = ",smile,1" if "level" in columns else ""
    rows = [f"scan_{k:02d}.obj,{'anna' if k < 4 else ''}{rest}" for k in range(12)]
    import_dataset(barrels[0], out, barrels[2], csv_of(tmp_path / "l.csv", f"file,{columns}", rows))
    np.testing.assert_array_equal(read_dataset(out).identity, [0, 0, 0, 0, *range(1, 9)])


GOOD = [f"scan_{k:02d}.obj,{k}" for k in range(12)]


@pytest.mark.parametrize(
    ("header", "rows", "said"),
    [
        ("name,BigNose", GOOD, "column 'file'"),
        ("file,BigNose", GOOD[:-1], "expected a row for every file, found none for scan_11.obj"),
        ("file,BigNose", [*GOOD[:-1], "scan_11.obj,big"], "line 13: expected a number"),
        ("file,BigNose", [*GOOD[:-1], "scan_11.obj,"], "line 13: expected a number"),
        ("file,BigNose", [*GOOD[:-1], "scan_11.obj"], "line 13: expected 2 columns, found 1"),
        ("file,BigNose", [*GOOD[:-1], "scan_11.obj,nan"], "line 13: expected a number"),
        ("file,BigNose", [*GOOD[:-1], "scan_11.obj,1_0"], "line 13: expected a number"),
        ("file,BigNose", [*GOOD[:-1], "scan_11.obj,1e308"], "line 13: expected finite labels"),
        ("file,BigNose", [*GOOD, GOOD[0]], "line 14: 'scan_00.obj' comes twice"),
        ("file,BigNose,BigNose", [row + ",1" for row in GOOD], "no column twice"),
        ("file,BigNose", [*GOOD, "x" * 200_000 + ",1"], "labels.csv: expected a CSV, found field larger"),
        ("file,BigNose", [row + ",1" for row in GOOD], "line 2: expected 2 columns, found 3"),
        ("<html>", GOOD, "HTML"),
    ],
)
def test_labels_that_do_not_fit_are_refused(barrels, out, tmp_path, header, rows, said):
    labels = csv_of(tmp_path / "labels.csv", header, rows)
    with pytest.raises(InputError, match=said):
        import_dataset(barrels[0], out, barrels[2], labels)
    assert not (out / "dataset.json").exists()


@pytest.mark.parametrize("content", [b"", b"\x80\x04\x95", b"\xff\xfe\x00f"])
def test_labels_that_are_no_text_are_refused(barrels, out, tmp_path, content):
    (tmp_path / "labels.csv").write_bytes(content)
    with pytest.raises(InputError, match="labels.csv"):
        import_dataset(barrels[0], out, barrels[2], tmp_path / "labels.csv")


def test_another_topology_is_refused_with_the_name_of_the_file(barrel, barrels, out):
    folder, shapes, annotation = barrels
    mesh = barrel.mesh
    bad = folder / "scan_07.obj"
    write_obj(bad, Mesh(np.vstack([shapes[7], [[0, 0, 0]]]), mesh.polygons, mesh.uvs, mesh.uv_polygons))
    with pytest.raises(InputError, match="scan_07.obj.*62 vertices.*found 63"):
        import_dataset(folder, out, annotation)
    write_obj(bad, Mesh(shapes[7], mesh.polygons[:-1], mesh.uvs, mesh.uv_polygons[:-1]))
    with pytest.raises(InputError, match="scan_07.obj"):
        import_dataset(folder, out, annotation)
    turned = mesh.polygons.copy()
    turned[3] = np.roll(turned[3], 1)
    write_obj(bad, Mesh(shapes[7], turned, mesh.uvs, mesh.uv_polygons))
    with pytest.raises(InputError, match="scan_07.obj.*faces"):
        import_dataset(folder, out, annotation)
    bad.write_text("v 0 0 nan\n")
    with pytest.raises(InputError, match="scan_07.obj"):
        import_dataset(folder, out, annotation)


def test_folders_and_annotations_that_do_not_fit_are_refused(barrel, barrels, out, tmp_path):
    folder, _, annotation = barrels
    with pytest.raises(InputError, match="none: expected a folder"):
        import_dataset(tmp_path / "none", out, annotation)
    with pytest.raises(InputError, match="at least two"):
        import_dataset(out, out, annotation)
    with pytest.raises(InputError, match="none.json"):
        import_dataset(folder, out, tmp_path / "none.json")
    for change in ({"ibug68": list(range(67))}, {"ibug68": [62] * 68}, {"jaw_paths": [[0]] * 17}, {"mirror": [0] * 62}):
        write_json(tmp_path / "bad.json", barrel.annotation | change)
        with pytest.raises(InputError, match="bad.json"):
            import_dataset(folder, out, tmp_path / "bad.json")


@pytest.mark.parametrize("aside", [0.0, 0.1])
def test_sides_meet_in_the_plane_that_mirror_images_are_made_by(barrel, barrels, out, tmp_path, aside):
    folder, shapes, _ = barrels
    for number, shape in enumerate(shapes):
        write_obj(folder / f"scan_{number:02d}.obj", Mesh(shape + [aside, 0, 0], barrel.mesh.polygons))
    flipped = barrel.template.vertices * [-1, 1, 1]
    mirror = np.linalg.norm(barrel.template.vertices[:, None] - flipped, axis=2).argmin(1)
    write_json(tmp_path / "mirror.json", barrel.annotation | {"mirror": mirror.tolist()})
    if not aside:
        assert import_dataset(folder, out, tmp_path / "mirror.json").meshes == 12
        return
    with pytest.raises(InputError, match="mirror.json: mirror: expected .* whose sides meet at x = 0, found .* 0.1"):
        import_dataset(folder, out, tmp_path / "mirror.json")


def test_meshes_without_area_are_refused(barrel, barrels, out):
    folder, shapes, annotation = barrels
    for number, shape in enumerate(shapes):
        flat = shape.copy()
        flat[barrel.mesh.polygons[0]] = flat[0]
        write_obj(folder / f"scan_{number:02d}.obj", Mesh(flat, barrel.mesh.polygons, None, None))
    with pytest.raises(CaricliError, match="area"):
        import_dataset(folder, out, annotation)


@pytest.mark.parametrize(("unit", "size"), [("m", 1), ("dm", 10), ("cm", 100), ("mm", 1000)])
def test_the_unit_is_measured_or_given(barrel, barrels, out, unit, size):
    folder, shapes, annotation = barrels
    for number, shape in enumerate(shapes):
        write_obj(folder / f"scan_{number:02d}.obj", barrel.mesh.with_vertices(size * shape))
    summary = import_dataset(folder, out, annotation)
    assert summary.unit == unit and f"taken as given in {unit}" in summary.describe()
    assert summary.height == pytest.approx(np.median(np.ptp(shapes[..., 1], axis=1)), rel=1e-5)
    np.testing.assert_allclose(read_dataset(out).vertices, shapes, atol=1e-7)
    assert read_dataset(out).manifest["unit"] == unit


def test_a_size_of_no_head_is_refused_unless_the_unit_is_given(barrel, barrels, out):
    folder, shapes, annotation = barrels
    for number, shape in enumerate(shapes):
        write_obj(folder / f"scan_{number:02d}.obj", barrel.mesh.with_vertices(4.5 * shape))
    with pytest.raises(InputError, match=r"scans: expected heads of 0\.1 to 0\.8 m, found them .* --unit"):
        import_dataset(folder, out, annotation)
    assert import_dataset(folder, out, annotation, settings=ImportSettings("dm")).height < 0.12


def renamed(folder, names):
    for path, name in zip(sorted(folder.glob("*.obj")), names, strict=True):
        path.rename(folder / f"{name}.obj")


def test_names_that_are_not_utf8_are_refused(barrels, out):
    path = min(barrels[0].glob("*.obj"))
    path.rename(path.with_stem("b\udcff"))
    with pytest.raises(InputError, match=r"b\\udcff\.obj: expected a name in UTF-8, found another"):
        import_dataset(barrels[0], out, barrels[2])


def test_names_of_files_say_person_expression_and_level(barrels, out):
    names = ["a__jawOpen__2", "a__neutral", "b", "b__jawOpen", "b__neutral__3", "c__smile", "d", "e", "f", "g"]
    renamed(barrels[0], [*names, "generic_neutral_mesh", "browInnerUp_L"])
    summary = import_dataset(barrels[0], out, barrels[2])
    assert (summary.people, summary.expressions) == (8, 4)
    data = read_dataset(out)
    assert data.manifest["expressions"] == ["neutral", "browInnerUp_L", "jawOpen", "smile"]
    rows = dict(zip(data.factors["file"].tolist(), range(12), strict=True))

    def shown(name):
        row = rows[f"{name}.obj"]
        return data.identity[row], data.manifest["expressions"][data.expression[row]], data.level[row]

    assert shown("a__jawOpen__2")[1:] == ("jawOpen", 2) and shown("b__neutral__3")[1:] == ("neutral", 3)
    assert shown("b")[1:] == ("neutral", 1) and shown("b")[0] == shown("b__jawOpen")[0] != shown("a__neutral")[0]
    assert shown("browInnerUp_L") == (shown("generic_neutral_mesh")[0], "browInnerUp_L", 1)


@pytest.mark.parametrize("name", ["a__jawOpen__x", "a__jawOpen__0", "a__b__1__2", "__jawOpen", "a__", "a__b__\u0661"])
def test_names_that_do_not_say_it_are_refused(barrels, out, name):
    (barrels[0] / "scan_03.obj").rename(barrels[0] / f"{name}.obj")
    with pytest.raises(InputError, match="expected a (name|level)"):
        import_dataset(barrels[0], out, barrels[2])


def test_a_table_says_expression_and_level(barrels, out, tmp_path):
    rows = [f"scan_{k:02d}.obj,p{k // 3},{['', 'smile', 'jawOpen'][k % 3]},{1 + k % 2},{k}" for k in range(12)]
    labels = csv_of(tmp_path / "l.csv", "file,identity,expression,level,BigNose", rows)
    import_dataset(barrels[0], out, barrels[2], labels)
    data = read_dataset(out)
    assert data.attributes == ("BigNose",) and data.manifest["expressions"] == ["neutral", "jawOpen", "smile"]
    np.testing.assert_array_equal(data.expression, [0, 2, 1] * 4)
    np.testing.assert_array_equal(data.level, 1 + np.arange(12) % 2)
    csv_of(tmp_path / "l.csv", "file,level", [f"scan_{k:02d}.obj,{k}" for k in range(12)])
    with pytest.raises(InputError, match="line 2: expected a level from 1"):
        import_dataset(barrels[0], out, barrels[2], tmp_path / "l.csv")


def test_blanks_around_cells_of_a_table_say_nothing(barrels, out, tmp_path):
    rows = [
        f"scan_{k:02d}.obj{' ' * (k % 2)}, p{k // 3}{' ' * (k % 3)},smile{' ' * (k % 2)}, 2 , {k}" for k in range(12)
    ]
    labels = csv_of(tmp_path / "l.csv", "file, identity ,expression, level,Smile", rows)
    import_dataset(barrels[0], out, barrels[2], labels)
    data = read_dataset(out)
    np.testing.assert_array_equal(data.identity, np.arange(12) // 3)
    assert data.manifest["expressions"] == ["neutral", "smile"] and set(data.level.tolist()) == {2}
    assert data.attributes == ("Smile",)


def test_expressions_have_one_spelling():
    names = ["a__Neutral", "a__JawOpen", "b__jawOpen", "b__eyeBlink_L", "a__eyeBlinkLeft", "NEUTRAL", "Jaw_Open"]
    labels = read_labels(None, [f"{name}.obj" for name in names])
    assert labels.expressions == ["neutral", "eyeBlinkLeft", "jawOpen"]
    assert labels.people == ["a", "b", "generic"] and labels.notes == ()
    assert [name.expression for name in labels.shown[-2:]] == ["neutral", "jawOpen"]


def test_expressions_of_a_table_have_one_spelling(tmp_path):
    files = ["a.obj", "b.obj", "c.obj"]
    rows = ["a.obj,anna,Neutral", "b.obj,anna,Jaw Open", "c.obj,bob,jawOpen"]
    labels = read_labels(csv_of(tmp_path / "l.csv", "file,identity,expression", rows), files)
    assert labels.expressions == ["neutral", "jawOpen"]


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["anna", "Anna__smile"], "expected people of one spelling, found 'anna' and 'Anna'"),
        (["anna__smile", "bob__Smile"], "expected expressions of one spelling, found '[sS]mile' and '[sS]mile'"),
    ],
)
def test_names_that_are_others_by_their_capitals_are_refused(names, said):
    with pytest.raises(InputError, match=said):
        read_labels(None, [f"{name}.obj" for name in names])


def test_names_that_are_others_by_their_capitals_name_their_folder(barrels, out):
    renamed(barrels[0], ["anna", "Anna", *"bcdefghijk"])
    with pytest.raises(InputError, match=r"scans: expected people of one spelling, found 'Anna' and 'anna'"):
        import_dataset(barrels[0], out, barrels[2])


def test_meshes_of_whom_none_is_neutral_are_told(barrels, out):
    renamed(barrels[0], [f"p{k}__{'smile' if k % 3 else 'jawOpen'}" for k in range(12)])
    notes = import_dataset(barrels[0], out, barrels[2]).notes
    assert notes == ("no mesh is neutral: of the expressions train morphable takes the commonest, smile, for none",)
