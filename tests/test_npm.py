"""The npm package: packed, installed in an empty folder, and run from there, as it is and by bundlers."""

import gzip
import json
import os
import re
import shutil
import subprocess
from contextlib import contextmanager

import numpy as np
import pytest
from browser import missing, numbers, serving

import bobrossnet as bob
from bobrossnet.page.package import README, write_package, write_types
from bobrossnet.picture.files import to_8_bit
from bobrossnet.support.paths import VIEWER

MOST_BYTES = 396_000
"""Maximum compressed bytes that a browser fetches before a mesh is exact."""

HEIGHT, WIDTH = 96, 128

PAGE = """<!doctype html>
<script type="module" src="node_modules/bob-view/component/bob-view.js"></script>
<bob-view src="{file}" picture-size="128x96" camera-controls></bob-view>
"""

DENSE = """
customElements.whenDefined("bob-view").then(() => {
  document.querySelector("bob-view").viewing.schedule.budget = 5000;
});
"""
"""Dense pictures need no network; without this, a busy machine's are not dense."""

EXACT = """async () => {
  const view = document.querySelector("bob-view");
  await new Promise((shown, failed) => {
    view.addEventListener("error", ({ detail }) => failed(new Error(detail.message)));
    const wrong = view.shadowRoot.querySelector("#wrong");
    if (!wrong.hidden) failed(new Error(wrong.textContent));
    if (view.viewing.statistics.pictures) shown();
    else view.addEventListener("load", shown);
  });
  for (let azimuth = 31; azimuth < 60; ++azimuth) {
    const next = new Promise((shown) => view.addEventListener("progress", shown, { once: true }));
    view.camera = { azimuth };
    await next;
  }
  view.camera = { azimuth: 30 };
  await view.converged();
  return new Uint8Array((await view.viewing.buffers()).image.buffer).toBase64();
}"""

TOOLS = {
    "@types/react": "19.3.3",
    "@vitejs/plugin-vue": "6.0.11",
    "esbuild": "0.28.2",
    "react": "19.3.1",
    "react-dom": "19.3.1",
    "typescript": "7.0.2",
    "vite": "8.3.8",
    "vue": "3.5.45",
    "webpack": "5.113.0",
    "webpack-cli": "7.3.1",
}


def npm(*arguments, cwd):
    done = subprocess.run(["npm", *arguments], cwd=cwd, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """Return the packed package."""
    if not shutil.which("npm"):
        missing("npm, which installs packages, is not installed")
    folder = tmp_path_factory.mktemp("package")
    write_package(folder)
    (name,) = npm("pack", "--silent", cwd=folder)
    assert name == f"bob-view-{bob.__version__}.tgz"
    return folder / name


@pytest.fixture(scope="module")
def folder(packed, tmp_path_factory):
    """Return an empty folder with the package installed."""
    empty = tmp_path_factory.mktemp("empty")
    npm("install", "--offline", "--no-audit", "--no-fund", str(packed), cwd=empty)
    mesh = bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1 + 0.2 * x * z).mesh(0.05)
    for name in ("part.glb", "part.stl", "part.ply"):
        mesh.save(empty / name)
    return empty


def assert_exact(page, file):
    page.wait_for_function("() => customElements.get('bob-view')")
    image = numbers(page.evaluate(EXACT)).reshape(HEIGHT, WIDTH)
    wanted = bob.trace(bob.load(file), bob.Camera(), size=(HEIGHT, WIDTH)).gray
    assert (np.abs(to_8_bit(image).astype(int) - to_8_bit(wanted)) > 1).mean() < 0.002


@pytest.mark.parametrize("name", ["part.ply", "part.stl", "part.glb"])
def test_a_mesh_is_shown_and_the_package_is_small(browser, folder, name):
    (folder / "index.html").write_text(PAGE.format(file=name))
    with serving(folder) as address:
        page = browser.new_context().new_page()
        page.add_init_script(DENSE)
        asked = set()
        page.on("request", lambda request: asked.add(request.url))
        page.goto(address)
        assert_exact(page, folder / name)
        page.context.close()
    paths = {url.removeprefix(address) for url in asked if url.startswith(f"{address}node_modules")}
    sizes = {path: len(gzip.compress((folder / path).read_bytes())) for path in paths}
    assert sum(sizes.values()) <= MOST_BYTES, sizes
    assert not any("core.relaxed" in path or "core.wasm" in path for path in sizes)


