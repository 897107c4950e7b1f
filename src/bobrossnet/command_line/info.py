"""`bobrossnet info`: the contents of a shape file, a scene, a weight file or a training's folder."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterable
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bobrossnet.command_line.report import Report, add_report, plural
from bobrossnet.support.messages import counted

if TYPE_CHECKING:
    import bobrossnet as bob

MAX_PARTS = 200
"""Lines of the tree."""

MATERIAL = ("color", "ambient", "diffuse", "specular", "shininess", "metallic", "roughness", "emissive")


def add(commands: Any) -> None:
    """Add the command to the subparsers of the command line."""
    what = "the contents of a shape file, a scene, a weight file or a training's folder"
    info = commands.add_parser("info", help=f"list {what}", description=f"List {what}.")
    info.set_defaults(run=run)
    info.add_argument(
        "file",
        metavar="FILE",
        help="shapes, a scene, a .safetensors file, the name of shipped weights, or a folder",
    )
    add_report(info)


def run(options: argparse.Namespace) -> None:
    """Print the contents of a file, a folder or shipped weights."""
    from bobrossnet.completion.weights import find_weights
    from bobrossnet.support.machine import limit_memory

    limit_memory()
    report = Report(options)
    report.fields["file"] = options.file
    configuration = Path(options.file) / "config.json"
    if os.path.isfile(configuration):  # isfile is also False for a name too long to exist
        parts = _configuration(configuration)
        report.fields |= {"kind": "training", "configuration": parts}
        _sections(report, parts)
    elif (weights := find_weights(options.file)) is not None:
        _weights(report, weights)
    else:
        _scene(report, options.file)
    report.end()


def _weights(report: Report, file: Path) -> None:
    from bobrossnet.completion.weights import read_weights

    metadata, tensors = read_weights(file)
    training = json.loads(metadata.pop("training", "{}"))
    parameters = sum(tensor.size for tensor in tensors.values())
    shapes = {name: tensor.shape for name, tensor in sorted(tensors.items())}
    _table(report, {"file": file, **metadata, "parameters": f"{parameters:,}"})
    _table(report, {name: f"{shape}" for name, shape in shapes.items()}, indent="  ")
    _sections(report, {"training": training})
    report.fields |= {"kind": "weights", **metadata, "parameters": parameters, "tensors": shapes, "training": training}


def _scene(report: Report, file: str) -> None:
    import bobrossnet as bob
    from bobrossnet.adapters.lights import stored
    from bobrossnet.tracing.upright import seems_to_lie

    scene = bob.load(file)
    lies = seems_to_lie(scene)
    _table(
        report,
        {
            "file": file,
            "scene": scene.describe(),
            **({"unit": scene.unit} if scene.unit else {}),
            "sphere": f"{_vector(scene.center)}, radius {scene.radius:.6g}",
            **({"light": _light(scene)} if scene.light is not None else {}),
            **({"up": "z; it seems to lie on its back, --up y would turn it upright"} if lies else {}),
        },
    )
    parts = list(scene.parts.walk())
    if len(parts) > 1:
        report.line()
        _tree(report, parts)
    instances = []
    for instance, (low, high) in zip(scene.instances, scene.boxes, strict=True):
        report.line()
        name = f", {instance.name!r}" if instance.name else ""
        _table(
            report,
            {
                "shape": instance.shape.kind + name,
                **instance.shape.describe(),
                "bounds": f"{_vector(low)} .. {_vector(high)}",
                "material": _material(instance.material),
            },
            indent="  ",
        )
        instances.append(
            {
                "name": instance.name,
                "kind": instance.shape.kind,
                **plural(instance.shape.counts()),
                "bounds": [[*low], [*high]],
                "material": {field: getattr(instance.material, field) for field in MATERIAL},
            }
        )
    report.fields |= {
        "kind": "scene",
        "scene": plural(scene.counts()),
        "center": [*scene.center],
        "radius": scene.radius,
        "light": stored(scene)[0],
        "seems_to_lie": lies,
        "unit": scene.unit,
        "parts": [
            {
                "name": str(part),
                "number": part.number,
                "path": part.path,
                "instances": part.instances,
                "color": part.color,
            }
            for part in parts
        ],
        "instances": instances,
    }


def _light(scene: bob.Scene) -> str:
    """Describe a scene's own light."""
    from bobrossnet.tracing.light import Light, Sky
    from bobrossnet.tracing.lit import shows_shadows

    text = scene.light
    if not isinstance(text, str):
        several = scene.light or []
        discs = sum(isinstance(light, Light) for light in several)
        skies = (light for light in several if isinstance(light, Sky))
        names = ["a sky" if sky.image is None else "an environment" for sky in skies]
        text = " and ".join([*([counted(discs, "disc")] if discs else []), *names]) or "none"
    return text + ", on a ground" * shows_shadows(scene, None, None)


def _tree(report: Report, parts: list[bob.Part]) -> None:
    """Print the parts with their numbers, each below the one that it is a part of."""
    width = len(str(parts[-1].number))
    for part in parts[:MAX_PARTS]:
        report.line(f"  {part.number:{width}}  {'  ' * (len(part.path) - 1)}{part.name}")
    if len(parts) > MAX_PARTS:
        report.line(f"  and {len(parts) - MAX_PARTS:,} more, which --json lists")


def _material(material: bob.Material) -> str:
    names = ("ambient", "diffuse", "specular", "shininess") if material.roughness is None else ("metallic", "roughness")
    numbers = ", ".join(f"{name} {getattr(material, name):.6g}" for name in names)
    emissive = f", emissive {_vector(material.emissive)}" if any(material.emissive) else ""
    coat = f", clear coat {material.clearcoat:.6g}" if material.clearcoat else ""
    return f"linear RGB {_vector(material.color)}, {numbers}{emissive}{coat}{_glass(material)}"


def _glass(material: bob.Material) -> str:
    from bobrossnet.tracing.glass import Glass

    if not isinstance(material, Glass):
        return ""
    inside = f", {_vector(material.attenuation)} after {material.distance:.6g}" if isfinite(material.distance) else ""
    return (
        f", transmission {material.transmission:.6g}, ior {material.ior:.6g}{', a sheet' if material.thin else inside}"
    )


def _configuration(path: Path) -> dict[str, dict[str, Any]]:
    """The settings that a training has written."""
    from bobrossnet.support.errors import InputError

    try:
        parts = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: expected a training's configuration, can't read it: {error}") from error
    if not (isinstance(parts, dict) and all(isinstance(fields, dict) for fields in parts.values())):
        raise InputError(f"{path}: expected a training's configuration, got other JSON")
    return parts


def _sections(report: Report, parts: dict[str, dict[str, Any]]) -> None:
    for name, fields in parts.items():
        if fields:
            report.line(name)
            _table(report, fields, indent="  ")


def _vector(numbers: Iterable[float]) -> str:
    return "(" + ", ".join(f"{x:.6g}" for x in numbers) + ")"


def _table(report: Report, rows: dict[str, Any], indent: str = "") -> None:
    width = max(map(len, rows), default=0)
    for name, value in rows.items():
        report.line(f"{indent}{name:{width}}  {value}")
