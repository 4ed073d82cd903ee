"""Rigs as USD: a mesh with named UsdSkel blend shapes and its pictures in one file; needs the extra `usd`."""

import os
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import OutputError, shown
from caricli.io.gltf.write_gltf import shading_normals
from caricli.io.image import write_png
from caricli.io.outputs import writing
from caricli.structures import Material, Rig
from caricli.structures.materials import FINISHES

_LAYER = "head.usdc"
_LONG_AGO = 315_705_600
"""Seconds: the second day that a ZIP knows, for the same bytes at any time."""


def require_usd(path: str | Path) -> None:
    """Load the package that writes USD, before any thread starts: beside others' work that may wait for ever.

    path: that is to be written. Raises OutputError when the package is missing.
    """
    try:
        from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade, UsdSkel, Vt  # noqa: F401
    except ImportError:
        raise OutputError(f"{shown(path)}: USD needs a package: pip install 'caricli[usd]'") from None


def write_usd(path: str | Path, rig: Rig) -> None:
    """Write a rig as USDZ: metres, +y up, +z front, polygons as they are, UVs by corner.

    What has a material of its own is a subset of faces with it (`UsdPreviewSurface`), whose picture is inside the file.
    Every shape is a `UsdSkel.BlendShape` of only the vertices that move, with the change of their normals. Names that
    USD does not take for a prim are changed for the prim; the token in ``skel:blendShapes`` is the name itself.
    path: .usdz.
    Raises OutputError when the suffix is another, the package is missing or the file cannot be written.
    """
    if Path(path).suffix != ".usdz":
        raise OutputError(f"{shown(path)}: expected a name in .usdz, found another")
    require_usd(path)
    from pxr import Sdf, Tf

    stage = _stage(rig)
    with writing(path), tempfile.TemporaryDirectory() as folder:
        try:
            saved = stage.GetRootLayer().Export(f"{folder}/{_LAYER}")
            package = Sdf.ZipFileWriter.CreateNew(str(path))
            names = [_LAYER, *(_picture_name(material) for material in _pictured(rig))]
            for material in _pictured(rig):
                write_png(Path(folder, _picture_name(material)), np.asarray(rig.pictures.of(material)))
            for name in names:
                os.utime(f"{folder}/{name}", (_LONG_AGO, _LONG_AGO))
            # The layer comes first, as USDZ wants it.
            saved = saved and all(package.AddFile(f"{folder}/{name}", name) for name in names) and package.Save()
        except Tf.ErrorException:
            saved = False
        if not saved:
            raise OutputError(f"{shown(path)}: cannot be written")


def _stage(rig: Rig) -> Any:
    from pxr import Usd, UsdGeom, UsdSkel

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    root = UsdSkel.Root.Define(stage, "/head")
    stage.SetDefaultPrim(root.GetPrim())
    normals, normal_deltas = shading_normals(rig)
    mesh = _add_mesh(stage, rig, normals)
    _add_uvs(mesh, rig)
    _add_materials(stage, mesh, rig)
    binding = _add_skeleton(stage, mesh, rig.names)
    _add_shapes(stage, binding, rig, normal_deltas)
    return stage


def _pictured(rig: Rig) -> list[Material]:
    """Materials with a picture that has a place on the surface."""
    if rig.mesh.uvs is None:
        return []
    return [material for material in _materials(rig) if rig.pictures.of(material) is not None]


def _materials(rig: Rig) -> list[Material]:
    """Those that polygons have."""
    return [Material(number) for number in np.unique(rig.triangle_materials).tolist()]


def _picture_name(material: Material) -> str:
    return f"{FINISHES[material].name}.png"


def _add_mesh(stage: Any, rig: Rig, normals: np.ndarray) -> Any:
    from pxr import UsdGeom

    neutral = np.asarray(rig.neutral, np.float32)
    used = rig.mesh.polygons >= 0
    mesh = UsdGeom.Mesh.Define(stage, "/head/mesh")
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    # A shell of hair is seen from inside, too, and sides are the mesh's, not a material's.
    mesh.CreateDoubleSidedAttr(Material.HAIR in rig.triangle_materials)
    mesh.CreatePointsAttr(_vectors(neutral))
    mesh.CreateNormalsAttr(_vectors(normals))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateExtentAttr(_vectors(np.stack([neutral.min(0), neutral.max(0)])))
    mesh.CreateFaceVertexCountsAttr(_whole_numbers(used.sum(1)))
    mesh.CreateFaceVertexIndicesAttr(_whole_numbers(rig.mesh.polygons[used]))
    return mesh


def _add_uvs(mesh: Any, rig: Rig) -> None:
    from pxr import Sdf, UsdGeom, Vt

    if rig.mesh.uvs is None or rig.mesh.uv_polygons is None:
        return
    kind = Sdf.ValueTypeNames.TexCoord2fArray
    places = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", kind, UsdGeom.Tokens.faceVarying)
    places.Set(Vt.Vec2fArray.FromNumpy(np.asarray(rig.mesh.uvs, np.float32)))
    places.SetIndices(_whole_numbers(rig.mesh.uv_polygons[rig.mesh.polygons >= 0]))


