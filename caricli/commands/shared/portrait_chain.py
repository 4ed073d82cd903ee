"""What is done with a picture until it is a head that moves: one command after the other, into one folder."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

from caricli.commands.detect import DetectTask
from caricli.commands.refine import RefineTask
from caricli.commands.rig import RigTask
from caricli.commands.shared.fit_tasks import COARSE_TASKS
from caricli.commands.shared.landmark_batch import FitTask, LandmarkFiles
from caricli.commands.shared.notes import echo_notes
from caricli.commands.shared.picture import SIZE, without_picture
from caricli.commands.shared.progress import progress_bar
from caricli.commands.stylise import StyliseTask
from caricli.commands.texture import TextureTask
from caricli.errors import CaricliError, InputError, shown
from caricli.io.image import read_image, write_png
from caricli.io.landmarks import read_landmarks, write_landmarks
from caricli.io.outputs import staged_folder
from caricli.io.provenance import provenance
from caricli.io.strict_json import write_json
from caricli.methods.detect.settings import DetectSettings
from caricli.methods.stylise.settings import StyliseSettings
from caricli.methods.texture.settings import PaintSettings
from caricli.store.detector import load_detector
from caricli.store.face_pictures import FaceReader
from caricli.store.pictures import MARKS, load_marked_picture
from caricli.store.portrait_page import (
    REPORT,
    SHEET,
    TAKEN,
    check_page,
    describe_head,
    doubt_of_head,
    portrait_heads,
    write_page,
)
from caricli.store.rig_sources import load_rig
from caricli.store.shape_tools import load_shape_tools


@dataclass(frozen=True)
class PortraitFiles:
    """What is read and written, as it was typed.

    names: of the heads, by the paths of their pictures. out_dir: folder of the heads and their page. landmarks: path of
    landmarks, or of a folder of them, or None. pts_origin: coordinate of the first pixel in .pts files. overwrite:
    whether what exists is replaced.
    """

    names: Mapping[Path, str]
    out_dir: Path
    landmarks: Path | None
    pts_origin: int
    overwrite: bool

    def check(self) -> None:
        """Refuse before the work what would be refused after it."""
        if self.landmarks is not None and not self.landmarks.is_dir() and len(self.names) > 1:
            raise InputError(f"{shown(self.landmarks)}: expected a folder of landmarks, as there are many pictures")
        for picture, name in self.names.items():
            if name in TAKEN:
                raise InputError(f"{shown(picture)}: expected a name that is not the page's, found {shown(name)}")
        check_page(self.out_dir, self.overwrite, [*self.names, self.landmarks])

    def marks(self, picture: Path) -> Path | None:
        """The landmarks that were given for a picture."""
        if self.landmarks is None or not self.landmarks.is_dir():
            return self.landmarks
        paths = (self.landmarks / f"{self.names[picture]}{suffix}" for suffix in MARKS)
        return next((path for path in paths if path.is_file()), None)

    def write_page(self, failures: Sequence[tuple[Path, CaricliError]]) -> None:
        """Write the page of all heads, and of pictures that failed; a head that nothing replaces stays as it was."""
        reports = {path: self.out_dir / name / REPORT for path, name in self.names.items()}
        lacking = {path: str(error) for path, error in failures if self.overwrite or not reports[path].is_file()}
        heads = portrait_heads(self.out_dir, self.names, lacking)
        write_page(self.out_dir, heads, self.overwrite, [*self.names, self.landmarks])


@dataclass(frozen=True, eq=False)
class PortraitChain:
    """What is done with every picture.

    style: one of STYLES, for a caricature of it, or None for the picture as it is. coarse: one of COARSE. paint: how
    heads are painted.
    """

    files: PortraitFiles
    style: str | None
    coarse: str
    paint: PaintSettings

    @cached_property
    def finding(self) -> DetectTask:
        """How faces are found."""
        return DetectTask(load_detector(), None, False, DetectSettings(), False)

    @cached_property
    def styling(self) -> StyliseTask:
        """How pictures become caricatures."""
        settings = StyliseSettings(self.style or "none", seed=self.paint.seed)
        reader = FaceReader(pts_origin=self.files.pts_origin)
        return StyliseTask(reader, None, load_shape_tools(settings), settings, None, None, (), False)

    @cached_property
    def fitting(self) -> FitTask:
        """How faces are reconstructed."""
        files = LandmarkFiles((), None, self.files.out_dir, None, FaceReader(), False)
        return COARSE_TASKS[self.coarse](files)

    def run(self, picture: Path, folder: Path) -> str:
        """Make the head of a picture, in a folder of its own, and say what came of it."""
        given = self.files.marks(picture)
        folders = staged_folder(folder, self.files.overwrite, (*self.files.names, given), REPORT)
        with folders as head, progress_bar(shown(picture.name)) as report:
            steps = self._steps(picture, given, head)
            for number, step in enumerate(steps):
                report(number, len(steps))
                step()
            about = {"style": self.style, "coarse": self.coarse, "doubt": doubt_of_head(head)}
            write_json(head / REPORT, provenance("portrait", (picture, given), self.paint.seed, **about))
            line = describe_head(head)
        # A caricature's doubts were told when it was made.
        if self.style is None and about["doubt"]:
            echo_notes(f"{shown(picture)}: doubtful: {about['doubt']}")
        return f"{folder}: {line}"

    def _steps(self, picture: Path, given: Path | None, head: Path) -> list[partial]:
        """What is done one after the other, in the folder of the head."""
        marks = head / "landmarks.json"
        steps = []
        if self.style is not None:
            styled = head / "styled.png"
            steps.append(partial(replace(self.styling, marks=given).run, picture, styled))
            picture, given = styled, styled.with_suffix(".json")
        labels = None if given else head / "landmarks-regions.png"
        files = LandmarkFiles((marks,), head / "face.obj", None, picture, FaceReader(), False, labels)
        painting = TextureTask(settings=self.paint, parsing=labels)
        rigging = RigTask(head=self.paint.head, seed=self.paint.seed)
        return [
            *steps,
            partial(self.finding.run, picture, marks) if given is None else partial(self._take, picture, given, marks),
            partial(self._fit, files, marks),
            partial(RefineTask(picture).run, head / "face.npz", marks, head / "refined.obj"),
            partial(painting.run, head / "refined.npz", picture, head / "textured"),
            partial(rigging.run, head / "textured" / "face.npz", head / "rig.glb"),
            partial(_draw, picture, marks, head),
        ]

    def _fit(self, files: LandmarkFiles, marks: Path) -> None:
        """Reconstruct a face; the picture of its refinement shows it, too."""
        assert files.out is not None
        with without_picture():
            replace(self.fitting, files=files).run(marks, files.out)

    def _take(self, picture: Path, given: Path, marks: Path) -> None:
        """Write the landmarks that were given."""
        write_landmarks(marks, load_marked_picture(given, picture, self.files.pts_origin)[0])


def _draw(picture: Path, marks: Path, head: Path) -> None:
    """Draw the picture and its head, whose files are in a folder."""
    # What draws takes a while to start, and failures come first.
    from caricli.render.sheets.head_sheet import head_sheet

    drawn, rig = (load_rig(head / name) for name in ("textured/face.glb", "rig.npz"))
    points = read_landmarks(marks).points
    write_png(head / SHEET, head_sheet(read_image(picture), points, drawn, rig, SIZE))
