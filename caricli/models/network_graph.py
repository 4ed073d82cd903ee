"""Networks for pictures as graphs of ONNX.

What `residual.py` trains is put together here again from the same weights, by the names that they have there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from onnx import TensorProto, helper, numpy_helper

from caricli.models.checks import foreign_weights, named_weights

_EPSILON = 1e-5
"""What PyTorch adds to variances."""

_OPSET = 17
_IR_VERSION = 8
"""Both of 2022: any ONNX Runtime of today knows them."""


@dataclass(frozen=True)
class Kernel:
    """What a convolution is made of: channels that go in and come out, side and stride in pixels, the side odd."""

    inputs: int
    outputs: int
    side: int = 3
    stride: int = 1

    @property
    def shape(self) -> tuple[int, ...]:
        """Of its weights."""
        return self.outputs, self.inputs, self.side, self.side


class NetworkGraph:
    """A graph in the making. Values, (B, C, H, W), go by their names. weights: arrays by name, all to be used once."""

    def __init__(self, weights: Mapping[str, np.ndarray]) -> None:
        self._weights = dict(weights)
        self._nodes: list[Any] = []
        self._constants: list[Any] = []

    def take(self, name: str, shape: tuple[int, ...]) -> np.ndarray:
        """The weights of a name, in single precision. Raises InputError where there are none of this shape."""
        array = named_weights(self._weights, name, shape)
        del self._weights[name]
        return array

    def constant(self, array: np.ndarray) -> str:
        """An array that is always the same."""
        name = f"constant {len(self._constants)}"
        self._constants.append(numpy_helper.from_array(np.ascontiguousarray(array), name))
        return name

    def node(self, operator: str, *values: str, name: str | None = None, **settings: Any) -> str:
        """What an operator of ONNX makes of values. name: of what it makes."""
        name = name or f"value {len(self._nodes)}"
        self._nodes.append(helper.make_node(operator, values, [name], **settings))
        return name

    def convolved(self, values: str, weight: np.ndarray, bias: np.ndarray, stride: int = 1) -> str:
        """A convolution; weight: (D, C, K, K), K odd, the border of zeros. bias: (D,)."""
        side = weight.shape[2]
        arrays = [self.constant(array.astype(np.float32)) for array in (weight, bias)]
        return self.node("Conv", values, *arrays, pads=[side // 2] * 4, strides=[stride] * 2)

    def convolution(self, name: str, values: str, inputs: int, outputs: int) -> str:
        """The convolution of a name, pixel by pixel."""
        weight = self.take(f"{name}.weight", Kernel(inputs, outputs, side=1).shape)
        return self.convolved(values, weight, self.take(f"{name}.bias", (outputs,)))

    def unit(self, name: str, values: str, kernel: Kernel) -> str:
        """`residual.unit`."""
        return self.node("Relu", self._normalised(f"{name}.0", f"{name}.1", values, kernel))

    def residual(self, name: str, values: str, width: int) -> str:
        """`residual.Residual`."""
        kernel = Kernel(width, width)
        second = self._normalised(f"{name}.second", f"{name}.norm", self.unit(f"{name}.first", values, kernel), kernel)
        return self.node("Relu", self.node("Add", values, second))

    def twice(self, values: str) -> str:
        """As wide and high again, by repeating."""
        factors = self.constant(np.array([1, 1, 2, 2], np.float32))
        how = {"mode": "nearest", "coordinate_transformation_mode": "asymmetric", "nearest_mode": "floor"}
        return self.node("Resize", values, "", factors, **how)

    def model(self, given: str, channels: int, results: Sequence[str]) -> bytes:
        """The graph as a file of ONNX, for `network_session`.

        given: name of the values (B, channels, H, W) that go in. results: names of those that come out.
        Raises InputError where weights are left.
        """
        if self._weights:
            raise foreign_weights(sorted(self._weights)[0])
        entry = helper.make_tensor_value_info(given, TensorProto.FLOAT, [None, channels, None, None])
        exits = [helper.make_tensor_value_info(name, TensorProto.FLOAT, None) for name in results]
        graph = helper.make_graph(self._nodes, "network", [entry], exits, self._constants)
        opsets = [helper.make_opsetid("", _OPSET)]
        return helper.make_model(graph, opset_imports=opsets, ir_version=_IR_VERSION).SerializeToString()

    def _normalised(self, name: str, norm: str, values: str, kernel: Kernel) -> str:
        """A convolution without bias and its batch normalisation, which are one convolution together."""
        weight = self.take(f"{name}.weight", kernel.shape)
        parts = ("weight", "bias", "running_mean", "running_var")
        gain, bias, mean, variance = (self.take(f"{norm}.{part}", (kernel.outputs,)) for part in parts)
        gain = gain / np.sqrt(np.maximum(variance, 0) + _EPSILON)
        return self.convolved(values, weight * gain[:, None, None, None], bias - gain * mean, kernel.stride)
