"""The commands of the command line for learning: `bobrossnet dataset | train | calibrate | evaluate | figures`.

Slow modules are imported inside functions, so that --help answers at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bobrossnet.command_line import arguments
from bobrossnet.learn.checks import (
    MAX_COUNT,
    MAX_FRAMES,
    MAX_SEED,
    MAX_SHAPES,
    MAX_VIEWS,
    check_dataset,
    check_figures,
    check_measured,
    check_orders,
    check_weights_path,
    is_dataset,
)
from bobrossnet.pictures import views as posed_views

QUICK_SHAPES, QUICK_FRACTIONS, QUICK_SECONDS = 24, (0.01, 0.05, 0.25), 60.0
"""Of `evaluate --quick`: half of two minutes is left for the start of the libraries and for the last pictures."""


def add_commands(commands: Any) -> None:
    """Add the commands to an argparse parser."""
    dataset = commands.add_parser("dataset", help="build a data set", description="Build a data set, or look into it.")
    actions = dataset.add_subparsers(metavar="ACTION", required=True)
    build = actions.add_parser("build", help="render shapes", description="Render a data set, or resume one.")
    build.set_defaults(run=_dataset_build)
    build.add_argument("folder", metavar="DIR", help="the data set's folder, new or from an interrupted build")
    build.add_argument(
        "--shapes",
        type=arguments.integer(0, MAX_SHAPES),
        help="number of generated shapes (default: 479; 0 with --files)",
    )
    build.add_argument(
        "--files",
        nargs="+",
        default=[],
        metavar="PLACE",
        help="shape files, or folders of them, instead of generated shapes, or with --shapes in addition",
    )
    build.add_argument(
        "--test-shapes",
        type=arguments.integer(1, MAX_SHAPES),
        default=10,
        help="number of shapes for testing (default: 10)",
    )
    arguments.add_seed(build, "shapes, cameras, splits and masks", MAX_SEED)
    build.add_argument(
        "--colored",
        action="store_true",
        help="give three quarters of the generated shapes colours and textures, and render half of the views in "
        "perspective",
    )
    arguments.add_scheduler(build)

    compare = actions.add_parser(
        "compare",
        help="compare a data set with real shapes",
        description="Compare a data set's pictures with those of real shapes from the same directions.",
    )
    compare.set_defaults(run=_dataset_compare)
    compare.add_argument("dataset", metavar="DIR", help="the data set's folder")
    compare.add_argument("folder", metavar="FOLDER", help="folder of shape files")
    compare.add_argument(
        "--limit", type=arguments.integer(1, MAX_COUNT), help="maximum number of files, taken evenly from the folder"
    )
    compare.add_argument("--markdown", metavar="FILE", help="also write the table to this file")

    views = actions.add_parser(
        "views",
        help="render views of shape files with depth, normals and poses",
        description="Render views of every shape file of a folder and below it: colour, depth, normals, instances and "
        "camera matrices. Finished shapes are kept, so the same command resumes.",
    )
    views.set_defaults(run=_dataset_views)
    arguments.add_pictures_of_folder(views, "folder of the data set", (480, 640))
    views.add_argument(
        "--views",
        type=arguments.integer(1, posed_views.MAX_VIEWS),
        default=24,
        metavar="N",
        help="cameras around each shape (default: 24)",
    )
    views.add_argument(
        "--format",
        choices=("npz", "exr", "webdataset"),
        default="npz",
        help="npz or exr: a folder for each shape with nerfstudio's transforms.json, and arrays as .npz or .exr; "
        "webdataset: a tar for each shape (default: npz)",
    )

    train = commands.add_parser(
        "train", help="train a network", description="Train a network; the same command resumes an interrupted run."
    )
    train.set_defaults(run=_train)
    train.add_argument("dataset", metavar="DATA", help="the data set's folder")
    train.add_argument("folder", metavar="RUN", help="the folder for weights, checkpoint, configuration and logs")
    train.add_argument("settings", nargs="*", metavar="NAME=VALUE", help="fields of TrainConfig, such as epochs=3")
    for name, what in (
        ("accelerator", "auto, cpu or cuda; auto takes the GPU if there is one"),
        ("devices", "GPUs, or processes on the CPU, that share the work"),
        ("precision", "32-true, or bf16-mixed for convolutions in bfloat16"),
    ):
        train.add_argument(f"--{name}", metavar=name.upper(), help=f"{what}; the same as {name}={name.upper()}")

    evaluate = commands.add_parser(
        "evaluate",
        help="measure networks next to classical interpolation",
        description="Measure networks on a data set's test split or on files, with one or more pixel orders, next to "
        "classical interpolation of the same pixels.",
    )
    evaluate.set_defaults(run=_evaluate)
    evaluate.add_argument("place", nargs="?", metavar="PLACE", help="a data set, or a folder of shape files")
    evaluate.add_argument(
        "--quick",
        action="store_true",
        help="finish within two minutes: the default model at 1, 5 and 25 %% of the pixels of at most 24 shapes, which "
        "are generated if PLACE is missing; other options still apply",
    )
    evaluate.add_argument(
        "--models",
        nargs="+",
        metavar="NAME",
        help="names of shipped weights, or .safetensors files (default: default paper)",
    )
    evaluate.add_argument(
        "--fractions",
        type=arguments.fractions,
        metavar="PERCENT,...",
        help="shares of the pixels to trace (default: 1%%,2%%,5%%,10%%,25%%,50%%,75%%,100%%)",
    )
    evaluate.add_argument(
        "--orders",
        type=arguments.checked("orders", lambda text: check_orders(text.split(","))),
        metavar="NAME,...",
        help="pixel orders (default: uniform)",
    )
    evaluate.add_argument(
        "--size",
        type=arguments.checked("size", check_measured),
        metavar="WIDTHxHEIGHT",
        help="size of pictures of files (default: 256x256)",
    )
    evaluate.add_argument("--views", type=arguments.integer(1, MAX_VIEWS), help="pictures of each file (default: 1)")
    evaluate.add_argument(
        "--limit", type=arguments.integer(1, MAX_COUNT), help="maximum number of shapes, taken evenly from all"
    )
    evaluate.add_argument(
        "--stability", action="store_true", help="also measure the flicker of converging pictures and of orbits"
    )
    evaluate.add_argument(
        "--color", action="store_true", help="complete and measure files in colour: luminance, components, sRGB"
    )
    evaluate.add_argument("--csv", metavar="FILE", help="write the scores of each picture to this file")
    evaluate.add_argument("--markdown", metavar="FILE", help="write the tables to this file")

    calibrate = commands.add_parser(
        "calibrate",
        help="learn to predict errors of completed pictures",
        description="Learn to predict errors of completed pictures, from generated shapes.",
    )
    calibrate.set_defaults(run=_calibrate)
    calibrate.add_argument("out", metavar="FILE.safetensors", help="the file to write")
    calibrate.add_argument(
        "--model", default="default", metavar="NAME", help="network that completes them (default: default)"
    )
    calibrate.add_argument(
        "--shapes", type=arguments.integer(2, MAX_SHAPES), default=250, help="number of shapes (default: 250)"
    )

    figures = commands.add_parser(
        "figures", help="draw the report's figures", description="Draw the report's figures from data, as SVG and PNG."
    )
    figures.set_defaults(run=_figures)
    figures.add_argument("out", metavar="OUT", help="the folder to write them to")
    figures.add_argument("--data", metavar="DIR", help="a data set; without one, figures that need it are left out")
    figures.add_argument("--weights", default="paper", help="name of shipped weights or a .safetensors file")
    figures.add_argument("--shape", metavar="FILE", help="the shape to show (default: the built-in scene)")
    arguments.add_up(figures, "z")
    figures.add_argument(
        "--scores", metavar="FILE.csv", help="evaluate's table; without one, figures that need it are left out"
    )
    figures.add_argument(
        "--steps",
        type=arguments.integer(0, MAX_COUNT),
        default=400,
        help="steps of each training that compares losses (default: 400)",
    )
    figures.add_argument(
        "--frames",
        type=arguments.integer(2, MAX_FRAMES),
        default=60,
        help="frames that measure stability (default: 60)",
    )
    figures.add_argument(
        "--only",
        type=arguments.checked("only", lambda text: check_figures(text.split(","))),
        metavar="NAME,…",
        help="figures to draw, such as 2.1,4.1 (default: all)",
    )


def _dataset_build(options: argparse.Namespace) -> None:
    from bobrossnet.adapters.files import shape_files
    from bobrossnet.support.atomic import check_folder

    check_folder(options.folder, "folder")  # before slow imports
    for place in options.files:
        shape_files(place)

    from bobrossnet.learn.dataset.build import build

    dataset = build(
        options.folder,
        shapes=options.shapes,
        files=options.files,
        seed=options.seed,
        test_shapes=options.test_shapes,
        colored=options.colored,
        scheduler=options.scheduler,
    )
    from bobrossnet.support.messages import counted

    plan = dataset.plan
    counts = ", ".join(f"{len(plan.split(name)):,} {name}" for name in ("train", "validation", "test"))
    print(f"wrote {options.folder}: {counted(plan.shapes, 'shape')}, {counted(plan.samples, 'sample')}: {counts}")


def _dataset_views(options: argparse.Namespace) -> int:
    import sys

    from bobrossnet.pictures.view_files import ViewStyle, dataset_of_views
    from bobrossnet.support.machine import limit_memory
    from bobrossnet.support.messages import counted, kept_and_failed, left_out
    from bobrossnet.support.progress import progress

    limit_memory()
    style = ViewStyle(
        cameras=options.views,
        size=options.size,
        format=options.format,
        samples=options.samples,
        background=arguments.background(options.background),
        up=options.up,
        light=options.light,
        ground=options.ground,
    )
    with progress("rendering") as show:
        written = dataset_of_views(options.folder, options.out, style, options.scheduler, show)
    for each in written:
        if each.error is not None:
            print(left_out(each.file, each.error), file=sys.stderr)
    failed = sum(each.error is not None for each in written)
    new = sum(each.is_new for each in written) - failed
    kept = len(written) - new - failed
    print(
        f"wrote {counted(new * options.views, 'view')} of {counted(new, 'shape')} to {options.out}; "
        f"{kept_and_failed(kept, 'shape', failed)}"
    )
    return 1 if failed else 0


def _dataset_compare(options: argparse.Namespace) -> None:
    from bobrossnet.adapters.files import shape_files
    from bobrossnet.support.atomic import check_writable, write_whole

    if options.markdown is not None:
        check_writable(options.markdown)
    check_dataset(options.dataset)
    shape_files(options.folder)  # before slow imports

    from bobrossnet.learn.dataset import Dataset
    from bobrossnet.learn.dataset.statistics import compare_with_folder

    text = str(compare_with_folder(Dataset.open(options.dataset), options.folder, limit=options.limit))
    print(text)
    if options.markdown is not None:
        write_whole(options.markdown, f"{text}\n".encode())
        print(f"\nwrote {options.markdown}")


def _train(options: argparse.Namespace) -> None:
    from bobrossnet.support.atomic import check_folder

    check_dataset(options.dataset)  # before slow imports
    check_folder(options.folder, "run")

    from bobrossnet.learn.config import config_from_settings
    from bobrossnet.learn.dataset import Dataset
    from bobrossnet.learn.train import train

    named = {name: getattr(options, name) for name in ("accelerator", "devices", "precision")}
    given = [f"{name}={value}" for name, value in named.items() if value is not None]
    config = config_from_settings([*options.settings, *given])
    train(config, Dataset.open(options.dataset), options.folder)


def _evaluate(options: argparse.Namespace) -> None:
    from bobrossnet.adapters.files import shape_files
    from bobrossnet.completion.network import load_network
    from bobrossnet.support.atomic import check_writable, write_whole
    from bobrossnet.support.errors import InputError

    for file in (options.csv, options.markdown):
        if file is not None:
            check_writable(file)
    if options.place is None and not options.quick:
        raise InputError("PLACE: expected a data set or a folder of shape files; --quick generates shapes")
    if options.place is None and options.stability:
        raise InputError("--stability: expected with a PLACE, got none")
    for model in options.models or ():
        load_network(model)
    is_measured = options.place is not None and is_dataset(options.place)
    if is_measured and not (options.size is None and options.views is None):
        raise InputError("--size and --views: expected with a folder of files; a data set has its own pictures")
    if is_measured and options.color:
        raise InputError("--color: expected with a folder of files; a data set holds gray pictures")
    if not is_measured and options.place is not None:
        shape_files(options.place)

    # These imports take seconds.
    from bobrossnet.learn.evaluation.costs import cost_table, measure_costs
    from bobrossnet.learn.evaluation.evaluate import MODELS, evaluate_dataset, evaluate_folder, evaluate_scenes
    from bobrossnet.learn.evaluation.scenes import own_scenes, scenes_of_dataset, scenes_of_folder
    from bobrossnet.learn.evaluation.stability import measure_stability

    names = ("orders", "limit", "fractions", "size", "views")
    given: dict[str, Any] = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    models = options.models or (MODELS[:1] if options.quick else MODELS)
    if options.quick:
        given = {"limit": QUICK_SHAPES, "fractions": QUICK_FRACTIONS, "seconds": QUICK_SECONDS} | given
    if is_measured:
        result = evaluate_dataset(options.place, models, **given)
    else:
        if options.color:
            given |= {"channel": "color", "repainting": False}
        if options.place is None:
            result = evaluate_scenes(own_scenes(given.pop("limit")), models, **given)
        else:
            result = evaluate_folder(options.place, models, **given)
    parts = [str(result)]
    if not options.quick:  # costs take as long as the pictures
        parts.append(cost_table(measure_costs(models)))
    if options.stability:
        scenes = (scenes_of_dataset if is_measured else scenes_of_folder)(options.place, options.limit)
        chosen = {"orders": given["orders"]} if "orders" in given else {}
        parts.append(str(measure_stability(scenes, models, **chosen)))
    text = "\n\n".join(parts)
    print(text)
    for file, content in ((options.csv, result.csv()), (options.markdown, f"{text}\n")):
        if file:
            write_whole(file, content.encode())
            print(f"wrote {file}")


def _calibrate(options: argparse.Namespace) -> None:
    import numpy as np

    from bobrossnet.completion.network import load_network

    check_weights_path(options.out)  # before slow imports
    load_network(options.model)

    from bobrossnet.learn.calibrate import calibrate

    ratios = np.array(calibrate(options.out, model=options.model, shapes=options.shapes))
    sure, alike = (ratios <= 1).mean(), (abs(np.log2(ratios)) <= 1).mean()
    print(
        f"wrote {options.out}: of {len(ratios)} pictures that were not learned from, {100 * sure:.0f} % are at most as "
        f"wrong as predicted, {100 * alike:.0f} % within a factor of two"
    )


def _figures(options: argparse.Namespace) -> None:
    from bobrossnet.adapters.files import load
    from bobrossnet.completion.network import load_network
    from bobrossnet.support.atomic import check_folder
    from bobrossnet.support.paths import check_file

    check_folder(options.out, "out")  # before slow imports
    load_network(options.weights)
    if options.data is not None:
        check_dataset(options.data)
    if options.scores is not None:
        check_file(Path(options.scores))

    from bobrossnet.learn.dataset import Dataset
    from bobrossnet.learn.figures import Sources, draw_figures

    given: dict[str, Any] = {}
    if options.shape is not None:
        scene = load(options.shape)
        given["scene"] = scene.turned("z" if options.up == "auto" else options.up)
    if options.data is not None:
        given["data"] = Dataset.open(options.data)
    if options.scores is not None:
        given["scores"] = Path(options.scores)
    sources = Sources(weights=options.weights, steps=options.steps, frames=options.frames, **given)
    draw_figures(options.out, sources, only=options.only)
