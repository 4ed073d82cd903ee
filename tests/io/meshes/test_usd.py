import builtins
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from caricli.errors import OutputError
from caricli.io.gltf.write_gltf import shading_normals
from caricli.io.image import read_image
from caricli.io.meshes.usd import write_usd
from caricli.structures import Material, Mesh, Pictures, Rig

Usd = pytest.importorskip("pxr.Usd", reason="usd-core is not installed")
from pxr import Gf, UsdGeom, UsdShade, UsdSkel, UsdValidation  # noqa: E402


@pytest.fixture
def written(full_rig, tmp_path):
    path = tmp_path / "a.usdz"
    write_usd(path, full_rig)
    return path


def mesh_of(stage):
    return UsdGeom.Mesh(stage.GetPrimAtPath("/head/mesh"))


def test_validators_of_usd_find_nothing(written):
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    assert [error.GetErrorAsString() for error in context.Validate(Usd.Stage.Open(str(written)))] == []


def test_the_mesh_is_the_rig(full_rig, written):
    stage = Usd.Stage.Open(str(written))
    assert (UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)) == (1, "Y")
    assert stage.GetDefaultPrim().GetTypeName() == "SkelRoot"
    mesh = mesh_of(stage)
    np.testing.assert_array_equal(mesh.GetPointsAttr().Get(), full_rig.neutral)
    np.testing.assert_array_equal(mesh.GetNormalsAttr().Get(), shading_normals(full_rig)[0])
    np.testing.assert_array_equal(mesh.GetFaceVertexCountsAttr().Get(), np.full(len(full_rig.mesh.polygons), 4))
    np.testing.assert_array_equal(mesh.GetFaceVertexIndicesAttr().Get(), full_rig.mesh.polygons.ravel())
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
    assert st.GetInterpolation() == "faceVarying"
    expected = full_rig.mesh.uvs[full_rig.mesh.uv_polygons.ravel()]
    np.testing.assert_allclose(st.ComputeFlattened(), expected, atol=1e-6)
    eyes = UsdGeom.Subset(stage.GetPrimAtPath("/head/mesh/eyes")).GetIndicesAttr().Get()
    np.testing.assert_array_equal(eyes, np.flatnonzero(full_rig.materials))


def test_shapes_store_what_moves(full_rig, written):
    stage = Usd.Stage.Open(str(written))
    binding = UsdSkel.BindingAPI(mesh_of(stage))
    assert tuple(binding.GetBlendShapesAttr().Get()) == full_rig.names
    targets = binding.GetBlendShapeTargetsRel().GetTargets()
    assert [target.name for target in targets] == list(full_rig.names)
    normals = shading_normals(full_rig)[1]
    assert not full_rig.deltas[3].any()
    for target, delta, normal in zip(targets, full_rig.deltas, normals, strict=True):
        shape = UsdSkel.BlendShape(stage.GetPrimAtPath(target))
        where = np.array(shape.GetPointIndicesAttr().Get(), int)
        moved = np.flatnonzero(delta.any(1) | normal.any(1))
        # Blender drops a shape without offsets.
        np.testing.assert_array_equal(where, moved if len(moved) else [0])
        np.testing.assert_array_equal(np.reshape(shape.GetOffsetsAttr().Get(), (-1, 3)), delta[where])
        np.testing.assert_array_equal(np.reshape(shape.GetNormalOffsetsAttr().Get(), (-1, 3)), normal[where])


def test_skin_and_eyes_have_materials_with_their_pictures(full_rig, written, tmp_path):
    stage = Usd.Stage.Open(str(written))
    for number, (name, image) in enumerate({"skin": full_rig.pictures.skin, "eyes": full_rig.pictures.eyes}.items()):
        part = UsdGeom.Subset(stage.GetPrimAtPath(f"/head/mesh/{name}"))
        np.testing.assert_array_equal(part.GetIndicesAttr().Get(), np.flatnonzero(full_rig.materials == number))
        material, _ = UsdShade.MaterialBindingAPI(part).ComputeBoundMaterial()
        assert material.GetPath() == f"/head/materials/{name}"
        surface, _, _ = material.ComputeSurfaceSource()
        colour = surface.GetInput("diffuseColor").GetConnectedSources()[0][0].source
        picture = UsdShade.Shader(colour.GetPrim())
        places = UsdShade.Shader(picture.GetInput("st").GetConnectedSources()[0][0].source.GetPrim())
        kinds = [shader.GetShaderId() for shader in (surface, picture, places)]
        assert kinds == ["UsdPreviewSurface", "UsdUVTexture", "UsdPrimvarReader_float2"]
        assert places.GetInput("varname").Get() == "st"
        asset = picture.GetInput("file").Get()
        with zipfile.ZipFile(written) as package:
            (tmp_path / "picture.png").write_bytes(package.read(asset.path.removeprefix("./")))
        np.testing.assert_array_equal(read_image(tmp_path / "picture.png"), image)


