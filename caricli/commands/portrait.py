"""caricli portrait: a picture to a textured, rigged head."""

import click

from caricli.commands.shared.batch import named_jobs, run_batch
from caricli.commands.shared.head_options import head_options
from caricli.commands.shared.options import (
    PATH,
    WholeRange,
    out_folder_option,
    overwrite_option,
    pts_origin_option,
    refuse_typed,
    seed_option,
)
from caricli.methods.reconstruct.settings import COARSE
from caricli.methods.stylise.settings import STYLES


@click.command()
@click.argument("pictures", nargs=-1, required=True, type=PATH, metavar="PICTURE...")
@out_folder_option("Write a folder for every picture into this one, under its name, and index.html.", required=True)
@click.option(
    "--style",
    type=click.Choice(STYLES),
    help="Make the picture a caricature first, as `stylise` does, painted with this, or not painted (none).",
)
@click.option(
    "--coarse",
    type=click.Choice(COARSE),
    default=COARSE[0],
    help="Begin with a surface that follows the landmarks (elastic), or with a regular face, which a network sees "
    "(network) or which is fitted to the landmarks (morphable).",
)
@click.option(
    "--landmarks",
    type=PATH,
    metavar="LANDMARKS",
    help="Take these landmarks, or those in this folder under the names of the pictures; other faces are looked for.",
)
@click.option(
    "--size",
    type=WholeRange(64, 4096),
    metavar="PIXELS",
    help="Make textures this wide and high.  [default: 1024 or more, as fine as the picture]",
)
@head_options
@pts_origin_option
@seed_option
@overwrite_option
@click.pass_context
def command(ctx, pictures, out_dir, style, coarse, landmarks, size, head, pts_origin, seed, overwrite):
    """Make textured, rigged heads of pictures: drawings, paintings, photographs.

    In every picture the largest face is found, reconstructed, moved exactly onto its landmarks, painted with the
    picture, brought to rest where it shows an expression, and given the 52 expressions of ARKit. Of drawing.png the
    folder drawing holds what the single commands write, to go on from there: landmarks.json of `detect`, face.obj of
    `reconstruct-from-landmarks` (by the label map of `detect`), `fit-coarse` or `fit-morphable`, refined.obj of
    `refine`, textured of `texture` by the same label map, rig.glb of `rig`; with --style also styled.png of `stylise`.
    index.html shows all heads of the folder, those of earlier runs too, to be turned in a browser.

    \b
    Example:
      caricli portrait drawing.png --out-dir heads
      caricli portrait photo.jpg --style watercolour --out-dir painted
      caricli portrait drawings/*.jpg --landmarks corrected --out-dir heads --overwrite
    """
    from caricli.commands.shared.portrait_chain import PortraitChain, PortraitFiles
    from caricli.methods.texture.settings import PaintSettings

    if landmarks is None:
        refuse_typed("--pts-origin is of --landmarks.", "pts_origin")
    jobs = named_jobs(pictures, "PICTURE", None, out_dir, "")
    names = {picture: folder.name for picture, folder in jobs}
    files = PortraitFiles(names, out_dir, landmarks, pts_origin, overwrite)
    files.check()
    chain = PortraitChain(files, style, coarse, PaintSettings(size, seed=seed, head=head))
    run_batch(ctx, jobs, chain.run, "pictures", files.write_page)
