"""Sections, parts, picks and measures of <bob-view>: pictures and numbers equal to Python's."""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest
import trimesh
from browser import picture_at, serving
from nurbs_shapes import cylinder, sphere, torus

import bobrossnet as bob
from bobrossnet import sdf
from bobrossnet.page.export import export, export_file
from bobrossnet.picture.files import color_to_8_bit
from bobrossnet.support.paths import VIEWER
from bobrossnet.tracing.section import PATTERN

WIDTH, HEIGHT = 160, 120

PAGE = """<!doctype html>
<meta name="viewport" content="width=device-width">
<script type="module" src="bob/component/bob-view.js"></script>
<style>body {{ margin: 0 }} bob-view {{ width: {width}px; height: {height}px }}</style>
<bob-view alt="A part" camera-controls {attributes}></bob-view>
"""

TOLD = """
window.told = [];
for (const name of ["load", "error", "pick"]) {
  document.addEventListener(name, ({ type, detail, target }) => {
    if (target.localName === "bob-view") told.push({ type, detail });
  }, true);
}
"""

VIEW = "document.querySelector('bob-view')"

SHARING = {"Cross_Origin_Opener_Policy": "same-origin", "Cross_Origin_Embedder_Policy": "require-corp"}

CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
SIDES = [face for a, b, c, d in QUADS for face in ((a, b, c), (a, c, d))]


def box(size, **held):
    return bob.Mesh(CORNERS * size, SIDES, **held)


def nested():
    """Return a red box with a ball inside, and a tube next to it, in millimetres."""
    ball = bob.Instance(sdf.sphere(0.7), material=bob.Material("#48c"), name="ball")
    tube = bob.Tube([(-2, -3, 0), (0, -2, 1), (2, -3, 0)], [0, 0, 0, 1, 1, 1], 0.3)
    scene = bob.Scene(
        [
            bob.Instance(box((2, 1.5, 1)), material=bob.Material("#c33"), name="box").translate((10, 0, 0)),
            ball.translate((10, 0, 0)),
            bob.Instance(tube, name="tube").translate((10, 0, 0)),
        ],
        unit="mm",
    )
    return scene


OBJ = "\n".join(
    [
        *(f"v {x} {y} {z}" for at in (0, 3, 6) for x, y, z in CORNERS * 0.8 + (at, 0, 0)),
        "f 1 2 4 3",
        "o housing",
        *(f"f {' '.join(str(corner + 1) for corner in quad)}" for quad in QUADS[1:]),
        "g bolt",
        *(f"f {' '.join(str(corner + 9) for corner in quad)}" for quad in QUADS),
        "o lid",
        *(f"f {' '.join(str(corner + 17) for corner in quad)}" for quad in QUADS),
    ]
)


@pytest.fixture(scope="module")
def folder(viewer, tmp_path_factory):
    """Return a folder with the element's files and scenes."""
    folder = tmp_path_factory.mktemp("cutaways")
    export({path: content for path, content in viewer.files.items() if "." in path}, folder / "bob")
    bob.save_scene(nested(), folder / "nested.bob")
    (folder / "machine.obj").write_text(OBJ)
    bob.save_scene(bob.load(folder / "machine.obj"), folder / "machine.bob")
    for name in ("csg.sdf", "gear.sdf"):
        shutil.copy(VIEWER / "gallery" / name, folder)
    open_box = bob.Mesh(CORNERS, SIDES[:-4])
    bob.save_scene(bob.Scene([bob.Instance(open_box, name="bin")]), folder / "open.bob")
    return folder


@pytest.fixture(params=["alone", "shared"])
def host(request):
    """Return a server's name: on one of them, workers may share memory."""
    return request.param


@pytest.fixture(scope="module")
def hosts(folder):
    """Serve the folder without and with the headers that let workers share memory."""
    with (
        serving(folder, Cache_Control="no-store") as alone,
        serving(folder, Cache_Control="no-store", **SHARING) as shared,
    ):
        yield {"alone": alone, "shared": shared}


@pytest.fixture
def shown(new_page, folder, hosts):
    """Open a page with an element of these attributes."""

    def shown(attributes, host="alone"):
        tab = new_page(TOLD, viewport={"width": 640, "height": 480})
        attributes = attributes if "samples" in attributes else f'{attributes} samples="1"'
        (folder / "index.html").write_text(PAGE.format(attributes=attributes, width=WIDTH, height=HEIGHT))
        tab.goto(hosts[host])
        tab.wait_for_function("() => told.some(({ type }) => type === 'load')")
        return tab

    return shown


