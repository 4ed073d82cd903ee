"""Faces of sketches, one after the other, each with its own files."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import click

from caricli.commands.shared.batch import named_jobs
from caricli.commands.shared.face_outputs import staged_face
from caricli.commands.shared.notes import echo_notes
from caricli.commands.shared.picture import write_picture
from caricli.errors import InputError, naming
from caricli.io.image import read_image
from caricli.io.meshes.mesh import MESH_SUFFIXES
from caricli.io.outputs import final_name
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.faces.subdivide_face import subdivide_face
from caricli.methods.parts.whole_head import mesh_face, whole_head
from caricli.methods.sketch.reconstruct_sketch import SketchReconstruction
from caricli.methods.sketch.settings import COARSE
from caricli.methods.sketch.strokes_read import Read, StrokesRead
from caricli.models.shape_model import ShapeModel
from caricli.store.face_files import write_face_files
from caricli.store.landmark_encoders import elastic_encoder
from caricli.store.models import DEFAULT_LATENT, load_model
from caricli.store.pictures import find_picture
from caricli.store.sketches import load_sketch
from caricli.structures import HeadChoice, Sketch
from caricli.structures.head_choice import WHOLE
from caricli.template.feature_curves import named_curves
from caricli.template.fine_mesh import FineMesh, fine_mesh
from caricli.template.template import Template


@dataclass(frozen=True)
class SketchTask:
    """What is done with every sketch, as it was typed.

    sketches: paths. out: of one result; out_dir: folder of many. image: path of the picture that a sketch was drawn
    over, or of a folder of them. coarse: of COARSE, or None for the network where it knows the mesh. network: path of
    it; strokes: of the one that reads strokes; model_path: of the shape model; None for the bundled ones. head:
    HeadChoice of the mesh, or None for the skin. levels: how often its polygons are split. follow: share of the way to
    the lines. overwrite: whether files that exist are replaced.
    """

    sketches: Sequence[Path]
    out: Path | None
    out_dir: Path | None
    image: Path | None
    coarse: str | None
    network: Path | None
    strokes: Path | None
    model_path: Path | None
    head: HeadChoice | None
    levels: int
    follow: float
    overwrite: bool

    def __post_init__(self) -> None:
        """Refuse wrong usage before anything is loaded."""
        self.jobs  # noqa: B018 (raises)
        if self.network is not None and self.coarse == COARSE[1]:
            raise click.UsageError(f"--network is for --coarse {COARSE[0]}.")

    @cached_property
    def jobs(self) -> list[tuple[Path, Path]]:
        """Pairs of a sketch and the mesh to write. Raises click.UsageError where one or many do not fit."""
        return named_jobs(self.sketches, "SKETCH", self.out, self.out_dir, *MESH_SUFFIXES)

    @cached_property
    def reconstruction(self) -> SketchReconstruction:
        """From sketches to faces. Raises InputError where a network was asked for that does not know the mesh."""
        model = load_model(self.model_path, DEFAULT_LATENT)
        encoder = elastic_encoder(model)
        read = self._reader if self.strokes else self._read
        plain = SketchReconstruction.of(encoder, read=read)
        if self.coarse == COARSE[1]:
            return plain
        # PyTorch takes a while to start.
        from caricli.methods.sketch.see_sketch import see_sketch
        from caricli.store.sketch_networks import load_sketch_networks

        given = ([path] if path else [] for path in (self.network, self.model_path))
        network, basis = load_sketch_networks(*given)[0]
        if basis.template.topology_id != model.template.topology_id:
            if not self.coarse and not self.network:
                return plain
            raise InputError(
                "the network: expected --model of the mesh whose faces it tells, found one of another mesh"
            )
        see = partial(see_sketch, network=network, basis=basis)
        return SketchReconstruction.of(encoder, see, read)

    @cached_property
    def _reader(self) -> Read:
        from caricli.methods.sketch.read_strokes import read_strokes
        from caricli.store.strokes import load_strokes

        return partial(read_strokes, network=load_strokes(self.strokes))

    def _read(self, sketch: Sketch, whole: Sequence[int]) -> StrokesRead:
        """What the strokes of a sketch draw; the network is loaded for the first one that needs it."""
        return self._reader(sketch, whole)

    @property
    def model(self) -> ShapeModel:
        """What faces are made of."""
        return self.reconstruction.model

    @cached_property
    def fine(self) -> FineMesh:
        """The finer mesh of the model's template."""
        return fine_mesh(self.model.template, self.levels)

    def run(self, path: Path, target: Path) -> str:
        """Make the face of a sketch, write it, and say how near its curves came to the lines."""
        image = find_picture(self.image, path, None if self.out else target.stem)
        inputs = (*self.sketches, self.network, self.strokes, self.model_path, image)
        with staged_face(target, self.overwrite, inputs) as files:
            sketch = load_sketch(path)
            reconstruction = self.reconstruction
            start = time.perf_counter()
            with naming(path):
                fit = reconstruction.reconstruct(sketch, self.follow)
            seconds = time.perf_counter() - start
            template = self.model.template
            finer = subdivide_face(fit.face, self.model, self.fine)
            write_face_files(files[0], files[1], fit.face, mesh_face(fit.face, template, self.head, finer))
            about: dict[str, Any] = {"model_id": self.model.model_id, "follow": self.follow, "subdivide": self.levels}
            report = provenance("reconstruct-from-sketch", [path, image, self.network, self.strokes], **about)
            write_json(files[2], report | fit.figures() | {"seconds": seconds})
            pixels = None if image is None else read_image(image)

            def sheet():
                # What draws takes a while to start.
                from caricli.render.sheets.sketch_sheet import sketch_sheet

                head = whole_head(fit.face, template, self.head or WHOLE)
                return sketch_sheet(fit.face, head, fit.sketch, fit.curves, pixels, fine=finer)

            write_picture(files[3], sheet)
        _tell_unknown(path, sketch, template)
        return f"{target}: {fit.describe()}"


def _tell_unknown(path: Path, sketch: Sketch, template: Template) -> None:
    """Say which names of a Sketch's strokes are no curves of a Template's head."""
    names = [curve.name for curve in named_curves(template.annotation)]
    unknown = sorted({stroke.curve for stroke in sketch.strokes if stroke.curve is not None} - {*names})
    if unknown:
        meant = {name: get_close_matches(name, names, 1) for name in unknown}
        told = ", ".join(f"{name} ({close[0]}?)" if close else name for name, close in meant.items())
        echo_notes(f"{final_name(path)}: strokes are left whose names are no curves of the head: {told}")
