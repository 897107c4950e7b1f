"""The controls of <bob-view>: wheel, fingers, keys and named views, in pages that scroll."""

import numpy as np
import pytest
from browser import TOLD, picture_at, serving
from PIL import Image
from statues import LYING

import bobrossnet as bob
from bobrossnet.page.export import export
from bobrossnet.picture.camera import FRONT
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.pictures.fitting import fitted
from bobrossnet.support.paths import VIEWER

WIDTH, HEIGHT = 300, 240

PAGE = """<!doctype html>
<meta name="viewport" content="width=device-width">
<script type="module" src="bob/component/bob-view.js"></script>
<style>body {{ margin: 0; height: {page} }} bob-view {{ width: {width}px; height: {height}px }}</style>
<bob-view alt="A box" samples="1" camera-controls {attributes}>{children}</bob-view>
"""

VIEW = "document.querySelector('bob-view')"


@pytest.fixture(scope="module")
def folder(viewer, tmp_path_factory):
    """Return a folder with the element's files and scenes."""
    folder = tmp_path_factory.mktemp("controls")
    export({path: content for path, content in viewer.files.items() if "." in path}, folder / "bob")
    bob.save_scene(scene(), folder / "two.bob")
    (folder / "gear.sdf").write_bytes((VIEWER / "gallery/gear.sdf").read_bytes())
    return folder


def scene():
    """Return two boxes far from the origin, a large one and a small one."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    large, small = bob.Mesh(corners * (3, 2, 1), faces), bob.Mesh(corners * 0.5, faces)
    return bob.Scene(
        [
            bob.Instance(large, name="large").translate((100, 50, 0)),
            bob.Instance(small, name="small").translate((100, 50, 3)),
        ]
    )


@pytest.fixture(scope="module")
def host(folder):
    with serving(folder, Cache_Control="no-store") as address:  # files change
        yield address


@pytest.fixture
def shown(new_page, folder, host):
    """Open a page with an element of these attributes; `page` is the page's height."""

    def shown(attributes='src="two.bob"', page="3000px", children="", script="", **context):
        tab = new_page(TOLD, script, **{"viewport": {"width": 800, "height": 600}, **context})
        (folder / "index.html").write_text(
            PAGE.format(attributes=attributes, page=page, width=WIDTH, height=HEIGHT, children=children)
        )
        tab.goto(host)
        tab.wait_for_function("() => told.some(({ type }) => type === 'load')")
        return tab

    return shown


def camera(page):
    found = page.evaluate(f"() => {VIEW}.camera")
    pan = found.pop("panX"), found.pop("panY")
    return bob.Camera(**found, pan=pan)


def changes(page):
    return page.evaluate("() => told.filter(({ type }) => type === 'camera-change').length")


def expected(view, size=(HEIGHT, WIDTH)):
    return color_to_8_bit(bob.trace(scene(), view, size=size).gray)


def settled(page):
    """Return the exact picture, (H, W, 4) uint8."""
    address = page.evaluate(f"async () => {{ await {VIEW}.converged(); return {VIEW}.toDataURL(); }}")
    return np.asarray(picture_at(address).convert("RGBA"))


# ---- Saving ----------------------------------------------------------------------------------------------

SAVE = f"""async () => {{
  const view = {VIEW}, {{ schedule }} = view.viewing;
  await view.converged();
  schedule.budget = 10;
  view.autoRotate = true; // it would turn at once
  view.camera = {{ azimuth: 70 }};
  const steps = [];
  view.addEventListener("progress", ({{ detail }}) => steps.push(detail.totalProgress));
  const [blob] = await Promise.all([view.toBlob(), view.toBlob()]), reader = new FileReader();
  view.autoRotate = false;
  await new Promise((done) => {{ reader.onload = done; reader.readAsDataURL(blob); }});
  return [reader.result, steps, schedule.refines];
}}"""


@pytest.mark.parametrize("refines", [True, False])
def test_a_picture_saved_in_motion_is_exact_and_of_full_size(shown, refines):
    page = shown('src="gear.sdf" auto-rotate-delay="0"', device_scale_factor=2, reduced_motion="no-preference")
    page.evaluate(f"() => {VIEW}.converged()")
    page.evaluate(f"(refines) => {{ {VIEW}.viewing.schedule.refines = refines; }}", refines)
    address, steps, still = page.evaluate(SAVE)
    found = np.asarray(picture_at(address).convert("RGB"))
    gear = bob.load(VIEWER / "gallery/gear.sdf")
    exact = color_to_8_bit(bob.trace(gear, bob.Camera(azimuth=70), size=(2 * HEIGHT, 2 * WIDTH)).gray)
    assert found.shape[:2] == exact.shape
    assert (np.abs(found.astype(int) - exact[..., None]).max(axis=-1) > 1).mean() < 0.005
    assert 1 in steps
    assert still == refines