def settled(page):
    """Return the exact picture, (H, W, 3) uint8."""
    address = page.evaluate(f"async () => {{ await {VIEW}.converged(); return {VIEW}.toDataURL(); }}")
    return np.asarray(picture_at(address).convert("RGB"))


def assert_shows(page, scene, camera=None, **held):
    seen = bob.trace(scene, camera or bob.Camera(), size=(HEIGHT, WIDTH), **held)
    wanted = color_to_8_bit(seen.color if "color" in seen.channels else seen.gray).reshape(HEIGHT, WIDTH, -1)
    assert wanted.any()
    difference = np.abs(settled(page).astype(int) - wanted).max(axis=-1)
    assert (difference > 1).mean() < 0.003, f"{(difference > 1).sum()} pixels differ"


# ---- Sections --------------------------------------------------------------------------------------------

RIGHT = ["x=0", " Z > -1.5e1 ", "y<=.5", "z<20", "x>=+3."]
WRONG = ["x=", "x=nan", "x=1_0", "w=1", "x==1", "x=0x10", "x=1 2", "=1", "x=1e999"]


def test_sections_have_one_grammar(tmp_path):
    """The page and Python take the same texts, and mean the same planes."""
    text = (VIEWER / "tracing/section.js").read_text("utf-8")
    (pattern,) = re.findall(r"^const PATTERN = /\^(.*)\$/i;$", text, re.MULTILINE)
    assert pattern == PATTERN.pattern
    script = f"""
      import {{ planesOf, sectionsOf }} from "{VIEWER}/tracing/section.js";
      const found = (text) => {{
        try {{ return planesOf(sectionsOf(text)); }} catch ({{ message }}) {{ return message; }}
      }};
      console.log(JSON.stringify({RIGHT + WRONG}.map(found)));
    """
    (tmp_path / "run.mjs").write_text(script)
    run = subprocess.run(["node", tmp_path / "run.mjs"], capture_output=True, text=True, timeout=60, check=True)
    found = json.loads(run.stdout)
    planes = [bob.Section(text) for text in RIGHT]
    assert found[: len(RIGHT)] == [[*plane.normal, plane.offset] for plane in planes]
    for text, message in zip(WRONG, found[len(RIGHT) :], strict=True):
        with pytest.raises(bob.InputError) as told:
            bob.Section(text)
        assert message == str(told.value)


@pytest.mark.parametrize("section", ["x=10", "x=10, z<0.4", "y>0.2"])
def test_sections_are_those_of_python(shown, host, section):
    page = shown(f'src="nested.bob" section="{section}"', host)
    assert_shows(page, nested(), section=section.split(","))


def test_formulas_are_cut(shown):
    page = shown('src="csg.sdf" section="x=0.1"')
    assert_shows(page, bob.load(VIEWER / "gallery/csg.sdf"), section="x=0.1")


def test_sections_come_move_and_go(shown, host):
    page = shown('src="nested.bob"', host)
    assert_shows(page, nested())
    for x in (9.5, 10.5, 10):
        page.evaluate(f"(x) => {{ {VIEW}.section = `x=${{x}}`; }}", x)
    assert_shows(page, nested(), section="x=10")
    page.evaluate(f"() => {{ {VIEW}.camera = {{ azimuth: 70 }}; }}")
    assert_shows(page, nested(), bob.Camera(azimuth=70), section="x=10")
    page.evaluate(f"() => {{ {VIEW}.section = null; {VIEW}.camera = {{ azimuth: 30 }}; }}")
    assert_shows(page, nested())


def test_keys_cut_through_the_middle(shown):
    page = shown('src="nested.bob"')
    page.locator("bob-view").focus()
    page.keyboard.press("x")
    page.wait_for_function(f"() => {VIEW}.section")
    assert page.evaluate(f"() => {VIEW}.section") == "x<10"
    assert_shows(page, nested(), section="x=10")
    page.keyboard.press("z")
    page.wait_for_function(f"() => /z/.test({VIEW}.section)")
    page.keyboard.press("x")
    page.wait_for_function(f"() => !/x/.test({VIEW}.section)")
    assert re.fullmatch(r"z<-?[\d.]+", page.evaluate(f"() => {VIEW}.section"))


