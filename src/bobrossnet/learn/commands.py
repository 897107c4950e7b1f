"""The commands of the command line for learning: `bobrossnet train | evaluate`.

Nothing slow is imported up here, so that --help is answered at once.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bobrossnet import arguments


def add_commands(commands: Any) -> None:
    """Add them to an argparse parser's commands."""
    dataset = commands.add_parser("dataset", help="build a data set", description="Build a data set to learn from.")
    actions = dataset.add_subparsers(metavar="ACTION", required=True)
    build = actions.add_parser("build", help="render shapes", description="Render a data set, or go on with one.")
    build.set_defaults(run=_dataset_build)
    build.add_argument("folder", metavar="DIR", help="the data set's folder, new or of a build that was stopped")
    build.add_argument("--shapes", type=int, help="how many the package makes itself (default: 479; 0 with --models)")
    build.add_argument(
        "--models",
        nargs="+",
        default=[],
        metavar="DIR",
        help="folders of models to take instead, or with --shapes as well",
    )
    build.add_argument("--test-shapes", type=int, default=10, help="set aside for testing (default: 10)")
    build.add_argument("--seed", type=int, default=0, help="of shapes, cameras, splits and masks (default: 0)")
    build.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler's, to render on its cluster")

    train = commands.add_parser("train", help="train a network", description="Train a network.")
    train.set_defaults(run=_train)
    train.add_argument("out", metavar="OUT.safetensors", help="the weight file to write")
    train.add_argument("settings", nargs="*", metavar="NAME=VALUE", help="fields of TrainConfig, such as steps=2000")
    train.add_argument("--checkpoint", metavar="FILE", help="written now and then; an interrupted run goes on from it")

    evaluate = commands.add_parser(
        "evaluate",
        help="measure models beside plain filling",
        description="Measure models on a data set's test split or on files, beside plain filling of the same pixels.",
    )
    evaluate.set_defaults(run=_evaluate)
    evaluate.add_argument("place", metavar="PLACE", help="a data set, or a folder of models in files")
    evaluate.add_argument(
        "--models", nargs="+", default=["default"], metavar="NAME", help="of shipped weights, or .safetensors files"
    )
    evaluate.add_argument(
        "--fractions",
        type=arguments.fractions,
        metavar="PERCENT,...",
        help="shares of the pixels to trace (default: 1%%,2%%,5%%,10%%,25%%,50%%,75%%,100%%)",
    )
    evaluate.add_argument("--order", default="uniform", help="sequence of the pixels (default: uniform)")
    evaluate.add_argument(
        "--size", type=arguments.size, metavar="WIDTHxHEIGHT", help="of pictures of files (default: 256x256)"
    )
    evaluate.add_argument("--views", type=int, help="pictures of each file (default: 1)")
    evaluate.add_argument("--limit", type=int, help="how many shapes at most, spread evenly over all")
    evaluate.add_argument("--csv", metavar="FILE", help="write the scores of each picture there")
    evaluate.add_argument("--markdown", metavar="FILE", help="write the tables there")


def _dataset_build(options: argparse.Namespace) -> None:
    from bobrossnet.learn.dataset.build import build

    dataset = build(
        options.folder,
        shapes=options.shapes,
        models=options.models,
        seed=options.seed,
        test_shapes=options.test_shapes,
        scheduler=options.scheduler,
    )
    plan = dataset.plan
    counts = ", ".join(f"{len(plan.split(name)):,} {name}" for name in ("train", "validation", "test"))
    print(f"wrote {options.folder}: {plan.shapes} shapes, {plan.samples:,} samples: {counts}")


def _train(options: argparse.Namespace) -> None:
    from bobrossnet.learn.config import config_from_settings
    from bobrossnet.learn.train import train

    train(config_from_settings(options.settings), options.out, checkpoint_path=options.checkpoint)
    print(f"wrote {options.out}")


def _evaluate(options: argparse.Namespace) -> None:
    from bobrossnet.atomic import check_writable, write_whole
    from bobrossnet.errors import InputError
    from bobrossnet.learn.evaluate import evaluate_dataset, evaluate_folder

    for file in filter(None, (options.csv, options.markdown)):
        check_writable(file)
    names = ("fractions", "order", "limit", "size", "views")
    given = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    if (Path(options.place) / "zarr.json").exists():
        if "size" in given or "views" in given:
            raise InputError("--size and --views: expected with a folder of files; a data set has pictures of its own")
        result = evaluate_dataset(options.place, options.models, **given)
    else:
        result = evaluate_folder(options.place, options.models, **given)
    print(result)
    for file, content in ((options.csv, result.csv()), (options.markdown, f"{result}\n")):
        if file:
            write_whole(file, content.encode())
            print(f"wrote {file}")