def test_a_removed_element_saves_nothing_and_says_so(shown):
    page = shown()
    told = page.evaluate(f"""async () => {{
      const view = {VIEW};
      await view.converged();
      view.camera = {{ azimuth: 1 }};
      const converged = view.converged().catch(({{ message }}) => message);
      const saved = view.toBlob().catch(({{ message }}) => message);
      view.remove();
      return [await converged, await saved];
    }}""")
    assert told == ["converged: expected an element in a document, got one that was removed"] * 2


# ---- Wheel -----------------------------------------------------------------------------------------------


def wheel(page, down):
    page.mouse.move(WIDTH / 4, HEIGHT / 4)
    page.mouse.wheel(0, down)
    page.wait_for_timeout(150)


def scrolled(page):
    return page.evaluate("() => scrollY")


def test_a_page_is_scrolled_past_the_picture(shown):
    page = shown()
    wheel(page, 100)
    assert scrolled(page) == 100
    assert camera(page) == bob.Camera()


def test_the_wheel_zooms_where_the_picture_has_the_focus(shown):
    page = shown()
    page.locator("bob-view").focus()
    wheel(page, -100)
    assert camera(page).zoom > 1.1
    assert scrolled(page) == 0
    page.keyboard.press("Escape")
    zoom = camera(page).zoom
    wheel(page, 100)
    assert scrolled(page) == 100
    assert camera(page).zoom == zoom


def test_a_pinch_on_a_trackpad_zooms_the_picture_and_not_the_page(shown):
    page = shown()
    page.keyboard.down("Control")
    wheel(page, -10)
    page.keyboard.up("Control")
    assert camera(page).zoom == pytest.approx(np.exp(0.1))
    assert page.evaluate("() => [visualViewport.scale, devicePixelRatio]") == [1, 1]


def test_the_wheel_zooms_where_nothing_scrolls(shown):
    page = shown(page="auto")
    wheel(page, -100)
    assert camera(page).zoom > 1.1
    page.evaluate(f"""() => {{
      const box = document.createElement("div");
      box.style = "height: 200px; overflow: auto";
      document.body.append(box);
      box.append({VIEW});
      return {VIEW}.converged();
    }}""")
    before = camera(page)
    wheel(page, 100)
    assert page.evaluate("() => document.querySelector('div').scrollTop") > 0
    assert camera(page) == before


# ---- Touch -----------------------------------------------------------------------------------------------

PHONE = {"has_touch": True, "is_mobile": True, "viewport": {"width": 400, "height": 700}}


class Hand:
    """Fingers on a touch screen."""

    def __init__(self, page):
        self._session = page.context.new_cdp_session(page)
        self._page = page

    def move(self, *ways, steps=8):
        """Move each finger from one place to another."""
        for i in range(steps + 1):
            points = [
                {"x": x0 + (x1 - x0) * i / steps, "y": y0 + (y1 - y0) * i / steps, "id": finger}
                for finger, ((x0, y0), (x1, y1)) in enumerate(ways)
            ]
            self._send("touchMove" if i else "touchStart", points)
        self._page.wait_for_timeout(60)  # no inertia
        self._send("touchEnd", [])
        self._page.wait_for_timeout(100)

    def _send(self, kind, points):
        self._session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        self._page.wait_for_timeout(16)


def test_a_finger_across_turns_and_a_finger_down_scrolls(shown):
    page = shown(**PHONE)
    hand = Hand(page)
    hand.move(((100, 100), (200, 110)))
    turned = camera(page)
    assert turned.azimuth != 30
    assert scrolled(page) == 0
    hand.move(((100, 200), (105, 80)))
    assert scrolled(page) > 50
    assert camera(page) == turned


@pytest.mark.parametrize("across", [False, True])
def test_where_the_page_may_not_scroll_any_finger_turns(shown, across):
    page = shown('src="two.bob" touch-action="none"', **PHONE)
    Hand(page).move(((100, 100), (180, 100) if across else (100, 180)))
    turned = camera(page)
    assert (turned.azimuth != 30, turned.elevation != 20) == (across, not across)
    assert scrolled(page) == 0


def test_two_fingers_pinch_and_pan(shown):
    page = shown(**PHONE)
    hand = Hand(page)
    hand.move(((120, 120), (70, 120)), ((180, 120), (230, 120)))
    pinched = camera(page)
    assert pinched.zoom == pytest.approx(160 / 60, rel=0.05)
    assert page.evaluate("() => visualViewport.scale") == 1
    hand.move(((120, 120), (160, 140)), ((180, 120), (220, 140)))
    panned = camera(page)
    assert panned.zoom == pytest.approx(pinched.zoom, rel=0.01)
    assert panned.pan[0] < pinched.pan[0]
    assert panned.pan[1] > pinched.pan[1]
    assert scrolled(page) == 0