def test_wrong_sections_are_told_and_change_nothing(shown):
    page = shown('src="nested.bob" section="x=10"')
    page.evaluate(f"() => {{ {VIEW}.section = 'x=1, y'; }}")
    (told,) = page.evaluate("() => told.filter(({ type }) => type === 'error')")
    assert told["detail"]["message"].startswith("section: expected an axis, a relation and a number, such as 'x=0'")
    assert_shows(page, nested(), section="x=10")


def test_moved_sections_have_pictures(shown):
    """While a plane is dragged, the picture moves along."""
    page = shown('src="gear.sdf"')
    pictures = page.evaluate(f"""async () => {{
      const view = {VIEW};
      await view.converged();
      let pictures = 0;
      view.addEventListener("progress", () => ++pictures);
      for (let i = 0; i < 40; ++i) {{
        view.section = `x=${{i / 100 - 0.2}}`;
        await new Promise(requestAnimationFrame);
      }}
      return pictures;
    }}""")
    assert pictures >= 4  # even on busy machines


# ---- Parts -----------------------------------------------------------------------------------------------

TREE = f"""async () => {{
  const list = (part) => [[part.path, part.number], ...part.children.flatMap(list)];
  return list(await {VIEW}.parts()).slice(1);
}}"""


def assembly(file):
    """Write a glTF of nodes below nodes; two share a mesh and a name."""
    scene = trimesh.Scene()
    cube, ball = trimesh.creation.box((2, 2, 2)), trimesh.creation.icosphere(2)
    for name, mesh, parent, x in [
        ("frame", cube, None, 0),
        ("pin", ball, "frame", 3),
        ("lid", cube, "frame", 6),
        ("pin 2", ball, None, 9),
    ]:
        at = np.eye(4)
        at[0, 3] = x
        scene.add_geometry(mesh, node_name=name, geom_name=name, parent_node_name=parent, transform=at)
    file.write_bytes(scene.export(file_type="glb"))


@pytest.fixture(scope="module")
def gltf(folder):
    assembly(folder / "assembly.glb")
    return folder / "assembly.glb"


@pytest.mark.parametrize("name", ["machine.obj", "machine.bob", "assembly.glb", "nested.bob"])
def test_the_tree_is_that_of_python(shown, folder, gltf, name):
    scene = bob.load(folder / name)
    page = shown(f'src="{name}"')
    assert page.evaluate(TREE) == [[str(part), part.number] for part in scene.parts.walk()]
    assert page.evaluate(f"async () => (await {VIEW}.about()).unit") == scene.unit


def without(scene, *parts):
    """Return the scene without some parts, in the sphere of the whole: with points at the ends of its box."""
    low, high = scene.extent
    dust = [bob.Instance(box(1e-7)).translate(corner) for corner in (low, high)]
    return bob.Scene([*scene.hide(*parts).instances, *dust])


def test_parts_of_a_mesh_are_hidden_and_come_back(shown, host, folder):
    scene = bob.load(folder / "machine.obj")
    page = shown('src="machine.obj"', host)
    page.evaluate(f"() => {VIEW}.hide('bolt')")
    assert_shows(page, without(scene, "bolt"))
    page.evaluate(f"() => {VIEW}.isolate('lid')")
    assert_shows(page, without(scene, "unnamed", "housing"))
    page.evaluate(f"() => {VIEW}.unhide('housing')")
    assert_shows(page, without(scene, "unnamed"))
    page.evaluate(f"async () => {{ await {VIEW}.isolate(); await {VIEW}.highlight('lid'); }}")
    assert_shows(page, scene.highlight("lid"))
    page.evaluate(f"() => {VIEW}.highlight()")
    assert_shows(page, scene)
    told = page.evaluate(f"() => {VIEW}.hide('bolts').catch(({{ message }}) => message)")
    assert told == "part: expected one of the 4 parts, such as unnamed, housing, housing/bolt, lid, got 'bolts'"


