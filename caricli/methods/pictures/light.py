"""Light from anywhere, on people who are drawn."""

from dataclasses import dataclass

import numpy as np

from caricli.methods.texture.estimate_light import harmonics


@dataclass(frozen=True, eq=False)
class Sky:
    """Where light comes from, in the axes of the camera (x right, y down, z into the picture).

    ways: (L, 3) unit, towards lamps. colours: (L, 3) linear light. sharpness: (L,) of their cosine lobes.
    above, below: (3,) linear light of the sky and of the ground.
    """

    ways: np.ndarray
    colours: np.ndarray
    sharpness: np.ndarray
    above: np.ndarray
    below: np.ndarray

    @property
    def half(self) -> np.ndarray:
        """(3,) unit, the normal of what mirrors the first lamp into the camera."""
        way: np.ndarray = self.ways[0] + np.array([0, 0, -1])
        return way / max(float(np.linalg.norm(way)), 1e-6)

    def radiance(self, directions: np.ndarray) -> np.ndarray:
        """(D, 3) linear light from directions (D, 3) in the camera's axes."""
        height = (0.5 - 0.5 * directions[:, 1])[:, None]
        light = height * self.above + (1 - height) * self.below
        for way, colour, sharpness in zip(self.ways, self.colours, self.sharpness, strict=True):
            lobe = np.maximum(directions @ way, 0) ** sharpness
            light = light + (sharpness + 1) / 2 * lobe[:, None] * colour
        return light

    def harmonics(self, directions: np.ndarray) -> np.ndarray:
        """(9, 3) spherical harmonics of its radiance over directions (D, 3) that are spread evenly."""
        return 4 * np.pi / len(directions) * harmonics(directions).T @ self.radiance(directions)


def random_sky(generator: np.random.Generator) -> Sky:
    """Draw a Sky: a key light from before the face or beside it, a fill, sometimes a rim light, often soft."""
    tint = 1 + generator.normal(0, 0.08, (3, 3))
    key = np.array([generator.normal(0, 0.8), generator.normal(-0.6, 0.6), -generator.uniform(0.2, 1.2)])
    fill = generator.normal(size=3)
    fill[2] = -abs(fill[2])
    rim = np.array([generator.choice([-1.0, 1.0]), generator.normal(-0.2, 0.4), generator.uniform(0.1, 0.6)])
    ways = np.stack([way / max(float(np.linalg.norm(way)), 1e-6) for way in (key, fill, rim)])
    soft = generator.random() < 0.3
    strengths = np.array(
        [
            generator.uniform(0.2, 0.5) if soft else generator.uniform(0.45, 1.2),
            generator.uniform(0, 0.35),
            generator.uniform(0.2, 0.9) if generator.random() < 0.2 else 0.0,
        ]
    )
    base = generator.uniform(0.35, 0.8) if soft else generator.uniform(0.12, 0.5)
    ambient = base * (1 + generator.normal(0, 0.08, (2, 3)))
    return Sky(
        ways,
        np.maximum(strengths[:, None] * tint, 0),
        np.array([generator.uniform(4, 24), generator.uniform(1, 4), 12.0]),
        np.maximum(ambient[0], 0.02),
        np.maximum(ambient[1] * generator.uniform(0.3, 1.0), 0.02),
    )
