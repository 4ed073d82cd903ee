"""Whether what was saved of a training fits the training that is to go on from it."""

from typing import Any

import torch

from caricli.errors import InputError, shown


def require_like(value: Any, own: Any, where: str = "state") -> None:
    """Refuse a saved value of another form than the own one.

    value: made of dicts, lists, tuples, tensors and plain values. own: the value of the same place here; its numbers
    and the contents of its tensors do not count. where: what the place is called in messages.
    Raises InputError where keys, lengths, kinds of values, or shapes or types of tensors differ.
    """
    if isinstance(own, torch.Tensor):
        if not isinstance(value, torch.Tensor) or value.shape != own.shape or value.dtype != own.dtype:
            raise InputError(f"{where}: expected {_form(own)}, found {_form(value)}")
    elif isinstance(own, dict):
        if not isinstance(value, dict) or value.keys() != own.keys():
            raise InputError(f"{where}: expected {shown(', '.join(map(str, own)), 60)!r}, found others")
        for key in own:
            require_like(value[key], own[key], f"{where}.{key}")
    elif isinstance(own, list | tuple):
        if type(value) is not type(own) or len(value) != len(own):
            raise InputError(f"{where}: expected {len(own)} values, found others")
        for number, (part, own_part) in enumerate(zip(value, own, strict=True)):
            require_like(part, own_part, f"{where}.{number}")
    elif _kind(value) is not _kind(own):
        raise InputError(f"{where}: expected {_form(own)}, found {_form(value)}")


def optimiser_form(optimiser: torch.optim.Optimizer, saved: Any) -> dict:
    """The ``state_dict()`` of an Adam or Muon after a step, or where the saved one has made none, before the first."""
    own = optimiser.state_dict()
    if isinstance(saved, dict) and not saved.get("state"):
        return own | {"state": {}}
    parameters = [parameter for group in optimiser.param_groups for parameter in group["params"]]
    return own | {"state": {number: _moments(optimiser, each.data) for number, each in enumerate(parameters)}}


def _moments(optimiser: torch.optim.Optimizer, values: torch.Tensor) -> dict[str, torch.Tensor]:
    if isinstance(optimiser, torch.optim.Muon):
        return {"momentum_buffer": values}
    return {"step": torch.zeros(()), "exp_avg": values, "exp_avg_sq": values}


def _kind(value: Any) -> type:
    return float if type(value) is int else type(value)


def _form(value: Any) -> str:
    if isinstance(value, torch.Tensor):
        return f"a tensor {tuple(value.shape)} of {value.dtype}"
    return type(value).__name__
