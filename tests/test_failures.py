"""If no picture can be shown, one sentence gives the reason and the remedy."""

import re
import shutil

import pytest
from browser import serving

import bobrossnet as bob
from bobrossnet.page.export import export
from bobrossnet.page.files import READ_IN_PAGE
from bobrossnet.support.paths import VIEWER

ELEMENT = """<!doctype html>
{head}<script type="module" src="bob/component/bob-view.js"></script>
<bob-view {attributes} picture-size="64x48"></bob-view>
"""

ANSWERED = """() => {
  const { shadowRoot } = document.querySelector("bob-view");
  return window.isShown || !shadowRoot.querySelector("#wrong").hidden;
}"""

BROWSERS = "Chrome 137, Firefox 131, Safari 18.4, or newer"


@pytest.fixture(scope="module")
def folder(viewer, tmp_path_factory):
    """Return a folder with the page's files, and a mesh of each format."""
    folder = tmp_path_factory.mktemp("host")
    export({path: content for path, content in viewer.files.items() if "." in path}, folder / "bob")
    ball = bob.implicit(lambda x, y, z: x**2 + y**2 + z**2 - 1).mesh(0.2)
    for name in ("ball.glb", "ball.stl"):
        ball.save(folder / name)
    shutil.copy(folder / "ball.glb", folder / "download")
    (folder / "list.glb").mkdir()  # shown as a page, as by servers that answer everything
    return folder


LOADED = """document.addEventListener("load", (event) => {
  if (event.target.localName === "bob-view") window.isShown = true;
}, true);"""


@pytest.fixture
def told(tabs, folder):
    """Open an element; return the sentence that is shown, or None once there is a picture."""

    def told(attributes, script="", head="", address=None):
        (folder / "index.html").write_text(ELEMENT.format(attributes=attributes, head=head))
        page = tabs.open(script, LOADED, on={})
        try:
            with serving(folder) as here:
                page.goto(here)
                page.wait_for_function("() => customElements.get('bob-view')")
                if address is not None:
                    page.evaluate("(address) => { document.querySelector('bob-view').src = address; }", address)
                page.wait_for_function(ANSWERED)
                return (page.text_content("#wrong") or "").replace(here, "HERE/") or None
        finally:
            tabs.release(page)

    return told


# ---- Browsers and policies -------------------------------------------------------------------------------


def test_a_browser_without_webassembly(told):
    assert told('src="ball.glb"', script="delete globalThis.WebAssembly;") == (
        "WebAssembly: expected a browser that has it, got one without; allow it in the browser's settings, or use "
        "another browser"
    )


def test_an_old_browser(told):
    assert told('src="ball.glb"', script="WebAssembly.validate = () => false;") == (
        f"WebAssembly: expected SIMD and exceptions, got an older browser; use {BROWSERS}"
    )


def policy(text):
    return f'<meta http-equiv="Content-Security-Policy" content="{text}">'


def test_a_policy_without_webassembly(told):
    assert told('src="ball.glb"', head=policy("script-src 'self' 'unsafe-inline'")) == (
        "core.mesh.wasm: this page's Content-Security-Policy forbids WebAssembly; add 'wasm-unsafe-eval' to its "
        "script-src"
    )


def test_a_policy_without_workers(told):
    text = told('src="ball.glb"', head=policy("worker-src 'none'"))
    assert re.fullmatch(
        r"\w+\.js: expected a worker, got none that starts; set base to the folder with the files of bob-view, and "
        r"allow workers by worker-src in the page's Content-Security-Policy",
        text,
    )


