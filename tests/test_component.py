"""<bob-view>: its pictures, attributes and events, from a server of static files."""

import re
from io import BytesIO

import numpy as np
import pytest
from browser import TOLD, numbers, picture_at, serving
from PIL import Image

import bobrossnet as bob
from bobrossnet.page.export import export
from bobrossnet.picture.camera import FRONT
from bobrossnet.picture.files import color_to_8_bit, to_8_bit
from bobrossnet.support.paths import VIEWER

WIDTH, HEIGHT = 128, 96

FIVE_LINES = """<!doctype html>
<script type="module" src="bob/component/bob-view.js"></script>
<style>body {{ margin: 0; background: #35a }} bob-view {{ width: {width}px; height: {height}px }}</style>
<bob-view {attributes}></bob-view>
"""

COUNT_WORKERS = """
window.alive = new Set();
window.Worker = class extends Worker {
  constructor(...settings) { super(...settings); alive.add(this); }
  terminate() { super.terminate(); alive.delete(this); }
};
"""


SCALED_RAYS = """
{
  const scaled = new Blob([`
    const { Instance } = WebAssembly;
    const now = performance.now.bind(performance);
    let times = 1, ahead = 0;
    performance.now = () => now() - ahead;
    new BroadcastChannel("rays").onmessage = ({ data }) => (times = data);
    WebAssembly.Instance = function (...given) {
      const { exports } = new Instance(...given), trace = (...values) => {
        const begin = performance.now(), result = exports.trace(...values), took = performance.now() - begin;
        while (performance.now() < begin + times * took);
        if (times < 1) ahead += (1 - times) * took;
        return result;
      };
      return { exports: { ...exports, trace } };
    };
  `], { type: "text/javascript" }), address = URL.createObjectURL(scaled);
  window.Worker = class extends Worker {
    constructor(url, options) {
      const of = `import ${JSON.stringify(address)}; import ${JSON.stringify(url)};`;
      const isTracer = String(url).endsWith("/tracer.js");
      super(isTracer ? URL.createObjectURL(new Blob([of], { type: "text/javascript" })) : url, options);
    }
  };
}
window.scaleRays = (times) => new BroadcastChannel("rays").postMessage(times);
"""
"""`scaleRays(times)` makes rays of tracers take this many times as long, below 1 by the tracers' clocks alone."""


@pytest.fixture(scope="module")
def folder(viewer, tmp_path_factory):
    """Return a folder with the page's files and scenes."""
    folder = tmp_path_factory.mktemp("host")
    export({path: content for path, content in viewer.files.items() if "." in path}, folder / "bob")
    wedge().save(folder / "wedge.glb")
    (folder / "gear.sdf").write_bytes((VIEWER / "gallery/gear.sdf").read_bytes())
    return folder


