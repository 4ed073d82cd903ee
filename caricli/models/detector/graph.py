"""The detector's network as it is used: what `networks.DetectorNetwork` trains, but for the last steps of landmarks."""

import numpy as np

from caricli.models.detector.config import HALF
from caricli.models.detector.landmark_heads import HEADS
from caricli.models.detector.weights import CHANCES, FACES, FEATURES, WINDOWS, DetectorWeights
from caricli.models.network_graph import Kernel, NetworkGraph


def detector_graph(weights: DetectorWeights, regions: int) -> bytes:
    """A detector's network as a file of ONNX. regions: R, how many there are.

    Of WINDOWS (B, 12, H / 2, W / 2), from -1 to 1, the four pixels of each cell by channels, it makes FACES (B, 6,
    H / 16, W / 16), see ``networks.FaceGrid``, FEATURES (B, C, H / 4, W / 4), of which landmarks are read, and CHANCES
    (B, H / 4, W / 4, 4, R), probabilities of regions at the four pixels of half size in every cell, by rows.
    Raises InputError for the weights of another network.
    """
    size = weights.size
    graph = NetworkGraph({name: array for name, array in weights.arrays.items() if name not in HEADS})
    first, second, third, fourth = size.widths
    levels = [graph.unit("stem", WINDOWS, Kernel(3 * HALF**2, size.stem))]
    steps = [(size.stem, first, 1), (first, second, 1), (second, third, size.depth), (third, fourth, size.depth)]
    for number, (inputs, outputs, depth) in enumerate(steps):
        values = graph.unit(f"down.{number}.0", levels[-1], Kernel(inputs, outputs, stride=2))
        for block in range(depth):
            values = graph.residual(f"down.{number}.{block + 1}", values, outputs)
        levels.append(values)
    features = levels.pop()
    for number, (inputs, outputs) in enumerate([(fourth, third), (third, second), (second, first)]):
        above = graph.twice(graph.unit(f"up.{number}", features, Kernel(inputs, outputs, side=1)))
        features = graph.residual(f"join.{number}", graph.node("Add", levels.pop(), above), outputs)
        if number == 0:
            near = graph.unit("near_face", features, Kernel(third, first))
            graph.node("Identity", graph.convolution("face", near, first, 6), name=FACES)
    for block in range(size.finer):
        features = graph.residual(f"finer.{block}", features, first)
    graph.node("Identity", features, name=FEATURES)
    fine = graph.convolution("regions", features, first, HALF**2 * regions)
    edges = _edges(graph, levels.pop(), size.stem, HALF**2 * regions)
    cells = graph.node("Transpose", graph.node("Add", fine, edges), perm=[0, 2, 3, 1])
    pixels = graph.node("Reshape", cells, graph.constant(np.array([0, 0, 0, HALF**2, regions])))
    graph.node("Softmax", pixels, axis=-1, name=CHANCES)
    return graph.model(WINDOWS, 3 * HALF**2, [FACES, FEATURES, CHANCES])


def _edges(graph: NetworkGraph, values: str, width: int, outputs: int) -> str:
    """The convolution ``edges`` of the four pixels in each cell of values."""
    weight = graph.take("edges.weight", (outputs, width * HALF**2, 1, 1))
    # PyTorch has the pixels of a channel beside each other, ONNX the channels of a pixel.
    by_pixels = weight.reshape(outputs, width, HALF**2).swapaxes(1, 2).reshape(weight.shape)
    cells = graph.node("SpaceToDepth", values, blocksize=HALF)
    return graph.convolved(cells, by_pixels, graph.take("edges.bias", (outputs,)))
