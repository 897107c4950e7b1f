"""The viewer's page in Chromium: user actions, and exact pictures equal to Python's."""

import base64
import itertools
import json
import os
import re
import warnings
import zlib
from io import BytesIO
from subprocess import PIPE
from urllib.parse import quote

import numpy as np
import pytest
import trimesh
from browser import numbers, page_server, picture_at, serving
from models import MODELS, needs_models
from PIL import Image
from processes import COMMAND, running
from statues import LYING

import bobrossnet as bob
from bobrossnet import _core
from bobrossnet.command_line import cli
from bobrossnet.page.export import export
from bobrossnet.page.files import page_files
from bobrossnet.page.look import attributes
from bobrossnet.picture.files import UNTRACED, color_to_8_bit, to_8_bit
from bobrossnet.support.paths import VIEWER

WIDTH, HEIGHT = 128, 96
SIZE = f"?size={WIDTH}x{HEIGHT}"

DROP = """
async ({ address, name }) => {
  const bytes = await (await fetch(address)).arrayBuffer(), dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([bytes], name));
  const drop = new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true });
  document.querySelector("#picture").dispatchEvent(drop);
}
"""


class Page:
    """The page from the user's view."""

    def __init__(self, tabs, address, script="", **settings):
        self.wrong = []
        self.asked = set()
        listeners = {
            "pageerror": lambda error: self.wrong.append(str(error)),
            "console": lambda entry: entry.type == "error" and self.wrong.append(entry.text),
            "request": lambda request: self.asked.add(request.url),
        }
        self.tabs = tabs
        self.tab = tabs.open(script, on=listeners, **{"reduced_motion": "reduce", **settings})  # cameras arrive at once
        self.visit(address)

    def visit(self, address):
        if self.tab.url.partition("#")[0] == address.partition("#")[0]:
            self.tab.goto("about:blank")  # otherwise a new fragment would not reload the page
        self.tab.goto(address)
        self.tab.evaluate("() => bobrossnet.started")

    def close(self):
        self.tabs.release(self.tab)
        assert self.wrong == []

    def opened(self):
        self.tab.wait_for_selector("#stage:not([aria-busy])")

    def wait_until(self, holds):
        """Wait for asynchronous work of the page, which takes longer on a busy machine."""
        for _ in range(1000):
            if holds():
                return
            self.tab.wait_for_timeout(20)
        raise AssertionError("the page never came to it")

    def choose(self, file):
        self.tab.select_option("#gallery", file)
        self.opened()
        assert self.tab.input_value("#gallery") == file, self.text("#message")

    def exact(self):
        """Return the exact picture, (H, W, 3) uint8, with one ray in each pixel."""
        self.tab.evaluate("() => document.querySelector('#picture').setAttribute('samples', '1')")
        return self.final()

    def final(self):
        """Return the last picture, (H, W, 3) uint8."""
        self.tab.evaluate("() => bobrossnet.converged()")
        return self.pixels()

    def pixels(self):
        address = self.tab.evaluate("() => document.querySelector('#picture').toDataURL()")
        picture = picture_at(address)
        rgba = np.asarray(picture.convert("RGBA"))
        assert (rgba[..., 3] == 255).all()
        return rgba[..., :3]

    def camera(self):
        found = self.tab.evaluate("() => bobrossnet.camera()")
        pan = found.pop("panX"), found.pop("panY")
        return bob.Camera(**found, pan=pan)

    def text(self, selector):
        return self.tab.locator(selector).text_content()


@pytest.fixture(scope="module")
def shared(tabs, viewer):
    page = Page(tabs, viewer.url + SIZE)
    yield page
    page.close()


@pytest.fixture
def page(shared):
    """Return the page at its start: the default view of a shape."""
    yield shared
    shared.tab.check("#refines")
    shared.tab.check("[value=completed]", force=True)
    shared.tab.uncheck("#perspective")
    shared.tab.click("#home")


def expected(scene, camera=None):
    seen = bob.trace(scene, camera, size=(HEIGHT, WIDTH))
    return color_to_8_bit(seen.color if "color" in seen.channels else seen.gray)


def assert_equal_pictures(found, expected, pixels=0.002):
    """Except for a few pixels on edges, where other instruction sets round differently."""
    if expected.ndim == 2:
        assert (found == found[..., :1]).all()
        expected = expected[..., None]
    difference = np.abs(found.astype(int) - expected).max(axis=-1)
    assert (difference > 1).mean() <= pixels, f"{(difference > 1).sum()} pixels differ, by up to {difference.max()}"


GALLERY = [entry["file"] for entry in json.loads((VIEWER / "gallery" / "index.json").read_text())]


# ---- Pictures --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("file", GALLERY)
def test_gallery_is_shown_as_python_renders_it(page, viewer, file):
    page.choose(file)
    assert_equal_pictures(page.exact(), expected(bob.load(viewer.files[f"gallery/{file}"])))
    assert page.text("#fraction") != ""


PICTURES = """
window.pictures = [];
document.addEventListener("progress", () => {
  const { exact, final, isSmoothed } = bobrossnet.statistics;
  pictures.push([exact, isSmoothed, final]);
}, true);
"""


@pytest.mark.parametrize("script", ["shared memory", "alone"])
@pytest.mark.parametrize("file", ["gear.sdf", "lantern.bob"])
def test_edges_at_rest_are_smoothed_as_python_renders_them(tabs, viewer, file, script):
    """After the exact picture, which comes first."""
    page = Page(
        tabs, f"{viewer.url}?size=300x201&workers=3#scene={file}", PICTURES + (ALONE if script == "alone" else "")
    )
    found = page.final()
    scene = bob.load(viewer.files[f"gallery/{file}"])
    wanted = bob.render(scene, size=(201, 300), background="#000").rgba[..., :3]
    assert_equal_pictures(found, wanted)
    seen = bob.trace(scene, size=(201, 300))
    exact = color_to_8_bit(seen.color if "color" in seen.channels else seen.gray)
    assert (np.abs(wanted.astype(int) - (exact if exact.ndim == 3 else exact[..., None])).max(-1) > 8).mean() > 0.005
    pictures = page.tab.evaluate("() => pictures")
    assert [True, False, False] in pictures
    assert pictures[-1] == [True, True, True]
    page.wait_until(lambda: page.text("#fraction") == "100 %, smoothed")
    assert page.tab.evaluate("() => new Promise((later) => setTimeout(() => later(pictures.length), 500))") == len(
        pictures
    )
    page.close()


def test_edges_of_a_picture_that_was_whole_in_motion_are_smoothed(tabs, viewer):
    page = Page(tabs, viewer.url + SIZE + "#scene=happy_tree.bob")
    page.tab.fill("#budget", "200")
    for azimuth in range(40, 60):
        page.tab.evaluate(NEXT, azimuth)
    wanted = bob.render(bob.happy_tree(), page.camera(), size=(HEIGHT, WIDTH), background="#000").rgba[..., :3]
    assert_equal_pictures(page.final(), wanted)
    page.tab.check("[value=difference]", force=True)
    page.wait_until(lambda: "4 times as bright" in page.text("#note"))
    page.close()


def test_an_enlarged_picture_is_called_enlarged(tabs, viewer):
    page = Page(tabs, viewer.url + "#scene=gear.sdf", viewport={"width": 2560, "height": 1440})
    page.tab.uncheck("#refines")
    page.tab.fill("#budget", "10")
    for azimuth in range(40, 50):
        page.tab.evaluate(NEXT, azimuth)
    page.wait_until(lambda: re.fullmatch(r"[\d.]+ % of \d+x\d+, enlarged", page.text("#fraction")))
    page.close()


RAYS = """
window.batches = [];
window.Worker = class extends Worker {
  constructor(...settings) {
    super(...settings);
    this.addEventListener("message", ({ data }) => data.kind === "traced" && batches.push(data));
  }
};
"""

REST = """
async (azimuth) => {
  const { statistics } = bobrossnet;
  let pictures = 0;
  const exact = new Promise((resolve) => {
    document.addEventListener("progress", () => ++pictures && statistics.exact && resolve(), true);
  });
  const begin = performance.now();
  batches.length = 0;
  bobrossnet.look({ azimuth });
  await exact;
  return { pictures, milliseconds: performance.now() - begin, batches };
}
"""


def test_at_rest_all_pixels_are_traced_on_all_threads_in_few_steps(tabs, viewer):
    width, height, threads = 800, 600, 2
    page = Page(tabs, f"{viewer.url}?size={width}x{height}&workers={threads}&samples=1#scene=gear.sdf", RAYS)
    page.tab.evaluate("() => bobrossnet.converged()")
    rests = [page.tab.evaluate(REST, azimuth) for azimuth in (40, 50)]
    for rest in rests:
        moving, *resting = (batch for batch in rest["batches"] if not batch["cancelled"])
        assert all(batch["batch"]["parts"] == threads for batch in (moving, *resting))
        assert sum(batch["rays"] for batch in resting if batch["batch"]["phase"] == "rows") == width * height
        assert sum(batch["rays"] for batch in resting) <= 1.3 * width * height
        # Steps double: to 250 ms while the picture is refined, and to a second.
        assert rest["pictures"] <= 5 + rest["milliseconds"] / 600
    page.close()