def wedge():
    """Return a mesh that looks different from each side."""
    return bob.Mesh([(0, 0, 0), (3, 0, 0), (0, 2, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])


@pytest.fixture(scope="module")
def host(folder):
    with serving(folder, Cache_Control="no-store") as address:  # files change
        yield address


@pytest.fixture
def shown(new_page, folder, host):
    """Open a page of five lines with an element of these attributes."""

    def shown(attributes, script="", size=(WIDTH, HEIGHT), **context):
        page = new_page(TOLD, script, **context)
        text = FIVE_LINES.format(attributes=attributes, width=size[0], height=size[1])
        (folder / "index.html").write_text(text)
        page.goto(host)
        return page

    return shown


def exact(page):
    """Return (H, W, 4) uint8, once it is exact."""
    page.wait_for_function("() => told.some(({ type }) => type === 'load')")
    page.evaluate("""() => {
      const view = document.querySelector("bob-view");
      if (view.getAttribute("samples") !== "1") view.setAttribute("samples", "1");
      return view.converged();
    }""")
    return pixels(page)


def pixels(page):
    address = page.evaluate("() => document.querySelector('bob-view').toDataURL()")
    return np.asarray(picture_at(address).convert("RGBA"))


def expected(scene, camera=None):
    return color_to_8_bit(bob.trace(scene, camera, size=(HEIGHT, WIDTH)).gray)


def assert_shows(page, gray):
    found = exact(page)
    assert (found[..., 3] == 255).all()
    difference = np.abs(found[..., :3].astype(int) - gray[..., None])
    assert gray.any()
    assert (difference > 1).mean() < 0.002


def told(page, kind):
    return [event["detail"] for event in page.evaluate("() => told") if event["type"] == kind]


# ---- Scenes ----------------------------------------------------------------------------------------------


def test_five_lines_show_a_file(shown, folder, host):
    asked = []
    page = shown('src="wedge.glb" alt="A wedge" camera-controls samples="1"')  # from the start on
    page.on("request", lambda request: asked.append(request.url))
    assert_shows(page, expected(bob.load(folder / "wedge.glb")))
    assert told(page, "error") == []
    assert len(told(page, "load")) == 1
    progress = [detail["totalProgress"] for detail in told(page, "progress")]
    assert progress[-1] == 1
    assert progress == sorted(progress)
    assert all(url.startswith((host, "blob:")) for url in asked)
    canvas = page.get_by_role("application", name="A wedge")
    assert canvas.get_attribute("aria-roledescription") == "3D view"


def test_another_scene_replaces_it(shown, folder):
    page = shown('src="wedge.glb"')
    exact(page)
    page.evaluate("() => { told.length = 0; document.querySelector('bob-view').src = 'gear.sdf'; }")
    assert_shows(page, expected(bob.load(folder / "gear.sdf")))


def test_the_final_picture_is_of_the_newest_scene(shown, folder):
    """Even if it was asked for while the previous scene was displayed."""
    page = shown('src="gear.sdf" samples="1"')
    exact(page)
    page.evaluate("""() => {
      const view = document.querySelector("bob-view");
      view.src = "wedge.glb";
      return view.converged();
    }""")
    assert_shows(page, expected(bob.load(folder / "wedge.glb")))
    reasons = page.evaluate("""async () => {
      const view = document.querySelector("bob-view"), other = document.createElement("bob-view"), reasons = [];
      document.body.append(other);
      for (const [of, src] of [[view, "none.ply"], [other, "none.ply"], [other, "http://["]]) {
        of.src = src;
        for (const end of [of.converged(), of.toBlob()]) reasons.push(await end.catch(({ message }) => message));
      }
      return reasons;
    }""")
    assert len(reasons) == 6
    assert all("404" in reason for reason in reasons[:4])
    assert reasons[4:] == ["src: expected an address, got http://["] * 2


def test_without_an_address_the_picture_is_empty(shown, folder):
    """As in <model-viewer>; also while a scene is being opened."""
    page = shown('src="gear.sdf" samples="1" poster="poster.svg"', COUNT_WORKERS)
    exact(page)
    for src in ("gear.sdf", "wedge.glb"):
        page.evaluate(
            """async (src) => {
          const view = document.querySelector("bob-view");
          view.src = src;
          view.src = null;
          while (view.ariaBusy) await new Promise(requestAnimationFrame);
        }""",
            src,
        )
        assert not pixels(page).any()
        assert page.is_visible("bob-view >> [part=poster]")
        assert page.evaluate("() => document.querySelector('bob-view').about()") is None
        page.evaluate("() => { document.querySelector('bob-view').src = 'wedge.glb'; }")
        assert_shows(page, expected(bob.load(folder / "wedge.glb")))
        assert page.is_hidden("bob-view >> [part=poster]")
    page.evaluate("() => document.querySelector('bob-view').removeAttribute('src')")
    page.wait_for_function("() => alive.size === 0")
    assert page.evaluate("() => told.filter(({ type }) => type === 'error')") == []


def test_an_element_in_another_document_says_so(shown):
    page = shown('src="wedge.glb"')
    exact(page)
    page.evaluate("""() => {
      const view = document.querySelector("bob-view"), frame = document.createElement("iframe");
      document.body.append(frame);
      window.reasons = [];
      view.addEventListener("error", ({ detail }) => reasons.push(detail.message));
      frame.contentDocument.body.append(view);
    }""")
    wanted = "document: expected an element that stays in its document, got one moved to another; make a new one there"
    assert page.evaluate("() => reasons") == [wanted]


def test_a_scene_from_bytes_moves_with_its_element(shown, folder):
    page = shown('src="gear.sdf" samples="1"')
    exact(page)
    page.evaluate("""async () => {
      const view = document.querySelector("bob-view"), place = document.createElement("div");
      await view.open("wedge.glb", await (await fetch("wedge.glb")).blob());
      document.body.append(place);
      place.append(view);
    }""")
    assert_shows(page, expected(bob.load(folder / "wedge.glb")))
    page.evaluate("""() => {
      const view = document.querySelector("bob-view");
      view.remove();
      view.src = "gear.sdf?newer#gear.sdf";
      document.body.append(view);
    }""")
    assert_shows(page, expected(bob.load(folder / "gear.sdf")))


LATER = """<!doctype html>
<bob-view picture-size="128x96"></bob-view>
<script>
  const view = document.querySelector("bob-view");
  Object.assign(view, { src: "wedge.glb", alt: "A wedge", camera: { azimuth: 50 } });
</script>
<script type="module" src="bob/component/bob-view.js"></script>
"""


def test_properties_set_before_the_module_has_loaded_are_taken_over(new_page, folder, host):
    (folder / "later.html").write_text(LATER)
    page = new_page(TOLD)
    page.goto(f"{host}later.html")
    assert_shows(page, expected(bob.load(folder / "wedge.glb"), bob.Camera(azimuth=50)))
    assert page.evaluate("() => [view.src, view.getAttribute('alt'), view.camera.azimuth]") == [
        "wedge.glb",
        "A wedge",
        50,
    ]


STATES = """
window.states = [];
document.addEventListener("progress", ({ target }) => {
  const { exact, final, isSmoothed, enlarged } = target.viewing.statistics;
  const { width } = target.shadowRoot.querySelector("canvas");
  states.push({ exact, final, isSmoothed, enlarged, width });
}, true);
"""


@pytest.mark.parametrize(("size", "ratio"), [((2560, 1440), 1), ((800, 600), 3)], ids=str)
def test_resting_pictures_have_the_pixels_of_the_screen(shown, folder, size, ratio):
    """However many: in rows, if they are too many for the core's memory. An enlarged picture is not called exact."""
    window = {"width": size[0], "height": size[1]}
    page = shown('src="wedge.glb"', STATES, size, viewport=window, device_scale_factor=ratio)
    found = exact(page)
    width, height = (ratio * each for each in size)
    assert found.shape == (height, width, 4)
    wanted = color_to_8_bit(bob.trace(bob.load(folder / "wedge.glb"), size=(height, width)).gray)
    assert (np.abs(found[..., 0].astype(int) - wanted) > 1).mean() < 0.002
    states = page.evaluate("() => states")
    assert states[-1]["exact"]
    for state in states:
        assert state["width"] == width or (state["enlarged"] and not state["exact"] and not state["final"])
    view = "document.querySelector('bob-view')"
    page.evaluate(f"() => {{ states.length = 0; {view}.setAttribute('samples', '4'); return {view}.converged(); }}")
    assert [state["isSmoothed"] for state in page.evaluate("() => states") if state["final"]] == [True]
    smoothed = bob.render(bob.load(folder / "wedge.glb"), size=(height, width), background="#000").rgba
    assert (np.abs(pixels(page)[..., 0].astype(int) - smoothed[..., 0]) > 2).mean() < 0.0002
    assert (np.abs(found[..., 0].astype(int) - smoothed[..., 0]) > 2).mean() > 0.0005


def test_the_picture_follows_the_screens_pixels(shown):
    """They change with the page's zoom, and with a window that moves to another screen."""
    page = shown('src="wedge.glb" edges')
    session = page.context.new_cdp_session(page)
    for ratio in (2, 1.5, 1):  # the width, too: else Chromium's emulation tells no page of the ratio
        screen = {"width": 800 + int(4 * ratio), "height": 600, "deviceScaleFactor": ratio, "mobile": False}
        session.send("Emulation.setDeviceMetricsOverride", screen)
        page.wait_for_function(
            "(size) => document.querySelector('bob-view').viewing.schedule.size.width === size", arg=WIDTH * ratio
        )
        assert exact(page).shape == (HEIGHT * ratio, WIDTH * ratio, 4)
        assert page.evaluate("() => document.querySelector('bob-view').viewing.schedule.thickness") == 1.5 * ratio
    session.send("Emulation.clearDeviceMetricsOverride")


def test_what_is_wrong_is_told_and_shown(shown):
    page = shown('src="none.ply"')
    page.wait_for_selector("#wrong:not([hidden])")
    (detail,) = told(page, "error")
    assert re.fullmatch(
        r"none\.ply: expected a file at http://\S+/none\.ply, got 404 File not found; check the address",
        detail["message"],
    )
    assert page.text_content("#wrong") == detail["message"]
    page.evaluate("""() => {
      document.querySelector("bob-view").addEventListener("error", (event) => event.preventDefault());
      document.querySelector("bob-view").src = "index.html";
    }""")
    page.wait_for_function("() => told.filter(({ type }) => type === 'error').length === 2")
    assert "expected one of .ply" in told(page, "error")[1]["message"]
    assert "404" in page.text_content("#wrong")


@pytest.mark.parametrize(
    ("attribute", "message"),
    [
        ('camera-orbit="up"', "camera-orbit: expected angles and a share, such as 120deg 70deg 100%, got up"),
        ('camera-orbit="1deg 2deg 3m"', "camera-orbit: expected angles and a share, such as 120deg 70deg 100%, got 1d"),
        ('field-of-view="wide"', "field-of-view: expected an angle, such as 35deg, got wide"),
        ('samples="all"', "samples: expected a number of at least 1, got all"),
    ],
)
def test_wrong_words_are_told(shown, attribute, message):
    page = shown(f'src="wedge.glb" {attribute}')
    exact(page)
    assert told(page, "error")[0]["message"].startswith(message)


def test_what_is_no_address_is_told(shown):
    page = shown('src="http://["')
    page.wait_for_selector("#wrong:not([hidden])")
    page.evaluate("""() => {
      const other = document.createElement("bob-view");
      other.src = "http://[";
      document.body.append(other);
      return new Promise((heard) => other.addEventListener("error", heard));
    }""")
    assert [detail["message"] for detail in told(page, "error")] == ["src: expected an address, got http://["] * 2
    page.evaluate("() => { told.length = 0; document.querySelector('bob-view').src = 'wedge.glb'; }")
    exact(page)
    assert told(page, "error") == []


def test_elements_that_leave_end_their_workers(shown, folder):
    page = shown('src="wedge.glb" camera-orbit="10deg 80deg 90%"', COUNT_WORKERS)
    before = exact(page)
    assert page.evaluate("() => alive.size") > 1
    page.evaluate("""() => {
      const other = document.createElement("bob-view");
      for (const src of ["wedge.glb", "gear.sdf"]) {
        other.src = src;
        document.body.append(other);
      }
      return new Promise((later) => setTimeout(() => later(other.remove()), 100));
    }""")
    page.evaluate("() => { window.view = document.querySelector('bob-view'); view.remove(); }")
    assert page.evaluate("() => alive.size") == 0
    page.evaluate("() => { told.length = 0; document.body.append(view); }")
    np.testing.assert_array_equal(exact(page), before)
    assert told(page, "error") == []


def test_the_package_may_be_on_another_server(new_page, folder, tmp_path):
    with serving(folder, Access_Control_Allow_Origin="*") as elsewhere, serving(tmp_path) as here:
        wedge().save(tmp_path / "wedge.stl")  # its reader needs further modules
        text = FIVE_LINES.format(attributes='src="wedge.stl"', width=WIDTH, height=HEIGHT)
        (tmp_path / "index.html").write_text(text.replace('"bob/', f'"{elsewhere}bob/'))
        page = new_page(TOLD)
        page.goto(here)
        assert_shows(page, expected(bob.load(tmp_path / "wedge.stl")))


def test_converged_of_a_scene_that_fails_is_rejected(shown):
    """And so a picture that waits for it is not waited for without end."""
    page = shown('src="wedge.glb"')
    exact(page)
    reason = page.evaluate("""() => {
      const view = document.querySelector("bob-view");
      view.camera = { azimuth: 77 };
      const end = view.converged();
      view.viewing.fail("a worker ended");
      return end.catch(({ message }) => message);
    }""")
    assert reason == "converged: expected a picture, got a scene that failed"


def test_networks_come_when_pictures_of_meshes_are_sparse(shown):
    """Otherwise they are never fetched (test_npm.py)."""
    page = shown('src="wedge.glb" picture-size="640x480"', SCALED_RAYS)
    exact(page)
    page.evaluate("""async () => {
      scaleRays(100);
      const view = document.querySelector("bob-view"), { statistics, schedule } = view.viewing;
      schedule.budget *= 6;  // so that busy machines complete by a network in time
      // At each place nothing is expected that the one before has shown.
      const isFilled = () => statistics.model === "filling" || statistics.fraction === 1;
      for (let azimuth = 0; azimuth < 10000 && isFilled(); azimuth += 100) {
        const next = new Promise((shown) => view.addEventListener("progress", shown, { once: true }));
        view.camera = { azimuth };
        await next;
      }
    }""")
    asked = page.evaluate("() => performance.getEntriesByType('resource').map(({ name }) => name.split('/').pop())")
    assert asked.index("filling.safetensors") < max(
        asked.index(name) for name in ("small.safetensors", "default.safetensors") if name in asked
    )
    assert told(page, "error") == []


@pytest.mark.parametrize("times", [400, 0.01], ids=["slow", "fast"])
def test_moving_pictures_carry_along_what_was_seen_where_rays_are_slow(shown, times):
    """With fast rays a new picture is dense, and as good."""
    page = shown('src="wedge.glb" picture-size="640x480"', SCALED_RAYS)
    exact(page)
    frames = page.evaluate(
        """async (times) => {
      const view = document.querySelector("bob-view"), { viewing } = view;
      scaleRays(times);
      viewing.schedule.refines = false;
      viewing.schedule.budget *= 6;  // so that a busy machine reprojects in time
      const frames = [];
      for (let azimuth = 0; azimuth < 40; azimuth += 2) {
        const next = new Promise((shown) => view.addEventListener("progress", shown, { once: true }));
        view.camera = { azimuth };
        await next;
        const { planes, known, height, width } = await viewing.buffers(), size = height * width;
        frames.push([planes, known].map((of) => of.subarray(0, size).reduce((sum, mask) => sum + mask, 0) / size));
      }
      return frames;
    }""",
        times,
    )
    traced, known = np.median(frames[10:], axis=0)  # the first ones measure the cost of rays
    if times > 1:
        assert 0 < traced < 0.05
        assert known > 0.25
    else:
        assert traced > 0.05
        assert known == traced
    assert told(page, "error") == []


# ---- Cameras ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "camera"),
    [
        ('camera-orbit="0deg 90deg 100%"', {"azimuth": -90, "elevation": 0}),  # the front of a glTF
        ('camera-orbit="120deg 70deg 50%"', {"azimuth": 30, "zoom": 2}),
        ('camera-orbit="1rad auto auto"', {"azimuth": np.degrees(1) - 90}),
        ('field-of-view="auto"', {"fov": 35}),
        ('field-of-view="60deg"', {"fov": 60}),
    ],
)
def test_cameras_in_the_words_of_model_viewer(shown, folder, words, camera):
    page = shown(f'src="wedge.glb" {words}')
    assert_shows(page, expected(bob.load(folder / "wedge.glb"), bob.Camera(**{"azimuth": FRONT} | camera)))