def test_hidden_parts_stay_hidden_where_an_element_moves(shown, host, folder):
    """In the document; another scene, or another side up, has other parts."""
    scene = bob.load(folder / "machine.obj")
    page = shown('src="machine.obj"', host)
    move = f"""async (change) => {{
      const view = {VIEW}, place = document.body.appendChild(document.createElement("div"));
      view.remove();
      Object.assign(view, change);
      place.append(view);
      await view.converged();
      return (await view.parts()).children.filter(({{ isHidden }}) => isHidden).map(({{ name }}) => name);
    }}"""
    page.evaluate(f"() => {VIEW}.hide('lid')")
    for change in ({}, {"snap": "5"}):
        assert page.evaluate(move, change) == ["lid"]
        assert_shows(page, without(scene, "lid"))
    page.evaluate(f"() => {VIEW}.unhide('lid')")
    assert_shows(page, scene)
    page.evaluate(f"() => {VIEW}.hide('lid')")
    assert page.evaluate(move, {"up": "y"}) == []
    assert_shows(page, scene.turned_upright(), bob.Camera(azimuth=300))  # its front


def test_other_shapes_are_hidden_and_highlighted(shown):
    page = shown('src="nested.bob" section="x=10"')
    page.evaluate(f"() => {VIEW}.hide('ball')")
    assert_shows(page, nested().hide("ball"), section="x=10")
    page.evaluate(f"() => {{ {VIEW}.section = null; }}")
    page.evaluate(f"async () => {{ await {VIEW}.isolate(); await {VIEW}.highlight('tube'); }}")
    assert_shows(page, nested().highlight("tube"))
    page.evaluate(f"() => {VIEW}.isolate('tube')")
    page.evaluate(
        f"""async () => {{
          {VIEW}.src = "csg.sdf";
          await new Promise((done) => {VIEW}.addEventListener("load", done));
        }}"""
    )
    assert_shows(page, bob.load(VIEWER / "gallery/csg.sdf"))


@pytest.mark.parametrize("name", ["machine.obj", "nested.bob"])
def test_picks_are_those_of_python(shown, folder, name):
    scene = bob.load(folder / name)
    page = shown(f'src="{name}" section="z<0.3"')
    settled(page)
    for x, y in [(50, 70), (90, 60), (110, 55), (80, 62), (3, 3)]:
        found = page.evaluate(f"([x, y]) => {VIEW}.pick(x + 0.5, y + 0.5)", [x, y])
        wanted = bob.pick(scene.sectioned("z<0.3"), y, x, size=(HEIGHT, WIDTH))
        assert (found is None) == (wanted is None)
        if wanted is None:
            continue
        assert found["part"] == str(wanted.part)
        assert (found["instance"], found["face"], found["section"]) == (wanted.instance, wanted.face, wanted.section)
        assert found["point"] == pytest.approx(wanted.point, abs=3e-6 * scene.radius)
        assert found["normal"] == pytest.approx(wanted.normal, abs=1e-4)
        assert found["unit"] == scene.unit


def test_measures_are_those_of_python(shown, folder, gltf):
    for name in ("machine.obj", "assembly.glb", "nested.bob"):
        scene = bob.load(folder / name)
        page = shown(f'src="{name}"')
        for part in [None, *scene.parts.walk()]:
            found = page.evaluate(f"(part) => {VIEW}.measure(part ?? undefined)", None if part is None else str(part))
            wanted = bob.measure(scene if part is None else part)
            assert found["size"] == pytest.approx(wanted.size, rel=3e-5)
            assert (found["part"], found["unit"]) == (wanted.name, scene.unit)
            if name != "nested.bob":
                assert found["area"] == pytest.approx(wanted.area, rel=1e-9)
                volume = wanted.volume
                assert found["volume"] == (None if volume is None else pytest.approx(volume, rel=1e-9))


def solids():
    """Return closed and open faces of NURBS, a stretched one, and a box of triangles, in millimetres."""
    can = cylinder(0.7, -0.6, 0.4)
    return bob.Scene(
        [
            bob.Instance(sphere(1.5), name="ball").scale(2).rotate(0.3, (1, 2, 3)).translate((5, 0, 0)),
            bob.Instance(can, name="can").translate((0, 3, 0)),
            bob.Instance(bob.Brep(can.faces[:1]), name="pipe"),
            bob.Instance(torus(0.7, 0.25), name="ring").translate((-4, 1, 0)),
            bob.Instance(sphere(1), name="egg").scale((1, 1, 2)).translate((0, 6, 0)),
            bob.Instance(box((1, 2, 1)), name="box").translate((0, -6, 0)),
        ],
        unit="mm",
    )


