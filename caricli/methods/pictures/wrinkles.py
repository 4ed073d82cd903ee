"""Lines that age and expressions draw into skin."""

import numpy as np
from scipy.spatial import KDTree

from caricli.data.albedo import AlbedoPainter
from caricli.methods.creases.crease_lines import usual_lines


class WrinkleLines:
    """Distances of places on a head to the usual lines of a face, so that many faces share them.

    Lengths are in the painter's unit, the distance between the outer corners of the eyes.
    """

    def __init__(self, painter: AlbedoPainter) -> None:
        """painter: AlbedoPainter, whose places get wrinkles."""
        front = painter.places[:, 2] > painter.marks[[0, 16], 2].mean()
        lines = usual_lines(painter.marks[:, :2])
        distances = [KDTree(line).query(painter.places[:, :2])[0] for line in lines]
        self.distances = [np.where(front, distance, np.inf) for distance in distances]

    def draw(self, generator: np.random.Generator) -> np.ndarray:
        """(P,) by how much skin is darker, factors up to 1: some of the lines, of random depth and width."""
        age = generator.uniform(0.1, 0.75)
        shade = np.ones(len(self.distances[0]))
        for distance in self.distances:
            depth = age * generator.uniform(0, 1) * (generator.random() < 0.7)
            width = generator.uniform(0.012, 0.035)
            shade *= 1 - depth * np.exp(-((distance / width) ** 2))
        return shade
