"""Figures 4.1 to 4.3: diagrams of the network, from the network itself. Coordinates are inches from the lower left."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import torch
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Polygon, Rectangle

from bobrossnet.learn.figures.figure import Drawing, Sources
from bobrossnet.learn.figures.graph import INPUT, Layer, layers_of
from bobrossnet.learn.figures.style import BLACK, BLUE, GRAY, GREEN, ORANGE, PAGE, PURPLE, RED, SKY
from bobrossnet.learn.networks import Network, Paper
from bobrossnet.learn.networks.paper import shuffle

GROUP_COLORS = (BLUE, ORANGE, GREEN, PURPLE, SKY)  # repeated for more groups
UNGROUPED = "#999999"
SKIP = {"color": RED, "linestyle": (0, (1, 1.5)), "linewidth": 1.1}


def draw_unet(sources: Sources) -> Drawing:
    """Draw the U-Net: layers as boxes, lower for lower resolutions, with dotted skips."""
    layers = layers_of(Paper())
    scales = sorted({layer.scale for layer in layers})
    box, level, left, gap = (0.8, 0.44), 0.92, 0.5, 0.14  # inches
    height = level * len(scales) + 0.06
    levels = [1, *(layer.scale for layer in layers), 1]  # including the input and the output
    turns = sum(a != b for a, b in pairwise(levels))
    # Boxes of one level are in a row, others start below or above each other, so that all fit.
    turn = (PAGE - left - box[0] - 0.1 - (len(levels) - 1 - turns) * (box[0] + gap)) / max(turns, 1)
    steps = [turn if a != b else box[0] + gap for a, b in pairwise(levels)]
    x = (left + box[0] / 2 + np.cumsum([0, *steps])).tolist()
    y = {scale: height - 0.56 - i * level for i, scale in enumerate(scales)}
    places = {
        name: (x[i], y[levels[i]]) for i, name in enumerate([INPUT, *(layer.name for layer in layers), "picture"])
    }
    figure, axes = _canvas(PAGE, height)

    for scale in scales:
        axes.axhspan(y[scale] - 0.4, y[scale] + 0.48, color="#f3f3f3", linewidth=0)
        axes.text(0.06, y[scale], _resolution(scale), ha="left", va="center", color=GRAY)
    _box(axes, places[INPUT], box, INPUT, (f"{layers[0].inputs} channels",), "white")
    _box(axes, places["picture"], box, "picture", (f"{layers[-1].outputs} channel",), "white")
    reads = [*((layer.name, layer.reads) for layer in layers), ("picture", ((layers[-1].name, layers[-1].outputs),))]
    for name, sources_of in reads:
        (before, _), *skips = sources_of
        _follow(axes, places[before], places[name], box)
        for source, channels in skips:
            _skip(axes, places[source], places[name], box, channels)
    for i, layer in enumerate(layers):
        at, (next_x, next_y) = places[layer.name], (x[i + 2], y[levels[i + 2]])
        _box(axes, at, box, layer.name, (_channels(layer), f"{layer.parameters:,} parameters"), "#dcebf5")
        below = at[1] - box[1] / 2 - 0.03
        words = ", ".join(layer.after)
        if next_y == at[1]:
            axes.text(at[0], below, words, ha="center", va="top", fontsize=6)
        elif next_y < at[1]:
            axes.text(at[0] + 0.05, below, words, ha="left", va="top", fontsize=6)
        else:
            axes.text(next_x + 0.05, at[1], words, ha="left", va="center", fontsize=6)
        if layer.shuffled:
            axes.text(at[0], at[1] + box[1] / 2 + 0.03, "shuffle", ha="center", va="bottom", fontsize=6)
    total = sum(layer.parameters for layer in layers)
    kernel = layers[0].kernel
    return Drawing(
        figure,
        f"The network, a U-Net of {len(layers)} convolutions of {kernel} x {kernel} and {total:,} parameters. Boxes "
        "give channels in → out, arrows the operation that follows. H and W are the picture's height and width. "
        "Dotted: skips, which are appended to a layer's input.",
    )


def draw_full(sources: Sources) -> Drawing:
    """Draw the network's channels, with full convolutions."""
    figure, total = _draw_channels(Paper(groups=1))
    return Drawing(
        figure,
        f"The network with full convolutions, {total:,} parameters: each channel of a layer reads all channels of the "
        "one before. A cell is a channel, white if it comes by a skip (dotted). H is the picture's height.",
    )


