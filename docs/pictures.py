"""Draws docs/pictures.webp: twenty models by `bob.render` and other viewers, without options; ours also in a studio.

    python -m venv /tmp/rivals/venv && /tmp/rivals/venv/bin/pip install pyvista f3d
    npm install --prefix /tmp/rivals @google/model-viewer
    python docs/pictures.py [/tmp/rivals] [folder of the single pictures]

The benchmarks use the same models, in shared/models. A missing viewer is left out.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

from PIL import Image, ImageDraw

import bobrossnet as bob

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "bench"))
from report import MODELS  # noqa: E402

SIZE = (480, 640)
TILE = (150, 200)
GAP, CAPTION = 6, 16
GRAY = (102, 102, 102, 255)  # linear
FILES = (
    "mechanical/fixed_ring_gear.ply",
    "mechanical/featuretype_block.ply",
    "loader_originals/stl_binary/angle_block.STL",
    "mechanical/satellite_fm1.ply",
    "mechanical/rod_assembly.ply",
    "robots/ur16e_base.ply",
    "robots/franka_hand.ply",
    "scans/nefertiti.ply",
    "animals/spot_cow.ply",
    "anatomy_bio/dog_vertebra_c4.ply",
    "anatomy_bio/human_skull.ply",
    "math_shapes/soccer_lattice.ply",
    "math_shapes/utah_teapot_mesh.ply",
    "vehicles/helicopter.ply",
    "furniture_household/headphones.ply",
    "furniture_household/wire_chair.ply",
    "architecture/ferris_wheel.ply",
    "loader_originals/gltf_external/coffin_decorated.gltf",
    "loader_originals/obj_mtl_fuze/fuze.obj",
    "textured/ycb_banana/textured_simple_reoriented.obj",
)


def name_of(file: str) -> str:
    path = Path(file)
    return path.parent.name if path.stem.startswith("textured_simple") else path.stem


def ours(out: Path, **options: Any) -> str:
    for file in FILES:
        bob.render(str(MODELS / file), **options).save(out / f"{name_of(file)}.png")
    return str(bob.__version__)


def in_python(name: str, rivals: Path, out: Path) -> str:
    """Run rival_pictures.py in the rivals' Python."""
    pairs = [text for file in FILES for text in (str(MODELS / file), str(out / f"{name_of(file)}.png"))]
    program = [rivals / "venv/bin/python", HERE / "rival_pictures.py", name, f"{SIZE[1]}x{SIZE[0]}", *pairs]
    done = subprocess.run(program, capture_output=True, text=True, check=True)
    version = done.stdout.split()
    if not version:
        raise FileNotFoundError(done.stderr.strip().splitlines()[-1])
    return version[-1]


PAGE = """<!doctype html><body style="margin: 0"><script type="module" src="/model-viewer.js"></script>
<model-viewer src="/model.EXT" style="width: 100vw; height: 100vh"><div slot="progress-bar"></div></model-viewer>"""


def model_viewer(rivals: Path, out: Path) -> str:
    """In Chromium; files that are not glTF are converted by trimesh: smooth but for creases, of gray plastic."""
    from playwright.sync_api import sync_playwright

    package = rivals / "node_modules/@google/model-viewer"
    version = json.loads((package / "package.json").read_text())["version"]
    site = out / "site"
    site.mkdir(exist_ok=True)
    shutil.copy(package / "dist/model-viewer.min.js", site / "model-viewer.js")
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(site)))
    Thread(target=server.serve_forever, daemon=True).start()
    program = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    flags = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=flags)
        for file in FILES:
            model = as_gltf(MODELS / file, site)
            (site / "index.html").write_text(PAGE.replace("/model.EXT", model))
            page = browser.new_page(viewport={"width": SIZE[1], "height": SIZE[0]})
            page.goto(f"http://127.0.0.1:{server.server_port}/index.html")
            page.wait_for_function("document.querySelector('model-viewer').modelIsVisible", timeout=120_000)
            page.wait_for_timeout(3000)
            page.screenshot(path=out / f"{name_of(file)}.png")
            page.close()
        browser.close()
    server.shutdown()
    return str(version)


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_: Any) -> None:
        """Print nothing."""


def as_gltf(file: Path, site: Path) -> str:
    """Copy a glTF file with its companions into the site, or convert another one; return its path there."""
    import trimesh

    name = name_of(str(file))
    if file.suffix == ".gltf":
        shutil.copytree(file.parent, site / name, dirs_exist_ok=True)
        return f"/{name}/{file.name}"
    if file.suffix == ".glb":
        shutil.copy(file, site)
        return f"/{file.name}"
    model = trimesh.load(file)
    if isinstance(model, trimesh.Trimesh) and model.visual.kind != "texture":
        model = model.smooth_shaded
        plastic = trimesh.visual.material.PBRMaterial(baseColorFactor=GRAY, metallicFactor=0, roughnessFactor=0.6)
        model.visual = trimesh.visual.TextureVisuals(material=plastic)
    model.export(site / f"{name}.glb", include_normals=True)
    return f"/{name}.glb"


def sheet(columns: dict[str, Path]) -> Image.Image:
    """A row for each model, a column for each viewer."""
    height, width = TILE
    made = Image.new("RGB", (len(columns) * (width + GAP) - GAP, CAPTION + len(FILES) * (height + CAPTION)), "white")
    draw = ImageDraw.Draw(made)
    for i, (viewer, folder) in enumerate(columns.items()):
        x = i * (width + GAP)
        draw.text((x + 4, 2), viewer, "black")
        for j, file in enumerate(FILES):
            y = CAPTION + j * (height + CAPTION)
            draw.text((4, y + height + 2), f"{j + 1}. {name_of(file)}", "#555")
            path = folder / f"{name_of(file)}.png"
            if path.exists():
                with Image.open(path) as image:
                    small = image.convert("RGBA").resize((width, height), Image.Resampling.LANCZOS)
                made.paste(Image.alpha_composite(Image.new("RGBA", small.size, "white"), small), (x, y))
    return made


def main() -> None:
    rivals, out = (Path(text) for text in [*sys.argv[1:], *("/tmp/rivals", "/tmp/pictures")[len(sys.argv) - 1 :]])
    viewers: dict[str, Callable[[Path], str]] = {
        "BobRossNet": ours,
        "BobRossNet, studio": partial(ours, light="studio", background="#ffffff"),
        "pyvista": partial(in_python, "pyvista", rivals),
        "F3D": partial(in_python, "f3d", rivals),
        "model-viewer": partial(model_viewer, rivals),
    }
    columns = {}
    for viewer, render in viewers.items():
        folder = out / viewer
        folder.mkdir(parents=True, exist_ok=True)
        try:
            version = render(folder)
        except (OSError, ImportError, subprocess.CalledProcessError) as error:
            print(f"{viewer}: left out, {str(error).splitlines()[0]}")
            continue
        columns[f"{viewer} {version}" if viewer != "BobRossNet, studio" else viewer] = folder
        print(f"{viewer} {version}")
    sheet(columns).save(HERE / "pictures.webp", quality=85, method=6)


if __name__ == "__main__":
    main()
