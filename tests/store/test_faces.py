import numpy as np
import pytest

from caricli.errors import InputError
from caricli.io.face import read_face, write_face
from caricli.io.meshes.obj import write_obj
from caricli.methods.faces.encode_face import decode_face, encode_face
from caricli.methods.parts.whole_head import whole_face
from caricli.store.faces import load_face, load_identity, load_latent_face, load_seen_face, load_shape, load_worn_face
from caricli.store.models import load_model, load_morphable
from caricli.structures import Camera, Face, Mesh

CAMERA = Camera(900.0, np.diag([1.0, -1.0, -1.0]), np.array([120.0, 230.0]))


@pytest.fixture(scope="module")
def model():
    return load_model(kind="intrinsic")


@pytest.fixture(scope="module")
def morphable():
    return load_morphable()


@pytest.fixture
def shape(head, model):
    return model.template.with_vertices(head.evaluate(gender=0.3, age=0.6))


@pytest.fixture
def path(shape, model, tmp_path):
    """A face of the intrinsic model with the camera of its picture."""
    path = tmp_path / "face.npz"
    write_face(path, encode_face(Face(shape, CAMERA, CAMERA.project(shape.vertices[:68])), model))
    return path


def test_a_face_of_the_model_comes_as_it_is(path, shape, model):
    face = load_face(path, model)
    np.testing.assert_allclose(face.vertices, shape.vertices, atol=1e-7)
    assert face.model_id == model.model_id and face.latent.shape == (128,)


@pytest.mark.parametrize(
    ("linear", "words"),
    [([[1, 0, 0], [0, 0, -1], [0, 1, 0]], "turned by 9. degrees"), (np.diag([-1.0, 1, 1]), "its mirror image")],
)
def test_heads_that_lie_or_are_mirrored_are_refused(shape, model, tmp_path, linear, words):
    write_obj(tmp_path / "other.obj", shape.with_vertices(shape.vertices @ np.transpose(linear)))
    with pytest.raises(InputError, match=rf"other.obj: expected a head that looks to \+z.*found .*{words}"):
        load_face(tmp_path / "other.obj", model)


def test_another_mesh_and_another_size_are_refused(shape, model, tmp_path):
    write_obj(tmp_path / "part.obj", Mesh(shape.vertices, shape.polygons[:-1]))
    with pytest.raises(InputError, match="part.obj: expected the topology of the model .4200 vertices, 8356 triangles"):
        load_face(tmp_path / "part.obj", model)
    loose = Mesh(np.vstack([shape.vertices, shape.vertices]), shape.polygons)
    write_obj(tmp_path / "loose.obj", loose)
    with pytest.raises(InputError, match="loose.obj: expected the topology of the model .*8400 vertices"):
        load_face(tmp_path / "loose.obj", model)
    write_obj(tmp_path / "mm.obj", Mesh(1000 * shape.vertices, shape.polygons))
    with pytest.raises(InputError, match="mm.obj: expected a head about 0.2.* m high, found 2"):
        load_face(tmp_path / "mm.obj", model)


def test_shapes_come_in_metres_whatever_their_unit(shape, model, tmp_path):
    for size in (1, 0.3, 10, 100, 1000):
        write_obj(tmp_path / "face.obj", Mesh(size * shape.vertices, shape.polygons))
        metres = size if size < 10 else 1
        np.testing.assert_allclose(load_shape(tmp_path / "face.obj", model), metres * shape.vertices, atol=1e-6)
    for size in (0.01, 1e5):
        write_obj(tmp_path / "other.obj", Mesh(size * shape.vertices, shape.polygons))
        with pytest.raises(InputError, match="other.obj: expected a head about 0.2.* m high, found"):
            load_shape(tmp_path / "other.obj", model)


def test_whole_heads_are_told_how_to_be_skin_alone(shape, model, tmp_path):
    path = tmp_path / "head.obj"
    write_obj(path, whole_face(Face(shape)).mesh)
    with pytest.raises(InputError, match="found another .*; the skin of a whole head is what --parts skin writes"):
        load_face(path, model)
    # What has less than the skin is none.
    write_obj(path, Mesh(shape.vertices, shape.polygons[:-1]))
    with pytest.raises(InputError, match=r"found another \([^;]*\)$"):
        load_face(path, model)


def test_quads_cut_into_other_triangles_are_told_to_be_written_whole(shape, model, tmp_path):
    triangles = np.concatenate([shape.polygons[:, [0, 1, 3]], shape.polygons[:, 1:]])
    write_obj(tmp_path / "cut.obj", Mesh(shape.vertices, triangles))
    with pytest.raises(InputError, match=r"\(as many in another order\); export quads, which were cut into other tri"):
        load_face(tmp_path / "cut.obj", model)