# ---- Inertia ---------------------------------------------------------------------------------------------


THROW = f"""() => {{
  const canvas = {VIEW}.shadowRoot.querySelector("canvas");
  canvas.setPointerCapture = () => {{}};
  let time = performance.now();
  const send = (type, clientX) => {{
    const event = new PointerEvent(type, {{ pointerId: 1, buttons: 1, clientX, clientY: 100 }});
    Object.defineProperty(event, "timeStamp", {{ value: time += 8 }}); // whatever else the machine does
    canvas.dispatchEvent(event);
  }};
  send("pointerdown", 100);
  for (let x = 105; x < 165; x += 5) send("pointermove", x);
  send("pointerup", 160);
  return {VIEW}.camera.azimuth;
}}"""

FRAMES = "() => new Promise((shown) => requestAnimationFrame(() => requestAnimationFrame(shown)))"


def test_a_thrown_picture_turns_on_and_slows_down(shown):
    page = shown(reduced_motion="no-preference")
    released = page.evaluate(THROW)
    page.wait_for_timeout(1500)
    page.evaluate(FRAMES)  # on a busy machine these are late
    rested = camera(page).azimuth
    assert 2 < (released - rested) % 360 < 180
    assert settled(page).any()
    page.wait_for_timeout(200)
    assert camera(page).azimuth == rested


@pytest.mark.parametrize("stop", ["press", "key", "set", "calm"])
def test_inertia_ends_where_something_else_moves_or_motion_is_unwanted(shown, stop):
    page = shown(reduced_motion="reduce" if stop == "calm" else "no-preference")
    page.evaluate(THROW)
    if stop == "press":
        page.mouse.move(100, 100)
        page.mouse.down()
    elif stop == "key":
        page.locator("bob-view").focus()
        page.keyboard.press("+")
    elif stop == "set":
        page.evaluate(f"() => {{ {VIEW}.camera = {{ azimuth: 5 }}; }}")
    before = camera(page)
    page.wait_for_timeout(300)
    assert camera(page) == before


# ---- Keys and views --------------------------------------------------------------------------------------

SIDES = {"front": (270, 0), "top": (270, 90), "right": (0, 0), "back": (90, 0), "bottom": (270, -90), "left": (180, 0)}


def test_numbers_show_the_sides(shown):
    page = shown()
    page.locator("bob-view").focus()
    for i, side in enumerate(SIDES.values()):
        page.keyboard.press(str(i + 1))
        view = camera(page)
        assert (view.azimuth, view.elevation) == side
    page.keyboard.press("1")
    found = settled(page)[..., 0]
    assert (np.abs(found.astype(int) - expected(bob.Camera(azimuth=270, elevation=0))) > 1).mean() < 0.002
    page.keyboard.press("PageUp")
    assert camera(page).zoom == pytest.approx(1.15)
    page.keyboard.press("0")
    assert camera(page) == bob.Camera()


def test_a_key_goes_on_from_where_the_last_one_leads(shown):
    page = shown(reduced_motion="no-preference")
    page.evaluate(f"""() => {{
      const picture = {VIEW}.shadowRoot.querySelector("[tabindex]");
      for (const key of ["4", "ArrowRight", "p"]) picture.dispatchEvent(new KeyboardEvent("keydown", {{ key }}));
    }}""")
    view = camera(page)
    assert (view.azimuth, view.elevation) == (SIDES["back"][0] + 5, SIDES["back"][1])
    assert view.fov > 0


@pytest.mark.parametrize("fov", [0, 50])
def test_fit_fills_the_picture(shown, fov):
    """As bobrossnet.fitted, which has the vertices."""
    page = shown()
    page.evaluate(f"(fov) => {{ {VIEW}.camera = {{ azimuth: 250, elevation: 40, zoom: 3, panX: 1, fov }}; }}", fov)
    page.evaluate(f"() => {VIEW}.fit()")
    found, wanted = camera(page), fitted(scene(), bob.Camera(250, 40, fov=fov), size=(HEIGHT, WIDTH))
    assert found.zoom == pytest.approx(wanted.zoom, rel=0.03)
    assert found.pan == pytest.approx(wanted.pan, abs=0.02)
    page.evaluate(f"() => {{ {VIEW}.camera = {{ zoom: 3, panX: 1 }}; }}")
    page.locator("bob-view").focus()
    page.keyboard.press("f")
    page.wait_for_function(f"(zoom) => Math.abs({VIEW}.camera.zoom - zoom) < 1e-3", arg=found.zoom)