def test_areas_and_volumes_of_nurbs_are_those_of_python(shown, folder):
    scene = solids()
    bob.save_scene(scene, folder / "solids.bob")
    page = shown('src="solids.bob"')
    for part in ["ball", "can", "pipe", "ring", "box"]:
        found = page.evaluate(f"(part) => {VIEW}.measure(part)", part)
        wanted = bob.measure(scene.part(part))
        assert found["area"] == pytest.approx(wanted.area, rel=1e-8)
        assert (found["volume"] is None) == (wanted.volume is None)
        assert found["volume"] == (None if wanted.volume is None else pytest.approx(wanted.volume, rel=1e-8))
    assert page.evaluate(f"() => {VIEW}.measure('ball')")["volume"] == pytest.approx(36 * np.pi, rel=1e-8)
    egg = page.evaluate(f"() => {VIEW}.measure('egg')")
    assert (egg["area"], egg["volume"]) == (None, None)


# ---- Edges -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["machine.obj", "nested.bob", "csg.sdf"])
def test_edges_are_those_of_python(shown, host, folder, name):
    """Over the exact picture; meshes fetch the module with all shapes."""
    page = shown(f'src="{name}" samples="4"', host)
    scene = bob.load(folder / name)
    for edges in (False, True, False):
        wanted = bob.render(scene, size=(HEIGHT, WIDTH), edges=edges, background="#000").rgba[..., :3]
        found = settled(page)
        difference = np.abs(found.astype(int) - wanted).max(axis=-1)
        assert (difference > 8).mean() < 0.003
        page.locator("bob-view").focus()
        page.keyboard.press("e")


MOVING = f"""async (azimuths) => {{
  const view = {VIEW}, {{ schedule }} = view.viewing;
  await view.converged();
  schedule.refines = false;
  for (const azimuth of azimuths) {{
    view.camera = {{ azimuth }};
    await new Promise((shown) => view.addEventListener("progress", shown, {{ once: true }}));
  }}
  const moving = view.toDataURL();
  schedule.refines = true;
  return moving;
}}"""


def assert_lined(address, lined, plain):
    """Nearly all lines of an exact picture are in this one, and few others. Both exact pictures are (H, W, 3)."""
    found, lined, plain = (
        np.asarray(picture).max(axis=-1).astype(int) for picture in (picture_at(address).convert("RGB"), lined, plain)
    )
    lines, dark = (plain - lined > 60) & (plain > 90), (plain - found > 40) & (plain > 90)
    assert lines.sum() > 200
    assert dark[lines].mean() > 0.7
    near = np.lib.stride_tricks.sliding_window_view(np.pad(lines, 3), (7, 7)).any(axis=(2, 3))
    assert near[dark].mean() > 0.7


@pytest.mark.parametrize("name", ["nested.bob", "machine.obj"])
def test_edges_stay_in_motion(shown, host, name, folder):
    """Drawn from fewer first hits."""
    page = shown(f'src="{name}" edges picture-size="320x240"', host)
    page.evaluate(f"() => {{ {VIEW}.viewing.schedule.budget = 200; }}")
    address = page.evaluate(MOVING, [33, 36, 39, 42])
    scene, camera = bob.load(folder / name), bob.Camera(azimuth=42)
    lined, plain = (
        bob.render(scene, camera, size=(240, 320), edges=edges, background="#000").rgba[..., :3]
        for edges in (True, False)
    )
    assert_lined(address, lined, plain)


COMING_TO_REST = f"""async (azimuth) => {{
  const view = {VIEW}, pictures = [];
  await view.converged();
  const keep = ({{ detail: {{ batch }} }}) => pictures.push([batch.phase, view.toDataURL()]);
  view.addEventListener("progress", keep);
  view.camera = {{ azimuth }};
  await view.converged();
  view.removeEventListener("progress", keep);
  return pictures;
}}"""


