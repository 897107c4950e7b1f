"""Default pictures by pyvista or F3D, in a Python that has it: `python rival_pictures.py NAME SIZE FILE PICTURE ...`.

Prints the version. This file imports nothing of the project, which that Python may lack.
"""

from __future__ import annotations

import sys


def pyvista(width: int, height: int, file: str, picture: str) -> str:
    """Scenes are imported with their materials; meshes are added to a plotter."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=(width, height))
    if file.endswith((".glb", ".gltf")):
        plotter.import_gltf(file)
    elif file.endswith(".obj"):
        plotter.import_obj(file)
    else:
        plotter.add_mesh(pyvista.read(file))
    plotter.screenshot(picture)
    plotter.close()
    return str(pyvista.__version__)


def f3d(width: int, height: int, file: str, picture: str) -> str:
    """Draw with the smooth edges, tone mapping and grid that its application turns on."""
    import f3d

    f3d.Engine.autoload_plugins()
    engine = f3d.Engine.create(True)
    engine.options["render.effect.antialiasing.mode"] = "fxaa"
    engine.options["render.effect.tone_mapping"] = True
    engine.options["render.grid.enable"] = True
    engine.window.size = (width, height)
    engine.scene.add(file)
    engine.window.render_to_image().save(picture)
    return str(f3d.__version__)


def main() -> None:
    name, size, *files = sys.argv[1:]
    width, height = map(int, size.split("x"))
    version = ""
    for file, picture in zip(files[::2], files[1::2], strict=True):
        try:
            version = {"pyvista": pyvista, "f3d": f3d}[name](width, height, file, picture)
        except Exception as error:
            print(f"{file}: {error}", file=sys.stderr)
    print(version)


if __name__ == "__main__":
    main()