def test_cameras_go_smoothly_the_short_way(shown):
    page = shown(reduced_motion="no-preference")
    steps = page.evaluate(f"""async () => {{
      const view = {VIEW}, steps = [];
      view.camera = {{ azimuth: 350, zoom: 1 }};
      view.addEventListener("camera-change", () => steps.push([view.camera.azimuth, view.camera.zoom]));
      await view.goTo({{ azimuth: 20, zoom: 4 }});
      return steps;
    }}""")
    assert len(steps) > 2
    ways = [(azimuth - 350) % 360 for azimuth, _ in steps]
    assert ways == sorted(ways)
    assert steps[-1] == [20, 4]
    assert [zoom for _, zoom in steps] == sorted(zoom for _, zoom in steps)
    told = page.evaluate(f"() => {VIEW}.goTo('above').catch(({{ message }}) => message)")
    assert told == "goTo: expected home, front, top, right, back, bottom, left or a camera, got above"


# ---- Surfaces under the pointer --------------------------------------------------------------------------


def corner_at(page, point, view):
    """Return the place of a point in the window."""
    row, column, _ = view.core(scene().center, scene().radius).seen(HEIGHT, WIDTH, in_sphere(point))[0]
    return float(column) + 0.5, float(row) + 0.5


def in_sphere(point):
    return ((np.array([point], float) - scene().center) / scene().radius).astype(np.float32)


@pytest.mark.parametrize("fov", [0, 60])
def test_a_click_picks_a_point_of_the_scene(shown, fov):
    page = shown(f'src="two.bob" field-of-view="{fov}deg" camera-orbit="130deg 60deg 100%"')
    view = camera(page)
    for point, normal, part in [((100, 50, 3.5), (0, 0, 1), "small"), ((103, 51, 0.5), (1, 0, 0), "large")]:
        before = page.evaluate("() => told.filter(({ type }) => type === 'pick').length")
        page.mouse.click(*corner_at(page, point, view))
        page.wait_for_function("(n) => told.filter(({ type }) => type === 'pick').length > n", arg=before)
        picked = page.evaluate("() => told.filter(({ type }) => type === 'pick').at(-1).detail")
        # The window's places are whole pixels.
        assert picked["point"] == pytest.approx(point, abs=0.1)
        assert picked["normal"] == pytest.approx(normal, abs=1e-4)
        assert picked["part"] == part
    found = page.evaluate(f"([x, y]) => {VIEW}.pick(x, y)", list(corner_at(page, (100, 50, 3.5), view)))
    assert found["point"] == pytest.approx((100, 50, 3.5), abs=2e-3 * scene().radius)
    assert page.evaluate(f"() => {VIEW}.pick(2, 2)") is None
    assert page.evaluate(f"() => {VIEW}.pick(700, 2)") is None


def test_a_drag_picks_nothing(shown):
    page = shown()
    page.mouse.move(150, 120)
    page.mouse.down()
    page.mouse.move(180, 130)
    page.mouse.up()
    page.wait_for_timeout(200)
    assert page.evaluate("() => told.filter(({ type }) => type === 'pick')") == []


@pytest.mark.parametrize("fov", [0, 60])
def test_a_double_click_centres_a_point_and_turns_about_it(shown, fov):
    page = shown(f'src="two.bob" field-of-view="{fov}deg" camera-orbit="130deg 60deg 100%"')
    point = (100, 50, 3.5)
    page.mouse.dblclick(*corner_at(page, point, camera(page)))
    page.wait_for_function(f"() => {VIEW}.camera.panY > 0.1")
    assert corner_at(page, point, camera(page)) == pytest.approx((WIDTH / 2, HEIGHT / 2), abs=1)
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowUp")
    page.mouse.move(100, 100)
    page.mouse.down()
    page.mouse.move(160, 120)
    page.mouse.up()
    turned = camera(page)
    assert turned.azimuth != 40
    assert corner_at(page, point, turned) == pytest.approx((WIDTH / 2, HEIGHT / 2), abs=4)  # of the pixel clicked
    page.mouse.dblclick(3, 3)  # next to the scene: fits everything
    wanted = fitted(scene(), bob.Camera(turned.azimuth, turned.elevation, fov=fov), size=(HEIGHT, WIDTH))
    page.wait_for_function(f"(zoom) => Math.abs({VIEW}.camera.zoom / zoom - 1) < 0.03", arg=wanted.zoom)


# ---- Attributes ------------------------------------------------------------------------------------------