def test_edges_stay_while_all_pixels_are_traced(shown, host, folder):
    """In each picture from the moving one to the exact one."""
    page = shown('src="machine.obj" edges samples="4" picture-size="960x720"', host)
    pictures = page.evaluate(COMING_TO_REST, 42)
    assert {"rows", "edges"} <= {phase for phase, _ in pictures}
    scene, camera = bob.load(folder / "machine.obj"), bob.Camera(azimuth=42)
    lined, plain = (
        bob.render(scene, camera, size=(720, 960), edges=edges, background="#000").rgba[..., :3]
        for edges in (True, False)
    )
    for _, address in pictures:
        assert_lined(address, lined, plain)


@pytest.mark.parametrize("name", ["nested.bob", "machine.obj"])
def test_edges_under_lights_are_those_of_python(shown, host, folder, name):
    """A pixel without its line is over 40 levels apart; some light paths part where arithmetic rounds otherwise."""
    page = shown(f'src="{name}" edges light="studio" samples="4"', host)
    scene = bob.load(folder / name)
    wanted = bob.render(scene, size=(HEIGHT, WIDTH), light="studio", edges=True, background="#000").rgba[..., :3]
    difference = np.abs(settled(page).astype(int) - wanted).max(axis=-1)
    assert (difference > 8).mean() < 0.015
    assert (difference > 40).mean() < 0.0005


def test_edges_stay_under_lights(shown, host):
    """In each picture from the moving one to the exact one, of the same pixels."""
    page = shown('src="machine.obj" light="studio" picture-size="240x180"', host)
    page.evaluate(f"() => {{ {VIEW}.viewing.schedule.budget = 400; {VIEW}.camera = {{ azimuth: 42 }}; }}")
    plain = settled(page)
    page.evaluate(f"() => {{ {VIEW}.edges = true; }}")
    lined = settled(page)
    page.evaluate(f"() => {{ {VIEW}.camera = {{ azimuth: 38 }}; }}")
    pictures = page.evaluate(COMING_TO_REST, 42)
    assert len(pictures) > 1
    for _, address in pictures:
        assert_lined(address, lined, plain)


def test_edges_of_meshes_need_the_larger_module_of_meshes(shown):
    page = shown('src="machine.obj"')
    settled(page)
    fetched = "() => performance.getEntriesByType('resource').map(({ name }) => name.split('/').at(-1))"
    before = page.evaluate(fetched)
    assert not any("light" in name for name in before)
    page.evaluate(f"() => {{ {VIEW}.edges = true; }}")
    settled(page)
    after = page.evaluate(fetched)[len(before) :]
    assert [name for name in after if name.endswith("wasm")] == ["core.mesh.light.relaxed.wasm"]


def test_single_files_of_meshes_have_edges_and_snap(new_page, folder, tmp_path):
    scene = bob.load(folder / "machine.obj")
    export_file(scene, "machine", tmp_path / "machine.html")
    page = new_page(fresh=True, viewport={"width": WIDTH, "height": HEIGHT})
    page.goto((tmp_path / "machine.html").as_uri())
    page.evaluate(f"() => {{ {VIEW}.setAttribute('samples', '4'); {VIEW}.setAttribute('edges', ''); }}")
    wanted = bob.render(scene, size=(HEIGHT, WIDTH), edges=True, background="#000").rgba[..., :3]
    assert (np.abs(settled(page).astype(int) - wanted).max(axis=-1) > 8).mean() < 0.003
    row, column = pixel_of(scene, (6.8, 0.8, 0.8))
    found = page.evaluate(f"([x, y]) => {VIEW}.pick(x, y, {{ snap: true }})", [column + 2, row - 1])
    assert found["snapped"] == "corner"
    assert found["point"] == pytest.approx((6.8, 0.8, 0.8), abs=1e-6)


# ---- Snapping --------------------------------------------------------------------------------------------


def pixel_of(scene, point, camera=bob.Camera()):  # noqa: B008
    """Return the pixel of a point of the scene."""
    at = ((np.array([point], float) - scene.center) / scene.radius).astype(np.float32)
    row, column, _ = camera.core(scene.center, scene.radius).seen(HEIGHT, WIDTH, at)[0]
    return round(float(row)), round(float(column))


SNAPPED = f"([x, y, snap]) => {VIEW}.pick(x, y, {{ snap }})"