def test_scenes_with_a_front_are_seen_from_it(shown, folder):
    """A chosen camera overrides it. Scene files keep their front, and a new scene has its own default."""
    bob.save_scene(bob.load(folder / "wedge.glb"), folder / "front.bob")
    wedge().save(folder / "wedge.stl")
    page = shown('src="front.bob"')
    front = expected(bob.load(folder / "wedge.glb"))
    assert_shows(page, front)

    def azimuth_of(source, camera=None):
        return page.evaluate(
            """async ([source, camera]) => {
              const view = document.querySelector("bob-view");
              if (camera === "home") await view.goTo(camera);
              else if (camera) view.camera = camera;
              const shown = new Promise((resolve) => view.addEventListener("load", resolve, { once: true }));
              view.src = source;
              await shown;
              return view.camera.azimuth;
            }""",
            [source, camera],
        )

    assert azimuth_of("wedge.stl") == 30
    assert azimuth_of("wedge.glb") == 360 + FRONT
    assert azimuth_of("wedge.stl", {"azimuth": 30}) == 30
    assert azimuth_of("wedge.glb") == 30
    assert azimuth_of("wedge.stl", "home") == 30
    assert azimuth_of("wedge.glb") == 360 + FRONT
    page.evaluate("() => document.querySelector('bob-view').setAttribute('up', 'y')")
    assert azimuth_of("wedge.stl") == 360 + FRONT  # +z of the file


