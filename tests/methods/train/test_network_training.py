import torch
from torch import nn

from caricli.methods.train.network_training import sum_gradients


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
