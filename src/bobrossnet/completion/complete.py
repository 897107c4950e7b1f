"""Completion of any channel: gray and coverage by a network, colours guided by them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.completion.display import displayed, restored
from bobrossnet.completion.guided import complete_guided, guided_alpha
from bobrossnet.completion.network import Network, NetworkLike, load_network
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.support.errors import InputError, InputTypeError, check_choice

GUIDED = "guided"
"""Model name of guided completion, which needs no network."""

DISPLAYED_MIDDLE = 0.2
"""Display-referred value of a high-dynamic-range picture's median, where its colours are compared."""


def complete(gbuffer: GBuffer, model: NetworkLike = "default", *, channel: str = "gray") -> NDArray[np.float32]:
    """Fill in the pixels that were not traced.

    Parameters
    ----------
    gbuffer : GBuffer, (H, W)
        Of any size, with any pixels traced.
    model : str, path or Network
        Name of shipped weights ("default", "filling", "paper", "small"), or a .safetensors file. "filling" has no
        learned weights, takes a third of the default's time, and matches its quality from 5 % of adaptive pixels on;
        "small" lies between. For a G-buffer with guides, "default" completes gray and colour along the guides
        instead, as "guided" does.
    channel : "gray", "color", "albedo" or "alpha"
        The channel to complete. The network completes gray, and coverage for albedo and alpha. Colours follow them
        by the ratio at the nearby traced pixels.

    Returns
    -------
    (H, W) float32, or (H, W, 3) of colours, in linear RGB
        In 0..1, or non-negative in the tracer's units for a high-dynamic-range G-buffer. Traced pixels are returned
        unchanged, except noisy ones with guides. With every pixel traced, the result is the channel itself.

    Raises
    ------
    InputError
        If `gbuffer` is not a GBuffer or lacks a channel that the network needs, if the weights can't be used, or if
        the channel does not exist.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> part = bob.trace(bob.happy_tree(), size=(120, 160), fraction=0.05)
    >>> image = bob.complete(part)
    >>> image.shape
    (120, 160)
    >>> bob.complete(part, channel="color").shape
    (120, 160, 3)
    """
    check_gbuffer(gbuffer)  # first, so that complete(gray, mask) gets an error that explains the call
    check_choice("channel", channel, ("gray", "color", "albedo", "alpha"))
    if channel in ("gray", "color") and follows_guides(gbuffer, model):
        return complete_guided(gbuffer, channel)
    if channel == "alpha" and "shadow" in gbuffer.layout.places and follows_guides(gbuffer, model):
        return guided_alpha(gbuffer)
    network = load_network(model)
    if gbuffer.mask.all():
        return gbuffer.channel(channel).copy()
    if channel in ("gray", "color"):
        gray = _completed(gbuffer, network)
        return gray if channel == "gray" else completed_color(gbuffer, gray)
    alpha = gbuffer.alpha
    coverage = GBuffer(mask=gbuffer.mask, gray=alpha, depth=gbuffer.depth, normal=gbuffer.normal)
    covered = _completed(coverage, network)
    return covered if channel == "alpha" else _completed_along("albedo", gbuffer, alpha, covered)


def follows_guides(gbuffer: GBuffer, model: NetworkLike) -> bool:
    """Whether `model` completes a G-buffer along its guides."""
    name = model if isinstance(model, str) else None
    if name == GUIDED and gbuffer.guides is None:
        raise InputError("model: expected a G-buffer with guides for 'guided', got one without")
    return gbuffer.guides is not None and name in ("default", GUIDED)


def completed_color(gbuffer: GBuffer, gray: NDArray[np.float32]) -> NDArray[np.float32]:
    """Complete the colour of a G-buffer, given its completed gray."""
    middle = None if gbuffer.transfer is None else gbuffer.transfer.middle
    unit = None if middle is None else middle / DISPLAYED_MIDDLE
    return _completed_along("color", gbuffer, gbuffer.gray, gray, unit)


def _completed(gbuffer: GBuffer, network: Network) -> NDArray[np.float32]:
    """Complete the gray of a G-buffer with untraced pixels."""
    shown = displayed(gbuffer)
    image, outputs = network.run(shown), network.core.outputs
    _core.interpolate_lattice(shown.layout.core, shown.planes, outputs, image[None])
    _core.keep_known(shown.layout.core, shown.planes, outputs, image[None])
    return restored(image, gbuffer)


def _completed_along(
    name: str,
    gbuffer: GBuffer,
    known: NDArray[np.float32],
    completed: NDArray[np.float32],
    unit: float | None = None,
) -> NDArray[np.float32]:
    """Complete a channel of colours along another channel, (H, W), given as traced and as completed.

    `unit` is the value that is shown as 1, for values of any range.
    """
    if name not in gbuffer.layout.places:  # the scene is white
        return np.repeat(completed[..., None], 3, -1)
    output = np.empty((3, *completed.shape), np.float32)
    channel = _core.Layout(name)
    _core.complete_along(gbuffer.layout.core, gbuffer.planes, channel, known, completed, unit, output)
    return np.moveaxis(output, 0, -1)


def check_gbuffer(gbuffer: object) -> None:
    """Raise InputTypeError unless the argument is a GBuffer."""
    if not isinstance(gbuffer, GBuffer):
        hint = "bobrossnet.GBuffer(mask=, gray=, depth=, normal=) makes one of arrays"
        raise InputTypeError(f"gbuffer: expected a GBuffer, got {type(gbuffer).__name__}; {hint}")
