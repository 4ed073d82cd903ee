"""A head with its picture as texture (portrait paper, equation 12)."""

from dataclasses import replace

import numpy as np

from caricli.structures import Camera
from caricli.template.template import Template


def project_picture(head: Template, camera: Camera, image: np.ndarray) -> Template:
    """The head with UVs where its vertices are seen in the picture: what the picture does not show is smeared.

    head: Template in the shape of the face. camera: Camera of the picture. image: (H, W, 3) uint8.
    """
    uvs = (camera.project(head.vertices) + 0.5) / image.shape[1::-1]
    uvs[:, 1] = 1 - uvs[:, 1]
    return replace(head, uvs=uvs, uv_polygons=head.polygons)
