"""The picture of a face drawn again, as commands do it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from caricli.commands.shared.notes import echo_notes, echo_numbering
from caricli.commands.shared.progress import progress_bar
from caricli.errors import shown
from caricli.io.image import write_png
from caricli.io.strict_json import write_json
from caricli.render.in_parallel import in_parallel

if TYPE_CHECKING:
    from caricli.methods.expressions.retarget_rig import Retargeting
    from caricli.methods.redraw.original import Original
    from caricli.store.face_pictures import FaceReader


@dataclass(frozen=True)
class RedrawPaths:
    """What is drawn again. picture: path, or None for nothing. parsing: path of its label map, or None to let the
    detector see. film: path of the film to write, or None.
    """

    picture: Path | None
    parsing: Path | None = None
    film: Path | None = None


@dataclass(frozen=True, eq=False)
class Redrawing:
    """A picture that is drawn again with the expressions of a Retargeting.

    paths: RedrawPaths. retargeting: Retargeting of a rig that has a camera. reader: FaceReader that sees what is in
    the picture where no label map says it.
    """

    paths: RedrawPaths
    retargeting: "Retargeting"
    reader: "FaceReader"

    @cached_property
    def original(self) -> "Original":
        """The Original; what it does not tell is said once, on stderr."""
        from caricli.store.originals import load_original

        picture = self.paths.picture
        assert picture is not None
        retargeting = self.retargeting
        original = load_original(retargeting.rig, retargeting.template, picture, self.paths.parsing, self.reader)
        echo_numbering(self.paths.parsing)
        echo_notes(*(f"{shown(picture)}: {note}" for note in original.unknown()))
        return original

    def draw(self, row: int) -> np.ndarray:
        """(H, W, 3) uint8, the picture with the expression of one driver, on white paper."""
        from caricli.methods.redraw.redraw_picture import redraw_picture

        return redraw_picture(self.original, self.retargeting.vertices(row), self.retargeting.change(row))

    def draw_layer(self, row: int) -> np.ndarray:
        """(H, W, 4) uint8, the same as transparent as the picture is."""
        from caricli.methods.redraw.redraw_picture import redraw_layer

        return redraw_layer(self.original, self.retargeting.vertices(row), self.retargeting.change(row))

    def write(self, png: Path, json: Path, row: int, description: dict[str, Any]) -> None:
        """Write PNG and JSON of one driver. Raises OutputError."""
        write_png(png, self.draw(row) if self.original.layer is None else self.draw_layer(row))
        figures = {"unknown": self.original.unknown(), "parsed": self.original.regions is not None}
        write_json(json, description | figures | self.retargeting.figures(row))

    def write_film(self, film: Path, fps: float) -> None:
        """Write all drivers in their order as a film. Raises OutputError."""
        from caricli.io.video import write_video

        count = len(self.retargeting.explanation.weights)
        with progress_bar("drawing") as report:
            write_video(film, self._frames(count, report), fps)

    def _frames(self, count: int, report: Callable[[int, int], object]) -> Iterator[np.ndarray]:
        # Loaded before several frames ask for it.
        assert self.original
        for row, frame in enumerate(in_parallel(self.draw, range(count))):
            yield frame
            report(row + 1, count)


def film_files(path: Path) -> list[Path]:
    """A film, an animation or a picture, and its JSON."""
    return [path, path.with_suffix(".json")]
