"""Completing a picture with a network in the core."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bobrossnet import _core
from bobrossnet.completion.guided import complete_guided
from bobrossnet.completion.weights import UNCERTAINTY, WEIGHTS, read_weights
from bobrossnet.errors import InputError, InputTypeError, brief, check_choice
from bobrossnet.paths import path_of
from bobrossnet.picture.gbuffer import GBuffer
from bobrossnet.threads import Turns

GUIDED = "guided"
"""The name of what completes along guides, without a network."""

DISPLAYED_MIDDLE = 0.2
"""What the middle of a picture of any range is taken for where colours are compared with what is display-referred."""


@dataclass(frozen=True)
class Network:
    """A network with its weights, ready to run."""

    core: _core.Network
    weights: tuple[Mapping[str, str], Mapping[str, NDArray[np.float32]]] = field(repr=False, compare=False)
    """Of which it was made, as `read_weights` returns them."""

    def __reduce__(self) -> tuple[Any, ...]:
        return make_network, self.weights  # what is in the core can't be copied

    def predict(self, gbuffer: GBuffer) -> NDArray[np.float32]:
        """The network's own output at every pixel, known ones too: (H, W) float32, of any value; display-referred."""
        return _predicted(displayed(gbuffer), self.core)


NetworkLike: TypeAlias = str | os.PathLike[str] | Network