# ---- Files for registries and editors --------------------------------------------------------------------


def test_the_description_names_what_is_there(tmp_path, monkeypatch):
    monkeypatch.setenv("GITHUB_REPOSITORY", "owner/name")
    write_package(tmp_path)
    described = json.loads((tmp_path / "package.json").read_bytes())
    assert described["repository"]["url"] == "git+https://github.com/owner/name.git"
    assert described["homepage"] == "https://owner.github.io/name/"
    assert "web-component" in described["keywords"]
    named = [described["types"], described["customElements"], described["exports"]["."]["default"]]
    assert all((tmp_path / name).is_file() for name in named)
    assert not re.search(r"\b[A-Z]{6,}S?\b", (tmp_path / "README.md").read_text().replace("NOTICES", ""))


def test_the_manifest_has_the_whole_element(folder):
    package = folder / "node_modules/bob-view"
    (module,) = json.loads((package / "custom-elements.json").read_bytes())["modules"]
    (element,) = module["declarations"]
    code = (VIEWER / "component/bob-view.js").read_text("utf-8")
    script = 'import("bob-view").then(({ BobView }) => console.log(BobView.observedAttributes.join()));'
    observed = subprocess.run(["node", "--eval", script], cwd=folder, capture_output=True, text=True, timeout=60).stdout
    read = re.findall(r'(?:get|has)Attribute\("([\w-]+)"\)', code)
    assert {attribute["name"] for attribute in element["attributes"]} == {*observed.strip().split(","), *read}
    told = set(re.findall(r'new CustomEvent\("([\w-]+)"', code))
    assert {event["name"] for event in element["events"]} == told
    members = {member["name"]: member for member in element["members"]}
    assert members["converged"] == {
        "kind": "method",
        "name": "converged",
        "description": "Resolves once the picture is exact, and its edges are smoothed; so not before it is seen.",
        "parameters": [],
        "return": {"type": {"text": "Promise<void>"}},
    }
    assert members["cameraOrbit"]["type"] == {"text": "string | null"}
    assert members["viewCube"]["type"] == {"text": "boolean"}
    assert {member["attribute"] for member in members.values() if "attribute" in member} >= {*read} - {"src", "alt"}
    assert {"src", "camera", "toBlob", "open", "base"} <= set(members)
    assert all(member["description"] for member in members.values())


# ---- Servers that render pages, several copies, other folders --------------------------------------------


