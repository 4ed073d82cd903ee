import re

import numpy as np
import pytest

from caricli.data.dataset import read_dataset
from caricli.data.summarise_dataset import components_for, summarise_dataset


@pytest.mark.parametrize(("count", "vertices"), [(40, 200), (200, 10)])
def test_components_of_shapes_of_a_known_rank(count, vertices):
    generator = np.random.default_rng(0)
    axes = np.linalg.qr(generator.normal(size=(3 * vertices, 5)))[0].T
    latents = np.linalg.qr(generator.normal(size=(count, 5)) - 0)[0]
    latents -= latents.mean(0)
    latents = np.linalg.qr(latents)[0]
    middle = generator.normal(size=3 * vertices)
    for needed in range(1, 6):
        spectrum = np.array([50.0] * needed + [0.1] * (5 - needed))
        shapes = (latents * np.sqrt(spectrum)) @ axes + middle
        assert components_for(shapes.reshape(count, vertices, 3)) == needed


def test_the_summary_tells_counts_kinds_and_components(built, grid):
    data = read_dataset(built[0])
    text = "\n".join(summarise_dataset(data))
    people = len(set(data.identity.tolist()))
    assert f"meshes 12, people {people}, vertices 4200, faces 8356" in text
    kinds = [int(n) for n in re.search(r"kinds: regular (\d+), curvature (\d+), parts (\d+), .* (\d+)", text).groups()]
    assert kinds == np.bincount(data.factors["kind"], minlength=4).tolist()
    flipped = re.search(r"flipped triangles: mean ([\d.]+) %, worst mesh ([\d.]+) %", text)
    assert 0 <= float(flipped[1]) <= float(flipped[2]) < 1
    assert 1 <= int(re.search(r"components for 99 % of the variance: (\d+)", text)[1]) <= 11
    sizes = [int(n) for n in re.search(r"train (\d+), validation (\d+), test (\d+)", text).groups()]
    assert sum(sizes) == 12
    share = data.labels[:, data.attributes.index("BigNose")].mean()
    assert f"BigNose {100 * share:.0f} %" in text
    assert "Caricature 75 %" in "\n".join(summarise_dataset(read_dataset(grid[0])))
