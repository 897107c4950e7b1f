"""The graph of a network's convolutions, traced from the network itself."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import torch
from torch import fx, nn
from torch.fx.passes.shape_prop import ShapeProp

from bobrossnet.learn.networks import Network

INPUT = "input"  # name of the network's input in `Layer.reads`


class Layer(NamedTuple):
    """A convolution."""

    name: str
    inputs: int  # channels
    outputs: int
    kernel: int  # height and width
    groups: int
    parameters: int
    scale: int  # downscaling relative to the picture's height and width
    reads: tuple[tuple[str, int], ...]  # its input layers, in channel order, each with its number of channels
    shuffled: bool  # whether its input channels are shuffled
    after: tuple[str, ...]  # operations on its outputs before the next layer


def layers_of(network: Network) -> list[Layer]:
    """Return a network's convolutions in execution order.

    They must be a chain: the first channels of each are the previous layer's outputs.
    """
    side = 64
    module = fx.symbolic_trace(network)
    ShapeProp(module).propagate(torch.zeros(1, _input_channels(network), side, side))
    convolutions = [node for node in module.graph.nodes if node.op == "call_module"]
    (end,) = (node for node in module.graph.nodes if node.op == "output")
    after: dict[fx.Node, tuple[str, ...]] = {}
    reads: dict[fx.Node, list[tuple[str, int]]] = {}
    shuffled: dict[fx.Node, bool] = {}
    for node in [*convolutions, end]:
        source, steps = _way_to(node.args[0])
        parts: Any = source.args[0] if _does(source) == "cat" else [source]
        shuffled[node] = any(_does(step) == "transpose" for step in steps)
        reads[node] = []
        for i, part in enumerate(parts):
            origin, before = _way_to(part)
            reads[node].append((str(origin.target) if origin in convolutions else INPUT, _shape(part)[1]))
            if i == 0:
                words = (_WORDS[_does(step)](step) for step in [*before, *steps] if _does(step) in _WORDS)
                after[origin] = tuple(words)
    return [
        Layer(
            name=str(node.target),
            inputs=conv.in_channels,
            outputs=conv.out_channels,
            kernel=conv.kernel_size[0],
            groups=conv.groups,
            parameters=sum(parameter.numel() for parameter in conv.parameters()),
            scale=side // _shape(node)[2],
            reads=tuple(reads[node]),
            shuffled=shuffled[node],
            after=after[node],
        )
        for node in convolutions
        for conv in [network.get_submodule(str(node.target))]
        if isinstance(conv, nn.Conv2d)
    ]


_WORDS: dict[str, Any] = {
    "relu": lambda step: "ReLU",
    "max_pool2d": lambda step: f"max pool {step.args[1]}×{step.args[1]}",
    "interpolate": lambda step: f"upsample {step.kwargs['scale_factor']}×{step.kwargs['scale_factor']}",
}


def _input_channels(network: Network) -> int:
    first = next(module for module in network.modules() if isinstance(module, nn.Conv2d))
    return first.in_channels


def _way_to(node: fx.Node) -> tuple[fx.Node, list[fx.Node]]:
    """Return the source of a value, a convolution, a concatenation or the input, and the steps from it, in order."""
    steps: list[fx.Node] = []
    while node.op not in ("call_module", "placeholder") and _does(node) != "cat":
        steps.insert(0, node)
        node = node.args[0]  # type: ignore[assignment]
    return node, steps


def _does(node: fx.Node) -> str:
    """Return a step's operation: the node's name without its number."""
    return re.sub(r"_\d+$", "", node.name)


def _shape(node: fx.Node) -> torch.Size:
    shape: torch.Size = node.meta["tensor_meta"].shape
    return shape