# ---- Files -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "core.mesh.relaxed.wasm",
            "core.mesh.relaxed.wasm: expected a file at HERE/bob/core.mesh.relaxed.wasm, got",
        ),
        ("workers/completing.js", "completing.js: expected a worker, got none that starts; set base to the folder"),
        ("workers/reader.js", "reader.js: expected a worker, got none that starts; set base to the folder"),
        ("workers/tracer.js", "tracer.js: expected a worker, got none that starts; set base to the folder"),
        ("weights/filling.safetensors", "weights/filling.safetensors: expected a file at HERE/bob/weights/filling"),
    ],
)
def test_a_missing_part(told, folder, name, message):
    (folder / "bob" / name).rename(folder / "away")
    try:
        assert told('src="ball.glb"').startswith(message)
    finally:
        (folder / "away").rename(folder / "bob" / name)


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("none.glb", "none.glb: expected a file at HERE/none.glb, got 404 File not found; check the address"),
        ("part.step", "part.step: expected a format that this page reads, got .step; convert it: bobrossnet pack "
                      "part.bob part.step"),
        ("download", f"download: expected one of {' '.join(READ_IN_PAGE)}, got no ending; add one, as in #part.glb "
                     "after an address"),
        ("http://127.0.0.1:9/ball.glb", "ball.glb: 127.0.0.1:9 did not send http://127.0.0.1:9/ball.glb; check the "
                                        "address, and that the server sends Access-Control-Allow-Origin"),
        ("file:///ball.glb", "ball.glb: expected a server, got file:///ball.glb, which this page may not fetch; serve "
                             "the folder, or make one file: bobrossnet view FILE --export page.html"),
        ("blob:HERE/4c2b#a.glb", "a.glb: expected data, got "),
    ],
)  # fmt: skip
def test_an_address(told, address, message):
    text = told("", address=address)
    assert text.startswith(message)
    assert "\n" not in text


def test_another_server_that_does_not_allow_it(told, folder):
    with serving(folder) as elsewhere:
        text = told("", address=f"{elsewhere}ball.glb")
    assert text.endswith("check the address, and that the server sends Access-Control-Allow-Origin")


def test_no_network(browser, viewer):
    """Playwright cuts off pages, not workers."""
    page = browser.new_context().new_page()
    page.goto(f"{viewer.url}?size=64x48")
    fetched = page.evaluate_handle("import(new URL('core/fetching.js', location.href))")
    page.context.set_offline(True)
    text = fetched.evaluate("""({ fetched }) =>
      fetched("a.stl", new URL("a.stl", location.href)).catch(({ message }) => message)""")
    expected = f"expected a network to fetch {viewer.url}a.stl, got none; connect this machine and try again"
    assert text == f"a.stl: {expected}"
    page.context.close()


def test_a_web_page_instead_of_a_file(told):
    text = told("", address="list.glb/#a.glb")
    assert text == "a.glb: expected a file at HERE/list.glb/#a.glb, got a web page; check the address"


@pytest.mark.parametrize("kind", ["fragment", "blob", "data"])
def test_names_of_addresses_without_one(told, kind):
    fetched = "const blob = await (await fetch('ball.glb')).blob();"
    script = {
        "fragment": "() => 'download#ball.glb'",
        "blob": f"async () => {{ {fetched} return URL.createObjectURL(blob) + '#ball.glb'; }}",
        "data": f"""async () => {{ {fetched}
          const reader = new FileReader();
          reader.readAsDataURL(new Blob([blob], {{ type: "model/gltf-binary" }}));
          await new Promise((read) => (reader.onload = read));
          return reader.result;
        }}""",
    }[kind]
    head = f"""<script type="module">
      const address = {script};
      document.querySelector("bob-view").setAttribute("src", await address());
    </script>"""
    assert told("", head=head) is None


# ---- The page --------------------------------------------------------------------------------------------


def test_the_page_from_a_disk(browser, folder):
    page = browser.new_page()
    page.goto((folder / "bob/index.html").as_uri())
    assert page.text_content("#message") == (
        "This page needs a server: run bobrossnet view, or python -m http.server here; or make one file that opens "
        "from a disk, by bobrossnet view FILE --export page.html"
    )
    page.close()


def test_the_page_without_its_script(browser, folder):
    (folder / "bob/interface/main.js").rename(folder / "away")
    try:
        with serving(folder / "bob") as address:
            page = browser.new_page()
            page.goto(address)
            assert page.text_content("#message").startswith("This page did not start: reload it, check that its server")
            page.close()
    finally:
        (folder / "away").rename(folder / "bob/interface/main.js")


def test_the_page_that_starts_says_nothing(browser, viewer):
    page = browser.new_page()
    page.goto(f"{viewer.url}?size=64x48")
    page.evaluate("() => bobrossnet.started")
    assert page.text_content("#message") == ""
    page.close()


def test_versions_of_browsers_are_everywhere_the_same():
    files = ("core/compile.js", "interface/unstarted.js")
    assert all(BROWSERS in (VIEWER / name).read_text("utf-8") for name in files)