def test_hands_turn_it_only_where_they_may(shown):
    page = shown('src="wedge.glb"')
    exact(page)
    view = page.locator("bob-view")
    assert page.get_by_role("img", name="Picture").count() == 1

    def drag():
        page.mouse.move(60, 50)
        page.mouse.down()
        page.mouse.move(80, 60)
        page.mouse.up()

    assert told(page, "camera-change") == [{"source": "none"}]  # to the front
    drag()
    assert len(told(page, "camera-change")) == 1
    view.evaluate("(view) => view.toggleAttribute('camera-controls', true)")
    drag()
    assert told(page, "camera-change")[-1] == {"source": "user-interaction"}
    assert view.evaluate("(view) => view.camera.azimuth") != 360 + FRONT
    view.focus()
    page.keyboard.press("Home")
    assert view.evaluate("(view) => view.camera") == {
        "azimuth": 360 + FRONT, "elevation": 20, "roll": 0, "zoom": 1, "panX": 0, "panY": 0, "fov": 0
    }  # fmt: skip
    count = len(told(page, "camera-change"))
    view.evaluate("(view) => { view.camera = { azimuth: 40 }; view.camera = { azimuth: 40 }; }")
    assert told(page, "camera-change")[count:] == [{"source": "none"}]
    view.evaluate("(view) => view.toggleAttribute('camera-controls', false)")
    drag()
    assert len(told(page, "camera-change")) == count + 1


