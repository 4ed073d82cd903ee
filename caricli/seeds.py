"""What random numbers are drawn for: every purpose has a stream of its own, so that none depends on another."""

from enum import IntEnum


class DatasetSeed(IntEnum):
    """Streams of a generated dataset, after its seed."""

    IDENTITY = 0
    DRAW = 1
    PRIOR = 2
    SPLIT = 3
    ALBEDO = 4


class TrainingSeed(IntEnum):
    """Streams of a training, after its seed."""

    ORDER = 0
    STEP = 1
    VALIDATION = 2
    START = 3
    CODES = 4
    SURFACE = 5
    DIM = 6
    HELD = 7
    EXTRA = 8


class LookSeed(IntEnum):
    """Streams of the looks that people with textures are painted in, after their seed: one for what they are for."""

    TRAINING = 0
    VALIDATION = 1
    DRAWINGS = 2
    EVALUATION = 3


class PictureSeed(IntEnum):
    """Streams of generated pictures, after their seed."""

    ORDER = 0
    SITTER = 1
    PICTURE = 2


class SketchSeed(IntEnum):
    """Streams of generated sketches, after their seed."""

    ORDER = 0
    SKETCH = 1


class TextureSeed(IntEnum):
    """Streams of generated textures, after their seed."""

    ORDER = 0
    PERSON = 1
