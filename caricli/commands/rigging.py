"""What rigs are made of and from: templates, target faces, the report on a GLB."""



from caricli.errors import InputError, shown
from caricli.io.face import read_face
from caricli.io.gltf.read_gltf import read_gltf
from caricli.io.mtl import texture_path
from caricli.methods.rig.check_rig import check_rig
from caricli.methods.rig.expression_templates import start_delta
from caricli.render.contact_sheet import contact_sheet
from caricli.render.draw_rig import draw_rig, neutral_sky
from caricli.structures.mesh import topology_id
from caricli.template.template import Template

NEUTRAL, EYES = "neutral", "eyes.png"
SIZE, COLUMNS = 224, 9




def load_mesh(path, templates, annotation):
    """The Template in the shape of a neutral face, OBJ or NPZ, of the topology of ExpressionTemplates."""
    face = read_face(path)
    if topology_id(face.faces) != topology_id(templates.faces):
        expected = f"{len(templates.neutral)} vertices, {len(templates.faces)} triangles"
        found = f"{len(face.vertices)} vertices, {len(face.faces)}"
        raise InputError(
            f"{shown(path)}: expected the topology of the templates ({expected}), found another ({found}); "
            "give --templates for a mesh of your own"
        )
    mesh = face.mesh
    return Template(mesh.vertices, mesh.polygons, mesh.uvs, mesh.uv_polygons, annotation=annotation)


def face_pictures(face, texture):
    """The pictures on skin and eyes: the one that was given, else what the OBJ names, or the OBJ beside an NPZ; and the
    `eyes.png` that `caricli texture` wrote beside that. Either may be None."""
    mesh = face if face.suffix.lower() == ".obj" else face.with_suffix(".obj")
    skin = texture_path(mesh) if texture is None and mesh.is_file() else texture
    eyes = skin and skin.with_name(EYES)
    return skin, eyes if eyes and eyes.is_file() else None


def expression_sheet(rig, progress, given=None):
    """A picture of the neutral face and every expression from the front.

    rig: Rig. progress: called with finished pictures and their total. given: (V, 3) another shape to begin with, or
    None.
    """
    sky, shapes = neutral_sky(rig), {} if given is None else {"as given": given}
    shapes |= {NEUTRAL: rig.neutral}
    for k, name in enumerate(rig.names):
        shapes[name] = rig.neutral + start_delta(rig.names, rig.deltas, k) + rig.deltas[k]
    drawn = []
    for shape in shapes.values():
        drawn.append(draw_rig(rig, shape, "front", SIZE, sky))
        progress(len(drawn), len(shapes))
    return contact_sheet(drawn, min(COLUMNS, len(drawn)), [*shapes])


def check_report(path):
    """Lines that say what is in a GLB."""
    found = check_rig(read_gltf(path))
    lines = [
        f"{path}: {found.vertices} vertices, {found.triangles} triangles, {len(found.shapes)} shapes, "
        f"{found.height:.3f} m high",
        f"ARKit: {len(found.exact)} of 52 names, {len(found.missing)} missing",
    ]
    lines += [] if found.hint is None else [found.hint]
    lines += [f"{name}: ARKit spells it {arkit}" for name, arkit in found.near.items()]
    lines += [f"{name}: no ARKit name" for name in found.unknown]
    lines += [f"missing: {', '.join(found.missing)}"] if found.missing else []
    if found.shapes:
        width = max(len(shape.name) for shape in found.shapes)
        lines.append(f"{'shape':{width}}  largest mm   moved  flipped %")
    for shape in found.shapes:
        flipped = "     -" if shape.flipped is None else f"{100 * shape.flipped:6.3f}"
        lines.append(f"{shape.name:{width}}  {1000 * shape.largest:10.2f}  {shape.moved:6}     {flipped}")
    return "\n".join(lines)
