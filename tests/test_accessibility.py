"""The page and its element for everyone: contrast, forced colours, keys alone, words for screen readers."""

import pytest

SIZES = [(1280, 800), (1920, 1080), (1000, 600), (800, 1100), (390, 844)]

CONTRASTS = """() => {
  const canvas = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
  const luminance = (color) => {
    canvas.fillStyle = color;
    canvas.fillRect(0, 0, 1, 1);
    const [r, g, b] = [...canvas.getImageData(0, 0, 1, 1).data].map((byte) => {
      const value = byte / 255;
      return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  window.contrast = (a, b) => {
    const [low, high] = [luminance(a), luminance(b)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  window.panel = getComputedStyle(document.querySelector("#controls")).backgroundColor;
}"""


@pytest.fixture
def opened(new_page, viewer):
    """Open the page in a context with these settings."""

    def opened(**context):
        page = new_page(**context)
        page.goto(viewer.url + "?size=128x96#scene=csg.sdf")
        page.evaluate("async () => { await bobrossnet.started; await bobrossnet.converged(); }")
        page.evaluate(CONTRASTS)
        return page

    return opened


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_borders_and_focus_are_seen(opened, scheme):
    """By the 3:1 of WCAG 1.4.11 and 2.4.13."""
    page = opened(color_scheme=scheme)
    page.click("#script summary")
    borders = page.evaluate("""() => [...document.querySelectorAll("#controls :is(button, select, #code, span)")]
      .filter((of) => of.checkVisibility() && !of.disabled && !of.closest("#numbers"))
      .map((of) => [of.id || of.textContent, contrast(getComputedStyle(of).borderTopColor, panel)])""")
    assert len(borders) > 8
    assert [name for name, contrast in borders if contrast < 3] == []
    page.evaluate("() => document.activeElement.blur()")
    seen = {}
    for _ in range(40):
        page.keyboard.press("Tab")
        found = page.evaluate("""() => {
          const of = document.activeElement, isSegment = of.matches(".segments input");
          const shown = isSegment ? of.nextElementSibling : of.closest("#code") ?? of;
          const { outlineStyle, outlineWidth, outlineColor } = getComputedStyle(shown);
          const isSeen = outlineStyle === "solid" && parseFloat(outlineWidth) >= 2;
          const contrasts = isSeen ? contrast(outlineColor, panel) : 0;
          return [of.id || of.value || of.localName, of.closest("#controls") ? contrasts : 9];
        }""")
        if found[0] in seen:
            break
        seen[found[0]] = found[1]
    assert {"picture", "gallery", "open", "completed", "budget", "home", "fit", "save", "link", "text"} <= set(seen)
    assert {name: contrast for name, contrast in seen.items() if contrast < 3} == {}


def test_the_picture_shows_its_focus_in_two_colours(opened):
    page = opened()
    ring = page.locator("#picture #ring")
    assert not ring.is_visible()
    page.keyboard.press("Tab")
    assert ring.is_visible()
    border, outline = ring.evaluate(
        "(ring) => { const style = getComputedStyle(ring); return [style.borderTopColor, style.outlineColor]; }"
    )
    assert page.evaluate("([a, b]) => contrast(a, b)", [border, outline]) > 9  # so any colour differs from one by 3
    page.mouse.click(100, 100)
    page.locator("#save").focus()
    page.mouse.click(100, 100)
    assert not ring.is_visible()


@pytest.mark.parametrize("colors", ["none", "active"])
def test_planes_of_sections_are_seen_and_focused(opened, colors):
    """On any background: in two colours, or in the user's colours."""
    page = opened(forced_colors=colors)
    page.locator("#picture").focus()
    page.keyboard.press("x")
    knob = page.get_by_role("slider", name="Section plane X")
    knob.wait_for()
    page.keyboard.press("Tab")
    seen = knob.evaluate("""(knob) => {
      const { backgroundColor, color, outlineStyle, outlineWidth, outlineColor } = getComputedStyle(knob);
      const isFocused = knob.getRootNode().activeElement === knob;
      const contrasts = [color, outlineColor].map((other) => contrast(backgroundColor, other));
      return [isFocused, outlineStyle, parseFloat(outlineWidth), ...contrasts];
    }""")
    assert seen[:2] == [True, "solid"]
    assert seen[2] >= 2
    assert seen[3] > 4.5
    assert seen[4] > (3 if colors == "active" else 9)


def test_forced_colours_show_what_is_chosen(opened):
    page = opened(forced_colors="active")
    segments = page.locator(".segments span")
    colors = segments.evaluate_all("(all) => all.map((of) => getComputedStyle(of).backgroundColor)")
    assert colors[0] not in colors[1:]
    assert len(set(colors[1:])) == 1


@pytest.mark.parametrize("size", SIZES)
def test_there_is_nothing_empty_to_scroll(opened, size):
    page = opened(viewport={"width": size[0], "height": size[1]})
    width, height, end = page.evaluate("""() => {
      const { scrollWidth, clientWidth, scrollHeight, clientHeight } = document.scrollingElement;
      const main = document.querySelector("main").getBoundingClientRect();
      return [scrollWidth - clientWidth, scrollHeight - clientHeight, main.bottom + scrollY - scrollHeight];
    }""")
    assert width <= 0
    assert height <= 1 or size[0] <= 800
    assert abs(end) <= 1


def test_movements_are_told_in_words(opened):
    page = opened()
    page.locator("#picture").focus()
    where = page.locator("#picture #where")
    assert where.text_content() == ""
    assert where.get_attribute("role") == "status"
    home = "View from the back right, 20 degrees above"
    for key, words in {
        "1": "View from the front", "3": "View from the right", "2": "View from above", "0": home,
        "p": f"{home}, in perspective",
    }.items():  # fmt: skip
        page.keyboard.press(key)
        page.wait_for_function(
            "(words) => document.querySelector('#picture').shadowRoot.querySelector('#where').textContent === words",
            arg=words,
        )
    page.keyboard.press("PageUp")
    page.wait_for_function(
        "() => /enlarged 1.1|enlarged 1.2/.test(document.querySelector('#picture').shadowRoot.textContent)"
    )


def test_the_centre_is_picked_without_a_mouse(opened):
    page = opened()
    view = page.locator("#picture")
    view.evaluate("(view) => view.addEventListener('pick', ({ detail }) => (window.seen = detail))")
    view.focus()
    page.keyboard.press("Enter")
    page.wait_for_function("() => window.seen")
    assert len(page.evaluate("() => seen.point")) == 3


@pytest.mark.parametrize("size", SIZES)
def test_no_control_is_cut(opened, size):
    page = opened(viewport={"width": size[0], "height": size[1]})
    cut = page.evaluate("""() => [...document.querySelectorAll("#controls :is(button, select, input, dd)")]
      .filter((of) => of.checkVisibility())
      .filter((of) => of.getBoundingClientRect().right > innerWidth)
      .map((of) => of.id || of.textContent)""")
    assert cut == []
