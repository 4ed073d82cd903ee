"""caricli encode: meshes to latents."""

import click

from caricli.commands.shared.options import PATH, model_option, out_folder_option, out_option, overwrite_option
from caricli.commands.shared.picture import SIZE, picture_files, picture_option
from caricli.io.face import write_face
from caricli.io.image import write_png
from caricli.io.outputs import staged
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.io.worn import picture_outputs


@click.command()
@click.argument("faces", nargs=-1, required=True, type=PATH, metavar="FACE...")
@out_option("FACE.npz", "Write the face of one input here; FACE.json and .png go beside it.", required=False)
@out_folder_option("Write the faces of many inputs into this folder, each under the name of its input.")
@model_option
@picture_option
@overwrite_option
@click.pass_context
def command(ctx, faces, out, out_dir, model, overwrite):
    """Find the latents of meshes (NPZ, OBJ, PLY, GLB or glTF) in the topology of a model.

    Meshes are in metres, Y up, +Z out of the face. The NPZ holds the mesh as it is, with the latent and, beside it,
    what the latent cannot express. The picture shows the mesh, the latent's own shape, and how far this is from the
    mesh.

    \b
    Example:
      caricli encode head.obj --out head.npz
      caricli encode scans/*.obj --out-dir encoded --model pca
    """
    from caricli.commands.shared.batch import named_jobs, run_batch
    from caricli.methods.faces.encode_face import encode_face, size_note
    from caricli.store.faces import load_worn_face
    from caricli.store.models import DEFAULT_LATENT, load_model

    jobs = named_jobs(faces, "FACE", out, out_dir, ".npz")
    shape_model = load_model(model, DEFAULT_LATENT)

    def encode(path, target):
        paths = [target, target.with_suffix(".json"), *picture_files(target.with_suffix(".png"))]
        with staged(*paths, overwrite=overwrite, inputs=(*faces, model), optional=picture_outputs(target)) as files:
            code = encode_face(load_worn_face(path, shape_model).without_latent(), shape_model)
            size = size_note(code, shape_model)
            write_face(files[0], code)
            error = {"millimetres": code.millimetres, "percent": code.percent}
            figures = {"model_id": code.model_id, "shape_error": error, "prior_rms": code.prior_rms}
            write_json(files[1], provenance("encode", [path], **figures))
            for png in files[2:]:
                write_png(png, _sheet(code, shape_model))
        error = f"{code.millimetres:.3f} mm ({code.percent:.3f} %)"
        return f"{target}: shape error {error}, prior {code.prior_rms:.2f}{f'; {size}' if size else ''}"

    run_batch(ctx, jobs, encode, "faces")


def _sheet(code, model):
    """The picture of an EncodedFace beside its latent alone."""
    from caricli.methods.parts.whole_head import whole_head
    from caricli.render.coat import mesh_coat
    from caricli.render.sheets.comparison_sheet import comparison_sheet

    latent = code.with_vertices(model.decode(code.latent))
    heads = [whole_head(face, model.template) for face in (code, latent)]
    return comparison_sheet(*heads, SIZE, mesh_coat(code.mesh, code.pictures))
