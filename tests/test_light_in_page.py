"""Lights in <bob-view>: the converged picture equals `render`'s, and the headlight is unchanged."""

import re
from contextlib import contextmanager

import numpy as np
import pytest
import trimesh
from browser import page_server, picture_at, serving
from PIL import Image

import bobrossnet as bob
from bobrossnet.command_line import cli
from bobrossnet.page.export import export, export_file
from bobrossnet.page.files import page_files
from bobrossnet.page.look import attributes

WIDTH, HEIGHT = 96, 72

VIEW = "document.querySelector('bob-view')"

PAGE = """<!doctype html>
<script type="module" src="bob/component/bob-view.js"></script>
<style>bob-view {{ width: 96px; height: 72px }}</style>
<bob-view background="transparent" {attributes}></bob-view>
"""

WATCH = """
window.pictures = [];
document.addEventListener("progress", ({ detail: { batch } }) => {
  pictures.push({ phase: batch.phase, width: batch.width, azimuth: batch.camera.azimuth });
}, true);
"""

SHARING = {"Cross_Origin_Opener_Policy": "same-origin", "Cross_Origin_Embedder_Policy": "require-corp"}

FORMULA, LITTLE = "ball.bob", 'picture-size="96x72"'


def meshes():
    """Return a red box and a mirror next to it."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    red, mirror = bob.Material("#c33", metallic=0, roughness=0.8), bob.Material("#ddd", metallic=1, roughness=0.0)
    box = bob.Mesh(corners, faces)
    return bob.Scene([bob.Instance(box, material=red), bob.Instance(box, material=mirror).translate((0, 2.6, 0))])


def glasses():
    """Return a glTF of a red, varnished ball behind a pane, and a ball of tinted glass next to it."""
    glass = {"KHR_materials_transmission": {"transmissionFactor": 1}}
    volume = {"thicknessFactor": 1, "attenuationDistance": 0.5, "attenuationColor": [0.3, 0.7, 0.5]}
    solid = glass | {"KHR_materials_ior": {"ior": 1.2}, "KHR_materials_volume": volume}
    coat = {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.2}}
    extensions = {"red": coat, "pane": glass, "solid": solid}
    shapes = {
        "red": trimesh.creation.icosphere(4),
        "pane": trimesh.creation.box((2, 2, 0.1)).apply_translation((0, 0, 1.5)),
        "solid": trimesh.creation.icosphere(4).apply_translation((2.5, 0, 0)),
    }
    for name, shape in shapes.items():
        material = trimesh.visual.material.PBRMaterial(
            name, baseColorFactor=(200, 40, 40, 255) if name == "red" else None, metallicFactor=0.0, roughnessFactor=0.0
        )
        shape.visual = trimesh.visual.TextureVisuals(material=material)

    def with_glass(tree):
        for material in tree["materials"]:
            material["extensions"] = extensions[material["name"]]

    return trimesh.Scene([*shapes.values()]).export(file_type="glb", tree_postprocessor=with_glass)


def ball():
    return bob.Scene(bob.sdf.sphere(1.0) - bob.sdf.sphere(0.6).translate((0.6, 0, 0.5)))


def light_of_day():
    """Return a sun and a sky, for a scene on the ground."""
    return [bob.Light((1, -1, 1.5), angle=4, color="#ffe9d0"), bob.Sky("#89b", "#443", intensity=0.6)]


def environment():
    """Return a sky that is bright and red on one side."""
    image = np.full((16, 32, 3), 0.2)
    image[3:8, 4:10] = (6, 1, 0.5)
    return bob.Sky(image=image, turn=30, intensity=0.8)


@pytest.fixture(scope="module")
def folder(viewer, tmp_path_factory):
    """Return a folder with the page's files and scenes."""
    folder = tmp_path_factory.mktemp("light")
    export({path: content for path, content in viewer.files.items() if "." in path}, folder / "bob")
    bob.save_scene(ball(), folder / FORMULA)
    bob.save_scene(meshes(), folder / "two.bob")
    bob.happy_tree().save(folder / "tree.ply")
    (folder / "glass.glb").write_bytes(glasses())
    bob.save_scene(bob.load(folder / "glass.glb"), folder / "glass.bob")
    return folder


@pytest.fixture
def shown(browser, folder):
    """Open a page with an element of these attributes."""
    pages, wrong = [], []

    def shown(attributes, headers=None, text=PAGE):
        (folder / "index.html").write_text(text.format(attributes=attributes))
        page = browser.new_context(viewport={"width": 640, "height": 480}).new_page()
        page.add_init_script(WATCH)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        server = serving(folder, **(headers or {}))
        pages.append((page, server))
        page.goto(server.__enter__())
        return page

    yield shown
    for page, server in pages:
        page.context.close()
        server.__exit__(None, None, None)
    assert wrong == []