def _add_materials(stage: Any, mesh: Any, rig: Rig) -> None:
    """A subset of the faces for every material, which is bound to it."""
    from pxr import UsdGeom, UsdShade

    binding = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
    of_polygons = np.zeros(len(rig.mesh.polygons)) if rig.materials is None else np.asarray(rig.materials)
    for material in _materials(rig):
        (polygons,) = np.nonzero(of_polygons == material)
        part = binding.CreateMaterialBindSubset(FINISHES[material].name, _whole_numbers(polygons), UsdGeom.Tokens.face)
        surface = _add_surface(stage, rig, material)
        UsdShade.MaterialBindingAPI.Apply(part.GetPrim()).Bind(surface)
    binding.SetMaterialBindSubsetsFamilyType(UsdGeom.Tokens.partition)


def _add_surface(stage: Any, rig: Rig, material: Material) -> Any:
    """A material of one colour, or of its picture by the UVs."""
    from pxr import Gf, Sdf, UsdShade

    kinds = Sdf.ValueTypeNames
    finish = rig.pictures.finish(material)
    path = f"/head/materials/{finish.name}"
    whole = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, f"{path}/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("roughness", kinds.Float).Set(finish.roughness)
    surface.CreateInput("metallic", kinds.Float).Set(0.0)
    colour = surface.CreateInput("diffuseColor", kinds.Color3f)
    whole.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
    if material not in _pictured(rig):
        colour.Set(Gf.Vec3f(*finish.linear))
        return whole
    places = UsdShade.Shader.Define(stage, f"{path}/places")
    places.CreateIdAttr("UsdPrimvarReader_float2")
    places.CreateInput("varname", kinds.String).Set("st")
    places.CreateOutput("result", kinds.Float2)
    picture = UsdShade.Shader.Define(stage, f"{path}/picture")
    picture.CreateIdAttr("UsdUVTexture")
    picture.CreateInput("file", kinds.Asset).Set(Sdf.AssetPath(f"./{_picture_name(material)}"))
    picture.CreateInput("sourceColorSpace", kinds.Token).Set("sRGB")
    for side in ("wrapS", "wrapT"):
        picture.CreateInput(side, kinds.Token).Set("repeat")
    picture.CreateInput("st", kinds.Float2).ConnectToSource(places.ConnectableAPI(), "result")
    picture.CreateOutput("rgb", kinds.Float3)
    colour.ConnectToSource(picture.ConnectableAPI(), "rgb")
    return whole


def _add_skeleton(stage: Any, mesh: Any, names: tuple[str, ...]) -> Any:
    """The skeleton under whose animation alone blend shapes move, though none of its joints moves anything."""
    from pxr import UsdSkel, Vt

    tokens = Vt.TokenArray(names)
    skeleton = UsdSkel.Skeleton.Define(stage, "/head/skeleton")
    animation = UsdSkel.Animation.Define(stage, "/head/skeleton/animation")
    animation.CreateBlendShapesAttr(tokens)
    animation.CreateBlendShapeWeightsAttr(Vt.FloatArray([0.0] * len(names)))
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateBlendShapesAttr(tokens)
    return binding


def _add_shapes(stage: Any, binding: Any, rig: Rig, normal_deltas: np.ndarray) -> None:
    from pxr import Tf, UsdSkel

    above = binding.GetPath()
    targets = binding.CreateBlendShapeTargetsRel()
    deltas = np.asarray(rig.deltas, np.float32)
    for number, (name, delta, normal) in enumerate(zip(rig.names, deltas, normal_deltas, strict=True)):
        prim = Tf.MakeValidIdentifier(name)
        if stage.GetPrimAtPath(above.AppendChild(prim)):
            prim = f"{prim}_{number}"
        shape = UsdSkel.BlendShape.Define(stage, above.AppendChild(prim))
        (moved,) = np.nonzero(delta.any(1) | normal.any(1))
        if not len(moved):
            # Blender drops a shape without offsets: one of zero keeps the name.
            moved = np.zeros(1, int)
        shape.CreateOffsetsAttr(_vectors(delta[moved]))
        shape.CreateNormalOffsetsAttr(_vectors(normal[moved]))
        shape.CreatePointIndicesAttr(_whole_numbers(moved))
        targets.AddTarget(shape.GetPath())


def _vectors(array: np.ndarray) -> Any:
    from pxr import Vt

    return Vt.Vec3fArray.FromNumpy(array)


def _whole_numbers(array: np.ndarray) -> Any:
    from pxr import Vt

    return Vt.IntArray.FromNumpy(np.ascontiguousarray(array, np.int32))
