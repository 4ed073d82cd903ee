"""caricli rig: a face that moves."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import click

from caricli.commands.shared.head_options import head_options
from caricli.commands.shared.notes import echo_notes, echo_result
from caricli.commands.shared.options import (
    PATH,
    WholeRange,
    out_option,
    overwrite_option,
    refuse_typed,
    seed_option,
)
from caricli.commands.shared.picture import picture_files, picture_option
from caricli.errors import InputError, naming, shown
from caricli.io.face import read_face
from caricli.io.gltf.write_gltf import write_gltf
from caricli.io.image import read_image
from caricli.io.meshes.usd import require_usd, write_usd
from caricli.io.outputs import final_name, staged
from caricli.io.provenance import provenance
from caricli.io.rig import write_rig
from caricli.io.strict_json import write_json
from caricli.structures import HeadChoice, Mood
from caricli.structures.frame import AXES, UNITS
from caricli.structures.head_choice import WHOLE


def _moods(ctx, param, texts):
    """Paths of pictures by the names of moods."""
    moods = {}
    for text in texts:
        name, _, path = text.partition("=")
        if not name or not path or name in moods:
            raise click.BadParameter(f"expected NAME=IMAGE with another name each time, found {text!r}.")
        moods[name] = Path(path)
    return moods


@click.command()
@click.argument("face", type=PATH)
@out_option("RIG.glb", "Write the rig here; RIG.npz, .json and .png go beside it.", suffix=".glb")
@click.option(
    "--templates",
    type=PATH,
    metavar="DIR",
    help="Take the expressions from meshes in this folder: neutral.obj, and one for each.  [default: the head's]",
)
@click.option(
    "--model",
    type=PATH,
    metavar="MODEL",
    help="Put eyes, neck and parts into an own mesh as this model of it knows their places, with --templates.",
)
@click.option(
    "--neutral",
    type=click.Choice(["auto", "as-is"]),
    default="auto",
    help="Find the neutral face where the given one shows an expression (auto), or take it as it is.",
)
@head_options
@click.option(
    "--texture", type=PATH, metavar="IMAGE", help="Put this picture on the skin.  [default: the one that the face has]"
)
@click.option(
    "--mood",
    "moods",
    multiple=True,
    callback=_moods,
    metavar="NAME=IMAGE",
    help="Let the skin change to this picture, as large as its own, in the GLB a variant of its material; repeat for "
    "more.",
)
@click.option("--sparse", is_flag=True, help="Store only what moves, for a smaller GLB that fewer programs read.")
@click.option(
    "--usd", is_flag=True, help="Write RIG.usdz too, with blend shapes and pictures; this needs caricli[usd]."
)
@click.option(
    "--subdivide",
    "levels",
    type=WholeRange(0, 4),
    default=0,
    metavar="N",
    help="Split every polygon of the face N times, in all files.",
)
@seed_option
@picture_option
@overwrite_option
def command(face, out, templates, model, neutral, head, texture, moods, sparse, usd, levels, seed, overwrite):
    """Give a face (NPZ, OBJ, PLY, GLB or glTF) the 52 expressions of ARKit by deformation transfer.

    Expressions start from the neutral face. Of one that laughs it is found first, as `blendshapes` finds it, with its
    lips closed; one that shows no expression, or has another mesh than the bundled models, is taken as it is.

    Lids close and lips meet as they do on the template, whatever the shape of the face; what no expression moves stays
    where it is. mouthClose is drawn on top of jawOpen, as it is meant. `caricli inspect` says what is in the result.

    \b
    Example:
      caricli rig face.npz --out rig.glb
      caricli rig sculpted.obj --neutral as-is --out sculpted.glb
      caricli rig face.obj --subdivide 1 --sparse --out fine.glb
      caricli rig textured/face.npz --bust --out bust.glb
      caricli rig textured/face.npz --mood sad=sad.png --mood angry=angry.png --out moods.glb
      caricli rig scan.obj --templates expressions --model own.safetensors --out rig.glb
    """
    if templates is None:
        refuse_typed("--model is for an own mesh, whose expressions --templates gives.", "model")
    task = RigTask(templates, model, neutral, head, texture, sparse, usd, levels, seed, overwrite, moods)
    echo_result(task.run(face, out))


@dataclass(frozen=True)
class RigTask:
    """What is done with a face.

    templates: folder of expressions, or None for the head's. model: path of one of their mesh, or None. neutral: "auto"
    or "as-is". head: HeadChoice. texture: path of the skin's picture, or None for the face's own. sparse, usd: what is
    written. levels: how often polygons are split. seed: of the eyes' picture. overwrite: whether files that exist are
    replaced. moods: pictures of the skin by name.
    """

    templates: Path | None = None
    model: Path | None = None
    neutral: str = "auto"
    head: HeadChoice = WHOLE
    texture: Path | None = None
    sparse: bool = False
    usd: bool = False
    levels: int = 0
    seed: int = 0
    overwrite: bool = False
    moods: Mapping[str, Path] = field(default_factory=dict)

    def run(self, face: Path, out: Path) -> str:
        """Rig a face, write it, and say what it does."""
        from caricli.commands.shared.progress import progress_bar
        from caricli.methods.rig.make_rig import RigSettings, make_rig
        from caricli.methods.rig.rig_figures import describe_rig
        from caricli.render.in_parallel import do_in_parallel
        from caricli.store.expression_templates import load_templates
        from caricli.store.rig_sources import load_pictures, picture_sources

        if self.usd:
            require_usd(out.with_suffix(".usdz"))
        expressions, template_files = load_templates(self.templates, self.model)
        given = read_face(face)
        if given.mesh.uvs is None and (self.texture or self.moods):
            raise InputError(f"{shown(face)}: expected a face with UVs for its picture, found one without")
        pictures = picture_sources(face, self.texture)
        inputs = [face, *pictures.files, *self.moods.values(), *template_files]
        settings = RigSettings(self.levels, self.head, self.seed)
        paths = [*_paths(out, self.usd), *picture_files(out.with_suffix(".png"))]
        with staged(*paths, overwrite=self.overwrite, inputs=inputs) as files:
            glb, npz, json, *others = files
            images = given.pictures if given.pictures and self.texture is None else load_pictures(face, self.texture)
            moods = [(path, Mood(name, read_image(path))) for name, path in self.moods.items()]
            with naming(self._named(face)), progress_bar("expressions"):
                rest = _rest(given, self.neutral)
                result = make_rig(rest.mesh, expressions, settings, images, given=given)
            result = replace(result, rig=_changing(result.rig, moods))
            about = {"subdivide": self.levels, "sparse": self.sparse, "units": UNITS, "axes": AXES}
            description = provenance("rig", inputs, self.seed, **about)
            do_in_parallel(
                partial(_report, json, others, result, rest, given, description),
                partial(write_gltf, glb, result.rig, self.sparse),
                partial(write_rig, npz, result.rig),
            )
        _advise(face, result, rest, self.neutral)
        if expressions.annotation is None and "eyes" in self.head.parts:
            echo_notes(f"{final_name(face)}: no eyes and no neck are put in: --model, of its mesh, says where they are")
        if self.usd and moods:
            echo_notes(f"{final_name(out.with_suffix('.usdz'))}: has the usual picture alone; moods are in GLB and NPZ")
        return f"{out}: {describe_rig(result)}, {rest.describe()}"

    def _named(self, face):
        """Paths of what is at fault where a face and its expressions do not fit each other."""
        return shown(face) if self.templates is None else f"{shown(face)}, {shown(self.templates)}"


def _paths(out, usd):
    """The files of a rig, pictures aside."""
    return [out, *map(out.with_suffix, (".npz", ".json", ".usdz") if usd else (".npz", ".json"))]


def _rest(given, neutral):
    """The NeutralFace of a Face."""
    from caricli.methods.expressions.find_neutral import find_neutral
    from caricli.store.expression_tools import load_neutral_tools

    return find_neutral(given, load_neutral_tools(given.mesh) if neutral == "auto" else None)


def _changing(rig, moods):
    """A Rig whose skin changes. moods: pairs of the path of a picture and its Mood. Raises InputError."""
    for path, mood in moods:
        with naming(path):
            rig = replace(rig, moods=(*rig.moods, mood))
    return rig


def _report(json, others, result, rest, given, description):
    """Write what is known of a RigResult and its NeutralFace of a Face, and where there are paths USD and picture."""
    from caricli.commands.shared.expression_picture import write_expression_sheet
    from caricli.methods.rig.rig_figures import rig_figures
    from caricli.store.expression_templates import load_action_units

    write_json(json, description | rest.figures() | rig_figures(result, load_action_units()))
    for path in others:
        if path.suffix == ".usdz":
            write_usd(path, result.rig)
        else:
            write_expression_sheet(path, result.rig, result.as_given(given) if rest.moved else None)


def _advise(face, result, rest, neutral):
    """Say what closes the lips of a RigResult, where they are apart, and where it is no head in metres."""
    from caricli.methods.inspect.size_hint import size_hint
    from caricli.methods.rig.rig_figures import lips_are_apart

    hint = size_hint(rest.mesh.height)
    if hint is not None:
        echo_notes(f"{final_name(face)}: {hint}")
    if lips_are_apart(result):
        advice = "give a face with its mouth at rest"
        if neutral != "auto":
            advice = "without --neutral as-is they are closed first"
        elif rest.shown is None:
            advice = "caricli blendshapes closes them with a --model and a --map of its mesh"
        echo_notes(f"{final_name(face)}: its lips are apart, and stay so where no expression closes them; {advice}")