@pytest.mark.parametrize("name", ["machine.obj", "nested.bob"])
def test_picks_snap_as_those_of_python(shown, host, folder, name):
    scene = bob.load(folder / name)
    page = shown(f'src="{name}" snap="4" section="z<0.7"', host)
    settled(page)
    kinds = set()
    for row in range(20, 105, 7):
        for column in range(20, 140, 9):
            found = page.evaluate(SNAPPED, [column + 0.5, row + 0.5, True])
            wanted = bob.pick(scene.sectioned("z<0.7"), row, column, size=(HEIGHT, WIDTH), snap=4)
            assert (found is None) == (wanted is None)
            if wanted is None:
                continue
            assert (found["snapped"], found["part"]) == (wanted.snapped, str(wanted.part))
            assert found["point"] == pytest.approx(wanted.point, abs=3e-6 * scene.radius)
            kinds.add(found["snapped"])
    assert {None, "corner", "edge"} <= kinds
    row, column = pixel_of(scene, scene.extent.high)
    assert page.evaluate(SNAPPED, [column, row, False])["snapped"] is None


def test_the_mark_says_what_a_click_snaps_to(shown):
    page = shown('src="nested.bob" snap')
    settled(page)
    mark = page.locator("bob-view #snap")
    scene = nested()
    row, column = pixel_of(scene, (12, 1.5, 1))
    page.mouse.move(column - 20, row - 20)
    page.mouse.move(column + 2, row + 2)
    page.wait_for_function(
        """([x, y]) => {
          const mark = document.querySelector("bob-view").shadowRoot.querySelector("#snap:not([hidden])");
          const place = mark?.querySelector("svg").getBoundingClientRect();
          return place && Math.hypot(place.x + place.width / 2 - x, place.y + place.height / 2 - y) < 1;
        }""",
        arg=[column + 0.5, row + 0.5],
    )
    assert mark.locator("p").inner_text() == "corner"
    page.mouse.down()
    page.mouse.up()
    page.wait_for_function("() => told.some(({ type }) => type === 'pick')")
    (picked,) = page.evaluate("() => told.filter(({ type }) => type === 'pick')")
    assert picked["detail"]["snapped"] == "corner"
    assert picked["detail"]["point"] == pytest.approx((12, 1.5, 1), abs=1e-6)
    page.mouse.move(3, 3)
    page.wait_for_function(f"() => {VIEW}.shadowRoot.querySelector('#snap').hidden")


def test_meshes_fetch_what_snaps_with_the_first_click(shown):
    page = shown('src="machine.obj" snap')
    settled(page)
    page.mouse.move(80, 60)
    fetched = "() => performance.getEntriesByType('resource').map(({ name }) => name.split('/').at(-1))"
    assert not any("light" in name or "marker" in name for name in page.evaluate(fetched))
    row, column = pixel_of(bob.Scene(box((1, 1, 1))), (0, 0, 0))
    page.mouse.click(column, row)
    page.wait_for_function("() => told.some(({ type, detail }) => type === 'pick' && detail)")
    assert any("core.mesh.light" in name for name in page.evaluate(fetched))
    settled(page)


# ---- The page --------------------------------------------------------------------------------------------


@pytest.fixture
def tab(new_page, viewer, folder):
    """Open the viewer's page with a scene of the folder."""

    def tab(name):
        viewer.files[f"files/{name}"] = (folder / name).read_bytes()
        page = new_page(viewport={"width": 1280, "height": 800})
        page.goto(f"{viewer.url}?size={WIDTH}x{HEIGHT}&samples=1&scene=files/{name}")
        page.evaluate("() => bobrossnet.started")
        return page

    return tab


def page_shows(tab, scene, **held):
    tab.evaluate("() => bobrossnet.converged()")
    seen = bob.trace(scene, size=(HEIGHT, WIDTH), **held)
    wanted = color_to_8_bit(seen.color if "color" in seen.channels else seen.gray).reshape(HEIGHT, WIDTH, -1)
    found = np.asarray(picture_at(tab.evaluate("() => document.querySelector('#picture').toDataURL()")).convert("RGB"))
    return (np.abs(found.astype(int) - wanted).max(axis=-1) > 1).mean() < 0.003


