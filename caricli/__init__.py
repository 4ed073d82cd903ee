"""caricli: drawings, sketches, portraits or landmarks to editable, rigged 3D caricatures."""

__version__ = "0.1.0"
