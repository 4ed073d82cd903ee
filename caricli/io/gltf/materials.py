"""The materials of a glTF document: what they are of, their pictures, and where a surface lies in these."""

import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from caricli.errors import InputError
from caricli.io.gltf.container import embedded
from caricli.io.gltf.document import Document
from caricli.io.gltf.scene import numbers
from caricli.io.image import read_image
from caricli.io.outputs import write_bytes
from caricli.io.strict_json import take, take_whole
from caricli.structures.materials import Material, material_named

_WEBP = "EXT_texture_webp"
_TRANSFORM = "KHR_texture_transform"
_SEEN_THROUGH = ("MASK", "BLEND")
_MOST_SETS = 16


@dataclass(frozen=True)
class Placing:
    """Where surfaces of a material lie in its picture: an attribute of their vertices, and how it is changed.

    key: of the attribute. offset, scale: along the picture's width and height. rotation: radians, counter-clockwise.
    """

    key: str
    offset: tuple[float, ...]
    rotation: float
    scale: tuple[float, ...]

    def uvs(self, places: np.ndarray) -> np.ndarray:
        """Places in the picture (V,2), origin at the bottom left. places: (V,2) the same from the top left."""
        cosine = np.cos(self.rotation)
        sine = np.sin(self.rotation)
        turned = (places * self.scale) @ [[cosine, -sine], [sine, cosine]] + self.offset
        return np.stack([turned[:, 0], 1 - turned[:, 1]], axis=1)


def material_of(document: Document, primitive: dict) -> dict:
    """The material of a primitive, empty where it has none."""
    return document.item(primitive, "material", "materials") if "material" in primitive else {}


def kind_of(material: dict) -> Material:
    """The Material of a material of a file by its name, skin where it has none."""
    name = material.get("name")
    return material_named(name) if isinstance(name, str) else Material.SKIN


def placing_of(material: dict) -> Placing:
    """Where a material's base colour lies (`KHR_texture_transform`). Raises InputError where it says so wrongly."""
    shading = take(material, "pbrMetallicRoughness", dict, {})
    texture = take(shading, "baseColorTexture", dict, {})
    changes = take(take(texture, "extensions", dict, {}), _TRANSFORM, dict, {})
    number = take_whole(texture | changes, "texCoord", 0, _MOST_SETS - 1, 0)
    offset = numbers({"offset": [0, 0]} | changes, "offset", 2)
    scale = numbers({"scale": [1, 1]} | changes, "scale", 2)
    (rotation,) = numbers({"rotation": [changes.get("rotation", 0)]}, "rotation", 1)
    return Placing(f"TEXCOORD_{number}", tuple(offset.tolist()), float(rotation), tuple(scale.tolist()))


def picture_of(document: Document, material: dict) -> np.ndarray | None:
    """The picture (H,W,3) of a material's base colour, or None where none is embedded that can be read."""
    with suppress(InputError), tempfile.TemporaryDirectory() as folder:
        shading = take(material, "pbrMetallicRoughness", dict)
        texture = document.item(take(shading, "baseColorTexture", dict), "index", "textures")
        image = document.item(take(take(texture, "extensions", dict, {}), _WEBP, dict, texture), "source", "images")
        if "uri" in image:
            data = embedded(image["uri"])
        else:
            data = bytes(document.view_bytes(document.item(image, "bufferView", "bufferViews")))
        write_bytes(Path(folder) / "image", data)
        # Elsewhere than where it is to be blended or cut out, alpha says nothing.
        return read_image(Path(folder) / "image", opaque=material.get("alphaMode") not in _SEEN_THROUGH)
    return None
