"""Measure the errors and the flicker of completed pictures by network and pixel order, and write docs/quality.md.

    python docs/quality.py [--scale small] [--shapes FOLDER] [--limit N] [--weights NAME] [--work DIR]

DIR keeps the results. A network is measured again only if its weights change, a pixel order only if its pixels change.
The small scale takes a minute with a few shapes and writes its page to DIR, not to docs/.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from work import MODELS, ROOT, Work

import bobrossnet as bob
from bobrossnet.completion.filling import FILLINGS
from bobrossnet.completion.weights import UNCERTAINTY, weights_path
from bobrossnet.learn.evaluation.costs import Cost, cost_table, measure_costs
from bobrossnet.learn.evaluation.evaluate import FRACTIONS, evaluate_scenes
from bobrossnet.learn.evaluation.known_error import KnownError, measure_known_error
from bobrossnet.learn.evaluation.methods import kept
from bobrossnet.learn.evaluation.runs import Run, label
from bobrossnet.learn.evaluation.scenes import Scenes, own_scenes, scenes_of_folder, with_colors
from bobrossnet.learn.evaluation.scores import METRICS, Evaluation
from bobrossnet.learn.evaluation.stability import LEVELS, Stability, measure_stability
from bobrossnet.learn.figures.style import BLUE, GREEN, ORANGE, PAGE, RED, new_figure, save, style
from bobrossnet.picture.files import side_by_side, to_8_bit, traced_on_green, write_picture
from bobrossnet.picture.order import ADAPTIVE, DEFAULT_ORDER, FIXED_ORDERS
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.tables import plus_minus, table

UNIFORM = "uniform"  # the report's order
LATTICE = "lattice"  # the best order that does not depend on the picture
ORDERS = (*FIXED_ORDERS, ADAPTIVE)
REPORT = "paper"  # the report's network
LINEAR = "delaunay-linear"
PACKAGES = ("bobrossnet", "numpy", "scipy", "torch")
STEADY_FILLINGS = (LINEAR, "pull-push")
SHOWN = (0.01, 0.02, 0.05, 0.1)  # shares of the pixels in the pictures
SHOWN_OF_ORDERS = (0.02, 0.05, 0.1)
SHOWN_OF_FAILURES = (0.05, 0.25)
COST_AT = 0.05  # share of the pixels for comparing quality with milliseconds
PANELS = (
    f"From the left: the pixels traced in order {DEFAULT_ORDER}; {LINEAR}, {REPORT} (the report's network) and ours, "
    f"from the same number of {UNIFORM} pixels; ours from the {DEFAULT_ORDER} ones; all pixels. Numbers are SSIM."
)
CREDITS = "The world of blocks is *Lost Empire* from Morgan McGuire's Computer Graphics Archive, CC BY 3.0."
ERRORS = {"ssim": "1 - SSIM", "psnr": "mean squared error", "flip": "FLIP"}

BY_NEED = {
    256: {0.02: -0.28, 0.05: -0.42, 0.1: -0.62, 0.25: -0.87},
    512: {0.02: -0.40, 0.05: -0.62, 0.1: -0.86, 0.25: -0.98},
}
"""Target changes of 1 - SSIM from the lattice to the adaptive order, by the size of pictures and the share of traced
pixels."""
WORSE = 0.005  # loss of SSIM above which a single picture is counted
FOVS = (0, 35, 60)  # fields of view in degrees; 0 is orthographic
GOOD = (0.95, 0.99)  # SSIM for which the share of pixels is given

KNOWN_BELOW, KNOWN_CLOSE = 0.9, 0.8
"""Target shares of pictures with a true error below the expected one, and within a factor of two of it."""

IN_COLOR = -0.2
"""Target change of FLIP from linear filling of each colour component, at every share of `SHOWN`."""

AT_MOST_UNIFORM = dict.fromkeys(SHOWN, -0.15) | dict.fromkeys((0.25, 0.5, 0.75), 0.0)
AT_MOST_LATTICE = dict.fromkeys(SHOWN, -0.3) | {0.25: -0.2}
"""Target changes of 1 - SSIM from linear filling in order uniform, by the share of traced pixels."""


class Subject(NamedTuple):
    """A shape to draw. The licences of all of them permit that."""

    file: str
    what: str
    camera: bob.Camera
    upright: bool = False  # turned so that y is up


SUBJECTS = (
    Subject("scans/nefertiti.ply", "scan", bob.Camera(azimuth=240, elevation=8), True),
    Subject("mechanical/fixed_ring_gear.ply", "CAD part", bob.Camera(azimuth=30, elevation=40)),
    Subject("furniture_household/acoustic_guitar.ply", "furniture", bob.Camera(azimuth=240, elevation=20), True),
    Subject("architecture/ferris_wheel.ply", "thin parts", bob.Camera(azimuth=60, elevation=15), True),
    Subject("nurbs/newell_teapot.bpt", "NURBS", bob.Camera(azimuth=30, elevation=25)),
)
THIN = (
    "animals/grey_snapper_fish.ply",
    "anatomy_bio/coronavirus.ply",
    "architecture/ferris_wheel.ply",
    "architecture/wind_turbine.ply",
    "furniture_household/acoustic_guitar.ply",
    "furniture_household/wire_chair.ply",
    "scans/arming_sword.ply",
    "scans/stanford_drill_bit.ply",
    "vehicles/pirate_ship.ply",
)
"""Shapes with parts so thin that the first pixels may miss them."""

FAILURES = (
    Subject("anatomy_bio/coronavirus.ply", "thin spikes", bob.Camera(azimuth=30, elevation=20)),
    Subject("implicit/prospero.vm", "text", bob.Camera(azimuth=270, elevation=90)),
    Subject(
        "architecture/lost_empire.ply", "a shape with more faces than the picture has pixels", bob.Camera(30, 30), True
    ),
)


@dataclass(frozen=True)
class Scale:
    """Sizes and counts of the measurements."""

    real: int | None = None  # maximum of files of real shapes; None: all
    own: int = 64  # shapes made by the package
    steady_real: int = 16  # real shapes for stability
    steady_own: int = 8
    size: int = 256  # of measured pictures
    large: int = 512  # of pictures for the second comparison of orders
    large_real: int = 96  # shapes in these pictures
    perspective_real: int = 20  # shapes in perspective
    colored: int = 24  # coloured shapes of each kind
    known_real: int = 96  # shapes for comparing expected and true errors
    panel: int = 176  # size of the panels in the document
    fractions: tuple[float, ...] = FRACTIONS
    frames: int = 20
    runs: int = 11  # timed runs


SCALES = {"full": Scale(), "small": Scale(3, 2, 1, 1, 48, 64, 2, 2, 2, 2, 48, (0.01, 0.05, 0.25), 3, 1)}


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scale", choices=SCALES, default="full")
    parser.add_argument("--shapes", type=Path, default=MODELS, help="folder of real shapes to measure on as well")
    parser.add_argument("--limit", type=int, help="how many real shapes at most, spread over the folder")
    parser.add_argument("--weights", default="default", help="name of shipped weights, or a .safetensors file")
    parser.add_argument("--work", type=Path, help="folder for what was measured (default: out/quality, -small)")
    options = parser.parse_args(arguments)
    small = options.scale == "small"
    scale = SCALES[options.scale]
    if options.limit is not None:
        scale = replace(scale, real=options.limit)
    work = Work(options.work or ROOT / "out" / ("quality-small" if small else "quality"))
    docs = work.folder if small else ROOT / "docs"
    pictures = docs / "quality"
    pictures.mkdir(parents=True, exist_ok=True)
    shapes = options.shapes if options.shapes.is_dir() else None
    ours = kept(Path(options.weights).stem)

    with work.timed("quality"):
        own = measure_quality(work.folder, "own", own_scenes(scale.own), options.weights, scale)
        real = shapes and measure_quality(
            work.folder, "real", scenes_of_folder(shapes, scale.real), options.weights, scale
        )
        large = shapes and measure_orders(
            work.folder, scenes_of_folder(shapes, scale.large_real), options.weights, scale
        )
    with work.timed("perspective"):
        scenes = scenes_of_folder(shapes, scale.perspective_real) if shapes else own_scenes(scale.own)
        by_fov = measure_perspective(work.folder, scenes, options.weights, scale)
    with work.timed("colour"):
        in_color = measure_colors(work.folder, "own", own_scenes(scale.colored, colored=True), options.weights, scale)
        colored = with_colors(scenes_of_folder(shapes)) if shapes else {}
        of_files = colored and measure_colors(work.folder, "real", colored, options.weights, scale)
    with work.timed("known errors"):
        known = known_errors(
            work.folder,
            scenes_of_folder(shapes, scale.known_real) if shapes else own_scenes(scale.own),
            options.weights,
            scale,
        )
    with work.timed("stability"):
        steady = {
            "our own shapes": steadiness(work.folder, "own", own_scenes(scale.steady_own), options.weights, scale)
        }
        if shapes:
            scenes = scenes_of_folder(shapes, scale.steady_real)
            steady = {"real shapes": steadiness(work.folder, "real", scenes, options.weights, scale)} | steady
    with work.timed("costs and pictures"):
        costs = measure_costs([options.weights, REPORT], runs=scale.runs)
        panels = []
        if shapes:
            draw = partial(draw_sheets, pictures, shapes, scale.panel)
            panels += picture_sections(partial(draw, partial(panels_of_methods, options.weights), ""), scale.panel)
            panels += order_sections(partial(draw, partial(panels_of_orders, options.weights), "-orders"), scale.panel)
        for name, result in (("real", real), ("own", own)):
            if result:
                draw_curves(pictures / f"curves-{name}", result, ours)
        draw_costs(pictures / "costs", real or own, costs)
    parts = [
        "# How good the pictures are",
        "Networks and fillings on the same pictures, in each pixel order and at every share of traced pixels. "
        f"`make quality{' SCALE=small' * small}` wrote this page; [tried.md](tried.md) lists the experiments.",
        "- **Shapes**: the real ones were never trained on; our own, made by the package, are in no data set.",
        "- **Completed pictures** keep the traced pixels. Where traced pixels of the lattice agree, `complete` "
        "interpolates between them.",
        f"- **Rows** are named by method and pixel order. The default order is {DEFAULT_ORDER}.",
        "- **Intervals** are 95 % confidence intervals for other shapes of the same kind.",
        *work.circumstances(PACKAGES),
        *targets(real or own, next(iter(steady)), next(iter(steady.values())), ours),
        *(quality("Real shapes", "real", real, ours) if real else []),
        *(placed_by_need(real, large, scale, ours) if real and large else []),
        *in_perspective(by_fov, scale, ours),
        *in_colors({"real shapes that have colours": of_files, "our own shapes": in_color}, scale, ours),
        "## Known error",
        known_error_met(known),
        f"{len(known.shapes)} pictures of {scale.size}x{scale.size} pixels were traced in steps of 1 % until the "
        "expected error fell below a limit. The expected error is `frame.error`, the mean of `uncertainty`, in gray "
        f"from 0 to 1. The targets: in {100 * KNOWN_BELOW:g} % of the pictures the true error is below the expected "
        f"one, and in {100 * KNOWN_CLOSE:g} % both are within a factor of two.",
        known.table(),
        *quality("Our own shapes", "own", own, ours),
        "## What it costs",
        "The built-in scene from 5 % of its pixels, in the core; medians of alternating runs.",
        cost_table(costs),
        "![milliseconds against SSIM](quality/costs.png)",
        *panels,
        "## Temporal stability",
        *(part for name, result in steady.items() for part in (f"### On {name}", *steadiness_of(result, ours))),
    ]
    (docs / "quality.md").write_text("\n\n".join(parts) + "\n", "utf-8")
    print(f"wrote {docs / 'quality.md'}")


# ---- Measuring -------------------------------------------------------------------------------------------


def measure_quality(folder: Path, name: str, scenes: Scenes, weights: str, scale: Scale) -> Evaluation:
    """Measure the networks and linear filling in three orders, the other fillings in one."""
    measure = partial(evaluate_scenes, scenes, size=(scale.size, scale.size), fractions=scale.fractions)
    recall = partial(recalled, Evaluation, folder, f"quality-{name}", scenes)
    network = partial(measure, fillings=[], repainting=False)
    fill = partial(measure, [])
    others = [filling for filling in FILLINGS if filling != LINEAR]
    parts = [
        recall(*content(weights), ORDERS, partial(network, [weights])),
        recall(*content(REPORT), ORDERS, partial(network, [REPORT])),
        recall(LINEAR, "", ORDERS, partial(fill, fillings=[LINEAR])),
        recall("fillings", " ".join(others), [UNIFORM], partial(fill, fillings=others)),
    ]
    return reduce(Evaluation.beside, parts)


def measure_orders(folder: Path, scenes: Scenes, weights: str, scale: Scale) -> Evaluation:
    """Measure the network with two orders in larger pictures."""
    recall = partial(recalled, Evaluation, folder, f"quality-{scale.large}", scenes)
    fractions = [fraction for fraction in scale.fractions if fraction <= max(BY_NEED[512])]
    measure = partial(evaluate_scenes, scenes, [weights], size=(scale.large, scale.large), fractions=fractions)
    result: Evaluation = recall(*content(weights), (LATTICE, ADAPTIVE), partial(measure, fillings=[], repainting=False))
    return result


def measure_perspective(folder: Path, scenes: Scenes, weights: str, scale: Scale) -> dict[float, Evaluation]:
    """Measure the network with two orders in pictures of each field of view."""
    fractions = [fraction for fraction in scale.fractions if fraction <= max(SHOWN)]
    size = (scale.size, scale.size)
    results = {}
    for fov in FOVS:
        recall = partial(recalled, Evaluation, folder, f"perspective-{fov}", scenes)
        measure = partial(evaluate_scenes, scenes, [weights], size=size, fractions=fractions, fov=fov)
        measure = partial(measure, fillings=[], repainting=False)
        results[fov] = recall(*content(weights), (LATTICE, ADAPTIVE), measure)
    return results


def measure_colors(folder: Path, name: str, scenes: Scenes, weights: str, scale: Scale) -> Evaluation:
    """Measure the network in colour, and linear filling of each component of the same pixels and of uniform ones."""
    recall = partial(recalled, Evaluation, folder, f"color-{name}", scenes)
    fractions = [fraction for fraction in scale.fractions if fraction <= max(SHOWN)]
    measure = partial(evaluate_scenes, scenes, size=(scale.size, scale.size), fractions=fractions, channel="color")
    measure = partial(measure, repainting=False)
    parts = [
        recall(*content(weights), [ADAPTIVE], partial(measure, [weights], fillings=[])),
        recall(LINEAR, "", (ADAPTIVE, UNIFORM), partial(measure, [], fillings=[LINEAR])),
    ]
    return reduce(Evaluation.beside, parts)


def known_errors(folder: Path, scenes: Scenes, weights: str, scale: Scale) -> KnownError:
    """Compare expected and true errors of the network's pictures in three orders."""
    name, version = content(weights)
    version += sha256(UNCERTAINTY.read_bytes()).hexdigest()
    measure = partial(measure_known_error, scenes, weights, size=(scale.size, scale.size))
    result: KnownError = recalled(KnownError, folder, "known-error", scenes, name, version, ORDERS, measure)
    return result


