"""The page's editor, links and files: nothing that was typed or chosen is lost."""

import numpy as np
import pytest
from test_viewer import Page, assert_equal_pictures, expected

import bobrossnet as bob
from bobrossnet import _core

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


def test_a_damaged_link_shows_a_scene_and_says_so(browser, viewer):
    for fragment, message in (("#script=!!!", "link: expected a script"), ("#scene=none", "none: expected a built-in")):
        page = browser.new_page()
        page.goto(f"{viewer.url}?size=64x48{fragment}")
        page.evaluate("() => bobrossnet.started")
        assert page.text_content("#message").startswith(message)
        page.evaluate("() => bobrossnet.converged()")
        assert page.evaluate("() => document.querySelector('#gallery').value")
        page.close()


def test_a_link_with_a_wrong_script_opens_the_editor(browser, viewer):
    page = browser.new_page()
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
    page.close()


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


def test_a_wrong_model_among_several_is_named(page, tmp_path):
    parts()[0].save(tmp_path / "a.stl")
    (tmp_path / "b.ply").write_bytes(b"OFF")
    (tmp_path / "c.step").write_bytes(b"ISO")
    page.tab.set_input_files("#file", [tmp_path / "a.stl", tmp_path / "b.ply"])
    page.wait_until(lambda: page.text("#message").startswith("b.ply: expected a PLY"))
    page.tab.set_input_files("#file", [tmp_path / "a.stl", tmp_path / "c.step"])
    page.wait_until(lambda: "convert it: bobrossnet pack c.bob c.step" in page.text("#message"))
    (tmp_path / "d e.sdf").write_text("sphere(1)")
    page.tab.set_input_files("#file", [tmp_path / "a.stl", tmp_path / "d e.sdf"])
    page.wait_until(lambda: "open one, or pack both: bobrossnet pack a.bob a.stl 'd e.sdf'" in page.text("#message"))
