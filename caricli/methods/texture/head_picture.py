"""A picture of a face, and the part of it that says anything of the head."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from caricli.render.pixels.smaller_mask import smaller_mask
from caricli.structures import Face
from caricli.structures.zoomed_pixels import zoomed_pixels

_AROUND = 1.0  # of the longer side of what the mesh covers: hair is not farther away, nor what tells what is behind it


@dataclass(frozen=True, eq=False)
class HeadPicture:
    """A picture of a face.

    face: Face with the camera of the picture. image: (H, W, 3) uint8. mask: (H, W) bool, the head in it, or None to
    find it. regions: (H, W) values of Region, what the pixels show, or None. share: of the picture that was given,
    what this part of it is.
    """

    face: Face
    image: np.ndarray
    mask: np.ndarray | None = None
    regions: np.ndarray | None = None
    share: float = 1.0

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.image.shape[1], self.image.shape[0]

    def near_head(self, most: int) -> "HeadPicture":
        """The part around the head, so much smaller that the head is no longer or wider than ``most`` pixels.

        A head outside of the picture has none: all of it is kept.
        """
        places = self.face.require_camera().project(self.face.vertices)
        low = places.min(0)
        high = places.max(0)
        longest = max(*(high - low), 1.0)
        start = np.clip(np.floor(low - _AROUND * longest), 0, self.size).astype(int)
        end = np.clip(np.ceil(high + _AROUND * longest), 0, self.size).astype(int)
        if (start >= end).any():
            return self
        part = np.s_[start[1] : end[1], start[0] : end[0]]
        image = np.ascontiguousarray(self.image[part])
        mask, regions = (None if each is None else each[part] for each in (self.mask, self.regions))
        share = self.share * image[..., 0].size / self.image[..., 0].size
        cut = HeadPicture(self._seen(1.0, start), image, mask, regions, share)
        return cut._smaller(most / longest) if longest > most else cut

    def _smaller(self, zoom: float) -> "HeadPicture":
        """The same picture so many times as large."""
        image = cv2.resize(self.image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
        mask = None if self.mask is None else smaller_mask(self.mask, zoom)
        regions = None
        if self.regions is not None:
            regions = cv2.resize(self.regions, image.shape[1::-1], interpolation=cv2.INTER_NEAREST_EXACT)
        return replace(self, face=self._seen(zoom, np.zeros(2)), image=image, mask=mask, regions=regions)

    def _seen(self, zoom: float, corner: np.ndarray) -> Face:
        """The face as the part of the picture that begins at a corner (2,) shows it, so many times as large."""
        landmarks = self.face.landmarks
        points = None if landmarks is None else zoomed_pixels(landmarks, zoom, corner)
        return replace(self.face, camera=self.face.require_camera().zoomed(zoom, corner), landmarks=points)
