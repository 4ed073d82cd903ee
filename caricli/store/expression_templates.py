"""Templates of expressions: the open head's, or a folder of OBJ files."""

from collections import Counter

import numpy as np

from caricli.data.expressions import NEUTRAL
from caricli.errors import InputError, shown
from caricli.io.face import read_face
from caricli.io.obj import read_obj
from caricli.methods.rig.expression_templates import check_templates, mended_templates
from caricli.template.head import load_head


def load_templates(folder):
    """ExpressionTemplates, the Annotation of their mesh or None, and the files that they are read from.

    folder: path of one with OBJ files, or None for the open head's own.
    """
    if folder is None:
        head = load_head()
        template = head.template()
        return mended_templates(head, template), template.annotation, []
    if not folder.is_dir():
        raise InputError(f"{shown(folder)}: expected a folder with {NEUTRAL}.obj and expressions, found none")
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() == ".obj")
    by_name, count = {path.stem.lower(): path for path in files}, Counter(path.stem.lower() for path in files)
    if len(by_name) < len(files):
        raise InputError(f"{shown(folder)}: expected distinct names, found {count.most_common(1)[0][0]!r} twice")
    if NEUTRAL not in by_name or len(files) < 2:
        raise InputError(f"{shown(folder)}: expected {NEUTRAL}.obj and expressions, found {len(files)} other OBJ files")
    neutral = read_face(by_name[NEUTRAL])
    others = [path for path in files if path != by_name[NEUTRAL]]
    shapes = [read_obj(path) for path in others]
    for path, mesh in zip(others, shapes, strict=True):
        if mesh.vertices.shape != neutral.vertices.shape or not np.array_equal(mesh.polygons, neutral.mesh.polygons):
            found = f"{len(mesh.vertices)} vertices and {len(mesh.polygons)} polygons"
            raise InputError(f"{shown(path)}: expected the mesh of {NEUTRAL}.obj, found another ({found})")
    names, vertices = [path.stem for path in others], np.stack([mesh.vertices for mesh in shapes])
    try:
        return check_templates(names, neutral.vertices, neutral.faces, vertices), None, files
    except InputError as error:
        raise InputError(f"{shown(by_name[NEUTRAL])}: {error}") from error
