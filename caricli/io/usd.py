"""Rigs as USD: a mesh with named UsdSkel blend shapes; needs the extra `usd`."""

import numpy as np

from caricli.errors import OutputError, shown
from caricli.io.gltf.write_gltf import shading_normals
from caricli.io.outputs import writing
from caricli.structures import Material

_SUFFIXES = (".usdc", ".usda")


def write_usd(path, rig):
    """Write a rig as USD: metres, +y up, +z front, polygons as they are, UVs by corner, the eyes a subset of faces.

    Every shape is a `UsdSkel.BlendShape` of only the vertices that move, with the change of their normals. Names that
    USD does not take for a prim are changed for the prim; the token in ``skel:blendShapes`` is the name itself.
    Parameters: path, .usdc (binary) or .usda (text); rig, Rig.
    Raises: OutputError when the suffix is another, the package is missing, the rig is none, or the file cannot be
    written.
    """
    if not str(path).endswith(_SUFFIXES):
        raise OutputError(f"{shown(path)}: expected a name in {' or '.join(_SUFFIXES)}, found another")
    try:
        from pxr import Sdf, Tf, Usd, UsdGeom, UsdSkel, Vt
    except ImportError:
        raise OutputError(f"{shown(path)}: USD needs a package: pip install 'caricli[usd]'") from None

    polygons = rig.mesh.polygons
    used = polygons >= 0
    neutral, deltas = (np.asarray(a, np.float32) for a in (rig.neutral, rig.deltas))
    normals, normal_deltas = shading_normals(rig)

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    root = UsdSkel.Root.Define(stage, "/head")
    stage.SetDefaultPrim(root.GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/head/mesh")
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(neutral))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(np.stack([neutral.min(0), neutral.max(0)])))
    mesh.CreateFaceVertexCountsAttr(_ints(used.sum(1), Vt))
    mesh.CreateFaceVertexIndicesAttr(_ints(polygons[used], Vt))
    if rig.mesh.uvs is not None:
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
        )
        st.Set(Vt.Vec2fArray.FromNumpy(np.asarray(rig.mesh.uvs, np.float32)))
        st.SetIndices(_ints(np.asarray(rig.mesh.uv_polygons)[used], Vt))
    if rig.materials is not None:
        (eyes,) = np.nonzero(np.asarray(rig.materials) == Material.EYE)
        UsdGeom.Subset.CreateGeomSubset(mesh, "eyes", UsdGeom.Tokens.face, _ints(eyes, Vt))

    names = Vt.TokenArray(rig.names)
    # Blend shapes move only under a skeleton's animation, though none of its joints moves anything.
    skeleton = UsdSkel.Skeleton.Define(stage, "/head/skeleton")
    animation = UsdSkel.Animation.Define(stage, "/head/skeleton/animation")
    animation.CreateBlendShapesAttr(names)
    animation.CreateBlendShapeWeightsAttr(Vt.FloatArray([0.0] * len(rig.names)))
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateBlendShapesAttr(names)
    targets = binding.CreateBlendShapeTargetsRel()
    for number, (name, delta, normal) in enumerate(zip(rig.names, deltas, normal_deltas, strict=True)):
        prim = Tf.MakeValidIdentifier(name)
        if stage.GetPrimAtPath(mesh.GetPath().AppendChild(prim)):
            prim = f"{prim}_{number}"
        shape = UsdSkel.BlendShape.Define(stage, mesh.GetPath().AppendChild(prim))
        (moved,) = np.nonzero(delta.any(1) | normal.any(1))
        shape.CreateOffsetsAttr(Vt.Vec3fArray.FromNumpy(delta[moved]))
        shape.CreateNormalOffsetsAttr(Vt.Vec3fArray.FromNumpy(normal[moved]))
        shape.CreatePointIndicesAttr(_ints(moved, Vt))
        targets.AddTarget(shape.GetPath())
    with writing(path):
        try:
            saved = stage.GetRootLayer().Export(str(path))
        except Tf.ErrorException:
            saved = False
        if not saved:
            raise OutputError(f"{shown(path)}: cannot be written")


def _ints(array, vt):
    return vt.IntArray.FromNumpy(np.ascontiguousarray(array, np.int32))
