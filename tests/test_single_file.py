"""`bobrossnet view --export page.html`: one file that shows a scene wherever scripts may run, without requests."""

import numpy as np
import pytest
from browser import picture_at

import bobrossnet as bob
from bobrossnet.command_line import cli
from bobrossnet.page.export import export_file
from bobrossnet.picture.files import color_to_8_bit

MOST_BYTES = 1_500_000

EXACT = """async () => {
  const view = document.querySelector("bob-view");
  if (!view.viewing.statistics.pictures) await new Promise((shown) => view.addEventListener("load", shown));
  view.setAttribute("samples", "1"); // as traced
  await view.converged();
  return view.toDataURL();
}"""


@pytest.fixture(scope="module")
def scene():
    return bob.Scene(
        [
            bob.Instance(bob.happy_tree(), material=bob.Material("#4a8"), name="</script><b>&amp;"),
            bob.Instance(bob.polyline([(0, 0, 0), (3, 0, 2)], radius=0.2)),
        ]
    )


@pytest.fixture(scope="module")
def file(scene, tmp_path_factory):
    folder = tmp_path_factory.mktemp("single")
    bob.save_scene(scene, folder / "a tree & more.bob")
    assert cli.main(["view", str(folder / "a tree & more.bob"), "--export", str(folder / "page.html")]) == 0
    return folder / "page.html"


def exact(frame):
    """Return the exact picture, (H, W, 3)."""
    address = frame.evaluate(EXACT)
    return np.asarray(picture_at(address).convert("RGB"))


def assert_shows(found, scene):
    wanted = color_to_8_bit(bob.trace(scene, size=found.shape[:2]).color)
    assert (np.abs(found.astype(int) - wanted).max(axis=-1) > 1).mean() < 0.002
    assert np.ptp(wanted.astype(int), axis=-1).max() > 50


@pytest.fixture
def page(new_page):
    """Return a page checked for errors, and its requests."""
    page = new_page(fresh=True, viewport={"width": 320, "height": 240})
    page.wrong, page.asked = [], []
    page.on("console", lambda entry: entry.type == "error" and page.wrong.append(entry.text))
    page.on("request", lambda request: page.asked.append(request.url))
    yield page
    assert page.wrong == []


def test_it_opens_from_a_disk(page, file, scene):
    page.goto(file.as_uri())
    assert_shows(exact(page), scene)
    assert page.title() == "a tree & more"
    assert page.get_by_role("application", name="Picture of a tree & more").count() == 1
    page.focus("bob-view")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("() => document.querySelector('bob-view').camera.azimuth") == 25
    assert [url for url in page.asked if not url.startswith("blob:")] == [file.as_uri()]


def test_it_opens_in_a_frame_that_may_only_run_scripts(page, file, scene):
    page.set_content('<iframe sandbox="allow-scripts" width="200" height="100"></iframe>')
    page.evaluate("(text) => { document.querySelector('iframe').srcdoc = text; }", file.read_text())
    page.wait_for_function("() => true")
    frame = page.frames[-1]
    frame.wait_for_selector("bob-view")
    assert_shows(exact(frame), scene)
    assert frame.evaluate("() => origin") == "null"


def test_its_policy_lets_it_ask_for_nothing(browser, file):
    page = browser.new_page()
    page.goto(file.as_uri())
    refused = page.evaluate("""async () => {
      const refused = [];
      const keep = ({ effectiveDirective }) => refused.push(effectiveDirective);
      document.addEventListener("securitypolicyviolation", keep);
      await fetch("https://example.org").catch(() => {});
      document.body.append(Object.assign(new Image(), { src: "https://example.org/a.png" }));
      document.body.append(Object.assign(document.createElement("script"), { textContent: "window.run = true;" }));
      await new Promise((later) => setTimeout(later, 100));
      return [...refused, String(window.run)];
    }""")
    assert sorted(refused) == ["connect-src", "img-src", "script-src-elem", "undefined"]
    page.close()


def test_it_is_small(file, scene, tmp_path):
    bob.save_scene(scene, tmp_path / "scene.bob")
    assert file.stat().st_size <= MOST_BYTES + 4 / 3 * (tmp_path / "scene.bob").stat().st_size


def test_meshes_need_less(page, tmp_path):
    scene = bob.Scene(bob.Instance(bob.happy_tree(), material=bob.Material("#4a8")))
    export_file(scene, "tree", tmp_path / "page.html")
    page.goto((tmp_path / "page.html").as_uri())
    assert_shows(exact(page), scene)
    bob.save_scene(scene, tmp_path / "scene.bob")
    assert (tmp_path / "page.html").stat().st_size <= 850_000 + 4 / 3 * (tmp_path / "scene.bob").stat().st_size


def test_without_a_file_it_is_the_tree(tmp_path, capsys):
    assert cli.main(["view", "--export", str(tmp_path / "tree.HTML")]) == 0
    assert capsys.readouterr().out == f"wrote {tmp_path / 'tree.HTML'}: one file, which any browser can show\n"
    assert "<title>happy tree</title>" in (tmp_path / "tree.HTML").read_text()


def test_it_has_the_lens_and_the_background_that_were_asked_for(page, scene, tmp_path):
    bob.save_scene(scene, tmp_path / "a.bob")
    look = ["--fov", "50", "--background", "#336699"]
    assert cli.main(["view", str(tmp_path / "a.bob"), *look, "--export", str(tmp_path / "page.html")]) == 0
    page.goto((tmp_path / "page.html").as_uri())
    address = page.evaluate(EXACT)
    rgba = np.asarray(picture_at(address).convert("RGBA"))
    seen = bob.trace(scene, bob.Camera(fov=50), size=rgba.shape[:2])
    assert np.mean((rgba[..., 3] > 0) != (seen.alpha > 0)) < 0.002
    behind = page.evaluate("() => getComputedStyle(document.querySelector('bob-view')).backgroundImage")
    assert behind == "linear-gradient(rgb(51, 102, 153), rgb(51, 102, 153))"


def test_what_cannot_be_written_is_told(tmp_path, capsys, monkeypatch):
    assert cli.main(["view", "--export", str(tmp_path / "none" / "page.html")]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    monkeypatch.setattr("bobrossnet.page.files.VIEWER", tmp_path)
    with pytest.raises(bob.InputError, match=r"viewer: expected core\.wasm in the package, got none"):
        export_file(bob.happy_tree(), "tree", tmp_path / "page.html")
    assert list(tmp_path.iterdir()) == []
