"""What readers and writers of GLB and glTF files share."""

import struct

import numpy as np

SOURCE_VERTEX = "_SOURCE_VERTEX"
"""The vertex attribute that tells which vertex of the rig a vertex, split where the UVs have a seam, comes from."""

SUFFIXES = (".glb", ".gltf")
"""Ends of names, in small letters: binary, and all of it one text."""

MAGIC = b"glTF"
VERSION = 2
JSON_CHUNK = b"JSON"
BINARY_CHUNK = b"BIN\0"
_COMPONENTS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}

HEADER = struct.Struct("<4sII")
CHUNK = struct.Struct("<I4s")

DTYPES: dict[int, np.dtype] = {code: np.dtype(name) for code, name in _COMPONENTS.items()}
"""Types of components by their codes."""

TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
"""Types of accessors by their width."""
