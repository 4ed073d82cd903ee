"""The caps that every reader checks before it allocates; far above honest use, far below what a small machine has."""

MAX_FILE_BYTES = 2**29
"""Largest file read whole, where no smaller cap below applies."""

MAX_VERTICES = 1_000_000
MAX_POLYGONS = 2_000_000
MAX_CORNERS = 16_000_000
"""Largest number of entries (polygons times the longest polygon) of one padded polygon table."""
MAX_POLYGON_CORNERS = 64
MAX_SHAPES = 1024
"""Largest number of expressions of one rig."""
MAX_MOODS = 64
"""Largest number of moods of one rig."""
MAX_CHANGE = 100.0
"""Largest magnitude of a gain or an offset of an atlas of changes."""
MAX_COORDINATE = 1e6
"""Largest magnitude of a coordinate: beyond it single precision no longer holds a face."""
MAX_NUMBER = 1e9
"""Largest magnitude of any other number: its fourth power still fits single precision."""
MIN_CAMERA_SCALE = 1e-6
MAX_CAMERA_SCALE = 1e6
"""Pixels per metre: a head is then a quarter of a million pixels high."""

MAX_IMAGE_BYTES = 2**28
MAX_IMAGE_PIXELS = 64_000_000
MAX_IMAGE_SIDE = 32_000
"""Pixels: OpenCV looks at none that are 32,767 wide or high."""

MAX_NPZ_BYTES = 2**30
"""Largest sum of the expanded members of one NPZ."""
MAX_NPZ_MEMBERS = 1024
MAX_NPZ_HEADER_BYTES = 4096
MAX_ARRAY_DIMENSIONS = 8

MAX_DATASET_BYTES = 2**33
"""Largest sum of the vertices of one dataset, which are held in memory together."""

MAX_JSON_BYTES = 2**26
MAX_JSON_DEPTH = 64
MAX_CONFIG_BYTES = 2**16
MAX_CONFIG_DEPTH = 8
MAX_LANDMARK_BYTES = 2**20

MAX_CHECKPOINT_BYTES = 2**31
MAX_CHECKPOINT_HEADER_BYTES = 2**24

MAX_SKETCH_BYTES = 2**25
MAX_SVG_BYTES = 2**22
"""Its paths are taken apart one by one."""
MAX_SKETCH_POINTS = 200_000
MAX_SKETCH_SIDE = 16_384
"""Pixels of a canvas, width or height."""
MAX_STROKES = 20_000

MAX_SESSION_BYTES = 2**26
MAX_OPERATIONS = 20_000
"""Steps of one session."""
