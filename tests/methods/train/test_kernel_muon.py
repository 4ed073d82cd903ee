import numpy as np
import pytest
import torch
from torch import nn

from caricli.methods.train.kernel_muon import KernelMuon, normalised_kernels

RATE = 0.01


def kernel_of(*shape, seed=0):
    values = torch.randn(shape, generator=torch.Generator().manual_seed(seed))
    return nn.Parameter(values.contiguous(memory_format=torch.channels_last) if len(shape) == 4 else values)


def rows(kernel):
    """As a matrix with a row for every channel that comes out."""
    ordered = kernel.detach().double().movedim(1, -1)
    return ordered.reshape(len(kernel), -1).numpy().copy()


@pytest.mark.parametrize("shape", [(8, 3, 3, 3), (24, 2, 3, 3), (16, 16, 1, 1), (12, 20)])
def test_every_direction_of_a_gradient_goes_a_step_of_about_the_same_length(shape):
    kernel = kernel_of(*shape)
    before = rows(kernel)
    kernel.grad = kernel_of(*shape, seed=1).detach()
    muon = KernelMuon([kernel], lr=RATE, weight_decay=0.0)
    muon.step()
    moved = before - rows(kernel)
    # An independent way to what all directions of the gradient are with length one: its singular vectors.
    left, _, right = np.linalg.svd(rows(kernel.grad), full_matrices=False)
    lengths = np.diag(left.T @ moved @ right.T) / (0.2 * RATE * np.sqrt(max(moved.shape)))
    assert (lengths > 0.6).all()
    assert (lengths < 1.3).all()
    across = left.T @ moved @ right.T
    assert np.linalg.norm(across - np.diag(np.diag(across))) < 0.05 * np.linalg.norm(across)


def test_a_kernel_without_a_gradient_stays():
    kernels = [kernel_of(4, 3, 3, 3), kernel_of(4, 3, 3, 3)]
    before = [rows(kernel) for kernel in kernels]
    kernels[0].grad = torch.ones_like(kernels[0])
    KernelMuon(kernels, lr=RATE, weight_decay=0.0).step()
    assert not np.array_equal(rows(kernels[0]), before[0])
    np.testing.assert_array_equal(rows(kernels[1]), before[1])


def test_a_kernel_of_another_order_in_memory_is_refused():
    with pytest.raises(RuntimeError, match="view"):
        KernelMuon([nn.Parameter(torch.zeros(4, 3, 3, 3))], lr=RATE, weight_decay=0.0)


def test_what_has_a_bias_is_not_normalised():
    first = nn.Conv2d(3, 4, 3, bias=False)
    network = nn.Sequential(first, nn.BatchNorm2d(4), nn.Conv2d(4, 2, 1), nn.Linear(2, 2, bias=False))
    assert [id(kernel) for kernel in normalised_kernels(network)] == [id(first.weight)]