def test_without_pictures_materials_have_a_colour(full_rig, tmp_path):
    write_usd(tmp_path / "a.usdz", replace(full_rig, pictures=Pictures()))
    stage = Usd.Stage.Open(str(tmp_path / "a.usdz"))
    colours = [
        UsdShade.Shader(stage.GetPrimAtPath(f"/head/materials/{name}/surface")).GetInput("diffuseColor").Get()
        for name in ("skin", "eyes")
    ]
    assert colours[0] != colours[1] and all(colours)
    with zipfile.ZipFile(tmp_path / "a.usdz") as package:
        assert package.namelist() == ["head.usdc"]


def test_usd_moves_the_mesh_by_the_weights(full_rig, written):
    stage = Usd.Stage.Open(str(written))
    weights = np.array([0.5, 0.25, 1.0, 0.0])
    UsdSkel.Animation(stage.GetPrimAtPath("/head/skeleton/animation")).GetBlendShapeWeightsAttr().Set(weights.tolist())
    root = UsdSkel.Root(stage.GetPrimAtPath("/head"))
    assert UsdSkel.BakeSkinning(root, Gf.Interval(0, 0))
    expected = full_rig.neutral + np.tensordot(weights, full_rig.deltas, 1)
    np.testing.assert_allclose(mesh_of(stage).GetPointsAttr().Get(0), expected, atol=1e-6)


def test_names_that_usd_does_not_take_stay_tokens(full_rig, tmp_path):
    names = ("a b", "a_b", "2nd", "eyes")
    write_usd(tmp_path / "a.usdz", replace(full_rig, names=names))
    stage = Usd.Stage.Open(str(tmp_path / "a.usdz"))
    binding = UsdSkel.BindingAPI(mesh_of(stage))
    assert tuple(binding.GetBlendShapesAttr().Get()) == names
    targets = binding.GetBlendShapeTargetsRel().GetTargets()
    assert len(set(targets)) == 4
    assert all(stage.GetPrimAtPath(target).GetTypeName() == "BlendShape" for target in targets)
    assert stage.GetPrimAtPath("/head/mesh/eyes").GetTypeName() == "GeomSubset"


def test_a_bare_rig_of_triangles_is_written_the_same_twice(full_rig, tmp_path):
    bare = Rig(full_rig.names, Mesh(full_rig.neutral, full_rig.faces), full_rig.deltas)
    for name in ("a", "b"):
        write_usd(tmp_path / f"{name}.usdz", bare)
    assert (tmp_path / "a.usdz").read_bytes() == (tmp_path / "b.usdz").read_bytes()
    stage = Usd.Stage.Open(str(tmp_path / "a.usdz"))
    counts = mesh_of(stage).GetFaceVertexCountsAttr().Get()
    np.testing.assert_array_equal(counts, np.full(len(bare.faces), 3))


def test_triangles_among_quads_have_three_corners(full_rig, tmp_path):
    mesh = full_rig.mesh
    polygons, uv_polygons = mesh.polygons.copy(), mesh.uv_polygons.copy()
    polygons[5, 3] = uv_polygons[5, 3] = -1
    mixed = replace(full_rig, mesh=Mesh(mesh.vertices, polygons, mesh.uvs, uv_polygons))
    write_usd(tmp_path / "a.usdz", mixed)
    stage = Usd.Stage.Open(str(tmp_path / "a.usdz"))
    written = mesh_of(stage)
    counts = np.array(written.GetFaceVertexCountsAttr().Get())
    np.testing.assert_array_equal(counts, np.where(np.arange(len(polygons)) == 5, 3, 4))
    np.testing.assert_array_equal(written.GetFaceVertexIndicesAttr().Get(), np.delete(polygons, 23))
    places = UsdGeom.PrimvarsAPI(written).GetPrimvar("st")
    np.testing.assert_array_equal(places.GetIndices(), np.delete(uv_polygons, 23))


def test_what_cannot_be_written_is_refused(full_rig, tmp_path, monkeypatch):
    with pytest.raises(OutputError, match="expected a name in .usdz"):
        write_usd(tmp_path / "a.usdc", full_rig)
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written"):
        write_usd(tmp_path / "file" / "a.usdz", full_rig)
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name.partition(".")[0] == "pxr":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(OutputError, match=r"pip install 'caricli\[usd\]'$"):
        write_usd(tmp_path / "a.usdz", full_rig)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_teeth_beside_a_grey_skin_are_grey(full_rig, tmp_path):
    kinds = np.where(full_rig.materials == Material.EYE, Material.GUMS, full_rig.materials)
    grey = Pictures(np.full((4, 4, 3), 120, np.uint8))
    write_usd(tmp_path / "a.usdz", replace(full_rig, materials=kinds, pictures=grey))
    stage = Usd.Stage.Open(str(tmp_path / "a.usdz"))
    surface = UsdShade.Shader(stage.GetPrimAtPath("/head/materials/gums/surface"))
    red, green, blue = surface.GetInput("diffuseColor").Get()
    assert red == green == blue > 0