def steadiness(folder: Path, name: str, scenes: Scenes, weights: str, scale: Scale) -> Stability:
    """Measure the flicker of the network, of the report's and of fillings, with three orders."""
    measure = partial(measure_stability, scenes, frames=scale.frames, repainting=False, size=(scale.size // 2,) * 2)
    recall = partial(recalled, Stability, folder, f"stability-{name}", scenes)
    parts = [
        recall(*content(weights), ORDERS, partial(measure, [weights], fillings=[])),
        recall(*content(REPORT), ORDERS, partial(measure, [REPORT], fillings=[])),
        recall("fillings", " ".join(STEADY_FILLINGS), ORDERS, partial(measure, [], fillings=STEADY_FILLINGS)),
    ]
    return reduce(Stability.beside, parts)


def recalled(
    kind: Any,
    folder: Path,
    name: str,
    scenes: Scenes,
    method: str,
    version: str,
    orders: Sequence[str],
    measure: Callable[..., Any],
) -> Any:
    """Return the result of `measure` for some orders, from files where it was measured before.

    Parameters
    ----------
    kind : Evaluation or Stability
    folder, name : of the files with results
    scenes : to measure on
    method, version : name of the methods, and a string that changes with their weights
    orders : pixel orders
    measure : called with the orders that have no file
    """
    files = {}
    picture = bob.trace(bob.happy_tree(), size=(96, 160))
    for order in orders:
        pixels = b"".join(picture.sample(share, order=order, seed=1).mask.tobytes() for share in SHOWN)
        key = sha256(b"\n".join([version.encode(), pixels, *map(str.encode, scenes)])).hexdigest()[:12]
        files[order] = folder / f"{name}-{method}-{order}-{key}.csv"
    missing = [order for order, file in files.items() if not file.exists()]
    if missing:
        result = measure(orders=missing)
        for order in missing:
            write_whole(files[order], result.of_order(order).csv().encode())
    return reduce(kind.beside, [kind.from_csv(file.read_text("utf-8")) for file in files.values()])


def content(weights: str) -> tuple[str, str]:
    """Return the name of weights, as used in results, and the hash of their file."""
    return Path(weights).stem, sha256(weights_path(weights).read_bytes()).hexdigest()


# ---- Text ------------------------------------------------------------------------------------------------


def targets(result: Evaluation, on: str, steady: Stability, ours: str) -> list[str]:
    """Return the tables of targets, with a verdict for each."""
    report, stages = kept(REPORT), [fraction for fraction in result.fractions if fraction < 1]
    verdicts = []

    def met(change: Sequence[float], limit: float) -> str:
        middle, half = change
        verdicts.append("yes" if middle + half <= limit else "maybe" if middle <= limit else "no")
        return verdicts[-1]

    rows = []
    for order, limits in ((UNIFORM, AT_MOST_UNIFORM), (LATTICE, AT_MOST_LATTICE)):
        changes = result.change_of_error((ours, order), (LINEAR, UNIFORM)).tolist()
        for stage, change in zip(result.fractions, changes, strict=True):
            if stage in limits:
                limit = f"{100 * limits[stage]:+.0f}" if limits[stage] else "below 0"
                middle, half = (100 * value for value in change)
                low_to_high = f"{middle - half:+.1f} .. {middle + half:+.1f}"
                verdict = met(change, limits[stage])
                rows.append([f"{ours}, {order}", percent(stage), limit, f"{middle:+.1f}", low_to_high, verdict])

    def cells(changes: Sequence[Sequence[float]]) -> list[str]:
        return [f"{plus_minus(100 * change[0], 100 * change[1], 1)} {met(change, 0)}" for change in changes]

    beside_report, beside_flicker = [], []
    for order in ORDERS:
        for metric, error in ERRORS.items():
            changes = result.change_of_error((ours, order), (report, order), metric).tolist()
            beside_report.append([f"{error}, {order}", *cells(changes[: len(stages)])])
        for rival in (report, LINEAR):
            changes = steady.change_of_flicker((ours, order), (rival, order)).tolist()
            beside_flicker.append([f"from {rival}, {order}", *cells(changes)])
    orbits = [f"orbit at {percent(fraction)}" for fraction in steady.orbit_fractions]
    return [
        "## Targets",
        f"Changes of errors in percent, on {on}. {verdicts.count('yes')} of {len(verdicts)} are met.",
        '"Yes" means that the whole interval meets the target, "maybe" that only the mean does.',
        f"Change of 1 - SSIM from {LINEAR} with order {UNIFORM}:",
        table(["method, order", "traced", "target, %", "measured, %", "interval", "met"], rows),
        f"Change from {report} with the same order; the target is below 0:",
        table(["change of", *map(percent, stages)], beside_report),
        "Change of flicker; the target is below 0:",
        table(["change of flicker", "converging", *orbits], beside_flicker),
    ]


def quality(title: str, name: str, result: Evaluation, ours: str) -> list[str]:
    """Return all scores of a set of pictures."""
    compared = [(ours, order) for order in ORDERS]

    def ssim_at(run: Run) -> str:
        return f"{result.mean(run)[result.fractions.index(COST_AT)]:.4f}"

    return [
        f"## {title}",
        f"{len(result.pictures)} pictures of {len(set(result.shapes))} shapes. At {percent(COST_AT)} of the pixels, "
        f"{label(result.scores, (ours, ADAPTIVE))} has an SSIM of {ssim_at((ours, ADAPTIVE))}, and "
        f"{label(result.scores, (LINEAR, UNIFORM))}, the usual method, {ssim_at((LINEAR, UNIFORM))}.",
        f"![SSIM by the share of traced pixels, and 1 - SSIM relative to {LINEAR}](quality/curves-{name}.png)",
        *(part for metric in METRICS for part in (f"{METRICS[metric].label}:", result.table(metric))),
        *(
            part
            for run in compared
            for part in (
                f"Gain of {label(result.scores, run)} in SSIM:",
                result.gain_table(run),
                f"1 - SSIM of {label(result.scores, run)}, change in percent:",
                result.error_table(run),
            )
        ),
    ]


def placed_by_need(real: Evaluation, large: Evaluation, scale: Scale, ours: str) -> list[str]:
    """Return the gain of adaptive pixels: on all real shapes, on shapes with thin parts, in large pictures."""
    thin = [shape for shape in THIN if shape in real.shapes]
    change = 100 * real.change_of_error((ours, ADAPTIVE), (ours, LATTICE))[real.fractions.index(COST_AT), 0]
    return [
        "## Adaptive pixels",
        f"At {percent(COST_AT)} of the pixels, 1 - SSIM changes by {change:.1f} % from order {LATTICE} to {ADAPTIVE}.",
        f"Each table has the change of errors of {ours} in percent, the target for 1 - SSIM, and the share of "
        f"pictures that lose more than {WORSE:g} of SSIM.",
        f"All real shapes, {scale.size}x{scale.size}:",
        by_need(real, ours, scale.size),
        *([f"{len(thin)} shapes with thin parts:", by_need(real.of_shapes(thin), ours, scale.size)] if thin else []),
        f"{len(large.pictures)} real shapes, {scale.large}x{scale.large}:",
        by_need(large, ours, scale.large),
        f"Pixels to trace for a mean SSIM of {' and '.join(map(str, GOOD))}, {scale.size}x{scale.size}, interpolated "
        "between the measured shares:",
        table(
            ["method, order", *(f"{good:g}" for good in GOOD)],
            [
                [label(real.scores, run), *(rays_to(real, run, good) for good in GOOD)]
                for run in real.scores
                if is_kept_or_filled(run, ours)
            ],
        ),
    ]


def by_need(result: Evaluation, ours: str, size: int) -> str:
    """Return the changes from the lattice as a table."""
    stages, limits = [fraction for fraction in result.fractions if fraction < 1], BY_NEED.get(size, {})
    adaptive, lattice = (ours, ADAPTIVE), (ours, LATTICE)
    rows = []
    for metric, error in ERRORS.items():
        changes = 100 * result.change_of_error(adaptive, lattice, metric)[: len(stages)]
        rows.append([error, *(plus_minus(middle, half, 1) for middle, half in changes.tolist())])
    asked = [f"{100 * limits[stage]:+.0f}" if stage in limits else "" for stage in stages]
    ssim = list(METRICS).index("ssim")
    lost = result.scores[lattice][..., ssim] - result.scores[adaptive][..., ssim]
    worse = [f"{100 * share:.1f} %" for share in (lost > WORSE).mean(0)[: len(stages)].tolist()]
    targets = [["target", *asked]] if any(asked) else []
    return table(["change of", *map(percent, stages)], [*rows, *targets, [f"worse by {WORSE:g}", *worse]])


def in_perspective(by_fov: Mapping[float, Evaluation], scale: Scale, ours: str) -> list[str]:
    """Compare pictures in perspective with orthographic ones."""
    first = next(iter(by_fov.values()))
    rows = [
        [
            label(result.scores, run),
            f"{fov:g}°" if fov else "orthographic",
            *(f"{ssim:.4f}" for ssim in result.mean(run)),
        ]
        for run in first.scores
        for fov, result in by_fov.items()
    ]
    return [
        "## Perspective",
        "The wider the field of view, the higher the SSIM, in part because a shape fills less of the picture.",
        f"Mean SSIM of {len(first.pictures)} real shapes, {scale.size}x{scale.size}, from the same sides in each "
        "field of view. The network was trained on orthographic and perspective pictures.",
        table(["method, order", "fov", *map(percent, first.fractions)], rows),
    ]


def in_colors(results: Mapping[str, Evaluation | Mapping[str, Any]], scale: Scale, ours: str) -> list[str]:
    """Compare completed colours with linear filling of each component, and with the target."""
    parts = [
        "## Colour",
        f"Pictures in colour, {scale.size}x{scale.size}: FLIP of sRGB, SSIM of the luminance and PSNR of the three "
        f"components. {LINEAR} interpolates each component over the triangles of the same pixels, or of the same "
        f"number in order {UNIFORM}. The target is a FLIP lower by {-100 * IN_COLOR:g} % at every share.",
    ]
    for what, result in results.items():
        if not isinstance(result, Evaluation):  # without coloured files there is no result
            continue
        rows, verdicts = [], []
        for rival in ((LINEAR, UNIFORM), (LINEAR, ADAPTIVE)):
            changes = result.change_of_error((ours, ADAPTIVE), rival, "flip")
            met = [
                "yes" if sum(change) <= IN_COLOR else "no" if change[0] > IN_COLOR else "maybe" for change in changes
            ]
            verdicts += met
            cells = [f"{plus_minus(*(100 * change), 1)} {each}" for change, each in zip(changes, met, strict=True)]
            rows.append([f"from {label(result.scores, rival)}", *cells])
        parts += [f"{len(result.pictures)} pictures of {what}."]
        parts += [part for metric in METRICS for part in (f"{METRICS[metric].label}:", result.table(metric))]
        parts += [
            f"FLIP of {label(result.scores, (ours, ADAPTIVE))}, change in percent; {verdicts.count('yes')} of "
            f"{len(verdicts)} meet the target:",
            table(["", *map(percent, result.fractions)], rows),
        ]
    return parts


def known_error_met(known: KnownError) -> str:
    """Return how often both targets of the expected error are met."""
    met = [below >= KNOWN_BELOW and close >= KNOWN_CLOSE for *_, (_, below, close) in known.shares()]
    return f"Both targets are met in {sum(met)} of {len(met)} rows."


def is_kept_or_filled(run: Run, ours: str) -> bool:
    """Return whether the needed pixels of a run are compared: of networks and linear filling, in any order."""
    return run[1] in ORDERS and run[0] in (ours, kept(REPORT), LINEAR)


def rays_to(result: Evaluation, run: Run, good: float) -> str:
    """Return the share of pixels for a mean SSIM of `good`, by linear interpolation of its logarithm."""
    means = np.maximum.accumulate(result.mean(run))
    if means[0] >= good:
        return f"below {percent(result.fractions[0])}"
    share = float(np.exp(np.interp(good, means, np.log(result.fractions))))
    return f"{100 * share:.3g} %"


def steadiness_of(result: Stability, ours: str) -> list[str]:
    """Return the flicker of all runs, and the changes of ours from its rivals."""
    share, best, usual = result.orbit_fractions[0], (ours, ADAPTIVE), (LINEAR, UNIFORM)
    least, most = (f"{LEVELS * result.orbit[run].mean(0)[0]:.2f}" for run in (best, usual))
    conclusion = f"On orbits at {percent(share)}, {label(result.frames, best)} flickers by {least} gray levels and "
    parts = [f"{conclusion}{label(result.frames, usual)} by {most}.", result.caption(), result.table()]
    for order in ORDERS:
        parts += [
            f"Flicker of {label(result.frames, (ours, order))}, change in percent:",
            result.change_table((ours, order)),
        ]
    return parts


def percent(fraction: float) -> str:
    return f"{100 * fraction:g} %"


# ---- Pictures --------------------------------------------------------------------------------------------


def looks(result: Evaluation, ours: str) -> dict[Run, dict[str, Any]]:
    """Return the line styles of runs, in the order of the legend."""
    shown = {
        (ours, ADAPTIVE): {"color": BLUE, "linestyle": "-", "marker": "s"},
        (ours, LATTICE): {"color": BLUE, "linestyle": "-", "marker": "o"},
        (ours, UNIFORM): {"color": BLUE, "linestyle": ":", "marker": "o", "markerfacecolor": "white"},
        (kept(REPORT), LATTICE): {"color": RED, "linestyle": "-"},
        (kept(REPORT), UNIFORM): {"color": RED, "linestyle": ":"},
        (LINEAR, LATTICE): {"color": ORANGE, "linestyle": "-"},
        (LINEAR, UNIFORM): {"color": ORANGE, "linestyle": ":"},
        ("pull-push", UNIFORM): {"color": GREEN, "linestyle": ":"},
    }
    return {run: look for run, look in shown.items() if run in result.scores}


def draw_curves(path: Path, result: Evaluation, ours: str) -> None:
    """Draw SSIM by the share of traced pixels, and 1 - SSIM relative to linear filling with its intervals."""
    stages = [fraction for fraction in result.fractions if fraction < 1]
    ticks = [100 * stage for stage in stages]
    with style():
        figure = new_figure(PAGE, 3.2)
        means, changes = figure.subplots(1, 2)
        for i, (run, look) in enumerate(looks(result, ours).items()):
            means.plot(ticks, result.mean(run)[: len(stages)], label=label(result.scores, run), **look)
            middle, half = 100 * result.change_of_error(run, (LINEAR, UNIFORM))[: len(stages)].T
            beside = np.multiply(ticks, 1.015 ** (i - 4))  # keeps the intervals apart
            changes.errorbar(beside, middle, np.nan_to_num(half), elinewidth=0.6, capsize=1.5, **look)
        for axes in (means, changes):
            axes.set(xscale="log", xlabel="pixels traced, %")
            axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
            axes.set_xticks([], minor=True)
            axes.grid()
        means.set_ylabel("mean SSIM")
        means.legend()
        changes.set_ylabel(f"change of 1 - SSIM from {LINEAR}, {UNIFORM}, in %")
        shown = [100 * result.change_of_error(run, (LINEAR, UNIFORM))[: len(stages), 0] for run in looks(result, ours)]
        changes.set_ylim(1.15 * min(-5, np.min(shown)), 60)  # much worse methods leave the axes at the top
    save(figure, path, "Mean SSIM by the share of traced pixels, and the change of 1 - SSIM from linear filling.")


def draw_costs(path: Path, result: Evaluation, costs: Mapping[str, Cost]) -> None:
    """Draw SSIM at one share of traced pixels against milliseconds."""
    at = result.fractions.index(COST_AT)
    with style():
        figure = new_figure(PAGE / 1.6, 2.8)
        axes = figure.subplots()
        for method, cost in costs.items():
            means = [result.mean((method, order))[at] for order in ORDERS if (method, order) in result.scores]
            axes.plot([cost.milliseconds] * len(means), means, color=BLUE, linewidth=0.6)
            for mean, order, face in zip(means, ORDERS, ("white", BLUE, ORANGE), strict=False):
                name = f"order {order}" if method == LINEAR else None
                axes.plot(cost.milliseconds, mean, "o", color=BLUE, markerfacecolor=face, label=name)
            axes.annotate(method, (cost.milliseconds, means[0]), (5, -2), textcoords="offset points", fontsize=6)
        axes.set(xscale="log", xlabel="milliseconds for 640x480", ylabel=f"mean SSIM at {percent(COST_AT)}")
        axes.margins(0.3, 0.15)
        axes.xaxis.set_major_formatter("{x:g}")
        axes.grid()
        axes.legend()
    save(figure, path, f"Mean SSIM at {percent(COST_AT)} of the pixels against the milliseconds to complete 640x480.")


def picture_sections(draw: Callable[..., list[str]], size: int) -> list[str]:
    """Draw the sheets of pictures, and return their sections."""
    parts = []
    for title, subjects, shares in (
        ("Pictures", SUBJECTS, SHOWN),
        ("Where it fails", FAILURES, SHOWN_OF_FAILURES),
    ):
        if links := draw(subjects, shares):
            at = f"At {', '.join(map(percent, shares))} of {size}x{size} pixels"
            parts += [f"## {title}", f"{at}. {PANELS}" if title == "Pictures" else f"{at}; panels as above.", *links]
    return [*parts, CREDITS] if parts else []


def order_sections(draw: Callable[..., list[str]], size: int) -> list[str]:
    """Draw lattice and adaptive pixels next to each other, and return the section."""
    links = draw(SUBJECTS, SHOWN_OF_ORDERS)
    at = ", ".join(map(percent, SHOWN_OF_ORDERS))
    what = (
        f"At {at} of {size}x{size} pixels. From the left: the pixels traced in order {LATTICE}, the completed picture "
        f"and its error, four times as bright; the same in order {ADAPTIVE}; all pixels. Numbers are SSIM."
    )
    return ["## Pixels of two orders", what, *links] if links else []


Panels: TypeAlias = list[tuple[NDArray[np.uint8], str]]


def draw_sheets(
    folder: Path,
    shapes: Path,
    size: int,
    panels_of: Callable[[bob.GBuffer, float], Panels],
    ending: str,
    subjects: Sequence[Subject],
    shares: Sequence[float],
) -> list[str]:
    """Draw a sheet for each subject, a row for each share of traced pixels, and return links to them.

    Parameters
    ----------
    folder : of the sheets
    shapes : folder of the subjects' files; subjects without a file are left out
    size : of a panel
    panels_of : maps all pixels and the traced share to a row's panels, except for the last, which has all pixels
    ending : of the sheets' names
    """
    links = []
    for subject in subjects:
        if not (shapes / subject.file).exists():
            continue
        scene = bob.Scene(bob.load(shapes / subject.file))
        full = bob.trace(scene.turned_upright() if subject.upright else scene, subject.camera, size=(size, size))
        last = (to_8_bit(full.gray), "all pixels")
        rows = [side_by_side([*panels_of(full, fraction), last]) for fraction in shares]
        name = Path(subject.file).name.split(".")[0] + ending
        write_picture(folder / f"{name}.png", np.vstack(rows))
        links.append(f"![{subject.what}](quality/{name}.png)")
    return links


def panels_of_methods(weights: str, full: bob.GBuffer, fraction: float) -> Panels:
    """Linear filling and the networks, in order uniform and in the default one."""
    uniform, ours = (full.sample(fraction, order=order) for order in (UNIFORM, DEFAULT_ORDER))
    images = {
        "linear": FILLINGS[LINEAR](uniform.gray, uniform.mask),
        "report": bob.complete(uniform, model=REPORT),
        "ours, uniform": bob.complete(uniform, model=weights),
        "ours": bob.complete(ours, model=weights),
    }
    completed = [(to_8_bit(image), f"{name}: {bob.ssim(image, full.gray):.3f}") for name, image in images.items()]
    return [(traced_on_green(ours), f"{percent(fraction)}, {DEFAULT_ORDER}"), *completed]


def panels_of_orders(weights: str, full: bob.GBuffer, fraction: float) -> Panels:
    """Two orders: traced pixels, completed picture and its error."""
    panels: Panels = []
    for order in (LATTICE, ADAPTIVE):
        part = full.sample(fraction, order=order)
        image = bob.complete(part, model=weights)
        panels += [
            (traced_on_green(part), f"{percent(fraction)}, {order}"),
            (to_8_bit(image), f"{bob.ssim(image, full.gray):.3f}"),
            (to_8_bit(np.minimum(4 * np.abs(image - full.gray), 1)), "error x 4"),
        ]
    return panels


if __name__ == "__main__":
    main()
