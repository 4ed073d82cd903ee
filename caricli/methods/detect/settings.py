"""Settings of the search for faces."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class DetectSettings:
    """How faces are looked for; the numbers follow from what the detector is trained on.

    sides: longer sides of the picture at which it is searched, in those of the windows that the detector was trained
    on: a face of 1/12 of it has 23 of 128 pixels at the largest, one that fills it 96 at the smallest, and the training
    is on 16 to 128. finer: those besides, where most faces have less of the picture's longer side than small, or none
    is found. start: score from which on a place is looked at more closely. sure: score of a face. most: places that are
    looked at in one search, the best first. alike: overlap of the frames of two places, above which they are one; a
    face may lie in what is taken for a larger one. overlap: share of a face that another one has, above which they are
    one. first, second: share of the window's side to the face's when it is looked at first, in the frame that the
    search gave, and when it is read, in the frame of its landmarks; looks: at a face, at most; agree: overlap of the
    frames of two of them, from which on there is no further one. parse: side of a face at which what is around it is
    read, in windows' sides. widest: spread of a face's landmarks, of its diagonal, at which its score counts half, and
    less and less beyond; what only looks like a face from afar, a cat or a cup, has landmarks nowhere. vague: spread of
    a landmark along its worse direction beyond which it counts as not known, of the face's diagonal; margin: how far
    beyond the edge of the picture it may be, of the face's side. A face is doubtful below the score doubtful, with a
    spread of its landmarks above blurred, of its diagonal, and with less known ones than fewest.
    """

    sides: tuple[float, ...] = (0.75, 1.25, 2.125)
    finer: tuple[float, ...] = (3.6,)
    small: float = 0.1
    start: float = 0.25
    sure: float = 0.4
    most: int = 12
    alike: float = 0.4
    overlap: float = 0.5
    first: float = 1.9
    second: float = 1.6
    looks: int = 4
    agree: float = 0.9
    parse: float = 0.375
    widest: float = 0.065
    vague: float = 0.12
    margin: float = 0.01
    doubtful: float = 0.55
    blurred: float = 0.04
    fewest: int = 60

    def sure_of(self, score: float) -> "DetectSettings":
        """The same with another score of a face; places that are less sure are not looked at."""
        return replace(self, sure=score, start=min(self.start, score))