def settled(page):
    """Return the last picture, (H, W, 4) uint8."""
    address = page.evaluate(f"async () => {{ await {VIEW}.converged(); return {VIEW}.toDataURL(); }}")
    return np.asarray(picture_at(address).convert("RGBA"))


OWN = {
    "day": lambda: bob.Scene(ball(), light=light_of_day(), ground=True),
    "environment": lambda: bob.Scene(meshes(), light=environment()),
    "studio": lambda: bob.Scene(ball(), light="studio", ground=False),
}


def premultiplied(rgba):
    return rgba[..., :3] * (rgba[..., 3:] / 255), rgba[..., 3].astype(float)


def assert_same(shown, expected):
    """Both have the same random numbers; light paths part where arithmetic rounds otherwise."""
    for own, other in zip(premultiplied(shown), premultiplied(expected.rgba), strict=True):
        apart = np.abs(own - other)
        assert apart.mean() < 0.05, apart.mean()
        assert (apart > 8).mean() < 1e-3, (apart > 8).mean()


@pytest.mark.parametrize("name", OWN)
def test_scene_files_have_their_own_lights(shown, folder, name):
    scene = OWN[name]()
    bob.save_scene(scene, folder / f"{name}.bob")
    page = shown(f'src="{name}.bob" {LITTLE}', SHARING)
    assert_same(settled(page), bob.render(scene, size=(HEIGHT, WIDTH)))
    page.evaluate(f"() => {VIEW}.light = 'headlight'")
    headlit = bob.render(scene, size=(HEIGHT, WIDTH), light="headlight").rgba
    assert np.abs(settled(page).astype(float) - headlit).mean() < 0.5
    page.evaluate(f"() => {VIEW}.light = null")
    assert_same(settled(page), bob.render(scene, size=(HEIGHT, WIDTH)))


@pytest.mark.parametrize("headers", [{}, SHARING], ids=["alone", "shared"])
@pytest.mark.parametrize(("file", "scene"), [("two.bob", meshes), (FORMULA, ball)])
def test_the_converged_picture_is_that_of_render(shown, file, scene, headers):
    page = shown(f'src="{file}" light="studio" {LITTLE}', headers)
    picture = settled(page)
    assert_same(picture, bob.render(scene(), size=(HEIGHT, WIDTH), light="studio"))
    assert 0 < picture[..., 3][picture[..., :3].max(-1) == 0].max() < 255  # shadows around the shapes
    assert page.evaluate("() => pictures.every(({ phase }) => phase === 'light')")


@pytest.mark.parametrize("name", ["glass.glb", "glass.bob"])
def test_glass_is_shown_as_by_render(shown, folder, name):
    page = shown(f'src="{name}" light="studio" {LITTLE}')
    assert {bob.Glass} < {type(instance.material) for instance in bob.load(folder / name).instances}
    assert_same(settled(page), bob.render(bob.load(folder / name), size=(HEIGHT, WIDTH), light="studio"))


def test_it_does_not_matter_how_the_camera_came(shown):
    """The studio stays where the first camera has it."""
    page = shown(f'src="two.bob" light="studio" {LITTLE}')
    before = settled(page)
    page.evaluate(f"() => {{ {VIEW}.camera = {{ azimuth: 70 }}; }}")
    assert not np.array_equal(settled(page), before)
    page.evaluate(f"() => {{ {VIEW}.camera = {{ azimuth: 30 }}; }}")
    np.testing.assert_array_equal(settled(page), before)


def test_moving_pictures_are_lit(shown):
    """The samples of a picture at rest are reprojected to a moving one."""
    page = shown(f'src="two.bob" light="studio" {LITTLE}')
    settled(page)
    page.evaluate(f"""async () => {{
      pictures.length = 0;
      {VIEW}.viewing.refine(false);
      {VIEW}.camera = {{ azimuth: 34 }};
      await new Promise((shown) => {VIEW}.addEventListener("progress", shown, {{ once: true }}));
    }}""")
    assert page.evaluate("() => pictures") == [{"phase": "light", "width": WIDTH, "azimuth": 34}]
    moving = np.asarray(picture_at(page.evaluate(f"() => {VIEW}.toDataURL()")).convert("RGBA"))
    page.evaluate(f"() => {VIEW}.viewing.refine(true)")
    light, alpha = (
        np.abs(a - b).mean() for a, b in zip(premultiplied(moving), premultiplied(settled(page)), strict=True)
    )
    assert max(light, alpha) < 4