def test_colors_are_those_of_python(tabs, viewer, tmp_path):
    texture = np.random.default_rng(0).integers(0, 256, (4, 4, 3), np.uint8)
    square = bob.Mesh([(0, 0, 0), (0, 2, 0), (0, 2, 2), (0, 0, 2)], [(0, 1, 2), (0, 2, 3)],
                      uv=[(0, 2), (2, 2), (2, 0), (0, 0)], texture=texture, wrap="mirror")  # fmt: skip
    metal = bob.Material("#b87333", metallic=1, roughness=0.4)
    (gear,) = bob.load(viewer.files["gallery/gear.sdf"]).instances  # slow: no machine traces all of it in one frame
    scene = bob.Scene([square, bob.Instance(gear.shape, material=metal).translate((1, 3, 0))])
    bob.save_scene(scene, tmp_path / "colors.bob")
    height, width = 480, 640
    page = Page(tabs, f"{viewer.url}?size={width}x{height}#scene=csg.sdf")
    page.tab.set_input_files("#file", tmp_path / "colors.bob")
    page.opened()
    assert page.text("#message") == ""
    exact = page.exact()
    wanted = color_to_8_bit(bob.trace(scene, size=(height, width)).color)
    difference = np.abs(exact.astype(int) - wanted).max(axis=-1)
    assert (difference > 1).mean() < 0.002
    assert np.ptp(wanted.astype(int), axis=-1).max() > 100
    page.tab.check("[value=traced]", force=True)
    page.tab.uncheck("#refines")
    page.tab.fill("#budget", "10")
    page.tab.evaluate("() => bobrossnet.look({ azimuth: 40 })")
    page.wait_until(lambda: is_untraced(page.pixels()).any())
    page.tab.check("[value=completed]", force=True)
    page.wait_until(lambda: not is_untraced(page.pixels()).any())
    moved = page.pixels()
    near = color_to_8_bit(bob.trace(scene, bob.Camera(azimuth=40), size=(height, width)).color)
    assert np.abs(moved.astype(int) - near).mean() < 6
    page.close()


