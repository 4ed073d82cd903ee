"""What the expressions of a rig do to the picture of its skin, in glTF: a texture that the skin's material tells of."""

from collections.abc import Callable

import numpy as np

from caricli.errors import InputError
from caricli.io.gltf.document import Document
from caricli.io.image import png_bytes
from caricli.io.strict_json import take
from caricli.limits import MAX_NUMBER
from caricli.structures.change_atlas import ChangeAtlas

KEY = "textureChanges"
"""In the extras of the skin's material."""

_LINEAR = 9729
_CLAMP = 33071
_NUMBERS = ("columns", "side", "window", "gain", "offset")


def add_changes(document: dict, skin: dict, changes: ChangeAtlas, view: Callable[[bytes], int]) -> None:
    """Add an atlas to a document in the making, which programs that do not know it leave aside.

    document: with its materials, textures and images, which grow. skin: the material of the skin, which wears a
    picture. view: puts bytes into the file and gives the number of their view.
    """
    about = {name: getattr(changes, name) for name in _NUMBERS} | {"window": list(changes.window)}
    skin["extras"] = {KEY: {"texture": len(document["textures"])} | about}
    document["textures"].append({"sampler": len(document["samplers"]), "source": len(document["images"])})
    # Levels of detail would mix neighbouring tiles.
    document["samplers"].append({"magFilter": _LINEAR, "minFilter": _LINEAR, "wrapS": _CLAMP, "wrapT": _CLAMP})
    image = {"name": f"{skin['name']} changes", "mimeType": "image/png", "bufferView": view(png_bytes(changes.picture))}
    document["images"].append(image)


def changes_of(
    document: Document, skin: dict, count: int, image: Callable[[dict], np.ndarray | None]
) -> ChangeAtlas | None:
    """The atlas of a rig of so many expressions, or None where there is none that can be read.

    skin: the material of the skin. image: the picture (H, W, 3) of a material. Raises InputError where what tells of it
    is malformed.
    """
    extras = skin.get("extras")
    about = extras.get(KEY) if isinstance(extras, dict) else None
    if not isinstance(about, dict):
        return None
    picture = image({"pbrMetallicRoughness": {"baseColorTexture": {"index": about.get("texture")}}})
    if picture is None:
        return None
    window = take(about, "window", list)
    values = [about.get("columns"), about.get("side"), *window, about.get("gain"), about.get("offset")]
    if not all(type(value) in (int, float) and abs(value) < MAX_NUMBER for value in values):
        raise InputError(f"{KEY}: expected {', '.join(_NUMBERS)} as numbers, found others")
    atlas = ChangeAtlas.laid_out(picture, np.array(values, float))
    return atlas if atlas.count >= 2 * count + 2 else None