@pytest.mark.parametrize("light", ["headlight", "studio"])
def test_moving_pictures_are_as_small_as_their_time_demands(shown, light):
    page = shown(f'src="two.bob" light="{light}"')
    before = settled(page)
    page.evaluate(f"""async () => {{
      {VIEW}.viewing.schedule.budget = 0.01;
      {VIEW}.viewing.refine(false);
      for (const azimuth of [34, 32, 30]) {{
        pictures.length = 0;
        {VIEW}.camera = {{ azimuth }};
        await new Promise((shown) => {VIEW}.addEventListener("progress", shown, {{ once: true }}));
      }}
    }}""")
    (moving,) = page.evaluate("() => pictures")
    assert WIDTH / 8 <= moving["width"] <= WIDTH / 2
    page.evaluate(f"() => {VIEW}.viewing.refine(true)")
    np.testing.assert_array_equal(settled(page), before)


def test_without_light_the_picture_has_the_same_bits(shown):
    page = shown(f'src="two.bob" {LITTLE}')
    headlight = settled(page)
    page.evaluate(f"() => {{ {VIEW}.light = 'studio'; }}")
    lit = settled(page)
    assert not np.array_equal(lit, headlight)
    page.evaluate(f"() => {{ {VIEW}.light = null; }}")
    np.testing.assert_array_equal(settled(page), headlight)
    page.evaluate(f"() => {{ {VIEW}.light = 'studio'; }}")
    np.testing.assert_array_equal(settled(page), lit)
    page.evaluate(f"() => {{ {VIEW}.light = 'headlight'; }}")
    np.testing.assert_array_equal(settled(page), headlight)


def test_unsmoothed_pictures_have_fewer_paths(shown):
    page = shown(f'src="two.bob" light="studio" samples="1" {LITTLE}')
    assert_same(settled(page), bob.render(meshes(), size=(HEIGHT, WIDTH), light="studio", samples=1))


def test_modules_with_lights_are_fetched_for_lights_alone(shown):
    page = shown(f'src="tree.ply" {LITTLE}')
    settled(page)
    fetched = (
        "() => performance.getEntriesByType('resource').map(({ name }) => name).filter((name) => /wasm$/.test(name))"
    )
    assert not any("light" in name for name in page.evaluate(fetched))
    page.evaluate(f"() => {{ {VIEW}.light = 'studio'; }}")
    settled(page)
    assert [name.rpartition("/")[2] for name in page.evaluate(fetched) if "light" in name] == [
        "core.mesh.light.relaxed.wasm"
    ]


def test_unknown_lights_are_named(shown):
    page = shown(f'src="two.bob" {LITTLE}')
    settled(page)
    page.evaluate(f"() => {{ {VIEW}.light = 'sun'; }}")
    assert page.inner_text("bob-view #wrong") == "light: expected scene, headlight or studio, got sun"
    settled(page)


def test_a_single_file_has_its_light(browser, tmp_path):
    file = tmp_path / "two.html"
    export_file(meshes(), "two", file, attributes(0, None, light="studio"))
    text = file.read_text()
    assert re.findall(r'"(core[.\w]*\.wasm)": ?"', text) == ["core.mesh.light.wasm"]
    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    page.goto(file.as_uri())
    assert_same(settled(page), bob.render(meshes(), size=(HEIGHT, WIDTH), light="studio"))
    page.close()


# ---- Doors -----------------------------------------------------------------------------------------------


@contextmanager
def page_of(browser, scene, look, query):
    """Open the page with a scene named two, once it is started."""
    with page_files(scene, "two", look) as files, page_server(files) as server:
        page = browser.new_page(viewport={"width": 900, "height": 600})
        page.goto(server.url + query)
        page.evaluate("() => bobrossnet.started")
        yield page
        page.close()


