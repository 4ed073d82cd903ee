"""Rigs as USD: a mesh with named UsdSkel blend shapes; needs the extra `usd`."""

from pathlib import Path
from typing import Any

import numpy as np

from caricli.errors import OutputError, shown
from caricli.io.gltf.write_gltf import shading_normals
from caricli.io.outputs import writing
from caricli.structures import Material, Rig

_SUFFIXES = (".usdc", ".usda")


def write_usd(path: str | Path, rig: Rig) -> None:
    """Write a rig as USD: metres, +y up, +z front, polygons as they are, UVs by corner, the eyes a subset of faces.

    Every shape is a `UsdSkel.BlendShape` of only the vertices that move, with the change of their normals. Names that
    USD does not take for a prim are changed for the prim; the token in ``skel:blendShapes`` is the name itself.
    path: .usdc (binary) or .usda (text).
    Raises OutputError when the suffix is another, the package is missing or the file cannot be written.
    """
    if not str(path).endswith(_SUFFIXES):
        raise OutputError(f"{shown(path)}: expected a name in {' or '.join(_SUFFIXES)}, found another")
    try:
        from pxr import Tf, Usd, UsdGeom, UsdSkel
    except ImportError:
        raise OutputError(f"{shown(path)}: USD needs a package: pip install 'caricli[usd]'") from None

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    root = UsdSkel.Root.Define(stage, "/head")
    stage.SetDefaultPrim(root.GetPrim())
    normals, normal_deltas = shading_normals(rig)
    mesh = _add_mesh(stage, rig, normals)
    _add_uvs(mesh, rig)
    _add_eyes(mesh, rig)
    binding = _add_skeleton(stage, mesh, rig.names)
    _add_shapes(stage, binding, rig, normal_deltas)
    with writing(path):
        try:
            saved = stage.GetRootLayer().Export(str(path))
        except Tf.ErrorException:
            saved = False
        if not saved:
            raise OutputError(f"{shown(path)}: cannot be written")


def _add_mesh(stage: Any, rig: Rig, normals: np.ndarray) -> Any:
    from pxr import UsdGeom

    neutral = np.asarray(rig.neutral, np.float32)
    used = rig.mesh.polygons >= 0
    mesh = UsdGeom.Mesh.Define(stage, "/head/mesh")
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
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


def _add_eyes(mesh: Any, rig: Rig) -> None:
    from pxr import UsdGeom

    if rig.materials is not None:
        (eyes,) = np.nonzero(np.asarray(rig.materials) == Material.EYE)
        UsdGeom.Subset.CreateGeomSubset(mesh, "eyes", UsdGeom.Tokens.face, _whole_numbers(eyes))


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
