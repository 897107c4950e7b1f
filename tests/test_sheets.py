"""Sheets: views to one scale, in their places, with true dimensions."""

import json

import numpy as np
import pytest
from PIL import Image, ImageDraw

import bobrossnet as bob
from bobrossnet.color import from_8_bit, from_srgb
from bobrossnet.command_line import cli
from bobrossnet.pictures.rendered import Picture
from bobrossnet.pictures.sheets import laid_out
from bobrossnet.sdf import box, cylinder, sphere

BLOCK = bob.Mesh(
    np.array([(x, y, z) for x in (0, 4) for y in (0, 2) for z in (0, 1)], float),
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4)]
    + [(1, 5, 7), (1, 7, 3)],
)


@pytest.fixture
def words(monkeypatch):
    """All texts that are drawn."""
    drawn = []
    text = ImageDraw.ImageDraw.text
    monkeypatch.setattr(
        ImageDraw.ImageDraw,
        "text",
        lambda self, place, words, *a, **k: (drawn.append(words), text(self, place, words, *a, **k)),
    )
    return drawn


def drawn_box(picture):
    """Height and width of whatever is not white, in pixels."""
    rows, columns = np.nonzero((picture.rgba[..., :3] < 250).any(axis=-1))
    return np.ptp(rows) + 1, np.ptp(columns) + 1


def test_extents():
    low, high = bob.Scene(BLOCK).extent
    assert np.array_equal(low, (0, 0, 0))
    assert np.array_equal(high, (4, 2, 1))
    for shape, expected in ((sphere(1), (2, 2, 2)), (box((1, 2, 3)), (1, 2, 3)), (cylinder(0.5) & box(2), (1, 1, 2))):
        assert np.allclose(bob.Scene(shape).extent.size, expected, rtol=1e-4)
        for cut in (bob.Scene(shape, section="x=0.1"), bob.Scene(shape).sectioned("x=0.1")):
            assert np.array_equal(cut.extent, bob.Scene(shape).extent)


def test_dimensions_are_written(words):
    bob.sheet(BLOCK, unit="mm", title="block")
    assert words.count("4 mm") == 2  # below the top and the front view
    assert words.count("2 mm") == 2  # next to the top view and below the right one
    assert words.count("1 mm") == 3  # next to two views, and the scale bar
    assert {"top", "front", "right", "isometric"} < {*words}
    assert "block   4 x 2 x 1 mm   1 part   volume 8 mm^3" in words


@pytest.mark.parametrize(("view", "across", "up"), [("front", 4, 1), ("left", 2, 1), ("bottom", 4, 2)])
def test_views_are_to_scale(view, across, up, monkeypatch):
    monkeypatch.setattr(ImageDraw.ImageDraw, "text", lambda *_, **__: None)
    monkeypatch.setattr(ImageDraw.ImageDraw, "line", lambda *_, **__: None)
    high, wide = drawn_box(bob.sheet(BLOCK, view, size=(600, 800)))
    assert wide / high == pytest.approx(across / up, rel=0.02)
    assert wide > 550 or high > 400


def test_all_views_have_one_scale_and_stand_in_line(monkeypatch):
    monkeypatch.setattr(ImageDraw.ImageDraw, "text", lambda *_, **__: None)
    monkeypatch.setattr(ImageDraw.ImageDraw, "line", lambda *_, **__: None)
    page = (bob.sheet(BLOCK, size=(600, 800)).rgba[..., :3] < 250).any(axis=-1)
    top, front, right = page[:285, :400], page[285:570, :400], page[285:570, 400:]
    columns = [np.flatnonzero(view.any(axis=0)) for view in (top, front)]
    assert abs(columns[0][0] - columns[1][0]) <= 1
    rows = [np.flatnonzero(view.any(axis=1)) for view in (front, right)]
    assert abs(rows[0][0] - rows[1][0]) <= 1
    assert abs(rows[0][-1] - rows[1][-1]) <= 1
    assert np.ptp(columns[0]) == pytest.approx(2 * np.ptp(np.flatnonzero(right.any(axis=0))), rel=0.03)


def test_edges_are_drawn_where_there_are_some():
    def drawn(shape):
        with_edges, without = (
            bob.sheet(shape, "isometric", size=(300, 400), edges=edges).rgba[..., 0].astype(int)
            for edges in (True, False)
        )
        return (without - with_edges > 40).sum()

    silhouette = drawn(sphere(1))
    assert silhouette > 200
    assert drawn(box(1)) > 1.3 * silhouette  # three creases more


def test_parts_are_named(words):
    ball, bar = (
        bob.Instance(sphere(1), name="ball"),
        bob.Instance(box((5, 0.5, 0.5)), name="a bar with a long, long name"),
    )
    bob.sheet([ball, bar])
    assert "ball" in words
    assert "a bar with a long, lo..." in words
    assert any("2 parts" in text for text in words)
    words.clear()
    bob.sheet([ball, bar], names=False)
    assert "ball" not in words


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"views": ["above"]}, r"^views: expected one of front, back, .*, got 'above'"),
        ({"views": []}, r"^views: expected 1 to 6 of "),
        ({"views": ["top"] * 7}, r"^views: expected 1 to 6 of "),
        ({"size": (100, 400)}, r"^size: expected at least 240x240, got 400x100"),
        ({"unit": 3}, r"^unit: expected one of .*, got int"),
        ({"unit": "furlongs"}, r"^unit: expected one of "),
        ({"title": b"x"}, r"^title: expected a string, got bytes"),
    ],
)
def test_bad_settings_are_one_line(settings, message):
    with pytest.raises(bob.InputError, match=message):
        bob.sheet(BLOCK, **settings)


