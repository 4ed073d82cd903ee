"""Wrinkle lines of many heads, found once: suggestive contours take a twentieth of a second each."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from typing import Self

import numpy as np

from caricli.data.worker_pool import worker_pool
from caricli.geometry.lines.along_lines import along
from caricli.io.kept import kept_arrays
from caricli.methods.sketch.draw_sketch import canvas_camera
from caricli.methods.sketch.sketch_artist import ArtistSettings, SketchArtist
from caricli.methods.train.sketch.sketch_hand import LINE, Wrinkles
from caricli.methods.train.stages import Report, unwatched
from caricli.template.template import Template

MOST = 12
"""Lines of a head, the strongest."""

_UNIT = 32
"""Heads that a worker looks at at a time."""


@dataclass(frozen=True, eq=False)
class WrinkleBook:
    """The lines of N heads as the front shows them: lines (L, LINE, 3) metres, and where each head's begin (N + 1,)."""

    lines: np.ndarray
    starts: np.ndarray

    @classmethod
    def of(cls, template: Template, vertices: np.ndarray, report: Report = unwatched) -> Self:
        """Find the lines of heads (N, V, 3), or take them from the user's cache.

        template: of them. report: told of heads that are done.
        """
        regions = json.dumps(template.annotation.source, sort_keys=True)
        given = (template.topology_id, template.vertices, regions, repr(asdict(ArtistSettings())), vertices)
        arrays = kept_arrays("wrinkles", given, partial(_found, template, vertices, report))
        return cls(arrays["lines"], arrays["starts"])

    def of_rows(self, rows: np.ndarray) -> Wrinkles:
        """The lines of some of the heads."""
        counts = self.starts[rows + 1] - self.starts[rows]
        there = np.arange(max(int(counts.max(initial=1)), 1)) < counts[:, None]
        lines = np.zeros((*there.shape, LINE, 3))
        numbers = self.starts[rows][:, None] + np.arange(there.shape[1])
        lines[there] = self.lines[numbers[there]]
        return Wrinkles(lines, there)

    def some(self, rows: np.ndarray) -> "WrinkleBook":
        """The lines of some of the heads alone."""
        parts = [self.lines[self.starts[row] : self.starts[row + 1]] for row in rows]
        return WrinkleBook(np.concatenate(parts), np.cumsum([0, *map(len, parts)]))


def _found(template: Template, vertices: np.ndarray, report: Report) -> dict[str, np.ndarray]:
    parts = [vertices[start : start + _UNIT] for start in range(0, len(vertices), _UNIT)]
    lines: list[np.ndarray] = []
    # A process takes longer to start than a few heads do.
    pool = worker_pool(None, partial(SketchArtist, template)) if len(parts) > 1 else _here(template)
    with pool as run:
        for done in run(_lines, parts):
            lines += done
            report(len(lines), len(vertices))
    counts = [0, *(len(own) for own in lines)]
    packed = np.concatenate(lines).reshape(-1, LINE, 3)
    return {"lines": packed.astype(np.float32), "starts": np.cumsum(counts)}


@contextmanager
def _here(template: Template) -> Iterator[Callable]:
    artist = SketchArtist(template)
    yield lambda function, parts: (function(artist, part) for part in parts)


def _lines(artist: SketchArtist, heads: np.ndarray) -> list[np.ndarray]:
    return [_of_head(artist, head.astype(float)) for head in heads]


def _of_head(artist: SketchArtist, head: np.ndarray) -> np.ndarray:
    """(W, LINE, 3) lines at equal distances along themselves."""
    lines = artist.wrinkle_lines(head, canvas_camera(head, artist.curves), MOST)
    shares = np.linspace(0, 1, LINE)[None]
    return np.concatenate([np.zeros((0, LINE, 3)), *(along(line[None], shares) for line in lines)])