def test_limits_hold_for_hands_and_for_words(shown):
    limits = 'min-camera-orbit="100deg 30deg 50%" max-camera-orbit="140deg 80deg auto" max-field-of-view="40deg"'
    page = shown(f'src="two.bob" {limits} camera-orbit="120deg 10deg 20%"')
    assert camera(page) == bob.Camera(azimuth=30, elevation=60, zoom=2)
    page.locator("bob-view").focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowDown")
    assert camera(page) == bob.Camera(azimuth=50, elevation=10, zoom=2)
    page.keyboard.press("4")  # the back, beyond: the nearer end
    assert camera(page).azimuth == 50
    page.evaluate(f"() => {{ {VIEW}.camera = {{ azimuth: 350, fov: 90 }}; }}")
    assert camera(page) == bob.Camera(azimuth=10, elevation=10, zoom=2, fov=40)
    page.evaluate(f"() => {{ {VIEW}.minCameraOrbit = null; {VIEW}.camera = {{ zoom: 9, azimuth: 300 }}; }}")
    assert camera(page).zoom == 9


@pytest.mark.parametrize(
    ("attributes", "turn"),
    [
        ('up="y"', ("x", 90)),
        ('orientation="0deg 0deg 90deg"', ("z", 90)),
        ('orientation="90deg 0deg 0deg"', ("y", -90)),
        ('orientation="0deg 90deg 0deg"', ("x", 90)),
    ],
)
def test_scenes_are_turned(shown, attributes, turn):
    page = shown(f'src="two.bob" {attributes} picture-size="{WIDTH}x{HEIGHT}"')
    axis = np.eye(3)["xyz".index(turn[0])]
    turned = bob.Scene([instance.rotate(np.radians(turn[1]), axis) for instance in scene().instances])
    seen = bob.Camera(FRONT) if "up" in attributes else bob.Camera()  # +z of what has y up is its front
    wanted = color_to_8_bit(bob.trace(turned, seen, size=(HEIGHT, WIDTH)).gray)
    assert (np.abs(settled(page)[..., 0].astype(int) - wanted) > 1).mean() < 0.005
    page.evaluate(f"async () => {{ const view = {VIEW}; view.up = view.orientation = null; }}")
    page.wait_for_function(f"() => {VIEW}.ariaBusy === null")
    assert (np.abs(settled(page)[..., 0].astype(int) - expected(bob.Camera())) > 1).mean() < 0.005


def test_meshes_that_lie_stand_up_unless_the_axis_is_known(shown, folder):
    LYING.save(folder / "lies.ply")
    for attributes, axis, front in (("", "y", 300), ('up="z"', "z", 30), ('up="y"', "y", 300)):
        page = shown(f'src="lies.ply" {attributes} picture-size="{WIDTH}x{HEIGHT}"')
        wanted = color_to_8_bit(bob.trace(bob.load(folder / "lies.ply", up=axis), size=(HEIGHT, WIDTH)).gray)
        assert (np.abs(settled(page)[..., 0].astype(int) - wanted) > 1).mean() < 0.005
        assert camera(page).azimuth == front


def test_exposure_is_a_factor_of_light(shown):
    page = shown('src="two.bob" exposure="0.25"')
    linear = bob.trace(scene(), size=(HEIGHT, WIDTH)).gray
    assert (np.abs(settled(page)[..., 0].astype(int) - color_to_8_bit(linear / 4)) > 1).mean() < 0.005
    page.evaluate(f"() => {{ {VIEW}.exposure = 2; }}")
    brighter = color_to_8_bit(np.minimum(2 * linear, 1))
    page.wait_for_timeout(200)
    assert (np.abs(settled(page)[..., 0].astype(int) - brighter) > 1).mean() < 0.005


def test_a_poster_stays_until_it_is_dismissed(shown, folder):
    Image.new("RGB", (64, 48), (200, 0, 0)).save(folder / "poster.png")
    page = shown('src="two.bob" poster="poster.png" reveal="manual"')
    assert page.is_visible("bob-view img")
    seen = page.evaluate(f"""() => {{
      let seen = 0;
      {VIEW}.addEventListener("poster-dismissed", () => ++seen);
      {VIEW}.dismissPoster();
      return seen;
    }}""")
    assert seen == 1
    assert not page.is_visible("bob-view img")


def test_it_turns_as_soon_and_as_fast_as_wanted(shown):
    page = shown(
        'src="two.bob" auto-rotate auto-rotate-delay="0" rotation-per-second="90deg"', reduced_motion="no-preference"
    )
    page.wait_for_function("() => told.filter(({ type }) => type === 'camera-change').length > 5")
    assert 1 < (30 - camera(page).azimuth) % 360 < 350