def test_it_turns_by_itself_while_nobody_does(shown):
    page = shown('src="wedge.glb" auto-rotate', reduced_motion="no-preference")
    page.wait_for_function("() => told.filter(({ type }) => type === 'camera-change').length > 1", timeout=20_000)
    azimuth = page.evaluate("() => document.querySelector('bob-view').camera.azimuth")
    assert 330 + FRONT < azimuth < 360 + FRONT
    page.evaluate("() => document.querySelector('bob-view').removeAttribute('auto-rotate')")
    count = len(told(page, "camera-change"))
    page.wait_for_timeout(100)
    assert len(told(page, "camera-change")) == count


def test_it_stands_still_where_little_motion_is_wanted(shown):
    page = shown('src="wedge.glb" auto-rotate', reduced_motion="reduce")
    exact(page)
    page.wait_for_timeout(3500)
    assert told(page, "camera-change") == [{"source": "none"}]  # to the front


# ---- Looks -----------------------------------------------------------------------------------------------


def test_a_hint_comes_late_and_goes_with_the_first_touch(shown):
    page = shown('src="wedge.glb" camera-controls')
    exact(page)
    assert page.locator("#prompt.unseen").count() == 1
    page.wait_for_selector("#prompt:not(.unseen)", timeout=20_000)
    assert page.text_content("#prompt") == "Drag to turn"
    page.locator("bob-view").focus()
    page.keyboard.press("ArrowLeft")
    assert page.locator("#prompt.unseen").count() == 1


