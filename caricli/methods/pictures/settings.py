"""How often pictures show what; light to import. Chances are from 0 to 1, ranges least and greatest."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SitterSettings:
    """What people wear. Lengths are shares of the head's height, where nothing else is said.

    bald, shaved: of hair: none, or painted on the scalp alone. thickness: of hair over the skull.
    fringe, sides, back: degrees from the whorl to where hair ends over the forehead, beside the face and behind.
    hat, glasses, dark, beard, wrinkled, lashes: chances; dark: of the glasses. beard_thickness: of a full beard.
    twisted, grinning, laughing: chances that the mouth or an eye is pulled to one side, that lips bare the teeth, and
    that they are drawn far apart, with the jaw closed or dropped. loudest: the strongest of such laughs; beyond 1 a
    face does more than people can, as in caricatures. widest: share of its width that half of the laughing mouths are
    drawn wider by, at the most; wide: chance that any is. cartoon: chance of teeth as cartoons have them.
    long_teeth: chance of teeth that are longer, up to ``longest`` times.
    """

    bald: float = 0.12
    shaved: float = 0.1
    thickness: tuple[float, float] = (0.015, 0.16)
    fringe: tuple[float, float] = (52, 100)
    sides: tuple[float, float] = (62, 150)
    back: tuple[float, float] = (95, 152)
    hat: float = 0.22
    glasses: float = 0.24
    dark: float = 0.35
    beard: float = 0.26
    beard_thickness: tuple[float, float] = (0.01, 0.07)
    wrinkled: float = 0.55
    lashes: float = 0.6
    twisted: float = 0.3
    grinning: float = 0.2
    laughing: float = 0.5
    loudest: float = 2.4
    widest: float = 1.1
    wide: float = 0.3
    cartoon: float = 0.35
    long_teeth: float = 0.4
    longest: float = 1.8


@dataclass(frozen=True)
class PoseSettings:
    """How heads stand in pictures.

    yaw, pitch, roll: standard deviations, degrees; farthest: the most of yaw. turned: chance of a yaw from anywhere
    within the most. around: degrees that are added to it; 180 show a head from behind. behind: the most of yaw then,
    with which nothing of the face is seen. rolled: chance of a roll of up to ``roll_far``.
    perspective: share by which what is a head's height nearer is larger, at most.
    filled: longer side of the landmarks' box as a share of the picture's. close, small: chances of faces that go beyond
    the picture's edges, and of small ones; their shares. aside: how far its middle is off, of the picture's side;
    apart: the same where there are several; smaller ones than ``filled`` stand anywhere.
    """

    yaw: float = 20
    pitch: float = 9
    roll: float = 9
    farthest: float = 65
    turned: float = 0.2
    around: float = 0
    behind: float = 35
    rolled: float = 0.12
    roll_far: float = 45
    perspective: float = 0.35
    filled: tuple[float, float] = (0.35, 0.72)
    close: float = 0.12
    close_filled: tuple[float, float] = (0.72, 1.1)
    small: float = 0.15
    small_filled: tuple[float, float] = (0.085, 0.35)
    aside: float = 0.12
    apart: float = 0.32


@dataclass(frozen=True)
class SceneSettings:
    """What pictures consist of.

    none, several: chances of no face, and of two to ``most``. held: chance that something is in front of a face.
    away: chance that a picture without faces shows a head from behind. drawn: size at which it is drawn, of its own.
    sitters: people of one unit of work; they meet in pictures with several. pictures: of one unit.
    """

    none: float = 0.08
    several: float = 0.1
    most: int = 4
    held: float = 0.12
    away: float = 0.3
    drawn: float = 1.5
    sitters: int = 3
    pictures: int = 24