@pytest.mark.parametrize(
    ("attribute", "message"),
    [
        ('up="x"', "up: expected y or z, got x"),
        ('orientation="1deg"', "orientation: expected three angles, such as 0deg 90deg 0deg, got 1deg"),
        ('exposure="-1"', "exposure: expected a number of at least 0, got -1"),
        ('min-camera-orbit="1"', "min-camera-orbit: expected angles and a share, such as auto 30deg 50%, got 1"),
        ('max-field-of-view="wide"', "max-field-of-view: expected an angle, such as 20deg, got wide"),
        ('exposure=""', "exposure: expected a number of at least 0, got "),
        ('light="sun"', "light: expected scene, headlight or studio, got sun"),
        (
            'section="x"',
            "section: expected an axis, a relation and a number, such as 'x=0', 'z>3' or 'y<=-1.5', got 'x'",
        ),
        ('picture-size="640"', "picture-size: expected a width and a height in pixels, such as 640x480, got 640"),
        ('workers="0"', "workers: expected a number of at least 1, got 0"),
        ('snap="-1"', "snap: expected a number of CSS pixels, or nothing, got -1"),
        ('auto-rotate-delay="3s"', "auto-rotate-delay: expected milliseconds, got 3s"),
        ('rotation-per-second="10%"', "rotation-per-second: expected an angle, such as 30deg, got 10%"),
    ],
)
def test_wrong_attributes_are_told_and_change_nothing(shown, attribute, message):
    """The message stays until the attribute is right."""
    page = shown(f'src="two.bob" {attribute}')
    told = page.evaluate("() => told.filter(({ type }) => type === 'error').map(({ detail }) => detail.message)")
    assert told == [message]
    assert camera(page) == bob.Camera()
    assert page.text_content("#wrong:not([hidden])") == message
    page.evaluate(f"(name) => {VIEW}.removeAttribute(name)", attribute.partition("=")[0])
    assert page.is_hidden("#wrong")


@pytest.mark.parametrize("camera", ["{ azimuth: NaN }", "{ zoom: 'near' }", "{ panX: Infinity }"])
def test_cameras_without_numbers_are_refused(shown, camera):
    page = shown()
    before, reasons = page.evaluate(f"""async () => {{
      const view = {VIEW}, before = view.camera, reasons = [];
      try {{ view.camera = {camera}; }} catch ({{ message }}) {{ reasons.push(message); }}
      await view.goTo({camera}).catch(({{ message }}) => reasons.push(message));
      view.camera = {{ azimuth: undefined }};
      return [before, reasons];
    }}""")
    assert len(reasons) == 2
    assert all(reason.startswith("camera: expected finite numbers, got ") for reason in reasons)
    assert page.evaluate(f"() => {VIEW}.camera") == before


def test_properties_reflect_attributes(shown):
    page = shown()
    values = page.evaluate(f"""() => {{
      const view = {VIEW};
      view.cameraOrbit = "90deg 90deg 100%", view.autoRotateDelay = 500, view.cameraControls = false;
      const isReflected = view.getAttribute("camera-orbit") === "90deg 90deg 100%";
      return [isReflected, view.autoRotateDelay, view.hasAttribute("camera-controls"), view.exposure];
    }}""")
    assert values == [True, "500", False, None]
    assert camera(page) == bob.Camera(azimuth=0, elevation=0)


# ---- Planes of sections ----------------------------------------------------------------------------------


def handle(page, axis="X"):
    """Return the handle of a section plane, once it has its place."""
    found = page.get_by_role("slider", name=f"Section plane {axis}", exact=True)
    found.wait_for()
    return found


def centre(of):
    box = of.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def place(page):
    return float(page.evaluate(f"() => {VIEW}.section").split(",")[0][2:])


def cuts(page):
    return page.evaluate("() => told.filter(({ type }) => type === 'section-change').map(({ detail }) => detail)")


@pytest.mark.parametrize("fov", [0, 60])
def test_a_plane_follows_the_mouse(shown, fov):
    """Along its normal, and not across it; the camera stays, and nothing is picked."""
    page = shown(f'src="two.bob" field-of-view="{fov}deg" section="x<100, z<3"')
    knob, before = handle(page), camera(page)
    (x, y), view = centre(knob), camera(page)
    ends = [np.array(corner_at(page, (at, 52, 3.5), view)) for at in (100, 98)]
    assert (x, y) == pytest.approx(tuple(ends[0]), abs=0.6)
    across = np.array([[0, 1], [-1, 0]]) @ (ends[1] - ends[0])
    page.mouse.move(x, y)
    page.mouse.down()
    for part in np.linspace(0.1, 1, 10):
        page.mouse.move(*(ends[0] + part * (ends[1] - ends[0]) + 0.3 * across))
    page.mouse.up()
    assert place(page) == pytest.approx(98, abs=0.1)
    assert centre(knob) == pytest.approx(tuple(ends[1]), abs=1.5)
    assert page.evaluate(f"() => {VIEW}.section").endswith(", z<3")
    page.wait_for_timeout(100)
    assert camera(page) == before
    assert page.evaluate("() => told.filter(({ type }) => type === 'pick')") == []
    told = cuts(page)
    assert {change["source"] for change in told} == {"none", "user-interaction"}  # the attribute at first
    assert told[-1]["section"] == page.evaluate(f"() => {VIEW}.section")
    section = told[-1]["section"].split(",")
    wanted = color_to_8_bit(bob.trace(scene(), view, size=(HEIGHT, WIDTH), section=section).color)
    assert (np.abs(settled(page)[..., :3].astype(int) - wanted).max(axis=-1) > 1).mean() < 0.005