def test_the_page_has_a_control_and_links_with_light(browser):
    """The studio has a bright background, which shows its shadows; modes that compare exact pictures are off."""
    with page_of(browser, meshes(), attributes(0, "#000", light="studio"), "?size=48x36&scene=files/two.bob") as page:
        light = f"() => {VIEW}.light"
        assert (page.input_value("#light"), page.evaluate(light)) == ("studio", "studio")
        page.wait_for_function("() => document.querySelector('#fraction').textContent.includes('%')")
        assert page.text_content("#network") == "–"  # it completes no picture with lights
        page.evaluate("() => bobrossnet.converged()")
        behind = f"() => getComputedStyle({VIEW}).backgroundImage"
        assert page.evaluate(behind).startswith("linear-gradient")
        assert page.is_disabled("input[value=difference]")
        assert "light=studio" in page.evaluate("() => bobrossnet.link()")
        page.select_option("#light", "headlight")
        page.evaluate("() => bobrossnet.converged()")
        assert page.evaluate("() => bobrossnet.statistics.exact")
        assert page.evaluate(behind) == "none"
        assert page.is_enabled("input[value=difference]")
        assert "light" not in page.evaluate("() => bobrossnet.link()")
        page.goto(
            f"{page.url.partition('?')[0]}?size=48x36&light=headlight#scene=gyroid.bob&camera=10_20_0_1_0_0_0&light=studio"
        )
        page.evaluate("() => bobrossnet.started")
        assert page.evaluate(light) == "studio"


def test_the_page_offers_the_scenes_own_lights(browser):
    """A large environment is reduced, with a warning, and lights the scene as before."""
    rows, columns = np.mgrid[:1040, :2080]
    image = np.stack([rows / 1040, columns / 2080, 0.5 + 0 * rows], axis=2)
    scene = bob.Scene(meshes(), light=bob.Sky(image=image))
    with page_of(browser, scene, attributes(0, None), f"?size={WIDTH}x{HEIGHT}") as page:
        warning = "environment: 2080 x 1040 pixels are reduced to 1040 x 520 in the page"
        assert page.inner_text("#message") == warning
        assert page.input_value("#light") == "scene"
        assert "light" not in page.evaluate("() => bobrossnet.link()")
        shown, expected = settled(page)[..., :3], bob.render(scene, size=(HEIGHT, WIDTH))
        apart = np.abs(shown.astype(float) - premultiplied(expected.rgba)[0])[expected.rgba[..., 3] == 255]
        assert apart.mean() < 0.3
        page.select_option("#light", "headlight")
        assert "light=headlight" in page.evaluate("() => bobrossnet.link()")
        page.select_option("#gallery", "gyroid.bob")  # another scene, without lights
        page.wait_for_function("() => document.querySelector('#light').options[0].hidden")
        assert page.input_value("#light") == "headlight"
        assert "light" not in page.evaluate("() => bobrossnet.link()")


def test_exported_pages_have_their_light(tmp_path, capsys):
    bob.save_scene(meshes(), tmp_path / "two.bob")
    view = ["view", str(tmp_path / "two.bob"), "--light", "studio", "--export"]
    assert cli.main([*view, str(tmp_path / "page")]) == 0
    assert 'data-light="studio"' in (tmp_path / "page/index.html").read_text()
    assert cli.main([*view, str(tmp_path / "two.html")]) == 0
    assert ' light="studio">' in (tmp_path / "two.html").read_text()
    for name, message in (
        ("sun.hdr", "sun.hdr: can't read it"),
        ("sun", "light: expected headlight, studio or"),
    ):
        view[3] = name
        assert cli.main([*view, str(tmp_path / "sun.html")]) == 2
        assert message in capsys.readouterr().err
    white = np.full((4, 8, 3), 255, np.uint8)
    Image.fromarray(white).save(tmp_path / "white.png")
    view[3] = str(tmp_path / "white.png")
    assert cli.main([*view, str(tmp_path / "white.html")]) == 0
    assert " light=" not in (tmp_path / "white.html").read_text().partition("<bob-view")[2].partition(">")[0]


def test_notebooks_have_their_light():
    pytest.importorskip("anywidget", reason="anywidget, which shows widgets in notebooks, is not installed")
    assert bob.view(meshes()).light == "headlight"
    assert bob.view(meshes(), light="studio").light == "studio"
    lit = bob.Scene(meshes(), light="studio")
    assert bob.view(lit).light == "studio"
    assert bob.view(lit, light="headlight").light == "headlight"
    assert bob.view(bob.Scene(meshes(), light=bob.Light((0, 0, 1)))).light == "scene"
    own = bob.view(meshes(), light=light_of_day(), ground=True, size=(36, 48))
    assert own.light == "scene"
    expected = bob.render(meshes(), own.camera, size=(36, 48), light=light_of_day(), ground=True, samples=1)
    assert np.array_equal(own.snapshot(samples=1).rgba, expected.rgba)
    shadows = bob.view(lit, size=(36, 48)).snapshot(samples=1).alpha
    assert ((shadows > 0.1) & (shadows < 0.9)).any()
    with pytest.raises(bob.InputError, match="light: expected headlight, studio or the path"):
        bob.view(meshes(), light="sun")
