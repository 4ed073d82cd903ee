"""What workflows from pictures to heads share: what a folder holds, and the commands up to the texture.

FOLDER, of the pictures and the landmarks of some of them, is set before this is included; None stands for the astronaut.
"""

import re
import sys
from pathlib import Path

from caricli.store.pictures import MARKS as MARK_KINDS
from caricli.store.pictures import PICTURES as PICTURE_KINDS

EXAMPLE = Path(workflow.basedir).parents[1] / "examples" / "astronaut"


def natural(name):
    """What names are ordered by: 2 comes before 10."""
    return [int(part) if k % 2 else part.lower() for k, part in enumerate(re.split(r"(\d+)", name))]


def by_stem(folder, kinds, alone=False):
    """The files of these kinds in a folder, but for hidden ones, by their stems; of one stem the kind that comes first.

    alone: whether two of one stem are refused.
    """
    if not Path(folder).is_dir():
        sys.exit(f"{folder}: expected a folder, found none")
    order = {kind: number for number, kind in enumerate(kinds)}
    seen = (path for path in sorted(Path(folder).iterdir()) if not path.name.startswith("."))
    paths = [path for path in seen if path.suffix.lower() in order]
    # Snakemake takes these for its own.
    if bad := next((path for path in paths if set("{}<>") & set(str(path))), None):
        sys.exit(f"{bad}: expected a path without any of {{}}<>, found this one")
    found = {path.stem: path for path in sorted(paths, key=lambda path: -order[path.suffix.lower()])}
    if alone and (twice := next((path for path in paths if found[path.stem] != path), None)):
        sys.exit(f"{twice}: expected pictures whose names differ before the suffix, found {found[twice.stem].name}, too")
    return {stem: found[stem] for stem in sorted(found, key=natural)}


if FOLDER is None:
    PICTURES, MARKS = {"astronaut": Path("pictures/astronaut.png")}, {}
else:
    PICTURES, MARKS = by_stem(FOLDER, PICTURE_KINDS, alone=True), by_stem(FOLDER, MARK_KINDS)


def picture(wildcards):
    """The picture of a head, if there is one."""
    return str(PICTURES[wildcards.name]) if wildcards.name in PICTURES else []


def image(wildcards, input):
    """The option for it."""
    return ["--image", input.picture] if input.picture else []


def marks(wildcards):
    """The landmarks of a head: those that were given, or those that are found."""
    return str(MARKS[wildcards.name]) if wildcards.name in MARKS else f"heads/{wildcards.name}/landmarks.json"


wildcard_constraints:
    name="[^/]+",


localrules:
    astronaut,


rule astronaut:
    output:
        "pictures/astronaut.png",
    shell:
        "python {EXAMPLE}/fetch_image.py {output[0]}"


rule detect:
    input:
        picture=picture,
    output:
        multiext("heads/{name}/landmarks", ".json", "-regions.json", "-regions.png", "-overlay.png"),
    log:
        "heads/{name}/logs/detect.txt",
    shell:
        "caricli detect {input.picture:q} --out {output[0]:q} --overwrite 2> {log:q}"


rule reconstruct:
    input:
        picture=picture,
        marks=marks,
    output:
        multiext("heads/{name}/face", ".obj", ".npz", ".json", ".png"),
    params:
        image=image,
    log:
        "heads/{name}/logs/reconstruct.txt",
    shell:
        "caricli reconstruct-from-landmarks {input.marks:q} {params.image:q} --out {output[0]:q} --overwrite"
        " 2> {log:q}"


rule refine:
    input:
        "heads/{name}/face.npz",
        picture=picture,
        marks=marks,
    output:
        multiext("heads/{name}/refined", ".obj", ".npz", ".json", ".png"),
    params:
        image=image,
    log:
        "heads/{name}/logs/refine.txt",
    # One head after the other.
    priority: 1
    shell:
        "caricli refine {input[0]:q} {input.marks:q} {params.image:q} --out {output[0]:q} --overwrite 2> {log:q}"


rule texture:
    input:
        "heads/{name}/refined.npz",
        picture=picture,
    output:
        directory("heads/{name}/textured"),
    params:
        size=["--size", str(config["size"])] if "size" in config else [],
    log:
        "heads/{name}/logs/texture.txt",
    priority: 2
    shell:
        "caricli texture {input[0]:q} {input.picture:q} {params.size:q} --out {output:q} --overwrite 2> {log:q}"