def draw_grouped(sources: Sources) -> Drawing:
    """Draw the network's channels, coloured by group, and their shuffle."""
    network = Paper()
    figure, total = _draw_channels(network)
    return Drawing(
        figure,
        f"The network with grouped convolutions, {total:,} parameters. A cell is a channel in the colour of its group, "
        f"white if it comes by a skip (dotted). In the layers of {network.groups} groups a channel reads its own group "
        "only. Channels are shuffled between these layers, so that each group reads from all. H is the picture's "
        "height.",
    )


def _draw_channels(network: Network) -> tuple[Figure, int]:
    """Draw channels as stacks of cells, with convolutions as areas between; return also the number of parameters."""
    layers = layers_of(network)
    shuffles = [layer.shuffled and layer.groups > 1 for layer in layers]
    tallest, width = 2.0, 0.1  # inches, of a stack
    skips = sum(len(layer.reads) - 1 for layer in layers)
    bottom = 0.14 * skips + 0.12
    height = bottom + tallest + 0.62
    middle = bottom + tallest / 2
    figure, axes = _canvas(PAGE, height)
    left, shuffle_width = 0.14, 0.62
    step = (PAGE - 2 * left - width - sum(shuffles) * (shuffle_width + width)) / len(layers)

    def stack_edges(channels: int) -> np.ndarray:
        """Return the upper edge of each channel's cell, and the lower edge of the last."""
        cell = min(tallest / channels, 0.06)
        return middle + (channels / 2 - np.arange(channels + 1)) * cell

    x, edges, colors = left, stack_edges(layers[0].inputs), [UNGROUPED] * layers[0].inputs
    _cells(axes, x, width, edges, colors)
    _above(axes, x + width / 2, edges, f"{INPUT}\n{_height(layers[0].scale)}")
    ends = {INPUT: (x + width / 2, edges[-1])}
    waiting = []  # skips, drawn once all of their ends are known
    for layer, shuffled, after in zip(layers, shuffles, [*layers[1:], None], strict=True):
        if shuffled:
            order = shuffle(torch.arange(layer.inputs).view(1, -1, 1, 1), layer.groups).flatten().tolist()
            centers = (edges[1:] + edges[:-1]) / 2
            for to, source in enumerate(order):
                sides = (x + width, x + width + shuffle_width)
                axes.plot(sides, (centers[source], centers[to]), color=colors[source], linewidth=0.4)
            axes.text(x + width + shuffle_width / 2, height - 0.04, "shuffle", ha="center", va="top", fontsize=6)
            x += width + shuffle_width
            colors = [colors[source] for source in order]
            _cells(axes, x, width, edges, colors)

        # The skips' channels for the next layer follow below this layer's channels.
        next_edges = stack_edges(layer.outputs if after is None else after.inputs)
        made = next_edges[: layer.outputs + 1]
        for group in range(layer.groups):
            top, low = (edges[g * layer.inputs // layer.groups] for g in (group, group + 1))
            made_top, made_low = (made[g * layer.outputs // layer.groups] for g in (group, group + 1))
            corners = [(x + width, top), (x + step, made_top), (x + step, made_low), (x + width, low)]
            area = Polygon(corners, closed=True, facecolor=_group_color(layer, group), alpha=0.3, linewidth=0)
            axes.add_patch(area)
        grouping = f"{layer.groups} groups" if layer.groups > 1 else "full"
        words = "\n".join((layer.name, _channels(layer), grouping, f"{layer.parameters:,} parameters"))
        axes.text(x + (width + step) / 2, height - 0.04, words, ha="center", va="top", fontsize=6)

        x += step
        colors = [_group_color(layer, i * layer.groups // layer.outputs) for i in range(layer.outputs)]
        _cells(axes, x, width, made, colors)
        ends[layer.name] = (x + width / 2, made[-1])
        first = layer.outputs
        for name, channels in after.reads[1:] if after is not None else ():
            brought = next_edges[first : first + channels + 1]
            _cells(axes, x, width, brought, ["white"] * channels)
            first += channels
            waiting.append((ends[name], (x + width / 2, brought[-1])))
        _above(axes, x + width / 2, made, "picture\nH" if after is None else _height(after.scale))
        edges = next_edges
    waiting.sort(key=lambda skip: skip[0][0])  # the widest lowest
    for i, (start, end) in enumerate(waiting):
        low = 0.08 + 0.14 * i
        _line(axes, [start, (start[0], low), (end[0], low), end], **SKIP)
    total = sum(layer.parameters for layer in layers)
    axes.text(PAGE - 0.08, 0.08, f"{total:,}\nparameters", ha="right", va="bottom", weight="bold")
    return figure, total


def _canvas(width: float, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(width, height))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_xlim(0, width)
    axes.set_ylim(0, height)
    axes.set_axis_off()
    return figure, axes


def _box(
    axes: Axes, center: tuple[float, float], size: tuple[float, float], name: str, lines: tuple[str, ...], color: str
) -> None:
    corner = (center[0] - size[0] / 2, center[1] - size[1] / 2)
    axes.add_patch(
        FancyBboxPatch(
            corner, *size, boxstyle="round,pad=0,rounding_size=0.04", facecolor=color, edgecolor=BLACK, linewidth=0.7
        )
    )
    top = center[1] + 0.06 * len(lines)
    axes.text(center[0], top, name, ha="center", va="center", weight="bold")
    for i, line in enumerate(lines, 1):
        axes.text(center[0], top - 0.12 * i, line, ha="center", va="center", fontsize=6)


def _follow(axes: Axes, start: tuple[float, float], end: tuple[float, float], box: tuple[float, float]) -> None:
    """Draw a connection to the next layer: down and then right, or right and then up."""
    if start[1] > end[1]:
        _line(axes, [(start[0], start[1] - box[1] / 2), (start[0], end[1]), (end[0] - box[0] / 2, end[1])])
    elif start[1] < end[1]:
        _line(axes, [(start[0] + box[0] / 2, start[1]), (end[0], start[1]), (end[0], end[1] - box[1] / 2)])
    else:
        _line(axes, [(start[0] + box[0] / 2, start[1]), (end[0] - box[0] / 2, end[1])])


def _skip(
    axes: Axes, start: tuple[float, float], end: tuple[float, float], box: tuple[float, float], channels: int
) -> None:
    """Draw a skip above the boxes of its level, into its layer from above."""
    over = end[1] + box[1] / 2 + 0.2
    begin = min(over, start[1] + box[1] / 2) if start[1] > end[1] else start[1] + box[1] / 2
    _line(axes, [(start[0], begin), (start[0], over), (end[0], over), (end[0], end[1] + box[1] / 2)], **SKIP)
    middle = (start[0] + end[0]) / 2
    axes.text(middle, over + 0.02, f"skip, {channels} channels", ha="center", va="bottom", fontsize=6, color=RED)


def _line(axes: Axes, points: list[tuple[float, float]], **style: object) -> None:
    """Draw a polyline with an arrowhead at its end."""
    look = {"color": BLACK, "linewidth": 0.7, **style}
    axes.plot(*zip(*points, strict=True), **look)  # type: ignore[arg-type]
    head = {"arrowstyle": "-|>,head_width=0.12,head_length=0.25", "color": look["color"], "linewidth": 0.7}
    (x, y), (end_x, end_y) = points[-2:]
    length = float(np.hypot(end_x - x, end_y - y))
    before = (end_x - 0.02 * (end_x - x) / length, end_y - 0.02 * (end_y - y) / length)
    axes.annotate("", points[-1], before, arrowprops={**head, "shrinkA": 0, "shrinkB": 0})


def _cells(axes: Axes, x: float, width: float, edges: np.ndarray, colors: list[str]) -> None:
    for top, low, color in zip(edges, edges[1:], colors, strict=False):
        edge = RED if color == "white" else "white"
        axes.add_patch(Rectangle((x, low), width, top - low, facecolor=color, edgecolor=edge, linewidth=0.3))


def _above(axes: Axes, x: float, edges: np.ndarray, text: str) -> None:
    axes.text(x, edges[0] + 0.03, text, ha="center", va="bottom", color=GRAY, fontsize=6)


def _group_color(layer: Layer, group: int) -> str:
    return GROUP_COLORS[group % len(GROUP_COLORS)] if layer.groups > 1 else UNGROUPED


def _channels(layer: Layer) -> str:
    return f"{layer.inputs} → {layer.outputs}"


def _height(scale: int) -> str:
    return "H" if scale == 1 else f"H/{scale}"


def _resolution(scale: int) -> str:
    return "H × W" if scale == 1 else f"H/{scale} ×\nW/{scale}"