def test_a_poster_is_there_until_the_first_picture(shown, folder):
    Image.new("RGB", (64, 48), (200, 0, 0)).save(folder / "poster.png")
    page = shown('poster="poster.png"')
    assert page.is_visible("bob-view img")
    page.evaluate("() => document.querySelector('bob-view').setAttribute('src', 'wedge.glb')")
    exact(page)
    assert not page.is_visible("bob-view img")


def test_backgrounds_are_seen_where_nothing_is(shown, folder):
    """Behind exact pictures, and through completed ones."""
    scene = bob.load(folder / "gear.sdf")
    page = shown('src="gear.sdf" background="linear-gradient(#fff, #f00)"', SCALED_RAYS)
    full = bob.trace(scene, size=(HEIGHT, WIDTH))
    found = exact(page)
    assert (found[..., 3] != to_8_bit(full.alpha)).mean() < 0.002
    covered = found[..., 3] > 0
    assert (np.abs(found[..., 0].astype(int) - color_to_8_bit(full.gray))[covered] > 1).mean() < 0.002
    seen = page.screenshot(clip={"x": 0, "y": 0, "width": WIDTH, "height": HEIGHT})
    picture = np.asarray(Image.open(BytesIO(seen)).convert("RGB")).astype(int)
    np.testing.assert_allclose(picture[[0, -1], 0], [(255, 255, 255), (255, 0, 0)], atol=3)
    page.evaluate("""async () => {
      const view = document.querySelector("bob-view"), { viewing } = view, { schedule } = viewing;
      schedule.refines = false;
      scaleRays(10); // so that not all is traced in a moment
      // Until silhouettes are not all traced, however fast the machine, and nothing is reprojected, however slow.
      for (let i = 0, share = NaN, reprojects = true; !(share > 0.03 && share < 0.09 && !reprojects) && i < 300; ++i) {
        if (share) schedule.budget *= share < 0.06 ? 1.2 : 0.8;
        const next = new Promise((shown) => view.addEventListener("progress", shown, { once: true }));
        view.camera = { azimuth: 40 + 50 * i };
        await next;
        share = viewing.statistics.fraction;
        const { planes, known, height, width } = await viewing.buffers(), size = height * width;
        const [traced, shown] = [planes, known].map((of) => of.subarray(0, size).reduce((sum, mask) => sum + mask, 0));
        reprojects = shown > traced;
      }
    }""")
    buffers = page.evaluate("""async () => {
      const { viewing } = document.querySelector("bob-view"), { known, height, width } = await viewing.buffers();
      return { known: new Uint8Array(known.buffer).toBase64(), size: [height, width], model: viewing.statistics.model };
    }""")
    size = buffers["size"]  # smaller on a busy machine
    part = bob.GBuffer.from_stack(numbers(buffers["known"]).reshape(5, *size))
    assert 0 < part.fraction < 1
    alpha = bob.complete(part, buffers["model"], channel="alpha")
    assert ((alpha > 0.1) & (alpha < 0.9)).mean() > 0.001
    assert np.abs(pixels(page)[..., 3] - 255 * alpha).mean() < 1


def test_colors_are_seen_through_as_well(shown, folder):
    red = bob.Instance(wedge(), material=bob.Material("#c33"))
    bob.save_scene(red, folder / "red.bob")
    found = exact(shown('src="red.bob" background="transparent"'))
    full = bob.trace(red, size=(HEIGHT, WIDTH))
    covered = full.alpha > 0
    assert (np.abs(found[..., :3].astype(int) - color_to_8_bit(full.color))[covered] > 1).mean() < 0.002
    assert not found[~covered].any()


def test_pictures_are_taken_along(shown):
    page = shown('src="wedge.glb" picture-size="200x100"')
    assert exact(page).shape == (100, 200, 4)
    kinds = page.evaluate("""async () => {
      const view = document.querySelector("bob-view");
      const blobs = [await view.toBlob(), await view.toBlob({ mimeType: "image/jpeg", qualityArgument: 0.5 })];
      return blobs.map(({ type }) => type);
    }""")
    assert kinds == ["image/png", "image/jpeg"]