def test_a_plane_stops_at_the_ends_of_the_scene(shown):
    page = shown('src="two.bob" section="z>1"')
    x, y = centre(handle(page, "Z"))
    page.mouse.move(x, y)
    page.mouse.down()
    for way, end in [(-500, 3.5), (500, -1)]:
        page.mouse.move(x, y + way / 2)
        page.mouse.move(x, y + way)
        assert place(page) == pytest.approx(end, abs=1e-3)
    page.mouse.up()
    assert page.evaluate(f"() => {VIEW}.section").startswith("z>")


def test_a_plane_that_faces_the_viewer_moves_up_and_down(shown):
    page = shown('src="two.bob" section="x<100" camera-orbit="90deg 90deg 100%"')
    x, y = centre(handle(page))
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 8)
    page.mouse.up()
    assert 100 < place(page) <= 103


def test_planes_have_keys(shown):
    page = shown('src="two.bob" section="x<100"')
    knob = handle(page)
    page.locator("bob-view").focus()
    page.keyboard.press("Tab")
    assert page.evaluate(f"() => {VIEW}.shadowRoot.activeElement.role") == "slider"
    outline = knob.evaluate("(knob) => getComputedStyle(knob.nextElementSibling).opacity")
    assert outline == "1"
    arrows = {"ArrowRight": 100.06, "ArrowUp": 100.12, "ArrowLeft": 100.06}
    for key, at in (arrows | {"PageUp": 100.66, "Home": 97, "End": 103}).items():
        page.keyboard.press(key)
        assert place(page) == pytest.approx(at)
    assert knob.get_attribute("aria-valuenow") == "103"
    assert knob.get_attribute("aria-valuetext") == "x up to 103"
    assert camera(page) == bob.Camera()


def test_planes_come_and_go_with_sections_and_controls(shown):
    page = shown()
    asked = []
    page.on("request", lambda request: asked.append(request.url.split("/")[-1]))
    page.locator("bob-view").focus()
    knobs = page.get_by_role("slider")
    assert "handles.js" not in asked
    page.keyboard.press("x")
    handle(page)
    assert "handles.js" in asked
    page.keyboard.press("y")
    handle(page, "Y")
    assert {change["source"] for change in cuts(page)} == {"user-interaction"}
    page.keyboard.press("x")
    page.wait_for_function(f"() => !/x/.test({VIEW}.section)")
    assert knobs.count() == 1
    page.evaluate(f"() => {{ {VIEW}.cameraControls = false; }}")
    assert knobs.count() == 0
    page.evaluate(f"() => {{ {VIEW}.cameraControls = true; }}")
    handle(page, "Y")
    page.evaluate(f"() => {{ {VIEW}.section = null; }}")
    assert knobs.count() == 0


def test_a_finger_moves_a_plane_and_scrolls_elsewhere(shown):
    page = shown('src="two.bob" section="z<1"', **PHONE)
    x, y = centre(handle(page, "Z"))
    assert handle(page, "Z").bounding_box()["width"] >= 44
    hand = Hand(page)
    hand.move(((x, y), (x, y - 40)))
    assert place(page) > 1.2
    assert scrolled(page) == 0
    assert camera(page) == bob.Camera()
    hand.move(((40, 200), (45, 80)))
    assert scrolled(page) > 50


def test_the_wheel_over_a_plane_zooms(shown):
    page = shown('src="two.bob" section="z<1"', page="100%")
    page.mouse.move(*centre(handle(page, "Z")))
    page.mouse.wheel(0, -100)
    page.wait_for_function(f"() => {VIEW}.camera.zoom > 1")


# ---- Hot spots and the view cube -------------------------------------------------------------------------

SPOT = '<button slot="hotspot-{i}" data-position="{place}" style="width: 20px; height: 20px; padding: 0"></button>'


def spots(*points):
    return "".join(SPOT.format(i=i, place=" ".join(f"{value}m" for value in point)) for i, point in enumerate(points))


def centres(page):
    spots = page.locator("bob-view > button")
    boxes = spots.evaluate_all("(all) => all.map((of) => of.getBoundingClientRect().toJSON())")
    return [(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2) for box in boxes]


