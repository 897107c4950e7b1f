"""The commands of the command line for learning: `bobrossnet dataset | train | calibrate | evaluate | figures`.

Slow modules are imported inside functions, so that --help answers at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bobrossnet.command_line import arguments


def add_commands(commands: Any) -> None:
    """Add the commands to an argparse parser."""
    dataset = commands.add_parser("dataset", help="build a data set", description="Build a data set, or look into it.")
    actions = dataset.add_subparsers(metavar="ACTION", required=True)
    build = actions.add_parser("build", help="render shapes", description="Render a data set, or resume one.")
    build.set_defaults(run=_dataset_build)
    build.add_argument("folder", metavar="DIR", help="the data set's folder, new or from an interrupted build")
    build.add_argument("--shapes", type=int, help="how many the package makes itself (default: 479; 0 with --files)")
    build.add_argument(
        "--files",
        nargs="+",
        default=[],
        metavar="PLACE",
        help="shape files, or folders of them, to take instead, or with --shapes as well",
    )
    build.add_argument("--test-shapes", type=int, default=10, help="set aside for testing (default: 10)")
    build.add_argument("--seed", type=int, default=0, help="of shapes, cameras, splits and masks (default: 0)")
    build.add_argument(
        "--colored",
        action="store_true",
        help="with colours and textures on three quarters of the made shapes, and half of the views in perspective",
    )
    arguments.add_scheduler(build)

    compare = actions.add_parser(
        "compare",
        help="with real shapes",
        description="Say how far a data set's pictures are like pictures of real shapes from the same places.",
    )
    compare.set_defaults(run=_dataset_compare)
    compare.add_argument("dataset", metavar="DIR", help="the data set's folder")
    compare.add_argument("folder", metavar="FOLDER", help="of shape files")
    compare.add_argument("--limit", type=int, help="how many files at most, spread over the folder")
    compare.add_argument("--markdown", metavar="FILE", help="also write the table to this file")

    views = actions.add_parser(
        "views",
        help="render views of shape files with depth, normals and poses",
        description="Render views of every shape file of a folder and below it: colour, depth, normals, instances and "
        "camera matrices. Finished shapes are kept, so the same command resumes.",
    )
    views.set_defaults(run=_dataset_views)
    arguments.add_pictures_of_folder(views, "folder of the data set", (480, 640))
    views.add_argument("--views", type=int, default=24, metavar="N", help="cameras around each shape (default: 24)")
    views.add_argument(
        "--format",
        choices=("npz", "exr", "webdataset"),
        default="npz",
        help="arrays next to PNG and transforms.json of nerfstudio, in npz or EXR; or one tar for each shape",
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
        help="measure models against plain filling",
        description="Measure models on a data set's test split or on files, with one or more pixel orders, against "
        "plain filling of the same pixels.",
    )
    evaluate.set_defaults(run=_evaluate)
    evaluate.add_argument("place", metavar="PLACE", help="a data set, or a folder of shape files")
    evaluate.add_argument(
        "--models",
        nargs="+",
        default=["default", "paper"],
        metavar="NAME",
        help="of shipped weights, or .safetensors files (default: default paper)",
    )
    evaluate.add_argument(
        "--fractions",
        type=arguments.fractions,
        metavar="PERCENT,...",
        help="shares of the pixels to trace (default: 1%%,2%%,5%%,10%%,25%%,50%%,75%%,100%%)",
    )
    evaluate.add_argument(
        "--orders",
        type=lambda text: text.split(","),
        metavar="NAME,...",
        help="sequences of the pixels (default: uniform)",
    )
    evaluate.add_argument(
        "--size", type=arguments.size, metavar="WIDTHxHEIGHT", help="of pictures of files (default: 256x256)"
    )
    evaluate.add_argument("--views", type=int, help="pictures of each file (default: 1)")
    evaluate.add_argument("--limit", type=int, help="at most how many shapes, spread evenly over all")
    evaluate.add_argument(
        "--stability", action="store_true", help="measure the flicker of converging pictures and of orbits as well"
    )
    evaluate.add_argument(
        "--color", action="store_true", help="complete and measure files in colour: luminance, components, sRGB"
    )
    evaluate.add_argument("--csv", metavar="FILE", help="write the scores of each picture there")
    evaluate.add_argument("--markdown", metavar="FILE", help="write the tables there")

    calibrate = commands.add_parser(
        "calibrate",
        help="learn how wrong completed pictures are",
        description="Learn to predict how wrong completed pictures are, from shapes that the package makes itself.",
    )
    calibrate.set_defaults(run=_calibrate)
    calibrate.add_argument("out", metavar="FILE.safetensors", help="the file to write")
    calibrate.add_argument("--model", default="default", metavar="NAME", help="whose pictures (default: default)")
    calibrate.add_argument("--shapes", type=int, default=250, help="how many (default: 250)")

    figures = commands.add_parser(
        "figures", help="draw the report's figures", description="Draw the report's figures from data, as SVG and PNG."
    )
    figures.set_defaults(run=_figures)
    figures.add_argument("out", metavar="OUT", help="the folder to write them to")
    figures.add_argument("--data", metavar="DIR", help="a data set; without one, figures that need it are left out")
    figures.add_argument("--weights", default="paper", help="name of shipped weights or a .safetensors file")
    figures.add_argument("--shape", metavar="FILE", help="the shape shown; by default the built-in scene")
    arguments.add_up(figures, "z")
    figures.add_argument("--scores", metavar="FILE.csv", help="the table that evaluate wrote, likewise")
    figures.add_argument("--steps", type=int, default=400, help="of trainings that compare losses (default: 400)")
    figures.add_argument("--frames", type=int, default=60, help="to measure stability in (default: 60)")
    figures.add_argument("--only", metavar="NAME,…", help="only these, such as 2.1,4.1")


def _dataset_build(options: argparse.Namespace) -> None:
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
    plan = dataset.plan
    counts = ", ".join(f"{len(plan.split(name)):,} {name}" for name in ("train", "validation", "test"))
    print(f"wrote {options.folder}: {plan.shapes} shapes, {plan.samples:,} samples: {counts}")


def _dataset_views(options: argparse.Namespace) -> int:
    import sys

    from bobrossnet.pictures.view_files import ViewStyle, dataset_of_views
    from bobrossnet.support.machine import limit_memory
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
            print(f"left out: {each.error}", file=sys.stderr)
    failed = sum(each.error is not None for each in written)
    new = sum(each.is_new for each in written) - failed
    print(
        f"wrote {new * options.views:,} views of {new:,} shapes to {options.out}; {len(written) - new - failed:,} "
        f"shapes were there, {failed:,} files left out"
    )
    return 1 if failed else 0


def _dataset_compare(options: argparse.Namespace) -> None:
    from bobrossnet.learn.dataset import Dataset
    from bobrossnet.learn.dataset.statistics import compare_with_folder
    from bobrossnet.support.atomic import check_writable, write_whole

    if options.markdown is not None:
        check_writable(options.markdown)
    text = str(compare_with_folder(Dataset.open(options.dataset), options.folder, limit=options.limit))
    print(text)
    if options.markdown is not None:
        write_whole(options.markdown, f"{text}\n".encode())
        print(f"\nwrote {options.markdown}")


def _train(options: argparse.Namespace) -> None:
    from bobrossnet.learn.config import config_from_settings
    from bobrossnet.learn.dataset import Dataset
    from bobrossnet.learn.train import train

    named = {name: getattr(options, name) for name in ("accelerator", "devices", "precision")}
    given = [f"{name}={value}" for name, value in named.items() if value is not None]
    config = config_from_settings([*options.settings, *given])
    train(config, Dataset.open(options.dataset), options.folder)


def _evaluate(options: argparse.Namespace) -> None:
    from bobrossnet.learn.evaluation.costs import cost_table, measure_costs
    from bobrossnet.learn.evaluation.evaluate import evaluate_dataset, evaluate_folder
    from bobrossnet.learn.evaluation.scenes import scenes_of_dataset, scenes_of_folder
    from bobrossnet.learn.evaluation.stability import measure_stability
    from bobrossnet.support.atomic import check_writable, write_whole
    from bobrossnet.support.errors import InputError

    for file in filter(None, (options.csv, options.markdown)):
        check_writable(file)
    names = ("orders", "limit", "fractions", "size", "views")
    given: dict[str, Any] = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    is_dataset = (Path(options.place) / "zarr.json").exists()
    if is_dataset:
        if "size" in given or "views" in given:
            raise InputError("--size and --views: expected with a folder of files; a data set has its own pictures")
        if options.color:
            raise InputError("--color: expected with a folder of files; a data set holds gray pictures")
        result = evaluate_dataset(options.place, options.models, **given)
    else:
        if options.color:
            given |= {"channel": "color", "repainting": False}
        result = evaluate_folder(options.place, options.models, **given)
    parts = [str(result), cost_table(measure_costs(options.models))]
    if options.stability:
        scenes = (scenes_of_dataset if is_dataset else scenes_of_folder)(options.place, options.limit)
        chosen = {"orders": given["orders"]} if "orders" in given else {}
        parts.append(str(measure_stability(scenes, options.models, **chosen)))
    text = "\n\n".join(parts)
    print(text)
    for file, content in ((options.csv, result.csv()), (options.markdown, f"{text}\n")):
        if file:
            write_whole(file, content.encode())
            print(f"wrote {file}")


def _calibrate(options: argparse.Namespace) -> None:
    import numpy as np

    from bobrossnet.learn.calibrate import calibrate

    ratios = np.array(calibrate(options.out, model=options.model, shapes=options.shapes))
    sure, alike = (ratios <= 1).mean(), (abs(np.log2(ratios)) <= 1).mean()
    print(
        f"wrote {options.out}: of {len(ratios)} pictures that were not learned from, {100 * sure:.0f} % are at most as "
        f"wrong as predicted, {100 * alike:.0f} % within a factor of two"
    )


def _figures(options: argparse.Namespace) -> None:
    from bobrossnet.adapters.files import load
    from bobrossnet.learn.dataset import Dataset
    from bobrossnet.learn.figures import Sources, check_names, draw_figures

    only = check_names(options.only.split(",")) if options.only else None
    given: dict[str, Any] = {}
    if options.shape is not None:
        scene = load(options.shape)
        given["scene"] = scene.turned("z" if options.up == "auto" else options.up)
    if options.data is not None:
        given["data"] = Dataset.open(options.data)
    if options.scores is not None:
        given["scores"] = Path(options.scores)
    sources = Sources(weights=options.weights, steps=options.steps, frames=options.frames, **given)
    draw_figures(options.out, sources, only=only)