def complete(gbuffer: GBuffer, model: NetworkLike = "default", *, channel: str = "gray") -> NDArray[np.float32]:
    """Fill in the pixels that were not traced.

    Parameters
    ----------
    gbuffer : GBuffer, (H, W)
        Of any size, with any pixels traced.
    model : str, path or Network
        Name of shipped weights ("default", "filling", "paper", "small"), or a .safetensors file. "filling" needs no
        learning and a third of the default's time, and is as good from 5 % of adaptive pixels on; "small" lies between.
        Of a G-buffer with guides, "default" completes gray and colour along these instead, as does "guided".
    channel : "gray", "color", "albedo" or "alpha"
        What to complete. The network completes gray, and coverage for albedo and alpha; colours follow them, by what
        their ratio is at the traced pixels around.

    Returns
    -------
    (H, W) float32, or (H, W, 3) of colours, in linear RGB
        In 0..1, unless more was traced: then in its units, and at least 0. Traced pixels are returned unchanged, but
        for noisy ones along guides; with every pixel traced, this is `gbuffer.gray`, or the other channel.

    Raises
    ------
    InputError
        If `gbuffer` is not a GBuffer or lacks a channel that the network needs, or the weights can't be used, or
        there is no such channel.

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
    check_gbuffer(gbuffer)  # first: whoever passes arrays instead, as in complete(gray, mask), is told how
    check_choice("channel", channel, ("gray", "color", "albedo", "alpha"))
    if channel in ("gray", "color") and follows_guides(gbuffer, model):
        return complete_guided(gbuffer, channel)
    network = load_network(model).core
    if gbuffer.mask.all():
        return gbuffer.channel(channel).copy()
    if channel in ("gray", "color"):
        gray = _completed(gbuffer, network, network.outputs)
        return gray if channel == "gray" else completed_color(gbuffer, gray)
    alpha = gbuffer.alpha
    coverage = GBuffer(mask=gbuffer.mask, gray=alpha, depth=gbuffer.depth, normal=gbuffer.normal)
    covered = _completed(coverage, network, network.outputs)
    return covered if channel == "alpha" else _completed_along("albedo", gbuffer, alpha, covered)


def follows_guides(gbuffer: GBuffer, model: NetworkLike) -> bool:
    """Whether `model` completes a G-buffer along its guides."""
    name = model if isinstance(model, str) else None
    if name == GUIDED and gbuffer.guides is None:
        raise InputError("model: expected a G-buffer with guides for 'guided', got one without")
    return gbuffer.guides is not None and name in ("default", GUIDED)


def completed_color(gbuffer: GBuffer, gray: NDArray[np.float32]) -> NDArray[np.float32]:
    """The completed colour of a G-buffer whose completed gray is known."""
    middle = None if gbuffer.transfer is None else gbuffer.transfer.middle
    unit = None if middle is None else middle / DISPLAYED_MIDDLE
    return _completed_along("color", gbuffer, gbuffer.gray, gray, unit)


def _completed_along(
    name: str,
    gbuffer: GBuffer,
    known: NDArray[np.float32],
    completed: NDArray[np.float32],
    unit: float | None = None,
) -> NDArray[np.float32]:
    """A channel of colours along another one, (H, W), as traced and as completed; of values of any range, `unit` is
    what counts as 1."""
    if name not in gbuffer.layout.places:  # of what is white
        return np.repeat(completed[..., None], 3, -1)
    output = np.empty((3, *completed.shape), np.float32)
    channel = _core.Layout(name)
    _core.complete_along(gbuffer.layout.core, gbuffer.planes, channel, known, completed, unit, output)
    return np.moveaxis(output, 0, -1)


class Completer:
    """Completes a picture again and again, and recomputes only what may have changed since the last time.

    Those are the tiles of the G-buffer that differ, and what the network reaches around them: 28 pixels with "paper",
    192 with "filling", 345 with the others, whose coarsest levels see far, so that it pays only in large pictures.
    Where much has changed, everything is recomputed. The last G-buffer and its picture are kept, 24 bytes a pixel.
    Threads that share one take turns; a copy has a picture of its own.

    Parameters
    ----------
    model : str, path or Network
        As in `complete`.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> full = bob.trace(bob.happy_tree(), size=(240, 320))
    >>> completer = bob.Completer(model="paper")
    >>> for fraction in (0.05, 0.06):
    ...     part = full.sample(fraction, order="lattice")
    ...     assert (completer(part) == bob.complete(part, model="paper")).all()
    """

    def __init__(self, model: NetworkLike = "default") -> None:
        self._network = load_network(model)
        self._run = self._network.core.incremental()
        self._turns = Turns("Completer")

    def __call__(self, gbuffer: GBuffer) -> NDArray[np.float32]:
        """The same as `complete`, to the bit."""
        check_gbuffer(gbuffer)
        if gbuffer.mask.all():
            return gbuffer.gray.copy()
        with self._turns:
            return _completed(gbuffer, self._run, self._network.core.outputs)

    def __reduce__(self) -> tuple[Any, ...]:
        return Completer, (self._network,)


Run: TypeAlias = Callable[[_core.Layout, NDArray[np.float32], NDArray[np.float32]], None]


def _completed(gbuffer: GBuffer, run: Run, outputs: _core.Layout) -> NDArray[np.float32]:
    """The gray, of which not every pixel was traced."""
    shown = displayed(gbuffer)
    image = _predicted(shown, run)
    _core.interpolate_lattice(shown.layout.core, shown.planes, outputs, image[None])
    _core.keep_known(shown.layout.core, shown.planes, outputs, image[None])
    if (transfer := gbuffer.transfer) is not None:
        image = transfer.decode(image)
        np.copyto(image, gbuffer.gray, where=gbuffer.mask > 0)
    return image


def displayed(gbuffer: GBuffer) -> GBuffer:
    """The same, as networks know it: with all channels in the ranges that these have."""
    transfer = gbuffer.transfer
    return (
        gbuffer
        if transfer is None
        else GBuffer.from_stack(transfer.planes(gbuffer.planes, gbuffer.layout), gbuffer.layout)
    )


def check_gbuffer(gbuffer: object) -> None:
    """Raise InputTypeError unless it is one."""
    if not isinstance(gbuffer, GBuffer):
        hint = "bobrossnet.GBuffer(mask=, gray=, depth=, normal=) makes one of arrays"
        raise InputTypeError(f"gbuffer: expected a GBuffer, got {type(gbuffer).__name__}; {hint}")


def _predicted(gbuffer: GBuffer, run: Run) -> NDArray[np.float32]:
    image = np.empty(gbuffer.size, np.float32)
    try:
        run(gbuffer.layout.core, gbuffer.planes, image[None])
    except ValueError as error:
        raise InputError(f"gbuffer: {error}") from None
    return image


def load_network(model: NetworkLike) -> Network:
    """Return the network that `model` names; it stays loaded.

    Raises
    ------
    InputError
        If there is no such file, or what it holds can't be used.
    """
    if isinstance(model, Network):
        return model
    path = weights_path(model)
    try:
        modified = path.stat().st_mtime_ns
    except OSError as error:
        raise InputError(f"model: can't read {path}: {error.strerror}") from error
    except ValueError as error:  # a NUL in its name
        raise InputError(f"model: can't read {str(path)!a:.100}: {error}") from error
    return _load(path, modified)


@lru_cache(maxsize=8)
def _load(path: Path, modified: int) -> Network:
    """`modified` is part of the key, so that a rewritten file is loaded again."""
    metadata, tensors = read_weights(path)
    try:
        return make_network(metadata, tensors)
    except ValueError as error:
        raise InputError(f"{path.name}: {error}") from error


def make_network(metadata: Mapping[str, str], tensors: Mapping[str, NDArray[np.float32]]) -> Network:
    """The network of what `read_weights` returns. ValueError if that does not fit."""
    inputs, outputs = _core.Layout(metadata["inputs"]), _core.Layout(metadata["outputs"])
    return Network(_core.Network(metadata["network"], dict(tensors), inputs, outputs), (metadata, tensors))


def weights_path(model: str | os.PathLike[str]) -> Path:
    """Return the file that `model` names.

    Raises
    ------
    InputError
        If it is neither the name of shipped weights nor a .safetensors path.
    """
    path = find_weights(model)
    if path is None:
        names = ", ".join(shipped_names())
        got = brief(str(path_of(model, "model")), of_type=False)
        raise InputError(f"model: expected one of {names} or a .safetensors file, got {got}")
    return path


def shipped_names() -> list[str]:
    """Return the names of the shipped weights that complete pictures."""
    return sorted(file.stem for file in WEIGHTS.glob("*.safetensors") if file != UNCERTAINTY)


def find_weights(model: str | os.PathLike[str]) -> Path | None:
    """Return the file of shipped weights of that name, `model` itself if it is a .safetensors path, else None."""
    path = path_of(model, "model")
    shipped = {file.stem: file for file in WEIGHTS.glob("*.safetensors")}
    return shipped.get(str(path), path if path.suffix == ".safetensors" else None)