def test_a_face_that_is_no_surface_is_refused(shape, model, tmp_path):
    crumbs = np.where(np.arange(len(shape.vertices))[:, None] < 3000, shape.vertices[0], shape.vertices)
    write_face(tmp_path / "heap.npz", Face(shape.with_vertices(crumbs)))
    with pytest.raises(InputError, match="heap.npz: expected triangles with an area, found [0-9]{4} of 8356 without"):
        load_face(tmp_path / "heap.npz", model)
    few = np.where(np.arange(len(shape.vertices))[:, None] < 2, shape.vertices[0], shape.vertices)
    write_face(tmp_path / "few.npz", Face(shape.with_vertices(few)))
    assert load_face(tmp_path / "few.npz", model).latent is None


@pytest.mark.parametrize("load", [load_seen_face, lambda path: load_latent_face(path, load_model())])
def test_a_latent_of_another_length_is_refused(shape, model, tmp_path, load):
    face = Face(shape, CAMERA, latent=np.zeros(3), model_id=model.model_id)
    write_face(tmp_path / "short.npz", face)
    with pytest.raises(InputError, match="short.npz: expected a latent of 128 numbers, found 3"):
        load(tmp_path / "short.npz")


def test_a_seen_face_brings_its_camera_and_its_model(path, model):
    face, own = load_seen_face(path)
    assert own.model_id == model.model_id and face.camera.scale == CAMERA.scale
    assert face.latent is not None and face.residual is not None


def test_a_mesh_without_uvs_needs_no_picture(shape, model, tmp_path):
    path = tmp_path / "plain.obj"
    write_obj(path, Mesh(shape.vertices, shape.polygons))
    path.write_text("mtllib missing.mtl\n" + path.read_text("utf-8"), "utf-8")
    assert not load_worn_face(path, model).pictures
    write_obj(path, shape)
    path.write_text("mtllib missing.mtl\n" + path.read_text("utf-8"), "utf-8")
    assert not load_worn_face(path, model).pictures
    path.with_name("missing.mtl").write_text("map_Kd missing.png\n", "utf-8")
    with pytest.raises(InputError, match="missing.png: expected an image, found no such file"):
        load_worn_face(path, model)


def test_materials_are_those_of_the_model_s_polygons(shape, model, tmp_path):
    materials = np.arange(len(shape.polygons), dtype=np.int32) % 2
    write_face(tmp_path / "face.npz", Face(shape, materials=materials))
    np.testing.assert_array_equal(load_worn_face(tmp_path / "face.npz", model).materials, materials)
    # Those of triangles are none of quads.
    flat = Mesh(shape.vertices, shape.faces)
    write_face(tmp_path / "flat.npz", Face(flat, materials=np.zeros(len(flat.polygons), np.int32)))
    assert load_worn_face(tmp_path / "flat.npz", model).materials is None


def test_a_seen_face_is_read_once(path, model, monkeypatch):
    reads = []

    def read(file):
        reads.append(file)
        return read_face(file)

    monkeypatch.setattr("caricli.store.faces.read_face", read)
    load_seen_face(path)
    assert reads == [path]


def test_a_latent_of_another_model_is_left_behind(path, morphable, tmp_path):
    from caricli.io.bundled import asset_path

    face, own = load_seen_face(path, asset_path("morphable.safetensors"))
    assert own.kind == "morphable" and face.latent is face.residual is None and face.camera is not None


def test_a_face_of_no_picture_is_refused_by_name(shape, tmp_path):
    write_face(tmp_path / "bare.npz", Face(shape))
    with pytest.raises(InputError, match="bare.npz: expected a face with the camera of its picture, found none; make"):
        load_seen_face(tmp_path / "bare.npz")


def test_a_latent_is_taken_or_found(path, shape, model, morphable, tmp_path):
    code, note = load_latent_face(path, model)
    assert note is None
    np.testing.assert_array_equal(code.latent, read_face(path).latent)
    write_face(tmp_path / "bare.npz", Face(shape, CAMERA))
    code, note = load_latent_face(tmp_path / "bare.npz", model)
    assert "bare.npz: had no latent; encoded by the bundled intrinsic model, shape error" in note
    assert code.model_id == model.model_id and code.camera.scale == CAMERA.scale
    code, note = load_latent_face(path, morphable, anew=True)
    assert note is None and code.model_id == morphable.model_id
    np.testing.assert_allclose(decode_face(code, morphable, code.shift).vertices, shape.vertices, atol=1e-6)
    with pytest.raises(InputError, match="is of the bundled intrinsic model, not of the bundled morphable model; give"):
        load_latent_face(path, morphable)


def test_a_head_of_another_size_is_told(shape, model, tmp_path):
    for times, told in ((0.5, True), (0.95, False), (2.0, True)):
        write_face(tmp_path / "bare.npz", Face(shape.with_vertices(times * shape.vertices)))
        note = load_latent_face(tmp_path / "bare.npz", model)[1]
        assert ("times as high as heads of the model" in note) == told


def test_the_identity_of_a_face_or_of_the_mean_one(path, morphable):
    mean, note = load_identity(None, morphable)
    assert mean.shape == (len(morphable.identity),) and not mean.any() and note is None
    own, note = load_identity(path, morphable)
    assert own.shape == mean.shape and own.any() and note is None
