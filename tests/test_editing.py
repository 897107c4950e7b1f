"""The page's editor, links and files: nothing that was typed or chosen is lost."""

import numpy as np
import pytest
from PIL import Image
from test_viewer import Page, assert_equal_pictures, expected

import bobrossnet as bob
from bobrossnet import _core, sdf

SIZE = "?size=128x96"

SCRIPT = "RADIUS = 2.0  # of the ball\nball = sphere(RADIUS)\nball - box(1)\n"
TURN = "slider.value = %s; slider.dispatchEvent(new Event('input', { bubbles: true }));"


@pytest.fixture
def page(tabs, viewer):
    page = Page(tabs, viewer.url + SIZE)
    page.choose("csg.sdf")
    page.tab.click("#script summary")
    yield page
    page.close()


def fill(page, text):
    page.tab.fill("#text", text)
    page.opened()


def slide(page, *values):
    """Drag the slider over these values."""
    turns = " ".join(TURN % value for value in values)
    page.tab.evaluate(f"""() => {{
      const slider = document.querySelector("#sliders input");
      slider.focus();
      {turns}
      slider.dispatchEvent(new Event("change", {{ bubbles: true }}));
    }}""")
    page.opened()


def script(page):
    return page.tab.input_value("#text")


def listed(page):
    return page.tab.locator("#edited option").all_text_contents()


# ---- Undo ------------------------------------------------------------------------------------------------


def test_a_slider_is_undone_in_one_step_and_typing_too(page):
    fill(page, SCRIPT)
    original = page.exact()
    page.tab.wait_for_timeout(1100)  # quick changes would be one step
    page.tab.focus("#text")
    page.tab.keyboard.press("Control+End")
    page.tab.keyboard.type("# a note")
    typed = script(page)
    slide(page, 2.1, 2.4, 3.0)
    assert script(page).startswith("RADIUS = 3 ")
    page.tab.keyboard.press("Control+z")  # on the slider
    assert script(page) == typed
    assert page.tab.evaluate("() => document.activeElement.value") == "2"
    page.tab.focus("#text")
    page.tab.keyboard.press("Control+z")
    assert script(page) == SCRIPT
    page.opened()
    np.testing.assert_array_equal(page.exact(), original)
    page.tab.keyboard.press("Control+Shift+z")
    assert script(page) == typed
    page.tab.keyboard.press("Control+y")
    assert script(page).startswith("RADIUS = 3 ")
    page.tab.keyboard.press("Control+y")
    assert script(page).startswith("RADIUS = 3 ")


def test_another_scene_begins_another_history(page):
    fill(page, SCRIPT)
    page.choose("gear.sdf")
    gear = script(page)
    page.tab.focus("#text")
    page.tab.keyboard.press("Control+z")
    assert script(page) == gear


# ---- Edits are kept --------------------------------------------------------------------------------------


def test_edits_outlast_other_scenes_and_a_reload(page):
    fill(page, SCRIPT)
    edited = page.exact()
    page.choose("gear.sdf")
    assert listed(page) == ["Ball, box and cylinders"]
    assert script(page) != SCRIPT
    page.choose("edited: Ball, box and cylinders")
    assert script(page) == SCRIPT
    np.testing.assert_array_equal(page.exact(), edited)
    page.tab.reload()
    page.tab.evaluate("() => bobrossnet.started")
    assert script(page) == SCRIPT
    np.testing.assert_array_equal(page.exact(), edited)
    assert page.tab.input_value("#gallery") == "edited: Ball, box and cylinders"
    page.choose("gear.sdf")
    page.tab.reload()
    page.tab.evaluate("() => bobrossnet.started")
    assert listed(page) == ["Ball, box and cylinders"]
    assert page.tab.input_value("#gallery") != "edited: Ball, box and cylinders"


def test_a_wrong_text_is_kept_too(page):
    fill(page, SCRIPT)
    page.tab.fill("#text", "sphere(")
    page.tab.wait_for_selector("#numbers .wrong")
    page.tab.reload()
    page.tab.evaluate("() => bobrossnet.started")
    assert script(page) == "sphere("
    assert page.tab.is_visible("#error")


def test_edits_of_one_scene_do_not_replace_each_other(page):
    fill(page, SCRIPT)
    page.choose("csg.sdf")
    assert script(page) != SCRIPT
    fill(page, "box(1)\n")
    assert listed(page) == ["Ball, box and cylinders", "Ball, box and cylinders 2"]
    page.choose("edited: Ball, box and cylinders")
    assert script(page) == SCRIPT


