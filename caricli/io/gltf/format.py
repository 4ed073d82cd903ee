"""What reader and writer of GLB files share."""

import struct

import numpy as np

from caricli.structures import Material

SOURCE_VERTEX = "_SOURCE_VERTEX"
"""The vertex attribute that tells which vertex of the rig a vertex, split where the UVs have a seam, comes from."""

MATERIAL_NAMES = {Material.SKIN: "skin", Material.EYE: "eyes"}
TEXTURE_FIELDS = {Material.SKIN: "texture", Material.EYE: "eye_texture"}

MAGIC = b"glTF"
VERSION = 2
JSON_CHUNK = b"JSON"
BINARY_CHUNK = b"BIN\0"
HEADER = struct.Struct("<4sII")
CHUNK = struct.Struct("<I4s")

DTYPES = {5121: np.dtype("u1"), 5123: np.dtype("<u2"), 5125: np.dtype("<u4"), 5126: np.dtype("<f4")}
"""Types of components by their codes."""

TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
"""Types of accessors by their width."""