def test_the_page_drags_planes(tab):
    page = tab("nested.bob")
    page.click("#section summary")
    page.check("#axes input >> nth=0")
    page.wait_for_function("() => document.querySelector('#axes output').value === '10 mm'")
    assert page_shows(page, nested(), section="x=10")
    slider = page.get_by_label("Section along X")
    slider.focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    value = float(page.locator("#axes output >> nth=0").text_content().removesuffix(" mm"))
    assert value > 10
    assert page_shows(page, nested(), section=f"x={value}")
    page.get_by_label("Keep the other side of X").click()
    assert page_shows(page, nested(), section=f"x>{value}")
    left, top, width, height = page.get_by_role("slider", name="Section plane X").bounding_box().values()
    page.mouse.move(left + width / 2, top + height / 2)
    page.mouse.down()
    page.mouse.move(left + width / 2 - 60, top + height / 2 + 40)
    page.mouse.up()
    dragged = float(page.locator("#axes output >> nth=0").text_content().removesuffix(" mm"))
    assert dragged > value
    assert slider.get_attribute("aria-valuetext") == f"{dragged:g} mm"
    assert page_shows(page, nested(), section=f"x>{dragged}")
    page.uncheck("#axes input >> nth=0")
    assert page_shows(page, nested())


def test_the_page_names_open_shapes(tab):
    page = tab("open.bob")
    page.click("#section summary")
    page.check("#axes input >> nth=0")
    page.wait_for_function("() => /^bin is open/.test(document.querySelector('#open-shape').textContent)")


def test_the_page_lists_parts_and_measures(tab, folder):
    scene = bob.load(folder / "machine.obj")
    page = tab("machine.bob")
    page.click("#parts > summary")
    page.get_by_label("Show bolt", exact=True).uncheck()
    assert page_shows(page, without(scene, "bolt"))
    assert page.get_by_label("Show housing", exact=True).evaluate("(box) => box.indeterminate")
    page.get_by_label("Show only lid").click()
    assert page_shows(page, without(scene, "unnamed", "housing"))
    page.click("#show-all")
    assert page_shows(page, scene)
    page.get_by_role("button", name="lid", exact=True).click()
    assert page_shows(page, scene.highlight("lid"))
    page.wait_for_function("() => /Volume4.096/.test(document.querySelector('#picked').textContent)")
    page.get_by_role("button", name="lid", exact=True).click()
    assert page_shows(page, scene)
    left, top, width, height = page.locator("#picture").bounding_box().values()
    page.mouse.click(left + width / 2, top + height / 2)
    page.wait_for_function("() => /Partbolt|Parthousing/.test(document.querySelector('#picked').textContent)")
    assert page.locator(".name[aria-pressed=true]").count() == 1
    page.mouse.click(left + width / 2 + 9, top + height / 2)
    page.wait_for_function("() => /Distance/.test(document.querySelector('#picked').textContent)")


def test_the_page_measures_from_corner_to_corner(tab):
    scene = nested()
    page = tab("nested.bob")
    page.evaluate("() => bobrossnet.converged()")
    left, top, width, _ = page.locator("#picture canvas").bounding_box().values()
    for corner in [(12, 1.5, 1), (8, 1.5, 1)]:
        row, column = pixel_of(scene, corner)
        page.mouse.click(left + (column + 1) * width / WIDTH, top + (row + 1) * width / WIDTH)
    text = "document.querySelector('#picked').textContent"
    page.wait_for_function(f"() => /Distance4 mm, corner to corner/.test({text})")
    assert "corner to corner" in page.locator("#status").text_content()
    page.uncheck("#snap")
    assert page.evaluate("() => document.querySelector('#picture').snap") is None


def test_the_page_shows_no_rounding(tab, folder):
    """Of a corner at 0, in single precision."""
    scene = bob.Scene([bob.Instance(box((2, 1.5, 1)), name="box").translate((2, 1.5, 1))])
    bob.save_scene(scene, folder / "corner.bob")
    page = tab("corner.bob")
    page.focus("#picture")
    page.keyboard.press("1")
    page.evaluate("() => bobrossnet.converged()")
    left, top, width, _ = page.locator("#picture canvas").bounding_box().values()
    row, column = pixel_of(scene, (0, 0, 2), bob.Camera(azimuth=-90, elevation=0))
    page.mouse.click(left + (column + 1) * width / WIDTH, top + (row + 1) * width / WIDTH)
    page.wait_for_function(
        "() => /Point0, 0, 2Normal0.000, -1.000, 0.000/.test(document.querySelector('#picked').textContent)"
    )