def test_a_new_visit_follows_its_link(page, viewer):
    fill(page, SCRIPT)
    page.visit(f"{viewer.url}{SIZE}#scene=gear.sdf")
    assert page.tab.input_value("#gallery") == "gear.sdf"
    assert listed(page) == ["Ball, box and cylinders"]


# ---- Links -----------------------------------------------------------------------------------------------


def test_another_link_in_the_same_tab_is_followed(page):
    fill(page, "sphere(1)")
    link = page.tab.evaluate("() => bobrossnet.link()")
    page.tab.evaluate("() => { location.hash = '#scene=knot.bob&camera=50_10_0_1_0_0_0'; }")
    page.wait_until(lambda: page.tab.input_value("#gallery") == "knot.bob")
    assert page.camera() == bob.Camera(50, 10)
    page.tab.evaluate("(link) => { location.hash = new URL(link).hash; }", link)
    page.wait_until(lambda: script(page) == "sphere(1)")
    page.opened()
    ball = bob.Implicit(_core.run_script(b"sphere(1)").expression)
    assert_equal_pictures(page.exact(), expected(ball))
    page.tab.evaluate("() => { location.hash = '#script=!!!'; }")
    page.wait_until(lambda: page.text("#message").startswith("link: expected a script"))
    page.tab.go_back()
    page.tab.go_back()
    page.wait_until(lambda: page.tab.input_value("#gallery") == "knot.bob")


def test_a_damaged_link_shows_a_scene_and_says_so(new_page, viewer):
    for fragment, message in (("#script=!!!", "link: expected a script"), ("#scene=none", "none: expected a built-in")):
        page = new_page()
        page.goto(f"{viewer.url}?size=64x48{fragment}")
        page.evaluate("() => bobrossnet.started")
        assert page.text_content("#message").startswith(message)
        page.evaluate("() => bobrossnet.converged()")
        assert page.evaluate("() => document.querySelector('#gallery').value")


def test_a_link_with_a_wrong_script_opens_the_editor(new_page, viewer):
    page = new_page()
    page.goto(f"{viewer.url}?size=64x48")
    page.evaluate("() => bobrossnet.started")
    fragment = page.evaluate("""async () => {
      const stream = new Blob(["spere(1)"]).stream().pipeThrough(new CompressionStream("deflate-raw"));
      return "#script=" + btoa(String.fromCharCode(...new Uint8Array(await new Response(stream).arrayBuffer())));
    }""")
    page.goto("about:blank")
    page.goto(f"{viewer.url}?size=64x48{fragment}")
    page.evaluate("() => bobrossnet.started")
    assert page.is_visible("#error")
    assert page.text_content("#error").startswith("line 1, column 1: ")
    assert page.input_value("#text") == "spere(1)"


# ---- Files -----------------------------------------------------------------------------------------------