@pytest.mark.parametrize("factor", [1e-6, 1, 1e9])
def test_any_scale(factor, words):
    bob.sheet(bob.Instance(BLOCK).scale(factor), size=(300, 400))
    assert any(f"{4 * factor:.4g} x {2 * factor:.4g}" in text for text in words)


def test_flat_things_have_sheets(words):
    bob.sheet(bob.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]), size=(300, 400))
    assert any("1 x 1 x 0" in text for text in words)


def test_command(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    BLOCK.save("block.stl")
    assert cli.main(["sheet", "block.stl", "--unit", "mm", "--size", "400x300", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["bounds"] == [[0, 0, 0], [4, 2, 1]]
    with Image.open("sheet.png") as picture:
        assert picture.size == (400, 300)
    assert cli.main(["sheet", "block.stl", "--views", "top,nowhere"]) == 2
    assert "views: expected one of " in capsys.readouterr().err


def test_a_part_of_a_mesh_is_named(words):
    """Parts of the tree are counted, not instances."""
    pieces = [(("lid",), 4), (("case",), 8)]
    bob.sheet(bob.Instance(BLOCK, pieces=pieces), "isometric", size=(300, 400))
    assert {"lid", "case"} < {*words}
    assert any(text.endswith("2 parts   volume 8") for text in words)


@pytest.mark.parametrize(
    ("shape", "fact"),
    [
        (bob.Scene(BLOCK, unit="mm"), "1 part   volume 8 mm^3"),
        (bob.Scene(bob.Instance(BLOCK).scale(30), unit="mm"), "1 part   volume 216000 mm^3"),
        (bob.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]), "1 part   open"),
        (sphere(1), "1 part"),  # a mesh of a formula is no exact volume
    ],
)
def test_the_bottom_line(shape, fact, words):
    bob.sheet(shape, "front", size=(300, 400), title="x")
    assert any(text.startswith("x   ") and text.endswith(fact) for text in words)


def test_a_long_title_leaves_room_for_the_facts(words):
    bob.sheet(BLOCK, size=(300, 400), title="long " * 40, unit="mm")
    (bottom,) = (text for text in words if text.startswith("long"))
    assert bottom.endswith("...   4 x 2 x 1 mm   1 part   volume 8 mm^3")


def test_sections_are_views_of_their_own(words, monkeypatch):
    whole = np.asarray(bob.sheet(BLOCK, ["front"], size=(400, 400)))
    words.clear()
    hollow = bob.Instance(box(2) - sphere(0.8))
    cut = bob.sheet(hollow, ["front"], size=(400, 800), section="y>0")
    assert words.count("section y>0") == 1
    assert "front" in words
    assert cut.size == (400, 800)
    assert whole.shape == (400, 400, 4)
    left, right = cut.rgba[:380, :400], cut.rgba[:380, 400:]
    assert (left != right).any(axis=-1).sum() > 2000  # the hatched cap, and the bowl
    words.clear()
    bob.sheet(BLOCK, size=(600, 1200), section=["x=1", "z=0.5", "x=9"])
    assert {"section x=1", "section z=0.5", "section x=9"} < {*words}
    # Marked where the cut is seen as a line, and not outside of the shape.
    assert (words.count("x=1"), words.count("z=0.5"), words.count("x=9")) == (2, 2, 0)


def test_cutting_lines_are_where_sections_cut():
    laid = laid_out(BLOCK, ["front", "back", "top", "left"], (600, 800))
    low, high = BLOCK.bounding_box(np.eye(4))
    for view in laid.views:
        (x, y), (right, bottom) = np.sort(view.places(np.array([low, high])), axis=0)
        wide, high_ = (4 if "x" in view.axes else 2), (2 if "z" not in view.axes else 1)
        assert right - x == pytest.approx(wide * laid.pixels, abs=1e-3)
        assert bottom - y == pytest.approx(high_ * laid.pixels, abs=1e-3)
        assert ((x + right) / 2, (y + bottom) / 2) == pytest.approx(view.middle, abs=0.1)


def test_oblique_sections_face_the_viewer(words):
    bob.sheet(box(2), ["front"], size=(300, 600), section=bob.Section((1, 1, 1), 0))
    assert any(text.startswith("section (0.577") for text in words)
    assert words.count("2") == 2  # the dimensions of the front view alone


def test_lengths_are_converted_from_a_known_unit(words):
    scene = bob.Scene(bob.Instance(BLOCK).scale(25.4), unit="mm")
    bob.sheet(scene, ["top", "front"], unit="in", size=(300, 600), section="x>50.8")
    assert "section x>2" in words
    assert words.count("4 in") == 2
    assert any("4 x 2 x 1 in   1 part   volume 8 in^3" in text for text in words)


def test_long_dimensions_stay_on_the_page(words):
    """Room for them is left at both sides."""
    thin = bob.Instance(BLOCK).scale(123456.789)
    page = bob.sheet(thin, ["front"], unit="mil", size=(300, 400)).rgba
    assert "493827 mil" in words
    assert (page[:, 0] == 255).all()


def test_the_page_is_read_back_exactly():
    levels = np.arange(256, dtype=np.uint8)
    assert np.array_equal(from_8_bit(levels), from_srgb(levels / 255).astype(np.float32))
    picture = Picture.opaque(np.broadcast_to(levels[:, None, None], (256, 2, 3)))
    assert np.array_equal(picture.rgba, Picture(picture.color, picture.alpha).rgba)
