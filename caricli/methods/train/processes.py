"""The processes of one training: one, or several under torchrun."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import torch


@dataclass(frozen=True)
class Share:
    """Which part of every batch a process takes: one in ``count``, from ``process`` on."""

    process: int = 0
    count: int = 1

    def rows(self, count: int) -> range:
        """The numbers that the process takes of so many."""
        return range(self.process, count, self.count)


ALL = Share()
"""Of a process that trains alone."""


@contextmanager
def training_processes(device: str) -> Iterator[Share]:
    """Set PyTorch up so that trainings repeat themselves, join the other processes, and yield this one's Share.

    device: "cpu" or "cuda".
    """
    share = Share(int(os.environ.get("RANK", 0)), int(os.environ.get("WORLD_SIZE", 1)))
    if device == "cuda":
        os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")  # what deterministic sums need
        torch.cuda.set_device(int(os.environ.get("LOCAL_RANK", 0)))
    torch.use_deterministic_algorithms(True)
    if share.count > 1:
        torch.distributed.init_process_group("nccl" if device == "cuda" else "gloo")
    try:
        yield share
    finally:
        torch.use_deterministic_algorithms(False)
        if share.count > 1:
            torch.distributed.destroy_process_group()