def test_servers_that_render_pages_may_import_it(folder):
    script = 'import("bob-view").then(({ BobView }) => console.log(typeof BobView));'
    done = subprocess.run(["node", "--eval", script], cwd=folder, capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("function\n", "")


def test_two_copies_of_the_package_share_the_element(new_page, folder):
    shutil.copytree(folder / "node_modules/bob-view", folder / "copy", dirs_exist_ok=True)
    page = PAGE.format(file="part.ply") + '<script type="module" src="copy/component/bob-view.js"></script>'
    (folder / "index.html").write_text(page)
    with serving(folder) as address:
        page = new_page(fresh=True)
        page.goto(address)
        assert_exact(page, folder / "part.ply")
        assert (
            page.evaluate("""async () => {
          const { BobView } = await import("./copy/component/bob-view.js");
          return new BobView().localName;
        }""")
            == "bob-view"
        )


@pytest.mark.parametrize("version", ["0.0.1", None])
def test_a_folder_of_another_version_is_told(browser, folder, version):
    other = folder / "other"
    shutil.copytree(folder / "node_modules/bob-view", other, dirs_exist_ok=True)
    (other / "package.json").write_text(json.dumps({"version": version}))
    if version is None:
        (other / "package.json").unlink()
    (folder / "index.html").write_text(PAGE.format(file="part.ply").replace("<bob-view ", '<bob-view base="other" '))
    with serving(folder) as address:
        page = browser.new_context().new_page()
        page.goto(address)
        page.wait_for_selector("#wrong:not([hidden])")
        assert page.text_content("#wrong") == (
            f"base: expected the files of bob-view {bob.__version__} in {address}other/, got version 0.0.1; "
            "copy node_modules/bob-view there"
            if version
            else f"base: expected a file at {address}other/package.json, got 404 File not found; "
            "set base to the folder with the files of bob-view"
        )
        page.context.close()


# ---- Bundlers --------------------------------------------------------------------------------------------

APP = """<!doctype html>
<script type="module" src="{script}"></script>
<bob-view {attributes}src="part.ply" picture-size="128x96" camera-controls view-cube></bob-view>
"""


@pytest.fixture(scope="module")
def tools(packed, tmp_path_factory):
    """Return a folder with the package, bundlers and frameworks installed."""
    folder = tmp_path_factory.mktemp("tools")
    (folder / "package.json").write_text('{ "private": true, "type": "module" }')
    named = [f"{name}@{version}" for name, version in TOOLS.items()]
    command = ["npm", "install", "--silent", "--no-audit", "--no-fund", "--prefer-offline", str(packed), *named]
    if subprocess.run(command, cwd=folder, capture_output=True, timeout=300).returncode != 0:
        missing("npm could not fetch the bundlers; is there a network?")
    return folder


@pytest.fixture
def app(tools, folder):
    """Return the folder of a page whose script imports the package."""
    for name in ("public", "dist"):
        shutil.rmtree(tools / name, ignore_errors=True)
    (tools / "vite.config.js").unlink(missing_ok=True)
    (tools / "public").mkdir()
    shutil.copy(folder / "part.ply", tools / "public")
    (tools / "main.js").write_text('import "bob-view";\n')
    return tools


def run(app, *command):
    done = subprocess.run(
        [f"node_modules/.bin/{command[0]}", *command[1:]], cwd=app, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def with_vite(app):
    (app / "index.html").write_text(APP.format(script="/main.js", attributes=""))
    run(app, "vite", "build", "--minify", "false")
    return serving(app / "dist")


@contextmanager
def with_vite_while_editing(app):
    (app / "index.html").write_text(APP.format(script="/main.js", attributes=""))
    command = ["node_modules/.bin/vite", "--host", "127.0.0.1", "--port", "0"]
    environment = {**os.environ, "NO_COLOR": "1"}
    process = subprocess.Popen(command, cwd=app, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        found = next(filter(None, (re.search(r"http://127\.0\.0\.1:\d+/", line) for line in process.stdout)))
        yield found[0]
    finally:
        process.terminate()
        process.communicate(timeout=30)


def with_webpack(app):
    run(app, "webpack", "--mode", "none", "--entry", "./main.js", "--output-path", "public", "--devtool", "false")
    (app / "public/index.html").write_text(APP.format(script="main.js", attributes=""))
    return serving(app / "public")


def with_esbuild(app):
    run(app, "esbuild", "main.js", "--bundle", "--format=esm", "--outfile=public/main.js")
    shutil.copytree(app / "node_modules/bob-view", app / "public/files")
    (app / "public/index.html").write_text(APP.format(script="main.js", attributes='base="files" '))
    return serving(app / "public")


@contextmanager
def with_a_cdn_that_bundles_again(app):
    run(app, "esbuild", "main.js", "--bundle", "--format=esm", "--outfile=public/main.js")
    with serving(app / "node_modules/bob-view", Access_Control_Allow_Origin="*") as elsewhere:
        (app / "public/index.html").write_text(APP.format(script="main.js", attributes=f'base="{elsewhere}" '))
        with serving(app / "public") as address:
            yield address


BUILDS = [with_vite, with_vite_while_editing, with_webpack, with_esbuild, with_a_cdn_that_bundles_again]


@pytest.mark.parametrize("build", BUILDS)
def test_bundlers_find_all_files(new_page, app, folder, build):
    with build(app) as address:
        page = new_page(fresh=True, viewport={"width": 200, "height": 150})
        wrong = []
        page.on("response", lambda response: response.ok or wrong.append(response.url))
        page.route("**/favicon.ico", lambda route: route.fulfill(status=204))
        page.goto(address)
        assert_exact(page, folder / "part.ply")
        sides = page.locator("bob-view").evaluate("(view) => view.shadowRoot.querySelectorAll('#cube button').length")
        assert sides == 6  # its module is fetched later
        if picture := os.environ.get("BUNDLED_PICTURE"):
            page.screenshot(path=f"{picture}/{build.__name__}.png")
        page.context.close()
    assert wrong == []


# ---- Frameworks and types --------------------------------------------------------------------------------


def snippet(language):
    (code,) = re.findall(rf"^```{language}\n(.*?)^```$", README.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    return code


def write_react(app):
    (app / "Part.jsx").write_text(snippet("jsx"))
    (app / "main.js").write_text("""
import { createElement } from "react";
import { createRoot } from "react-dom/client";
import { Part } from "./Part.jsx";
createRoot(document.body).render(createElement(Part, { onTurn: (camera) => (window.turned = camera) }));
""")


def write_vue(app):
    (app / "Part.vue").write_text(snippet("vue"))
    (app / "vite.config.js").write_text("""
import vue from "@vitejs/plugin-vue";
const compilerOptions = { isCustomElement: (name) => name === "bob-view" };
export default { plugins: [vue({ template: { compilerOptions } })] };
""")
    (app / "main.js").write_text("""
import { createApp, h } from "vue";
import Part from "./Part.vue";
createApp(() => h(Part, { onTurn: (camera) => (window.turned = camera) })).mount(document.body);
""")


@pytest.mark.parametrize("write", [write_react, write_vue])
def test_the_snippets_of_frameworks_run(new_page, app, folder, write):
    write(app)
    shutil.copy(folder / "part.glb", app / "public")
    (app / "index.html").write_text('<!doctype html><body><script type="module" src="/main.js"></script></body>')
    run(app, "vite", "build", "--minify", "false")
    with serving(app / "dist") as address:
        page = new_page(fresh=True, viewport={"width": 320, "height": 200})
        page.goto(address)
        page.wait_for_selector("bob-view[camera-controls]")
        assert page.evaluate("() => document.querySelector('bob-view').src") == "part.glb"
        page.evaluate("() => document.querySelector('bob-view').converged()")
        page.focus("bob-view")
        page.keyboard.press("ArrowRight")
        page.wait_for_function("() => window.turned?.azimuth === 305")  # 5 degrees from the front's
        page.evaluate("() => document.querySelector('bob-view').converged()")
        if picture := os.environ.get("BUNDLED_PICTURE"):
            page.screenshot(path=f"{picture}/{write.__name__}.png")
        page.context.close()


USER = """
import { BobView, type BobViewAttributes, type Camera } from "bob-view";
BobView.base = "files";
const view: BobView = document.querySelector("bob-view")!;
const camera: Camera = { ...view.camera, azimuth: 3 };
view.camera = { azimuth: camera.azimuth };
view.cameraOrbit = "10deg 70deg 100%";
new BobView().viewCube = true;
const arrived: Promise<void> = view.goTo("front");
const picture: Promise<Blob> = view.toBlob({ mimeType: "image/webp" });
const attributes: BobViewAttributes = { src: "part.glb", "camera-controls": true };
// @ts-expect-error
view.camera = { azimuth: "3" };
// @ts-expect-error
view.viewCube = "yes";
// @ts-expect-error
view.open("part.glb", "text");
// @ts-expect-error
const wrong: BobViewAttributes = { "camera-controls": 3 };
"""

REACT_USER = """
import type {} from "bob-view/react";
export const part = <bob-view src="part.glb" camera-controls className="wide" ref={(view) => void view?.converged()} />;
// @ts-expect-error
export const wrong = <bob-view src={3} />;
"""

VUE_USER = """
import type {} from "bob-view/vue";
import type { GlobalComponents } from "vue";
export const props: Partial<InstanceType<GlobalComponents["bob-view"]>["$props"]> = { src: "part.glb" };
"""


def test_types_are_those_of_the_comments(app):
    write_types(app / "node_modules/bob-view", app / "node_modules/.bin/tsc")
    for name, text in {"user.ts": USER, "react.tsx": REACT_USER, "vue.ts": VUE_USER}.items():
        (app / name).write_text(text)
    options = "--noEmit --strict --target esnext --module esnext --moduleResolution bundler --jsx react-jsx"
    run(app, "tsc", "user.ts", "react.tsx", "vue.ts", *options.split(), "--lib", "esnext,dom,dom.iterable")