def parts():
    """Return two parts of one assembly."""
    return [
        bob.Mesh([(x, 0, 0), (x + 3, 0, 0), (x, 2, 0), (x, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
        for x in (0, 4)
    ]


def test_several_models_are_one_scene(page, tmp_path):
    files = [tmp_path / "a.stl", tmp_path / "b.ply"]
    for part, file in zip(parts(), files, strict=True):
        part.save(file)
    page.tab.set_input_files("#file", files)
    page.wait_until(lambda: page.text("#gallery option:checked") == "a.stl and 1 more")
    assert page.text("#message") == ""
    assert_equal_pictures(page.exact(), expected(bob.load(files)))


def test_files_that_are_no_models_are_not_opened(page, tmp_path):
    """Whatever their order, as in downloads with a licence."""
    (tmp_path / "LICENSE.txt").write_text("CC0")
    parts()[0].save(tmp_path / "part.stl")
    page.tab.set_input_files("#file", [tmp_path / "LICENSE.txt", tmp_path / "part.stl"])
    page.wait_until(lambda: page.text("#gallery option:checked") == "part.stl")
    assert page.text("#message") == ""
    page.tab.set_input_files("#file", tmp_path / "LICENSE.txt")
    page.wait_until(lambda: page.text("#message").startswith("LICENSE.txt: expected one of .ply"))


def dropped(page, *paths):
    session = page.tab.context.new_cdp_session(page.tab)
    data = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}
    for event in ("dragEnter", "dragOver", "drop"):
        session.send("Input.dispatchDragEvent", {"type": event, "x": 60, "y": 60, "data": data})


def test_folders_are_dropped(page, tmp_path):
    """With textures in a folder below."""
    folder = tmp_path / "model"
    (folder / "textures").mkdir(parents=True)
    (folder / "empty").mkdir()
    (folder / "LICENSE.txt").write_text("CC0")
    Image.new("RGB", (2, 2), (255, 0, 0)).save(folder / "textures/red.png")
    (folder / "part.mtl").write_text("newmtl red\nmap_Kd textures/red.png\n")
    corners = "v 0 0 0\nv 3 0 0\nv 0 2 0\nv 0 0 1\nvt 0 0\n"
    faces = "f 1/1 3/1 2/1\nf 1/1 2/1 4/1\nf 2/1 3/1 4/1\nf 3/1 1/1 4/1\n"
    (folder / "part.obj").write_text(f"mtllib part.mtl\n{corners}usemtl red\n{faces}")
    dropped(page, folder)
    page.wait_until(lambda: page.text("#gallery option:checked") == "part.obj")
    assert page.text("#message") == ""
    picture = page.exact()
    assert picture[..., 0].max() > 100
    assert picture[..., 1].max() < 20
    dropped(page, folder / "empty")
    page.wait_until(lambda: page.text("#message") == "drop: expected files, got an empty folder")


def test_dropped_text_is_the_editors(page):
    assert page.tab.evaluate("""() => ["text/plain", "Files"].map((type) => {
      const dataTransfer = new DataTransfer();
      if (type === "Files") dataTransfer.items.add(new File([], "a.stl"));
      else dataTransfer.setData(type, "sphere(1)");
      const settings = { dataTransfer, bubbles: true, cancelable: true }, text = document.querySelector("#text");
      return ["dragover", "drop"].map((name) => text.dispatchEvent(new DragEvent(name, settings)));
    })""") == [[True, True], [False, False]]
    page.wait_until(lambda: page.text("#message") == "a.stl: expected a mesh, got an empty file")


def test_a_wrong_model_among_several_is_named(page, tmp_path):
    parts()[0].save(tmp_path / "a.stl")
    (tmp_path / "b.ply").write_bytes(b"OFF")
    (tmp_path / "c.step").write_bytes(b"ISO")
    page.tab.set_input_files("#file", [tmp_path / "a.stl", tmp_path / "b.ply"])
    page.wait_until(lambda: page.text("#message").startswith("b.ply: expected a PLY"))
    page.tab.set_input_files("#file", [tmp_path / "a.stl", tmp_path / "c.step"])
    page.wait_until(lambda: "convert it: bobrossnet pack c.bob c.step" in page.text("#message"))


def test_lights_of_files_that_are_opened_together_are_told(page, tmp_path):
    bob.save_scene(bob.Scene(sdf.sphere(1), light="studio"), tmp_path / "lit.bob")
    sdf.box(1).mesh(0.2).save(tmp_path / "box.stl")
    files = [tmp_path / "box.stl", tmp_path / "lit.bob"]
    page.tab.set_input_files("#file", files)
    page.opened()
    with pytest.warns(bob.InputWarning, match=r"lit\.bob: its lights are not shown") as told:
        assert bob.load(files).light is None
    assert page.text("#message") == str(told[0].message)
    assert bob.load(files[1]).light is not None


@pytest.mark.parametrize("first", range(3))
def test_files_of_all_kinds_are_opened_together(page, tmp_path, first):
    """In one unit: that of the first file that has one, as in Python."""
    ball, box, tall = sdf.sphere(1), sdf.box(1), sdf.box((1, 1, 3))
    ball.mesh(0.1).save(tmp_path / "ball.stl")
    box.translate((3, 0, 0)).save(tmp_path / "box.3mf")  # in mm
    bob.save_scene(bob.Scene([tall.translate((0, 0.15, 0))], unit="in"), tmp_path / "tall.bob")
    names = ["ball.stl", "box.3mf", "tall.bob"]
    files = [tmp_path / name for name in names[first:] + names[:first]]
    page.tab.set_input_files("#file", files)
    page.opened()
    with pytest.warns(bob.InputWarning, match="taken as") as told:
        scene = bob.load(files)
    assert page.text("#message") == str(told[0].message)
    assert_equal_pictures(page.exact(), expected(scene))
    assert page.tab.evaluate("async () => (await document.querySelector('#picture').about()).unit") == scene.unit
    page.tab.check("#y-up")
    page.opened()
    assert_equal_pictures(page.exact(), expected(scene.turned_upright(), bob.Camera(azimuth=300)))
