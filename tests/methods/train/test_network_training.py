from types import SimpleNamespace

import pytest
import torch
from torch import nn

from caricli.methods.train.network_training import NetworkTraining, sum_gradients
from caricli.methods.train.processes import ALL, Share

CONFIG = SimpleNamespace(
    batch=8, epochs=1, steps=1, seed=0, learning_rate=1e-3, weight_decay=0.0, decay=0.9, validate_every=1
)


class LineTraining(NetworkTraining):
    """Of a line through points."""

    def __init__(self, share=ALL):
        super().__init__(lambda generator: nn.Linear(1, 1), CONFIG, share)
        for parameter in self.network.parameters():
            nn.init.constant_(parameter, 0.5)

    def _draw(self, step):
        return torch.linspace(-1, 1, CONFIG.batch)[self.share.rows(CONFIG.batch), None]

    def _loss(self, drawn):
        loss = (self.network(drawn) - drawn.exp()).square().mean()
        return loss, 2 * loss.detach()

    def _validate(self):
        return 0.0


@pytest.mark.parametrize("count", [2, 3, 8])
def test_any_number_of_processes_goes_down_the_same_gradient(monkeypatch, count):
    # Each keeps its own part of the sums.
    monkeypatch.setattr(torch.distributed, "all_reduce", lambda values: None)
    trainings = [LineTraining(), *(LineTraining(Share(process, count)) for process in range(count))]
    figures = [training._step(0, training._draw(0)) for training in trainings]
    torch.testing.assert_close(sum(figures[1:]), figures[0])
    whole, *parts = ([each.grad for each in training.network.parameters()] for training in trainings)
    for own, shares in zip(whole, zip(*parts, strict=True), strict=True):
        torch.testing.assert_close(sum(shares), own)


def test_gradients_are_summed_in_one_piece_in_the_order_of_their_memory(monkeypatch):
    convolution = nn.Conv2d(2, 3, 3)
    kernel = convolution.weight
    kernel.data = kernel.data.contiguous(memory_format=torch.channels_last)
    own = torch.arange(54.0).reshape(3, 2, 3, 3)
    kernel.grad = own.contiguous(memory_format=torch.channels_last)
    sums = []

    def another_process(values):
        sums.append(len(values))
        values += 1

    monkeypatch.setattr(torch.distributed, "all_reduce", another_process)
    sum_gradients(list(convolution.parameters()))
    assert sums == [57]
    assert torch.equal(kernel.grad, own + 1)
    assert kernel.grad.is_contiguous(memory_format=torch.channels_last)
    # This process had nothing for the bias.
    assert torch.equal(convolution.bias.grad, torch.ones(3))
