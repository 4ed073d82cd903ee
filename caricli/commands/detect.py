"""caricli detect: faces, landmarks and regions of pictures."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from caricli.commands.shared.batch import named_jobs, run_batch
from caricli.commands.shared.notes import echo_notes
from caricli.commands.shared.options import (
    PATH,
    FiniteRange,
    detector_option,
    out_folder_option,
    out_option,
    overwrite_option,
)
from caricli.errors import InputError, shown
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import write_landmarks
from caricli.io.outputs import check_outputs, staged
from caricli.io.parsing import legend, write_parsing
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.detect.settings import DetectSettings


@click.command()
@click.argument("pictures", nargs=-1, required=True, type=PATH, metavar="PICTURE...")
@out_option("MARKS.json", "Write the landmarks of one picture here, and the rest beside it.", required=False)
@out_folder_option("Write landmarks, regions and overlays into this folder, under the names of the pictures.")
@click.option("--all", "everyone", is_flag=True, help="Write the landmarks of all faces, not of one alone.")
@detector_option
@click.option(
    "--score", type=FiniteRange(0, 1), default=DetectSettings().sure, help="Take for faces what is as sure as this."
)
@overwrite_option
@click.pass_context
def command(ctx, pictures, out, out_dir, everyone, detector, score, overwrite):
    """Find faces in pictures: drawings, paintings, photographs; with their landmarks and what every pixel shows.

    Of head.png the 81 landmarks are written to head.json, where people mark them, with how sure each is, `null` where
    it cannot be known; the label map to head-regions.png, with its legend and the faces' scores beside it as JSON; and
    head-overlay.png shows both. The face is the largest that nothing speaks against, or the largest; with --all the
    second largest is head-2.json.

    \b
    Example:
      caricli detect drawing.png --out-dir marks
      caricli detect party.jpg --all --out-dir marks
      caricli detect drawing.png --out heads/drawing/landmarks.json
    """
    from caricli.store.detector import load_detector

    jobs = named_jobs(pictures, "PICTURE", out, out_dir, ".json")
    settings = DetectSettings().sure_of(score)
    task = DetectTask(load_detector(detector), detector, everyone, settings, overwrite, pictures)
    run_batch(ctx, jobs, task.run, "pictures")


@dataclass(frozen=True, eq=False)
class DetectTask:
    """What is done with every picture.

    detector: Detector, and the path of its file or None for the bundled one. everyone: write all faces. settings: of
    the search. overwrite: whether files that exist are replaced. inputs: all pictures that are read.
    """

    detector: Any
    path: Path | None
    everyone: bool
    settings: DetectSettings
    overwrite: bool
    inputs: Sequence[Path] = ()

    def run(self, source: Path, target: Path) -> str:
        """Find the faces of a picture, write them, and say what they are."""
        from caricli.methods.detect.detect_faces import detect_faces
        from caricli.methods.detect.see_face import main_face
        from caricli.render.sheets.detection_sheet import detection_sheet
        from caricli.structures.parsing import Region

        ends = ("regions.png", "regions.json", "overlay.png")
        beside = [target.with_name(f"{target.stem}-{end}") for end in ends]
        inputs = (source, self.path, *self.inputs)
        check_outputs(target, *beside, overwrite=self.overwrite, inputs=inputs)
        picture = read_image(source)
        detection = detect_faces(picture, self.detector, self.settings)
        if not detection.faces:
            raise InputError(f"{shown(source)}: expected a face, found none")
        faces = detection.faces if self.everyone else [main_face(detection.faces, self.settings)]
        marks = [target, *(target.with_name(f"{target.stem}-{k}.json") for k in range(2, len(faces) + 1))]
        with staged(*marks, *beside, overwrite=self.overwrite, inputs=inputs) as temporaries:
            *points, labels, about, sheet = temporaries
            for file, face in zip(points, faces, strict=True):
                write_landmarks(file, face.landmarks)
            write_parsing(labels, detection.regions, Region)
            write_json(about, self._report(source, detection))
            write_png(sheet, detection_sheet(picture, replace(detection, faces=faces)))
        following = target.with_name(f"{target.stem}-{len(faces) + 1}.json")
        if self.everyone and following.exists():
            echo_notes(f"{shown(following)}: was there before, and is no face of {shown(source)}")
        return f"{shown(target)}: {_summary(faces, detection.faces)}"

    def _report(self, source: Path, detection: Any) -> dict:
        """The legend of the label map, and what is known of the faces."""
        from caricli.structures.parsing import Region

        about = provenance("detect", [source, self.path], detector=self.detector.model_id, score=self.settings.sure)
        return legend(Region, **about, faces=[_described(face, self.settings) for face in detection.faces])


def _described(face: Any, settings: DetectSettings) -> dict:
    from caricli.methods.detect.see_face import doubt_of

    frame = face.frame
    return {
        "score": face.score,
        "centre": frame.centre.tolist(),
        "side": frame.side,
        "roll": float(np.degrees(frame.roll)),
        "spread": face.spread,
        "known": int(face.landmarks.known.sum()),
        "doubt": doubt_of(face, settings),
    }


def _summary(faces: list, every: list) -> str:
    """One line. faces: those that are written. every: those that were found, the largest first."""
    face = faces[0]
    side = f"{face.frame.side:.0f} pixels"
    doubt = f"score {face.score:.2f}, landmarks to {100 * face.spread:.1f} % of its diagonal"
    if len(faces) > 1:
        return f"{len(faces)} faces, the largest of {side}, {doubt}"
    rank = "the largest" if face is every[0] else "the largest sure one"
    others = "" if len(every) == 1 else f", {rank} of {len(every)}"
    return f"a face of {side}{others}, {doubt}"
