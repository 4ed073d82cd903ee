"""A SIREN hypernetwork and the latents of a dataset's training meshes (deformable paper, section 3.3)."""

import copy

import numpy as np
import torch
from scipy.spatial import KDTree

from caricli.data.dataset import Dataset
from caricli.methods.evaluate.evaluate_shape import split_rows
from caricli.methods.train.deformable.surface import Surface, TrainingMeshes
from caricli.methods.train.processes import ALL, Share
from caricli.methods.train.train_autodecoder import AutoDecoderTraining
from caricli.models.deformable.config import DeformableConfig
from caricli.models.deformable.model import DeformableModel, UnitBox
from caricli.models.deformable.networks import HyperSiren
from caricli.models.prior import Prior
from caricli.template.template import Template

TOUCHING = 1e-6
"""Distance at which two vertices are in one place, a share of the height: rounding of single precision."""


def train_deformable(
    data: Dataset, points: np.ndarray, config: DeformableConfig, device: str = "cpu", share: Share = ALL
) -> AutoDecoderTraining:
    """The training of a DeformableModel, to be followed epoch by epoch.

    points: (V, 3) metres, the shape that the network deforms. device: "cpu" or "cuda". share: of this process.
    Raises InputError when the dataset has too few training meshes.
    """
    shapes = data.vertices[split_rows(data, "train", least=3)]
    unseen = data.vertices[data.rows("validation")]
    generator = torch.Generator().manual_seed(config.seed)
    network = HyperSiren(config.size(), generator, getattr(torch, config.precision)).to(device)
    surface = Surface(UnitBox(points), data.template.faces, device)
    return AutoDecoderTraining(network, TrainingMeshes(surface, shapes, unseen), config, share)


def trained_model(training: AutoDecoderTraining, template: Template) -> DeformableModel:
    """The DeformableModel that a training has come to; its prior is the spread of the training latents."""
    latents = training.latents.detach().cpu().double().numpy()
    # A copy: the model freezes its weights.
    network = copy.deepcopy(training.network)
    assert isinstance(network, HyperSiren)
    return DeformableModel(template, network, training.surface.box.points, Prior.of(latents))


def touching_vertices(points: np.ndarray) -> int:
    """How many vertices of a shape (V, 3) lie on others: a network that knows positions alone cannot part them."""
    nearest = KDTree(points).query(points, 2)[0][:, 1]
    return int(np.sum(nearest < TOUCHING * np.ptp(points[:, 1])))
