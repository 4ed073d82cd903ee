"""Moods of a rig in glTF: variants of the material of its skin (extension KHR_materials_variants)."""

from collections.abc import Callable

import numpy as np

from caricli.errors import InputError
from caricli.io.gltf.document import Document
from caricli.io.image import png_bytes
from caricli.io.strict_json import take
from caricli.limits import MAX_MOODS
from caricli.structures import Mood

EXTENSION = "KHR_materials_variants"


def add_variants(document: dict, skin: dict, moods: tuple[Mood, ...], view: Callable[[bytes], int]) -> None:
    """Add a variant for every mood to a document in the making.

    A viewer that knows no variants shows the rig as it is without a mood.
    document: with its materials, textures and images, which grow. skin: the primitive of the skin, whose material wears
    a picture. view: puts bytes into the file and gives the number of their view.
    """
    usual = document["materials"][skin["material"]]
    mappings = []
    for number, mood in enumerate(moods):
        mappings.append({"material": len(document["materials"]), "variants": [number]})
        shading = usual["pbrMetallicRoughness"] | {"baseColorTexture": {"index": len(document["textures"])}}
        name = f"{usual['name']} {mood.name}"
        document["materials"].append(usual | {"name": name, "pbrMetallicRoughness": shading})
        document["textures"].append({"sampler": 0, "source": len(document["images"])})
        document["images"].append({"name": name, "mimeType": "image/png", "bufferView": view(png_bytes(mood.skin))})
    skin["extensions"] = {EXTENSION: {"mappings": mappings}}
    document.setdefault("extensionsUsed", []).append(EXTENSION)
    document["extensions"] = {EXTENSION: {"variants": [{"name": mood.name} for mood in moods]}}


def moods_of(document: Document, skin: dict, image: Callable[[dict], np.ndarray | None]) -> tuple[Mood, ...]:
    """The moods of a rig, in the order of the document's variants; what says none is left aside.

    skin: the primitive of the skin. image: the picture (H, W, 3) of a material, None where none can be read.
    Raises InputError where variants are malformed or more than the cap.
    """
    names = [_name(variant) for variant in take(_extension(document.content), "variants", list, [])]
    mappings = take(_extension(skin), "mappings", list, [])
    if max(len(names), len(mappings)) > MAX_MOODS:
        raise InputError(f"{EXTENSION}: expected at most {MAX_MOODS} variants, found {max(len(names), len(mappings))}")
    pictures: dict[int, np.ndarray | None] = {}
    for mapping in mappings:
        material = document.item(mapping if isinstance(mapping, dict) else {}, "material", "materials")
        numbers = [number for number in take(mapping, "variants", list) if type(number) is int]
        if any(0 <= number < len(names) and number not in pictures for number in numbers):
            pictures |= dict.fromkeys(numbers, image(material))
    moods: dict[str, Mood] = {}
    for number, name in enumerate(names):
        picture = pictures.get(number)
        if name and name not in moods and picture is not None:
            moods[name] = Mood(name, picture)
    return tuple(moods.values())


def _extension(holder: dict) -> dict:
    return take(take(holder, "extensions", dict, {}), EXTENSION, dict, {})


def _name(variant: object) -> str:
    name = variant.get("name") if isinstance(variant, dict) else None
    return name if isinstance(name, str) else ""