@pytest.mark.parametrize("fov", [0, 60])
def test_hot_spots_are_at_points_and_hide_behind_things(shown, fov):
    """One each on a right side, on a left side, within and outside the boxes."""
    points = [(103, 51, 0.5), (97, 51, 0.5), (100, 50, 0), (100, 50, 5)]
    page = shown(f'src="two.bob" field-of-view="{fov}deg"', children=spots(*points))
    for azimuth, wanted in [(30, [True, False, False, True]), (190, [False, True, False, True])]:
        page.evaluate(f"(azimuth) => {{ {VIEW}.camera = {{ azimuth }}; }}", azimuth)
        page.evaluate(f"() => {VIEW}.converged()")
        page.wait_for_function(
            "(wanted) => [...document.querySelectorAll('bob-view > button')].every("
            "(of, i) => of.hasAttribute('data-visible') === wanted[i])",
            arg=wanted,
        )
        view = camera(page)
        for point, centre, is_visible in zip(points, centres(page), wanted, strict=True):
            if is_visible:
                assert centre == pytest.approx(corner_at(page, point, view), abs=0.6)
    page.evaluate("() => { document.querySelectorAll('bob-view > button')[1].dataset.position = '103 49 0.5'; }")
    page.evaluate(f"() => {{ {VIEW}.camera = {{ azimuth: 350 }}; }}")
    page.wait_for_function("() => document.querySelectorAll('bob-view > button')[1].hasAttribute('data-visible')")
    page.keyboard.press("Tab")  # the picture, then only visible controls
    seen = []
    for _ in range(4):
        page.keyboard.press("Tab")
        seen.append(page.evaluate("() => document.activeElement.slot ?? ''"))
    assert "hotspot-2" not in seen
    assert "hotspot-1" in seen


def test_hot_spots_come_and_go_and_are_pressed(shown):
    page = shown()
    asked = []
    page.on("request", lambda request: asked.append(request.url.split("/")[-1]))
    page.evaluate(f"() => {VIEW}.converged()")
    assert asked == []
    page.evaluate(f"([html]) => {VIEW}.insertAdjacentHTML('beforeend', html)", [spots((100, 50, 3.5))])
    page.wait_for_function("() => document.querySelector('[slot=hotspot-0]').hasAttribute('data-visible')")
    assert "spots.js" in asked
    page.evaluate(
        "() => document.querySelector('[slot=hotspot-0]').addEventListener('click', () => (window.pressed = true))"
    )
    page.mouse.click(*centres(page)[0])
    assert page.evaluate("() => window.pressed")
    page.evaluate("() => document.querySelector('[slot=hotspot-0]').remove()")
    page.wait_for_function(f"() => {VIEW}.shadowRoot.querySelectorAll('#spots > div').length === 0")


def test_hot_spots_without_a_place_are_not_shown(shown):
    """Before the first picture, and outside of it, even if hidden ones are to show."""
    page = shown('src="two.bob" style="--min-hotspot-opacity: 0.3"', children=spots((100, 50, 0), (100, 50, 3.5)))
    states = f"""() => [...{VIEW}.children].map((spot) => {{
      const {{ opacity, visibility }} = getComputedStyle(spot.assignedSlot.parentElement);
      return visibility === "hidden" ? 0 : Number(opacity);
    }})"""
    page.wait_for_function(f"() => String(({states})()) === '0.3,1'")
    page.evaluate(f"() => {{ {VIEW}.camera = {{ zoom: 20, panX: 2 }}; }}")
    page.wait_for_function(f"() => String(({states})()) === '0,0'")
    page.evaluate(f"""() => {{
      const other = document.createElement("bob-view");
      other.append(...{VIEW}.children);
      {VIEW}.replaceWith(other);
    }}""")
    page.wait_for_function(f"() => {VIEW}.shadowRoot.querySelector('#spots')")
    assert page.evaluate(states) == [0, 0]


def test_the_cube_turns_with_the_scene_and_shows_its_sides(shown):
    page = shown('src="two.bob" view-cube')
    for side, (azimuth, elevation) in SIDES.items():
        page.evaluate(
            """([azimuth, elevation]) => {
          const view = document.querySelector("bob-view");
            view.camera = { azimuth: azimuth + 20, elevation: elevation - Math.sign(elevation) * 20 };
        }""",
            [azimuth, elevation],
        )
        name = side.capitalize()
        page.get_by_role("button", name=name, exact=True).click()
        view = camera(page)
        assert (view.azimuth, view.elevation) == (azimuth, elevation)
        # It faces the viewer, upright.
        box = page.get_by_role("button", name=name, exact=True).bounding_box()
        assert box["width"] == pytest.approx(box["height"], rel=0.01)
        middle = page.evaluate(
            """([x, y]) => {
          return document.querySelector("bob-view").shadowRoot.elementFromPoint(x, y).textContent;
        }""",
            [WIDTH - 54, 54],
        )
        assert middle == name
    page.evaluate(f"() => {{ {VIEW}.viewCube = false; }}")
    page.wait_for_function(f"() => !{VIEW}.shadowRoot.querySelector('#cube')")