def test_factors_of_gltf_are_linear_light(page, tmp_path):
    """Base colours and emission, displayed in sRGB by the page, as written by Python."""
    factors = [((40, 90, 200, 255), 0.0, 0.6, (0, 0, 0)), ((230, 120, 30, 255), 1.0, 0.4, (0, 0, 0)),
               ((0, 0, 0, 255), 0.0, 1.0, (0.5, 0.05, 0.2)), ((100, 100, 100, 255), 0.5, 0.7, (0, 0.1, 0))]  # fmt: skip
    balls = []
    for i, (color, metallic, roughness, emissive) in enumerate(factors):
        ball = trimesh.creation.icosphere(4).apply_translation((2.2 * (i % 2), 2.2 * (i // 2), 0))
        material = trimesh.visual.material.PBRMaterial(
            f"m{i}", emissiveFactor=emissive, baseColorFactor=color, metallicFactor=metallic, roughnessFactor=roughness
        )
        ball.visual = trimesh.visual.TextureVisuals(material=material)
        balls.append(ball)
    file = tmp_path / "factors.glb"
    file.write_bytes(trimesh.Scene(balls).export(file_type="glb"))
    scene = bob.load(file)
    assert sorted(i.material.emissive for i in scene.instances) == sorted(emissive for *_, emissive in factors)
    page.tab.set_input_files("#file", file)
    page.opened()
    assert page.text("#message") == ""
    color = bob.trace(scene, size=(HEIGHT, WIDTH)).color
    wanted = color_to_8_bit(color).astype(int)
    assert (np.abs(page.exact().astype(int) - wanted).max(axis=-1) > 1).mean() < 0.002
    assert np.abs(255 * color - wanted)[wanted.any(axis=-1)].mean() > 20  # otherwise it would be a different picture


def test_files_are_opened_together_with_their_textures(page, tmp_path):
    """The model among them, in any order; and again after the axes are turned."""
    texels = np.zeros((8, 8, 3), np.uint8) + np.array((255, 0, 90), np.uint8)
    Image.fromarray(texels).save(tmp_path / "paint.png")
    (tmp_path / "a.mtl").write_text("newmtl a\nmap_Kd paint.png\n")
    square = "v 0 0 0\nv 0 2 0\nv 0 2 2\nv 0 0 2\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1 4/1\n"
    (tmp_path / "square.obj").write_text(f"mtllib a.mtl\n{square}")
    page.tab.set_input_files("#file", [tmp_path / name for name in ("paint.png", "a.mtl", "square.obj")])
    page.opened()
    assert page.text("#message") == ""
    scene = bob.load(tmp_path / "square.obj")
    for upright in (scene, scene.turned_upright()):
        wanted = color_to_8_bit(bob.trace(upright, size=(HEIGHT, WIDTH)).color)
        assert np.ptp(wanted.astype(int), axis=-1).max() > 100
        page.wait_until(lambda wanted=wanted: np.abs(page.exact().astype(int) - wanted).max(axis=-1).mean() < 0.1)
        page.tab.check("#y-up")
    page.tab.set_input_files("#file", [tmp_path / name for name in ("square.obj", "a.mtl")])
    page.wait_until(lambda: "paint.png" in page.text("#message"))


def test_a_page_opens_with_its_lens_and_background(tabs):
    """Parameters of links take precedence."""
    look = attributes(50, ("#ffffff", "#99bbdd"))
    with page_files(bob.happy_tree(), "tree", look) as files, page_server(files) as server:
        page = Page(tabs, server.url + "?scene=files/tree.bob&size=80x60")
        assert page.camera() == bob.Camera(fov=50)
        assert page.tab.is_checked("#perspective")
        page.tab.evaluate("() => bobrossnet.converged()")
        page.tab.locator("#home").click()
        assert page.camera() == bob.Camera(fov=50)
        shown = Image.open(BytesIO(page.tab.locator("#stage").screenshot())).convert("RGB")
        assert shown.getpixel((3, 3)) == pytest.approx((255, 255, 255), abs=3)
        assert shown.getpixel((3, shown.height - 3)) == pytest.approx((153, 187, 221), abs=3)
        page.visit(server.url + "?size=80x60#camera=10_20_0_1_0_0_0")
        assert page.camera() == bob.Camera(azimuth=10)
        page.close()


def test_one_worker_is_enough(tabs, viewer):
    page = Page(tabs, viewer.url + SIZE + "&workers=1#scene=csg.sdf")
    assert_equal_pictures(page.exact(), expected(bob.load(VIEWER / "gallery" / "csg.sdf")))
    page.close()


def test_moving_pictures_are_completed_from_few_pixels(page):
    page.choose("csg.sdf")
    page.exact()
    page.tab.uncheck("#refines")
    shares = page.tab.evaluate("""
        async () => {
          const shares = [];
          document.addEventListener("progress", () => shares.push(bobrossnet.statistics.fraction), true);
          while (shares.length < 12) {
            bobrossnet.look({ azimuth: bobrossnet.camera().azimuth + 1 });
            await new Promise(requestAnimationFrame);
          }
          await new Promise((resolve) => setTimeout(resolve, 500));
          return shares;
        }
    """)
    assert min(shares) > 0
    first = page.tab.evaluate("""
        async () => {
          const { height, width, planes, image } = await bobrossnet.buffers();
          const known = planes.slice(0, height * width);
          const [mask, gray] = [known, image].map(({ buffer }) => new Uint8Array(buffer).toBase64());
          return { size: [height, width], mask, gray };
        }
    """)
    mask, image = numbers(first["mask"]), numbers(first["gray"]).reshape(first["size"])
    assert mask.sum() / mask.size == pytest.approx(page.tab.evaluate("() => bobrossnet.statistics.fraction"))
    assert_equal_pictures(page.pixels(), color_to_8_bit(image), pixels=0)


def test_movement_ends_what_is_traced_at_rest(tabs, viewer):
    """At most the picture in progress still shows the previous view."""
    page = Page(tabs, viewer.url + "?size=640x480#scene=gear.sdf")
    stale = page.tab.evaluate("""
        async () => {
          const once = { once: true, capture: true };
          const next = () => new Promise((shown) => {
            document.addEventListener("progress", ({ detail }) => shown(detail.batch), once);
          });
          const stale = [];
          for (let azimuth = 31; azimuth < 35; ++azimuth) {
            let before, batch = await next();
            do [before, batch] = [batch, await next()]; while (batch.view !== before.view);  // refined once
            bobrossnet.look({ azimuth });
            stale.push(0);
            while ((await next()).camera.azimuth !== azimuth) ++stale[stale.length - 1];
          }
          return stale;
        }
    """)
    assert max(stale) <= 1
    page.close()


def buffers(page):
    """Return the G-buffer, (C, H, W), of the last completed picture."""
    found = page.tab.evaluate("""
        async () => {
          const { height, width, planes } = await bobrossnet.buffers();
          return { size: [height, width], planes: new Uint8Array(planes.buffer).toBase64() };
        }
    """)
    return planes_of(found)


def planes_of(found):
    return numbers(found["planes"]).reshape(-1, *found["size"])


NEXT = """async (azimuth) => {
  const next = new Promise((shown) => document.addEventListener("progress", shown, { once: true, capture: true }));
  bobrossnet.look({ azimuth });
  await next;
}"""

# The G-buffers of the last of some views, in motion and during refinement, until all of it is traced.
EACH = """async (azimuths) => {
  const next = () => new Promise((shown) => {
    const see = ({ detail }) => shown(detail.batch.camera.azimuth);
    document.addEventListener("progress", see, { once: true, capture: true });
  });
  const found = [];
  for (const azimuth of azimuths) {
    bobrossnet.look({ azimuth });
    while (await next() !== azimuth);
  }
  const converged = bobrossnet.converged();
  let goesOn = true;
  converged.then(() => { goesOn = false; });
  do {
    const { height, width, planes } = await bobrossnet.buffers();
    found.push({ size: [height, width], planes: new Uint8Array(planes.buffer).toBase64() });
    await Promise.race([next(), converged]);
  } while (goesOn);
  return found;
}"""


def first_pixels(planes, count, order):
    """Return a mask of the first pixels of an order, from a whole picture, (H, W)."""
    mask = np.zeros(planes.shape[1:], np.float32)
    while (left := int(count - mask.sum())) > 0:
        rows, columns = order.next(_core.gbuffer_layout(), planes)[:left].T
        mask[rows, columns] = 1
    return mask


@pytest.mark.parametrize("workers", [1, 4])
def test_pixels_are_those_of_an_order(tabs, viewer, workers):
    """For any speed and number of workers, in motion and during refinement."""
    page = Page(tabs, f"{viewer.url}?size=480x360&workers={workers}#scene=vase.sdf")
    page.tab.fill("#budget", "10")
    # Reprojection exceeds the budget, which is known after the first view that tried it.
    partial = [planes_of(found) for found in page.tab.evaluate(EACH, [39, 40, 41])]
    full = buffers(page)
    size = full.shape[1:]
    for planes in partial:
        orders = _core.AdaptiveOrder(0, *size), _core.SquaresOrder(*size)
        assert any(np.array_equal(planes, full * first_pixels(full, planes[0].sum(), order)) for order in orders)
    assert partial[0][0].mean() < partial[-1][0].mean()
    page.close()


def test_a_moving_picture_is_whole_where_there_is_time_for_it(tabs, viewer):
    page = Page(tabs, viewer.url + "?size=96x72#scene=happy_tree.bob")
    page.tab.fill("#budget", "200")
    shares = []
    for azimuth in range(40, 60):
        page.tab.evaluate(NEXT, azimuth)
        shares.append(page.tab.evaluate("() => bobrossnet.statistics.fraction"))
    assert shares[-1] == 1
    page.tab.evaluate("() => bobrossnet.converged()")
    page.close()


WORKERS = """
window.workers = [];
window.Worker = class extends Worker {
  constructor(url, options) {
    super(url, options);
    this.leads = false, this.file = url.pathname;
    workers.push(this);
  }
  postMessage(message, transfer) {
    if (message.kind === "lead") this.leads = true;
    if (message.kind === "help") this.helps = true;
    super.postMessage(message, transfer);
  }
};
"""


# As on servers where no page's workers share memory.
ALONE = 'Object.defineProperty(globalThis, "crossOriginIsolated", { value: false });'


# Thirty pictures in motion.
ORBIT = """async () => {
  const { statistics } = bobrossnet, until = statistics.pictures + 30;
  while (statistics.pictures < until) {
    bobrossnet.look({ azimuth: bobrossnet.camera().azimuth + 1 });
    await new Promise(requestAnimationFrame);
  }
}"""

# Asks for one more picture, unless two workers help: a busy machine may start them after the first picture.
JOINED = """() => {
  if (workers.filter((worker) => worker.helps).length > 1) return true;
  bobrossnet.look({ azimuth: bobrossnet.camera().azimuth + 1 });
  return false;
}"""


COMPLETE = """
async ({ address, batches, height, width, pixels, samples }) => {
  const part = (path) => import(new URL(path, address).href);
  const bytesOf = async (name) => (await fetch(new URL(`weights/${name}.safetensors`, address))).arrayBuffer();
  const worker = new Worker(new URL("workers/completing.js", address), { type: "module" });
  const reply = (kind) => new Promise((resolve, reject) => {
    worker.onmessage = ({ data }) => {
      if (data.kind === "failed") reject(new Error(data.message));
      if (data.kind === kind) resolve(data);
    };
  });
  const module = await (await part("core/compile.js")).compileCore(), { port1, port2 } = new MessageChannel();
  const weights = await bytesOf("default"), uncertainty = await bytesOf("uncertainty");
  worker.postMessage({ kind: "start", module, name: "default", weights, uncertainty });
  worker.postMessage({ kind: "network", name: "filling", weights: await bytesOf("filling") });
  worker.postMessage({ kind: "connect", tracer: port2 }, [port2]);
  const result = [];
  for (const [id, { count, model: planned, expected }] of batches.entries()) {
    const batch = { id, view: id, parts: 1, height, width }, picture = reply("picture");
    const values = {
      pixels: Int32Array.from(pixels.slice(0, 2 * count)), samples: Float32Array.from(samples.slice(0, 6 * count)),
    };
    const back = expected && new Promise((resolve) => (port1.onmessage = ({ data }) => resolve(data.length)));
    const planes = expected ? new Float32Array(Uint8Array.fromBase64(expected).buffer) : null;
    const message = { kind: "samples", batch, model: planned, ...values, expected: planes };
    port1.postMessage(message, planes ? [planes.buffer] : []);
    const { model, traced } = (await picture).picture, buffers = reply("buffers");
    worker.postMessage({ kind: "buffers" });
    result.push([model, traced, new Uint8Array((await buffers).buffers.image.buffer).toBase64(), await back]);
  }
  worker.terminate();
  return result;
}
"""


# Hashes of each batch's picture, and of its gray, with a number of helping workers; and the messages they received.
IN_BANDS = """
async ({ address, batches, height, width, isColored, isTransparent, helpers }) => {
  const part = (path) => import(new URL(path, address).href), components = isColored ? 12 : 6, total = height * width;
  let state = 1;
  const next = () => (state = (48271 * state) % 0x7fffffff) / 0x7fffffff;
  const noise = (count) => Float32Array.from({ length: count }, next);
  const samples = noise(components * total), expected = noise((isColored ? 8 : 5) * total);
  for (let i = 0; i < total; ++i) samples[components * i] = Number(samples[components * i] < 0.7);
  for (let i = expected.length - 1; i >= 0; --i) expected[i] *= Number(expected[i % total] < 0.5);
  for (let i = 0; i < total; ++i) expected[i] = Number(expected[i] > 0);
  const place = (i) => (i * 7919) % total, pixels = Int32Array.from({ length: 2 * total }, (_, i) =>
    i % 2 ? place((i - 1) / 2) % width : Math.floor(place(i / 2) / width));
  const bytesOf = async (name) => (await fetch(new URL(`weights/${name}.safetensors`, address))).arrayBuffer();
  const module = await (await part("core/compile.js")).compileCore(), { port1: tracer, port2 } = new MessageChannel();
  const [weights, filling, uncertainty] = await Promise.all(["default", "filling", "uncertainty"].map(bytesOf));
  const hash = async (array) => new Uint8Array(await crypto.subtle.digest("SHA-256", array)).toHex();
  const asked = { samples: 0, complete: 0, nothing: 0 };
  const started = () => {
    const worker = new Worker(new URL("workers/completing.js", address), { type: "module" });
    worker.postMessage({ kind: "start", module, name: "default", weights, uncertainty });
    return worker;
  };
  const leader = started();
  leader.postMessage({ kind: "network", name: "filling", weights: filling });
  leader.postMessage({ kind: "connect", tracer: port2 }, [port2]);
  leader.postMessage({ kind: "show", mode: "completed", divider: 0.5, isTransparent });
  const others = [];
  for (let i = 0; i < helpers; ++i) {
    const helper = started(), ofLeader = new MessageChannel(), ofHelper = new MessageChannel();
    if (i > 0) helper.postMessage({ kind: "network", name: "filling", weights: filling }); // the first lacks it
    helper.postMessage({ kind: "help", leader: ofHelper.port2 }, [ofHelper.port2]);
    leader.postMessage({ kind: "helped", helper: ofLeader.port2 }, [ofLeader.port2]);
    await new Promise((ready) => {
      ofHelper.port1.onmessage = ({ data }) => {
        asked.nothing += data === null;
        ofLeader.port1.postMessage(data);
        ready();
      };
    });
    ofLeader.port1.onmessage = ({ data }) => {
      ++asked[data.kind];
      ofHelper.port1.postMessage(data);
    };
    others.push(helper);
  }
  const result = [];
  for (const [id, { view, from, to, isExpected }] of batches.entries()) {
    const picture = new Promise((resolve, reject) => {
      leader.onmessage = ({ data }) => data.kind === "picture" ? resolve(data.picture) : reject(data.message);
    });
    const batch = { id, view, parts: 1, height, width };
    const model = view === 2 || to >= 0.05 * total ? "filling" : "default";
    tracer.postMessage({
      kind: "samples", batch, isColored, model, pixels: pixels.slice(2 * from, 2 * to),
      samples: samples.slice(components * from, components * to), expected: isExpected ? expected.slice() : null,
    });
    const { bitmap, model: used } = await picture, context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const buffers = new Promise((resolve) => (leader.onmessage = ({ data }) => resolve(data.buffers)));
    leader.postMessage({ kind: "buffers" });
    result.push([used, await hash(context.getImageData(0, 0, width, height).data), await hash((await buffers).image)]);
  }
  for (const worker of [leader, ...others]) worker.terminate();
  return [result, asked];
}
"""


@pytest.mark.parametrize(("is_colored", "is_transparent"), [(False, False), (True, False), (True, True)])
def test_bands_of_several_workers_are_the_picture_of_one(page, viewer, is_colored, is_transparent):
    """To the bit: for views refined, with reprojection, and whole; for every size."""
    for height, width in ((1, 1), (2, 3), (60, 80), (213, 97)):
        total = height * width
        few, more, most = total // 40, total // 25, total // 3
        # One worker completes the first five pictures of each network, while a GPU may still become ready.
        batches = [{"view": -i, "from": 0, "to": max(1, most if i > 5 else few)} for i in range(10, 0, -1)] + [
            {"view": 1, "from": 0, "to": max(1, few)},
            {"view": 1, "from": max(1, few), "to": max(1, more)},
            {"view": 1, "from": max(1, more), "to": max(1, most)},
            {"view": 2, "from": 0, "to": max(1, few), "isExpected": True},
            {"view": 2, "from": max(1, few), "to": max(1, more)},
            {"view": 3, "from": few, "to": max(1, more)},
            {"view": 4, "from": 0, "to": total},
            {"view": 5, "from": 0, "to": max(1, more)},
        ]
        settings = {
            "address": viewer.url, "batches": batches, "height": height, "width": width, "isColored": is_colored,
            "isTransparent": is_transparent,
        }  # fmt: skip
        alone, _ = page.tab.evaluate(IN_BANDS, settings | {"helpers": 0})
        for helpers in (1, 2):
            together, asked = page.tab.evaluate(IN_BANDS, settings | {"helpers": helpers})
            assert together == alone
            if total > 50:  # of views 1, 3 and 5; the filling has not reached the first helper
                assert asked == {"samples": 10 * helpers, "complete": 5 * helpers, "nothing": helpers + 1}


@pytest.mark.parametrize(("cores", "completing"), [(2, 1), (4, 2)])
def test_two_workers_complete_pictures_where_there_are_four_cores(tabs, viewer, cores, completing):
    of_cores = f"Object.defineProperty(navigator, 'hardwareConcurrency', {{ value: {cores} }});"
    page = Page(tabs, f"{viewer.url}?size=300x201#scene=csg.sdf", WORKERS + of_cores)
    page.exact()
    page.tab.evaluate(ORBIT)
    files = page.tab.evaluate("() => workers.map(({ file }) => file)")
    assert sum("completing" in file for file in files) == completing
    csg = bob.trace(bob.load(VIEWER / "gallery" / "csg.sdf"), page.camera(), size=(201, 300))
    assert_equal_pictures(page.exact(), color_to_8_bit(csg.gray))
    page.close()


def test_pictures_are_completed_by_the_network_that_was_planned(page, viewer):
    """Or by the default if it is missing."""
    size, few = (60, 80), 96  # 2 % of the pixels
    full = bob.trace(bob.happy_tree(), size=size)
    pixels = bob.pixel_order(size, count=480)
    samples = np.zeros((480, 6), np.float32)
    samples[:, :5] = full.stack()[:, pixels[:, 0], pixels[:, 1]].T
    samples[:, 0] = samples[:, 2] > 0  # hits
    expected = full.stack() * (np.arange(80) < 40)  # the left half, slightly darker
    expected[1] *= 0.9
    batches = [
        {"count": few, "model": "default"},
        {"count": 480, "model": "filling"},
        {"count": few, "model": "paper"},
        {"count": few, "model": "filling", "expected": base64.b64encode(expected.astype(np.float32)).decode()},
        {"count": few, "model": "default"},
    ]
    found = page.tab.evaluate(
        COMPLETE,
        {"address": viewer.url, "batches": batches, "height": 60, "width": 80,
         "pixels": pixels.ravel().tolist(), "samples": samples.ravel().tolist()},
    )  # fmt: skip
    assert [name for name, *_ in found] == ["default", "filling", "default", "filling", "default"]
    assert [traced for _, traced, *_ in found] == [few, 480, few, few, few]
    assert [back for *_, back in found] == [None, None, None, expected.size, None]
    for batch, (name, _, image, _) in zip(batches, found, strict=True):
        known = np.zeros_like(expected) if "expected" not in batch else expected.copy()
        at = tuple(pixels[: batch["count"]].T)
        known[:, at[0], at[1]] = full.stack()[:, at[0], at[1]]
        part = bob.GBuffer(mask=known[0], gray=known[1], depth=known[2], normal=np.moveaxis(known[3:], 0, -1))
        ours, other = (bob.complete(part, model=model) for model in (name, {"default": "filling"}.get(name, "default")))
        # The page clamps before interpolation, Python after it.
        assert np.abs(numbers(image).reshape(ours.shape) - ours).mean() < 1e-4 < np.abs(ours - other).mean(), name


MOVES = """
async ({ address, file, height, width }) => {
  const part = (path) => import(new URL(path, address).href);
  const [{ loadCore }, { readFile }, { History }, { PixelSequence }, { buildScene }] = await Promise.all(
    ["core/load.js", "files/read.js", "picture/history.js", "picture/order.js", "tracing/scene.js"].map(part));
  const core = await loadCore(), bytes = await (await fetch(new URL(file, address))).arrayBuffer();
  const scene = buildScene(core, await readFile(core, file, bytes)), size = { height, width };
  const cameraAt = (azimuth) => ({ azimuth, elevation: 20, roll: 0, zoom: 1, panX: 0, panY: 0, fov: 0 });
  const trace = (sequence, camera, count) => {
    const traced = [];
    while (traced.length < 2 * count) {
      const left = count - traced.length / 2, pixels = sequence.next(Math.min(sequence.available(left), left));
      sequence.add(pixels, scene.trace(pixels, size, camera));
      traced.push(...pixels);
    }
    return traced;
  };
  const history = new History(core, size, scene.layout), first = new PixelSequence(core, size, scene.layout);
  trace(first, cameraAt(30), height * width);
  const expects = history.move(scene.handle, cameraAt(30), first.planes, cameraAt(33), 7);
  const expected = history.picture(), second = new PixelSequence(core, size, scene.layout, history);
  const traced = trace(second, cameraAt(33), 300), shown = history.picture(new Float32Array(expected.length));
  const rest = trace(second, cameraAt(33), height * width - 300);
  const jumps = !history.move(scene.handle, cameraAt(33), second.planes, cameraAt(200), 8);
  const [before, after] = [expected, shown].map((planes) => new Uint8Array(planes.slice().buffer).toBase64());
  return { expects, jumps, expected: before, shown: after, traced, rest };
}
"""


def test_what_the_page_carries_along_is_shaded_anew_and_its_pixels_are_exact(page, viewer):
    size = (60, 80)
    found = page.tab.evaluate(
        MOVES, {"address": viewer.url, "file": "gallery/happy_tree.bob", "height": 60, "width": 80}
    )
    exact = bob.trace(bob.happy_tree(), bob.Camera(azimuth=33), size=size).stack()
    expected, shown = (numbers(found[name]).reshape(5, *size) for name in ("expected", "shown"))
    known = expected[0] > 0
    assert found["expects"]
    assert found["jumps"]
    assert 0.8 < known.mean() < 1
    assert (np.abs(expected - exact)[1][known] < 0.02).mean() > 0.8
    traced = np.reshape(found["traced"], (-1, 2))
    np.testing.assert_allclose(shown[:, traced[:, 0], traced[:, 1]], exact[:, traced[:, 0], traced[:, 1]], atol=1e-5)
    assert (np.abs(shown - exact)[1] > 0.02).sum() < 0.9 * (np.abs(expected - exact)[1] > 0.02).sum()
    everywhere = np.concatenate([traced, np.reshape(found["rest"], (-1, 2))])
    assert len(np.unique(everywhere, axis=0)) == len(everywhere) == size[0] * size[1]


@pytest.mark.parametrize("role", ["leads", "helps"])
def test_others_go_on_where_a_worker_ends(tabs, viewer, role):
    page = Page(tabs, f"{viewer.url}?size=640x480&workers=3#scene=vase.sdf", WORKERS + ALONE)
    page.wait_until(lambda: page.tab.evaluate(JOINED))
    page.tab.evaluate(
        """
        (role) => {
          const worker = workers.find((worker) => worker[role]);
          worker.terminate();
          worker.dispatchEvent(new ErrorEvent("error", { message: "it ended" }));
        }
        """,
        role,
    )
    expected = bob.trace(bob.load(viewer.files["gallery/vase.sdf"]), page.camera(), size=(480, 640))
    assert_equal_pictures(page.exact(), color_to_8_bit(expected.gray))
    page.close()


@pytest.mark.parametrize(("script", "tracers", "lenders"), [("", 1, 2), (ALONE, 3, 0)], ids=["shared", "alone"])
def test_workers_share_a_scene_where_they_may_share_memory(tabs, viewer, script, tracers, lenders):
    page = Page(tabs, f"{viewer.url}?size=300x201&workers=3#scene=gear.sdf", WORKERS + script)
    page.exact()
    page.tab.evaluate(ORBIT)
    files = page.tab.evaluate("() => workers.map(({ file }) => file.split('/').at(-1))")
    # The next scene's workers may have been started, too.
    assert files.count("tracer.js") in (tracers, tracers + 1)
    assert files.count("thread.js") in (lenders, 2 * lenders)
    gear = bob.trace(bob.load(viewer.files["gallery/gear.sdf"]), page.camera(), size=(201, 300))
    assert_equal_pictures(page.exact(), color_to_8_bit(gear.gray))
    page.close()


def test_a_page_says_so_where_a_lent_thread_ends(tabs, viewer):
    page = Page(tabs, f"{viewer.url}?size=300x201&workers=2#scene=csg.sdf", WORKERS)
    page.exact()
    page.tab.evaluate(
        """
        () => {
          const worker = workers.find(({ file }) => file.endsWith("thread.js"));
          worker.terminate();
          worker.dispatchEvent(new ErrorEvent("error", { message: "it ended" }));
        }
        """
    )
    page.wait_until(lambda: "it ended" in page.text("body"))
    page.choose("gyroid.bob")
    gyroid = bob.trace(bob.load(VIEWER / "gallery" / "gyroid.bob"), size=(201, 300))
    assert_equal_pictures(page.exact(), color_to_8_bit(gyroid.gray))
    page.close()


# A worker that traces every pixel of a scene, rebuilt each time, with a given number of threads.
TRACES = b"""
import { compileCore } from "./core/compile.js";
import { Core, sharedMemoryFor } from "./core/core.js";
import { readFile } from "./files/read.js";
import { buildScene } from "./tracing/scene.js";

onmessage = async ({ data: { name, file, threads, times, lenders } }) => {
  const module = await compileCore(name), memory = sharedMemoryFor(module), core = new Core(module, memory);
  for (const port of lenders) port.postMessage({ module, memory });
  while (memory && core.call("set_threads", threads) < threads) await new Promise((later) => setTimeout(later, 5));
  const description = await readFile(core, file, await (await fetch(file)).arrayBuffer());
  const height = 60, width = 80, size = { height, width }, pixels = new Int32Array(2 * height * width);
  for (let i = 0; i < height * width; ++i) pixels.set([Math.floor(i / width), i % width], 2 * i);
  const camera = { azimuth: 30, elevation: 20, roll: 0, zoom: 1, panX: 0, panY: 0, fov: 0 }, pictures = [];
  for (let i = 0; i < times; ++i) {
    const scene = buildScene(core, description);
    pictures.push(new Uint8Array(scene.trace(pixels, size, camera).slice().buffer).toBase64());
    scene.free();
  }
  let refused = "";
  try {
    buildScene(core, { shapes: [{ kind: "script", source: "f = sphere(" }], instances: [{ shape: 0 }] });
  } catch (error) {
    refused = error.message;
  }
  const [picture] = pictures, same = pictures.every((other) => other === picture);
  postMessage({ same, picture, refused });
};
"""

TRACE_IN_WORKER = """
(settings) => new Promise((resolve, reject) => {
  const start = (file, message, ports) => {
    const worker = new Worker(file, { type: "module" });
    worker.onerror = ({ message }) => reject(new Error(message));
    worker.postMessage(message, ports);
    return worker;
  };
  const lenders = Array.from({ length: settings.threads - 1 }, () => {
    const { port1, port2 } = new MessageChannel();
    start("workers/thread.js", port1, [port1]);
    return port2;
  });
  start("traces.js", { ...settings, lenders }, lenders).onmessage = ({ data }) => resolve(data);
})
"""


@pytest.mark.parametrize("file", ["gallery/gear.sdf", "gallery/vase.sdf", "gallery/happy_tree.bob", "gallery/knot.bob"])
def test_lent_threads_make_the_same_picture_each_time(tabs, viewer, file):
    viewer.files |= {"traces.js": TRACES, "blank.html": b"<!doctype html>"}
    tab = tabs.open(on={})
    tab.goto(viewer.url + "blank.html")

    def traced(**settings):
        return tab.evaluate(TRACE_IN_WORKER, {"file": file, **settings})

    one = traced(name="core", threads=1, times=1)
    shared = traced(name="core.threads", threads=3, times=4)
    tabs.release(tab)
    assert shared == one
    assert shared["same"]
    assert "line 1" in shared["refused"]


# ---- Hands -----------------------------------------------------------------------------------------------


def drag(page, right, down, button="left"):
    box = page.tab.locator("#picture canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.tab.mouse.move(x, y)
    page.tab.mouse.down(button=button)
    for step in (0.5, 1):
        page.tab.mouse.move(x + step * right, y + step * down)
    page.tab.mouse.up(button=button)


def test_mouse_orbits(page):
    page.choose("csg.sdf")
    before = page.camera()
    drag(page, 60, 30)
    after = page.camera()
    assert (after.azimuth - before.azimuth) % 360 > 180  # it follows the pointer
    assert after.elevation > before.elevation
    assert_equal_pictures(page.exact(), expected(bob.load(VIEWER / "gallery" / "csg.sdf"), after))


def test_keys_orbit_zoom_and_reset(page):
    page.choose("csg.sdf")
    page.tab.focus("#picture")
    for key in ("ArrowLeft", "ArrowLeft", "ArrowUp", "]", "+"):
        page.tab.keyboard.press(key)
    assert page.camera() == bob.Camera(azimuth=20, elevation=25, roll=5, zoom=1.15)
    assert_equal_pictures(page.exact(), expected(bob.load(VIEWER / "gallery" / "csg.sdf"), page.camera()))
    page.tab.keyboard.press("Home")
    assert page.camera() == bob.Camera()


def test_perspective_is_switched(page):
    page.choose("csg.sdf")
    scene = bob.load(VIEWER / "gallery" / "csg.sdf")
    page.tab.check("#perspective")
    assert page.camera() == bob.Camera(fov=35)
    assert_equal_pictures(page.exact(), expected(scene, bob.Camera(fov=35)))
    drag(page, 60, 30)
    drag(page, 20, 10, button="right")
    turned = page.camera()
    assert turned.azimuth != 30
    assert turned.pan[0] < 0 < turned.pan[1]
    assert_equal_pictures(page.exact(), expected(scene, turned))
    page.tab.focus("#picture")
    page.tab.keyboard.press("Home")  # it keeps the lens
    assert page.camera() == bob.Camera(fov=35)
    page.tab.keyboard.press("p")
    assert page.camera() == bob.Camera()
    assert not page.tab.is_checked("#perspective")
    assert_equal_pictures(page.exact(), expected(scene))


@pytest.mark.parametrize("fov", [35, 90])
def test_zooming_in_perspective_keeps_what_is_under_the_pointer(page, fov):
    """For points at the distance of the scene's centre."""
    page.choose("csg.sdf")
    page.tab.evaluate("(fov) => bobrossnet.look({ fov })", fov)
    box = page.tab.locator("#picture canvas").bounding_box()
    page.tab.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.25 * box["height"])

    def under_pointer():
        camera = page.camera()
        core = camera.core((0, 0, 0), 1)
        half = np.tan(np.radians(camera.fov) / 2)
        toward = np.array([np.cos(a := np.radians(30)) * np.cos(e := np.radians(20)), np.sin(a) * np.cos(e), np.sin(e)])
        right, up = np.array([-np.sin(a), np.cos(a), 0]), np.cross(toward, [-np.sin(a), np.cos(a), 0])
        distance = 1 / np.sin(np.arctan(half * min(WIDTH, HEIGHT) / HEIGHT))
        side = 2 * half * distance / (HEIGHT * camera.zoom)
        x, y = camera.pan[0] + 0.25 * WIDTH * side, camera.pan[1] + 0.25 * HEIGHT * side
        point = (x * right + y * up).astype(np.float32)
        row, column, _ = core.seen(HEIGHT, WIDTH, point[None])[0]
        assert (column + 0.5, row + 0.5) == pytest.approx((0.75 * WIDTH, 0.25 * HEIGHT), abs=0.01)
        return point

    before = under_pointer()
    page.tab.mouse.wheel(0, -400)
    page.wait_until(lambda: page.camera().zoom > 1.5)
    assert under_pointer() == pytest.approx(before, abs=0.01)


def test_dragging_with_the_other_button_moves_the_picture(page):
    page.choose("csg.sdf")
    before = page.exact()
    box = page.tab.locator("#picture canvas").bounding_box()
    columns, rows = 20, 10
    drag(page, columns * box["width"] / WIDTH, rows * box["height"] / HEIGHT, button="right")
    after = page.exact()
    assert_equal_pictures(after[rows:, columns:], before[: HEIGHT - rows, : WIDTH - columns, 0], pixels=0.01)
    assert not after[:rows].any()


def test_wheel_zooms_about_the_pointer(page):
    page.choose("csg.sdf")
    box = page.tab.locator("#picture canvas").bounding_box()
    page.tab.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.25 * box["height"])
    page.tab.mouse.wheel(0, -400)
    page.wait_until(lambda: page.tab.evaluate("() => bobrossnet.camera().zoom") > 1.5)
    camera = page.tab.evaluate("() => bobrossnet.camera()")
    # The point under the pointer, in radii: pan + offset from the centre.
    shorter = min(WIDTH, HEIGHT)
    for pan, offset in (("panX", 0.25 * WIDTH), ("panY", 0.25 * HEIGHT)):
        assert camera[pan] + offset * 2 / (shorter * camera["zoom"]) == pytest.approx(offset * 2 / shorter, abs=0.01)


def test_two_fingers_pinch(page):
    page.tab.evaluate("""
        () => {
          const picture = document.querySelector("#picture").shadowRoot.querySelector("canvas");
          const { left, top } = picture.getBoundingClientRect();
          picture.setPointerCapture = () => {};
          const touch = (type, pointerId, x, y) => picture.dispatchEvent(new PointerEvent(
            type, { pointerId, pointerType: "touch", clientX: left + x, clientY: top + y, bubbles: true }));
          touch("pointerdown", 11, 100, 100), touch("pointerdown", 12, 200, 100);
          touch("pointermove", 11, 50, 100), touch("pointermove", 12, 250, 100);
          touch("pointerup", 11, 50, 100), touch("pointerup", 12, 250, 100);
          delete picture.setPointerCapture;
        }
    """)
    assert page.tab.evaluate("() => bobrossnet.camera().zoom") == pytest.approx(2, rel=0.05)


# ---- Modes -----------------------------------------------------------------------------------------------


def is_untraced(pixels):
    return (pixels == np.array(UNTRACED, np.uint8)).all(-1)


def test_split_picture_has_traced_pixels_left_of_its_divider(page):
    page.choose("gear.sdf")  # its rays are slow: no machine traces all of them in one frame
    page.tab.uncheck("#refines")
    page.tab.fill("#budget", "10")
    page.tab.check("[value=split]", force=True)
    page.tab.evaluate("() => bobrossnet.look({ azimuth: 31 })")
    page.tab.focus("#divider")

    def untraced():
        columns = is_untraced(page.pixels()).any(0)
        return [part.sum() for part in np.split(columns, [WIDTH // 4, WIDTH // 2])]

    page.tab.keyboard.press("End")
    page.wait_until(lambda: sum(untraced()[:2]) > WIDTH // 10 < untraced()[2])
    page.tab.keyboard.press("Home")
    page.wait_until(lambda: sum(untraced()[1:]) == 0)


def test_difference_is_that_of_the_first_picture(page):
    page.choose("csg.sdf")
    page.exact()
    before = page.pixels()
    page.tab.check("[value=difference]", force=True)
    page.wait_until(lambda: (page.pixels() != before).any())
    first, image = page.tab.evaluate("""
        async () => {
          const { first, image } = await bobrossnet.buffers();
          return [first, image].map(({ buffer }) => new Uint8Array(buffer).toBase64());
        }
    """)
    difference = 4 * np.abs(numbers(first) - numbers(image)).reshape(HEIGHT, WIDTH)
    assert_equal_pictures(page.pixels(), to_8_bit(difference), pixels=0)
    page.wait_until(lambda: "4 times as bright" in page.text("#note"))


def test_uncertain_is_where_errors_are_expected(page):
    page.choose("gear.sdf")
    page.tab.uncheck("#refines")
    page.tab.fill("#budget", "10")
    page.tab.check("[value=uncertain]", force=True)
    page.tab.evaluate("() => bobrossnet.look({ azimuth: 31 })")
    page.wait_until(lambda: "is expected to be" in page.text("#note") and "NaN" not in page.text("#note"))
    planes, shown = None, None
    while planes is None or (shown != page.pixels()).any():
        shown = page.pixels()
        planes = buffers(page)
    mask, gray, depth, x, y = planes
    part = bob.GBuffer(mask=mask, gray=gray, depth=depth, normal=np.stack([x, y], -1))
    assert 0 < part.fraction < 1
    model = page.tab.evaluate("() => bobrossnet.statistics.model")
    assert_equal_pictures(shown, to_8_bit(np.minimum(4 * bob.uncertainty(part, model=model), 1)))
    page.tab.check("#refines")
    page.wait_until(lambda: "exact" in page.text("#note"))
    assert not page.pixels()[..., :3].any()


def test_dense_pictures_are_completed_by_the_filling(page):
    page.choose("csg.sdf")
    page.tab.uncheck("#refines")
    page.tab.fill("#budget", "100")  # time for many of 96x128 pixels
    azimuths = itertools.count(40)

    def is_filled():  # once that network has been loaded
        page.tab.evaluate("(azimuth) => bobrossnet.look({ azimuth })", next(azimuths))
        return page.tab.evaluate("() => bobrossnet.statistics.model") == "filling"

    page.wait_until(is_filled)


# ---- Files -----------------------------------------------------------------------------------------------

FORMULA = (
    b"a var-x\nb var-y\nc var-z\nd square a\ne square b\nf square c\ng add d e\nh add g f\ni const 0.5\nj sub h i\n"
)


def drop(page, viewer, name, content):
    viewer.files["dropped"] = content
    page.tab.evaluate(DROP, {"address": "/dropped", "name": name})
    page.opened()


def test_dropped_file_is_shown(page, viewer, tmp_path):
    (tmp_path / "ball.vm").write_bytes(FORMULA)
    drop(page, viewer, "ball.vm", FORMULA)
    assert_equal_pictures(page.exact(), expected(bob.load(tmp_path / "ball.vm")))
    assert page.text("#gallery option:checked") == "ball.vm"
    assert page.tab.get_attribute("#picture canvas", "aria-label") == "Picture of ball.vm"
    assert page.tab.is_disabled("#link")


def test_what_has_y_up_is_turned(page, viewer, tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 3 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 9 9 9\n"
    (tmp_path / "thing.obj").write_text(text)
    page.choose("csg.sdf")
    assert not page.tab.is_visible("#y-up")
    drop(page, viewer, "thing.obj", text.encode())
    with pytest.warns(bob.InputWarning):
        scene = bob.load(tmp_path / "thing.obj")
    assert_equal_pictures(page.exact(), expected(scene))
    assert "thing.obj" in page.text("#message")
    page.tab.check("#y-up")
    page.opened()
    assert_equal_pictures(page.exact(), expected(scene.turned_upright()))
    page.tab.uncheck("#y-up")
    page.opened()
    assert_equal_pictures(page.exact(), expected(scene))


def test_meshes_that_lie_are_stood_up(page, viewer, tmp_path):
    """Each file that is opened is judged anew; those of formats that say which axis is up stay as they are."""
    LYING.save(tmp_path / "lies.ply")
    drop(page, viewer, "lies.ply", (tmp_path / "lies.ply").read_bytes())
    with pytest.warns(bob.InputWarning, match="seems to lie") as told:
        scene = bob.load(tmp_path / "lies.ply", up="auto")
    assert page.text("#message") == str(told[0].message)
    assert page.tab.is_checked("#y-up")
    assert_equal_pictures(page.exact(), expected(scene))
    page.tab.uncheck("#y-up")
    page.opened()
    assert page.text("#message") == ""
    assert_equal_pictures(page.exact(), expected(bob.load(tmp_path / "lies.ply")))
    LYING.save(tmp_path / "more.stl")
    page.tab.set_input_files("#file", [tmp_path / name for name in ("more.stl", "lies.ply")])
    page.opened()
    assert page.text("#message").startswith("more.stl and others: seems to lie on its back, ")
    bob.save_scene(bob.load(tmp_path / "lies.ply"), tmp_path / "lies.bob")
    drop(page, viewer, "lies.bob", (tmp_path / "lies.bob").read_bytes())
    assert page.text("#message") == ""
    assert not page.tab.is_checked("#y-up")


# Ends workers of the displayed scene while another one of the gallery is being opened.
END_WHILE_OPENING = """([kind, file]) => {
  const gallery = document.querySelector("#gallery"), known = workers.filter(({ file }) => file.endsWith(`${kind}.js`));
  const ending = kind === "tracer" ? known.filter(({ leads, helps }) => leads || helps) : known;
  gallery.value = file;
  gallery.dispatchEvent(new Event("change"));
  for (const worker of ending) {
    worker.terminate();
    worker.dispatchEvent(new ErrorEvent("error", { message: "it ended" }));
  }
}"""


@pytest.mark.parametrize(
    ("ending", "message", "shown"), [("tracer", "", "gyroid.bob"), ("completing", "it ended", "csg.sdf")]
)
def test_workers_end_while_the_next_scene_is_being_opened(tabs, viewer, ending, message, shown):
    page = Page(tabs, viewer.url + SIZE + "&workers=2#scene=csg.sdf", WORKERS)
    page.exact()
    page.tab.evaluate(END_WHILE_OPENING, [ending, "gyroid.bob"])
    page.opened()
    assert page.text("#message") == message
    assert page.tab.input_value("#gallery") == shown
    if shown != "gyroid.bob":
        page.choose("gyroid.bob")
    assert_equal_pictures(page.exact(), expected(bob.load(VIEWER / "gallery" / "gyroid.bob")))
    page.close()


def test_the_failure_of_a_scene_that_was_given_up_does_not_end_the_next(page):
    """Tracers keep the scenes of several elements."""
    warnings = page.tab.evaluate("""
        async () => {
          const part = (path) => import(new URL(path, location.href));
          const [{ compileCore }, { Pool }] = await Promise.all(["core/compile.js", "workers/pool.js"].map(part));
          const pool = new Pool(1, compileCore(), { postMessage() {} }, () => {}, () => {});
          const scene = (source) => ({ shapes: [{ kind: "script", source }], instances: [{ shape: 0 }] });
          pool.open(1, scene("sphere(")).catch(() => {});
          const warnings = await pool.open(2, scene("sphere(1)"));
          pool.end();
          return warnings;
        }
    """)
    assert warnings == []


BROKEN = {
    "broken.bob": b"no scene",
    "empty.sdf": b"",
    "wrong.vm": b"a var-q\n",
    "letter.doc": b"Dear",
    "wrong.sdf": b"box(\n",
}


@needs_models
@pytest.mark.parametrize("name", ["scans/stanford_bunny.ply", "nurbs/ducky.nurbs.json"])
def test_chosen_file_is_shown(page, name):
    page.tab.set_input_files("#file", MODELS / name)
    page.opened()
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        scene = bob.load(MODELS / name, up="auto")
    assert page.text("#message") == " ".join(str(each.message) for each in told)
    assert_equal_pictures(page.exact(), expected(scene))


def test_a_shape_beyond_its_budget_is_shown_with_a_warning(page, tmp_path):
    """Python's warning. A formula's would take a page a minute on a busy machine."""
    rng, count, degree = np.random.default_rng(0), 20, 9
    u, v = np.meshgrid(*2 * [np.linspace(0, 1, count)], indexing="ij")
    knots = np.concatenate([np.zeros(degree), np.linspace(0, 1, count - degree + 1), np.ones(degree)])
    points = np.stack([u, v, rng.standard_normal((count, count))], axis=-1)
    face = bob.Face(points, knots, knots, 10 ** rng.uniform(-4, 4, (count, count)))
    with pytest.warns(bob.InputWarning) as told:
        bob.save_scene(bob.Brep([face]), tmp_path / "face.bob")
    page.tab.set_input_files("#file", tmp_path / "face.bob")
    page.opened()
    assert page.text("#message") == str(told[0].message)


@pytest.mark.parametrize(("name", "content"), BROKEN.items(), ids=BROKEN)
def test_broken_file_leaves_the_scene(page, viewer, name, content):
    page.choose("csg.sdf")
    before = page.exact()
    drop(page, viewer, name, content)
    assert re.fullmatch(rf"{name}: .+", page.text("#message"))
    np.testing.assert_array_equal(page.exact(), before)
    assert page.text("#gallery option:checked") == "Ball, box and cylinders"
    page.tab.focus("#picture")
    page.tab.keyboard.press("ArrowLeft")
    assert (page.exact() != before).any()
    page.choose("gyroid.bob")
    assert page.text("#message") == ""


# ---- Scripts ---------------------------------------------------------------------------------------------


@pytest.fixture
def script(page):
    """Return the page with a ball's script and its editor open."""
    page.choose("csg.sdf")
    if page.tab.get_attribute("#script", "open") is None:
        page.tab.click("#script summary")
    page.tab.fill("#text", "RADIUS = 2  # of the ball\nball = sphere(RADIUS)\nball - box(1)\n")
    page.opened()
    return page


def test_edited_script_is_shown(script):
    assert script.text("#gallery option:checked").startswith("Ball, box and cylinders")
    source = script.tab.input_value("#text").encode()
    ball = bob.Implicit(_core.run_script(source).expression)
    assert_equal_pictures(script.exact(), expected(ball))


def test_a_scene_that_comes_late_does_not_replace_a_newer_one(page):
    """As if a script is edited while other workers still receive the file."""
    editions = page.tab.evaluate("""
        async () => {
          const at = (path) => new URL(path, location.href);
          const { compileCore } = await import(at("core/compile.js"));
          const worker = new Worker(at("workers/tracer.js"), { type: "module" });
          const completing = new MessageChannel(), reading = new MessageChannel(), editions = [];
          worker.postMessage({ kind: "connect", completing: completing.port1, reading: reading.port1 },
                             [completing.port1, reading.port1]);
          worker.postMessage({ kind: "start", module: await compileCore() });
          const open = (edition, to) => new Promise((resolve) => {
            const scene = { shapes: [{ kind: "script", source: `sphere(${edition + 1})` }], instances: [{ shape: 0 }] };
            worker.onmessage = ({ data }) => resolve(editions.push(data.edition));
            to.postMessage({ kind: "open", scene, edition });
          });
          await open(1, worker);
          open(0, reading.port2);
          await new Promise((resolve) => setTimeout(resolve, 200));
          await open(2, worker);
          worker.terminate();
          return editions;
        }
    """)
    assert editions == [1, 2]


def test_wrong_line_is_marked_and_the_picture_stays(script):
    before = script.exact()
    script.tab.fill("#text", "RADIUS = 2\nball = spere(RADIUS)\nball\n")
    script.tab.wait_for_selector("#numbers .wrong")
    assert script.text("#numbers .wrong") == "2"
    assert script.text("#error").startswith("line 2, column 8: ")
    assert script.tab.get_attribute("#text", "aria-invalid") == "true"
    np.testing.assert_array_equal(script.exact(), before)
    script.tab.fill("#text", "box(1)\n")
    script.opened()
    assert script.tab.locator("#numbers .wrong").count() == 0
    assert (script.exact() != before).any()


def test_named_numbers_have_sliders(script):
    slider = script.tab.get_by_label("RADIUS")
    before = script.exact()
    slider.focus()
    script.tab.keyboard.press("ArrowLeft")
    assert script.tab.input_value("#text").startswith("RADIUS = 1  # of the ball\n")
    script.opened()
    assert (script.exact() != before).any()


GEAR = (VIEWER / "gallery" / "gear.sdf").read_text().rstrip()

EDITS = """
async ([milliseconds, every]) => {
  const text = document.querySelector("#text"), before = text.value;
  let pictures = 0, edits = 0;
  const count = () => ++pictures;
  document.addEventListener("progress", count, true);
  for (const begin = performance.now(); pictures < 3 && performance.now() < begin + milliseconds;) {
    text.value = `${before} - sphere(${(.2 + .001 * edits++).toFixed(3)})`;
    text.dispatchEvent(new Event("input"));
    await new Promise((resolve) => setTimeout(resolve, every));
  }
  document.removeEventListener("progress", count, true);
  return { pictures, edits };
}
"""


def test_each_edit_that_is_opened_gets_a_picture(script):
    """A slider is dragged: faster than pictures come, and the last text is shown in the end."""
    script.tab.fill("#text", GEAR)
    script.opened()
    found = script.tab.evaluate(EDITS, [20_000, 15])
    assert found["pictures"] >= 3
    script.opened()
    source = f"{GEAR} - sphere({0.2 + 0.001 * (found['edits'] - 1):.3f})"
    assert script.tab.input_value("#text") == source
    assert_equal_pictures(script.exact(), expected(bob.Implicit(_core.run_script(source.encode()).expression)))


def test_script_can_be_written_from_nothing(page):
    page.choose("knot.bob")
    assert page.tab.input_value("#text") == ""
    if page.tab.get_attribute("#script", "open") is None:
        page.tab.click("#script summary")
    page.tab.fill("#text", "spere(1)")
    page.opened()
    assert page.text("#error").startswith("line 1, column 1: ")
    assert page.text("#gallery option:checked") == "Knot"
    page.tab.fill("#text", "torus(1, 0.3)")
    page.opened()
    torus = bob.Implicit(_core.run_script(b"torus(1, 0.3)").expression)
    assert_equal_pictures(page.exact(), expected(torus))
    assert page.text("#gallery option:checked").startswith("Script")


# ---- Links -----------------------------------------------------------------------------------------------


def test_link_restores_gallery_and_camera(page, tabs):
    page.choose("knot.bob")
    page.tab.evaluate(
        "() => bobrossnet.look({ azimuth: 100, elevation: -12.5, zoom: 1.25, panX: 0.1, panY: -0.2, fov: 50 })"
    )
    before, link = page.exact(), page.tab.evaluate("() => bobrossnet.link()")
    other = Page(tabs, link)
    np.testing.assert_array_equal(other.exact(), before)
    assert other.text("#gallery option:checked") == "Knot"
    assert other.camera() == bob.Camera(100, -12.5, zoom=1.25, pan=(0.1, -0.2), fov=50)
    assert other.tab.is_checked("#perspective")
    other.close()


def test_link_restores_script(script, tabs):
    before, link = script.exact(), script.tab.evaluate("() => bobrossnet.link()")
    other = Page(tabs, link)
    np.testing.assert_array_equal(other.exact(), before)
    assert other.tab.input_value("#text") == script.tab.input_value("#text")
    other.close()


def script_link(packed):
    """Return a fragment with these bytes as its script."""
    return "#script=" + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def deflated(data):
    deflate = zlib.compressobj(9, wbits=-15)
    return deflate.compress(data) + deflate.flush()


DAMAGED = "link: expected a script as this page packs it, got a damaged one; was the whole link copied?"


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("#script=!!!", DAMAGED),
        (script_link(b"nonsense"), DAMAGED),
        (script_link(deflated(b"sphere(1)")[:-3]), DAMAGED),
        (script_link(deflated(b"sphere(1) # \xff")), DAMAGED),
        ("#scene=" + "x" * 1000, f"{'x' * 100}: expected a built-in scene, one of "),
        ("?scene=%zz", "%zz: expected one of .ply "),
        ("?scene=files/100%25.bob", "/files/100%.bob, got 404 Not Found; check the address"),
        ("?scene=http://[", "scene: expected a file of http://127.0.0.1:"),
        ("?scene=http://example.com/a.bob", "scene: expected a file of http://127.0.0.1:"),
        ("#camera=1_2", "camera: expected 7 numbers, azimuth_elevation_roll_zoom_panX_panY_fov, got 1_2"),
        ("#scene=csg.sdf&camera=1_2_3_4_5_6_x", "camera: expected 7 numbers, azimuth_elevation_roll_zoom_panX_panY_"),
        ("?scene=gallery/csg.sdf#camera=1_2_3__5_6_7", "got 1_2_3__5_6_7"),
        ("#scene=csg.sdf&light=sun", "light: expected scene, headlight or studio, got sun"),
    ],
    ids=range(13),
)
def test_a_damaged_link_is_told(shared, viewer, address, message):
    shared.visit(viewer.url + SIZE + address.replace("?", "&"))
    shared.opened()
    assert message in shared.text("#message")
    assert shared.text("#message").count("\n") == 0
    assert shared.camera() == bob.Camera()
    shared.wrong[:] = [text for text in shared.wrong if "404" not in text]


def test_a_link_is_unpacked_as_far_as_scripts_go(shared, viewer):
    """A deflate stream of zeros is a thousandth of its content: here of 900 MB."""
    deflate = zlib.compressobj(9, wbits=-15)
    block = deflate.compress(bytes(2**20)) + deflate.flush(zlib.Z_FULL_FLUSH)  # which refers to nothing before it
    for data in (deflated(bytes(2**20 + 1)), 900 * block + deflate.flush()):
        shared.visit(viewer.url + SIZE + script_link(data))
        assert shared.text("#message") == f"link: expected a script of at most {2**20} bytes, got a larger one"
    shared.visit(viewer.url + SIZE + script_link(deflated(bytes(2**20))))
    assert shared.text("#message") == ""  # the core refuses it


def test_a_file_of_any_name_is_shown(browser, tabs, tmp_path):
    name = os.fsdecode(b"a #1? 100%41&b=c+d<e>\"'\\\t\n\xe9.obj")
    (tmp_path / name).write_text("v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")
    wanted = expected(bob.load(tmp_path / name))
    command = [*COMMAND, "view", "--no-browser", name]
    with running(command, stdout=PIPE, cwd=tmp_path) as process:
        page = Page(tabs, process.stdout.readline().partition(" ")[0] + f"&{SIZE[1:]}")
        assert_equal_pictures(page.exact(), wanted)
        assert page.text("#gallery option:checked").split() == name.replace("\udce9.obj", "\ufffd.bob").split()
        page.close()
    assert cli.main(["view", "--export", str(tmp_path / "page"), str(tmp_path / name)]) == 0
    with serving(tmp_path / "page") as address:
        page = Page(tabs, address + SIZE)
        assert_equal_pictures(page.exact(), wanted)
        page.close()
    one = tmp_path / name.replace(".obj", ".html")
    assert cli.main(["view", "--export", str(one), str(tmp_path / name)]) == 0
    tab = browser.new_page()
    tab.goto("file://" + quote(os.fsencode(one)))
    tab.evaluate("() => document.querySelector('bob-view').converged()")
    assert tab.title().startswith("a #1? 100%41")
    tab.close()


def test_saved_picture_is_the_one_shown(page):
    page.choose("gyroid.bob")
    shown = page.exact()
    with page.tab.expect_download() as download:
        page.tab.click("#save")
    assert download.value.suggested_filename == "gyroid.png"
    np.testing.assert_array_equal(np.asarray(Image.open(download.value.path()).convert("RGB")), shown)


def test_a_picture_saved_right_after_a_movement_is_exact_and_says_how_far_it_is(tabs, viewer):
    page = Page(tabs, viewer.url + "?size=640x480#scene=gear.sdf")
    page.exact()
    page.tab.evaluate("""() => {
      window.labels = [];
      const save = document.querySelector("#save");
      new MutationObserver(() => labels.push(save.textContent)).observe(save, { childList: true });
    }""")
    with page.tab.expect_download() as download:  # a busy machine would be exact between two calls
        page.tab.evaluate("() => { bobrossnet.look({ azimuth: 80 }); document.querySelector('#save').click(); }")
    gear = bob.trace(bob.load(VIEWER / "gallery" / "gear.sdf"), bob.Camera(azimuth=80), size=(480, 640))
    found = np.asarray(Image.open(download.value.path()).convert("RGB"))
    assert_equal_pictures(found, color_to_8_bit(gear.gray))
    page.wait_until(lambda: page.text("#save") == "Save PNG" and not page.tab.is_disabled("#save"))
    assert re.fullmatch(r"Tracing… \d+ %", page.tab.evaluate("() => labels[0]"))
    assert page.text("#status") == "The picture is saved"
    page.close()


def test_page_opens_the_file_that_its_address_names(tabs, viewer, tmp_path):
    scene = bob.Scene([bob.load(VIEWER / "gallery" / "csg.sdf"), bob.Instance(bob.happy_tree()).translate((2, 0, 0))])
    bob.save_scene(scene, tmp_path / "two.bob")
    viewer.files["files/two.bob"] = tmp_path / "two.bob"
    page = Page(tabs, viewer.url + SIZE + "&scene=files/two.bob")
    assert_equal_pictures(page.exact(), expected(scene))
    assert page.text("#gallery option:checked") == "two.bob"
    page.visit(viewer.url + SIZE + "&scene=//example.org/two.bob")
    assert page.text("#message").startswith("scene: expected a file of http://127.0.0.1")
    page.close()


def test_files_open_by_addresses_relative_to_the_page(page):
    page.tab.evaluate("() => bobrossnet.openFile({ title: 'relative' }, 'csg.sdf', 'gallery/csg.sdf')")
    assert page.text("#message") == ""
    assert page.text("#gallery option:checked") == "relative"


def test_exported_page_needs_no_other_server(tabs, viewer, tmp_path):
    export({path: content for path, content in viewer.files.items() if "/" in path or "." in path}, tmp_path / "page")
    with serving(tmp_path) as address:
        page = Page(tabs, address + "page/index.html" + SIZE + "#scene=csg.sdf")
        assert_equal_pictures(page.exact(), expected(bob.load(VIEWER / "gallery" / "csg.sdf")))
        assert all(url.startswith((address, "about:", "blob:")) for url in page.asked)
        page.close()


SCHEDULED = """
async (address) => {
  const { Schedule } = await import(new URL("workers/schedule.js", address).href);
  const schedule = new Schedule({ azimuth: 0 }, true), batches = [];
  schedule.refines = false;
  schedule.show({ threads: 2, trace: (batch) => batches.push(batch), cancel() {} });
  const traced = () => {
    const batch = { ...batches.at(-1), height: 240, width: 320, scale: 2 };
    schedule.traced({ batch, rays: 1000, milliseconds: 20, left: 75800, cancelled: false });
    schedule.completed({ batch, traced: 1000, total: 10, model: "filling" });
  };
  for (let i = 0; i < 3; ++i) {
    traced();
    schedule.change({ camera: { azimuth: batches.length } });
  }
  const moving = batches.length;
  traced();
  schedule.refines = true;
  while (batches.length === moving) await new Promise((done) => { schedule.next(); setTimeout(done, 5); });
  return batches.map((batch) => [batch.parts, batch.height, batch.scale, batch.milliseconds, batch.completed]);
}"""


def test_moving_pictures_leave_their_size_to_the_tracer(page, viewer):
    """In 33 ms each. All threads trace. At rest, the page decides the size."""
    *moving, (_, height, scale, _, _) = page.tab.evaluate(SCHEDULED, viewer.url)
    parts, heights, scales, milliseconds, completed = map(list, zip(*moving, strict=True))
    assert set(parts) == {2}
    assert (set(heights), set(scales)) == ({480}, {None})
    assert all(each == pytest.approx(0.8 * 33) for each in milliseconds)
    assert completed == [[], *3 * [[{"model": "filling", "pixels": 320 * 240, "milliseconds": 10}]]]
    assert (height, scale) == (480, 1)
