"""The skin painted as expressions show it, as commands do it."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from caricli.commands.shared.notes import echo_notes
from caricli.commands.shared.options import PATH
from caricli.errors import naming, shown

if TYPE_CHECKING:
    from caricli.methods.dynamic.rig_moods import MoodPainter
    from caricli.models.texture.model import TextureModel
    from caricli.structures import Rig
    from caricli.template.template import Template

network_option = click.option(
    "--texture-network",
    "network",
    type=PATH,
    metavar="FILE",
    help="Paint the skin by this network of `caricli train texture`.  [default: bundled]",
)


def dynamic_texture_option(help: str) -> Callable:
    """The flag that lets the skin follow expressions, with the option that names the network."""

    def add(command: Callable) -> Callable:
        return click.option("--dynamic-texture", "dynamic", is_flag=True, help=help)(network_option(command))

    return add


def load_network(network: Path | None, wanted: bool, flag: str = "--dynamic-texture") -> "TextureModel | None":
    """The texture network where it is wanted, read before anything else is done, or None.

    network: path, or None for the bundled one. flag: what wants it. Raises UsageError for a network that nothing wants,
    InputError for one that is not there or another.
    """
    if network is not None and not wanted:
        raise click.UsageError(f"--texture-network is for {flag}.")
    if not wanted:
        return None
    from caricli.store.texture_networks import load_texture_network

    return load_texture_network(network)


def load_painter(
    rig: "Rig", path: Path, network: "TextureModel | None", template: "Template | None" = None
) -> "MoodPainter | None":
    """The MoodPainter of a Rig, None without a network; what it cannot know is said on stderr.

    path: of what the rig is of, for messages. template: of its skin, or None for the head's own. Raises InputError.
    """
    from caricli.methods.dynamic.rig_moods import MoodPainter
    from caricli.store.models import load_morphable

    if network is None:
        return None
    with naming(path):
        painter = MoodPainter(rig, template or load_morphable().template, network)
    echo_notes(*(f"{shown(path)}: {note}" for note in painter.unknown()))
    return painter
