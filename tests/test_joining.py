"""Modules of the page, bundled to one file for each entry."""

import re

import pytest
from browser import serving

from bobrossnet.page.files import VIEWER
from bobrossnet.page.joining import ENTRIES, Modules, joined, squeezed

FILES = {
    "a/entry.js": """
// @ts-check
import { base, scaled as twice } from "../b/numbers.js";
import {
  Thing,
} from "./thing.js";
import "../b/effect.js";

/** @type {import("./thing.js").Thing} */
const thing = new Thing(base);
const later = (await import("./later.js")).later; // fetched later
const beside = new URL("x.js", import.meta.url).pathname;
export const result = [twice(thing.value), [...steps()], later(), globalThis.effect, beside];
import { steps } from "../b/numbers.js";
""",
    "a/thing.js": """
import { base } from "../b/numbers.js";
/**
 * A thing: "*" it is.
 */
export class Thing {
  // of base
  constructor(/** @type {number} */ start) { this.value = start + base; }
}
""",
    "a/later.js": "export async function unused() {}\nexport const later = () => 7;\n",
    "b/numbers.js": """
const hidden = 20;
export const { base, other } = { base: hidden, other: 1 };
export function scaled(x) { return 2 * x; }
export function* steps() { yield base; yield other; }
""",
    "b/effect.js": 'globalThis.effect = "done";\n',
}


class Folder(Modules):
    """Modules without files."""

    def __init__(self, files, tmp_path):
        for path, text in files.items():
            (tmp_path / path).parent.mkdir(exist_ok=True)
            (tmp_path / path).write_text(text)
        super().__init__(tmp_path)


SPACED = [
    ('const a = [ 1, 2 ], b = "x , y";\n', 'const a=[1,2],b="x , y";\n'),
    ("a = b + +c - -d + e;\n", "a=b+ +c- -d+e;\n"),
    ('f = `${a ? `( ${b + 1} )` : " : "} , ${ { c } }` + 1;\n', 'f=`${a ? `( ${b + 1} )` : " : "} , ${ { c } }`+1;\n'),
    (r"""x = /[/] , (\/) "/ .exec(y) ; z = a / b / c;""" + "\n", r"""x=/[/] , (\/) "/ .exec(y);z=a / b / c;""" + "\n"),
    (
        "// a / b : it's\nreturn typeof c in d ? '( it\\'s )' : e;\n",
        "return typeof c in d?'( it\\'s )':e;\n",
    ),
    ("f(\n1,\n2\n)\n++a\n", "f(1,2\n)\n++a\n"),
]


@pytest.mark.parametrize(("text", "wanted"), SPACED)
def test_spaces_go_where_nothing_needs_them(text, wanted):
    assert squeezed(text) == wanted


def test_joined_modules_do_what_they_did(browser, tmp_path):
    text = joined(Folder(FILES, tmp_path), "a/entry.js")
    assert "A thing" not in text
    assert "@type" not in text
    (tmp_path / "a/joined.js").write_text(text)
    (tmp_path / "index.html").write_text("")
    page = browser.new_page()
    with serving(tmp_path) as address:
        page.goto(address)
        ask = "async (path) => (await import(path)).result"
        found = page.evaluate(ask, "./a/joined.js")
        assert found == page.evaluate(ask, "./a/entry.js") == [80, [20, 1], 7, "done", "/a/x.js"]
    page.close()


@pytest.mark.parametrize(
    ("changed", "error"),
    [
        ({"b/numbers.js": "export const base = 1;\n"}, "a/entry.js: expected scaled to be exported by b/num"),
        ({"b/effect.js": 'import "../a/entry.js";\n'}, "needs itself, got a/entry.js > b/effect.js > a/entry.js"),
        ({"b/effect.js": "export default 1;\n"}, "b/effect.js: expected another form than: export default 1;"),
        ({"b/effect.js": "export let changes = 1;\n"}, "b/effect.js: expected another form than: export let changes"),
        ({"b/effect.js": 'import all from "./x.js";\n'}, "b/effect.js: expected another form than: import all"),
        ({"b/effect.js": 'import "./c/deep.js";\n', "b/c/deep.js": "import.meta;\n"}, "deep.js: expected no address"),
    ],
)  # fmt: skip
def test_other_forms_are_refused(tmp_path, changed, error):
    (tmp_path / "b/c").mkdir(parents=True)
    with pytest.raises(ValueError, match=error):
        joined(Folder(FILES | changed, tmp_path), "a/entry.js")


def test_entries_ask_for_nothing():
    modules = Modules(VIEWER)
    for entry in ENTRIES:
        text = joined(modules, entry)
        assert re.findall(r"^import\b.*", text, re.MULTILINE) == []
        assert re.findall(r"\bimport\(.+?\)", text) == []
