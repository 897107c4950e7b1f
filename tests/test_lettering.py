"""Text as shapes: compared with outlines sampled from the font by fontTools, and letters drawn by Pillow."""

# ruff: noqa: N802, N815  # the pen's methods have fontTools' names

import pickle
import sys
from itertools import pairwise
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.basePen import BasePen
from fontTools.pens.t2CharStringPen import T2CharStringPen
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib import TTFont, newTable
from fontTools.ttLib.tables._k_e_r_n import KernTable_format_0
from PIL import Image, ImageDraw, ImageFont
from scipy.spatial import cKDTree

import bobrossnet as bob
from bobrossnet.sdf import SDF3, measure_text, text
from bobrossnet.support.errors import InputError

DEJAVU = f"{matplotlib.get_data_path()}/fonts/ttf/DejaVuSans.ttf"


class Sampling(BasePen):
    """Points of a glyph's curves, 2,000 of each."""

    def __init__(self, glyphs):
        super().__init__(glyphs)
        self.points = []

    def _add(self, *controls):
        t = np.linspace(0, 1, 2000)[:, None]
        points = [np.array(control, float)[None] for control in (self._getCurrentPoint(), *controls)]
        while len(points) > 1:
            points = [a * (1 - t) + b * t for a, b in pairwise(points)]
        self.points.append(points[0])

    def _moveTo(self, point):
        self.start = point

    def _closePath(self):
        self._add(self.start)

    _lineTo = _curveToOne = _qCurveToOne = _add


def sampled(font_file, letters):
    """Return points of the outline, in the font's units, and Pillow's box of the text."""
    points, at = [], 0
    with TTFont(font_file) as font:
        glyphs, names = font.getGlyphSet(), font.getBestCmap()
        for letter in letters:
            pen = Sampling(glyphs)
            glyphs[names[ord(letter)]].draw(pen)
            points += [each + (at, 0) for each in pen.points]
            at += glyphs[names[ord(letter)]].width
        size = font["head"].unitsPerEm
    points = np.concatenate(points)
    low, high = points.min(axis=0), points.max(axis=0)
    return points, (min(low[0], 0), low[1]), (max(high[0], at), high[1]), size


SQUARE = [(100, 0), (100, 500), (600, 500), (600, 0)]


def drawn(pen, *outlines):
    for first, *rest in outlines:
        pen.moveTo(first)
        for point in rest:
            if isinstance(point[0], tuple):
                pen.curveTo(*point)
            else:
                pen.lineTo(point)
        pen.closePath()


def built(path, glyphs, cff=False, kern=None):
    """Write a font of 1000 units, with glyphs 800 wide."""
    names = [".notdef", *glyphs]
    builder = FontBuilder(1000, isTTF=not cff)
    builder.setupGlyphOrder(names)
    builder.setupCharacterMap({ord(name): name for name in glyphs})
    shapes = {}
    for name in names:
        pen = T2CharStringPen(800, None) if cff else TTGlyphPen(None)
        drawn(pen, *glyphs.get(name, [SQUARE]))
        shapes[name] = pen.getCharString() if cff else pen.glyph()
    if cff:
        builder.setupCFF("Test", {}, shapes, {})
    else:
        builder.setupGlyf(shapes)
    builder.setupHorizontalMetrics(dict.fromkeys(names, (800, 100)))
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupNameTable({"familyName": "Test", "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    if kern:
        table = KernTable_format_0()
        table.coverage, table.tupleIndex, table.kernTable = 1, None, kern
        builder.font["kern"] = newTable("kern")
        builder.font["kern"].version, builder.font["kern"].kernTables = 0, [table]
    builder.save(path)
    return str(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fonts")


@pytest.fixture(scope="module")
def cff(folder):
    """Write a font of cubics: an S-shaped one, and one with a control point at its end."""
    drop = [(100, 0), ((300, -100), (600, 200), (500, 500)), ((400, 800), (100, 700), (100, 700)), (50, 300)]
    return built(folder / "cubics.otf", {"d": [drop]}, cff=True)


@pytest.fixture(scope="module")
def squares(folder):
    """A: a square. B: two that overlap by half. C: a square inside another, in the opposite direction."""
    over = [(x + 250, y) for x, y in SQUARE]
    inner = [(x / 2 + 100, y / 2 + 100) for x, y in SQUARE[::-1]]
    return built(
        folder / "squares.ttf", {"A": [SQUARE], "B": [SQUARE, over], "C": [SQUARE, inner]}, kern={("A", "B"): -100}
    )


def away_from(points, places):
    return cKDTree(points).query(places)[0]


@pytest.mark.parametrize(("width", "height"), [(None, None), (3, None), (2, 1)])
@pytest.mark.parametrize("letters", ["a", "Bob&8", "%Ω "])
def test_distances_are_those_of_the_curves(letters, width, height):
    points, low, high, size = sampled(DEJAVU, letters)
    wide, high_ = measure_text(DEJAVU, letters, width, height)
    scale = np.array([wide / (high[0] - low[0]), high_ / (high[1] - low[1])])
    outline = (points - (np.array(low) + high) / 2) * scale
    places = np.random.default_rng(0).uniform(-0.8, 0.8, (4000, 2)) * (wide, high_)
    expected = away_from(outline, places)
    distance = text(DEJAVU, letters, width, height)(places)[:, 0]
    clear = expected > 0.01  # nearer, the samples are too sparse
    assert np.abs(np.abs(distance) - expected)[clear].max() < 3e-5 * size * scale.max() + 1e-5


def test_cubics_of_cff(cff):
    points, low, high, size = sampled(cff, "d")
    scale = 1 / (high[1] - low[1])
    outline = (points - (np.array(low) + high) / 2) * scale
    places = np.random.default_rng(1).uniform(-1, 1, (20_000, 2))
    expected = away_from(outline, places)
    distance = text(cff, "d")(places)[:, 0]
    clear = expected > 0.01
    assert np.abs(np.abs(distance) - expected)[clear].max() < 3e-5 * size * scale + 1e-5


@pytest.mark.parametrize("letters", ["g&8", "%Ω"])
def test_inside_is_where_pillow_draws(letters):
    size = 400
    font = ImageFont.truetype(DEJAVU, size, layout_engine=ImageFont.Layout.BASIC)
    x0, y0, x1, y1 = font.getbbox(letters)
    picture = Image.new("L", (x1 - x0, y1 - y0))
    ImageDraw.Draw(picture).text((-x0, -y0), letters, font=font, fill=255)
    white = np.asarray(picture) > 127
    width, height = measure_text(DEJAVU, letters)
    rows, columns = np.mgrid[: white.shape[0] : 6, : white.shape[1] : 6]
    scale = 1 / white.shape[0]
    places = np.stack([(columns + 0.5) * scale - width / 2, height / 2 - (rows + 0.5) * scale], axis=-1)
    distance = text(DEJAVU, letters)(places.reshape(-1, 2)).reshape(rows.shape)
    clear = np.abs(distance) > 4 * scale  # hinting moves letters by a pixel or two
    assert (white[rows, columns] == (distance < 0))[clear].all()
    assert clear.mean() > 0.8


def test_sizes(squares):
    """800 wide and 500 high each."""
    assert measure_text(squares, "A") == pytest.approx((1.6, 1))
    assert measure_text(squares, "AA", height=2) == pytest.approx((6.4, 2))
    assert measure_text(squares, "A", width=3.2) == pytest.approx((3.2, 2))
    assert measure_text(squares, "A", width=5, height=2) == pytest.approx((5, 2))
    assert measure_text(squares, "AB") == pytest.approx((1550 / 500, 1))  # kerned by 100, and B itself is 850 wide


def test_places(squares):
    """The box around A is 0..800 by 0..500, the square 100..600 in it."""
    f = text(squares, "A", height=500)
    assert f([(-50, 0), (-50, 240), (300, 0), (-300, 250), (-310, -260)])[:, 0] == pytest.approx(
        [-250, -10, 100, 0, np.hypot(10, 10)]
    )
    kerned = text(squares, "AB", height=500)  # A at 100..600, B at 800..1550, of 0..1550
    assert kerned([(-100, 0), (0, 0)])[:, 0] == pytest.approx([75, 25])
    stretched = text(squares, "A", width=1600, height=500)
    assert stretched([(-100, 0), (700, 0)])[:, 0] == pytest.approx([-250, 300])


def test_outlines_that_overlap_are_one(squares):
    """B reaches from 100 to 850; the overlap of its halves is all inside."""
    f = text(squares, "B", height=500)
    low = -425  # of the box, which is as wide as the letter, 850
    assert f([(low + 475, 0), (low + 350, 0), (low + 840, 0)])[:, 0] == pytest.approx([-250, -250, -10])


def test_holes(squares):
    """C has a hole from 150 to 400 by 100 to 350."""
    f = text(squares, "C", height=500)
    assert f([(-125, -25), (-245, -25), (-275, 0)])[:, 0] == pytest.approx([125, 5, -25])


def test_what_the_font_lacks_is_its_box(squares):
    assert text(squares, "?").expression == text(squares, "A").expression


def test_text_is_a_shape_like_others(tmp_path):
    f = text(DEJAVU, "Bo").extrude(0.2)
    assert isinstance(f, SDF3)
    picture = bob.trace(f, bob.Camera(azimuth=-90, elevation=90), size=(60, 80))
    assert 0.1 < picture.alpha.mean() < 0.6
    assert f.unresolved_rays == 0
    assert pickle.loads(pickle.dumps(f)).expression == f.expression
    scene = bob.Scene([f])
    bob.save_scene(scene, tmp_path / "text.bob")
    again = bob.load(tmp_path / "text.bob")
    assert np.array_equal(bob.trace(again, size=(40, 60)).gray, bob.trace(scene, size=(40, 60)).gray)
    f.save(tmp_path / "text.stl", step=0.02)
    assert (tmp_path / "text.stl").stat().st_size > 10_000


def test_text_makes_closed_meshes():
    """Their volume matches the letter's area, from a grid over it."""
    f = text(DEJAVU, "B").extrude(0.5)
    mesh = f.mesh(0.01)
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    steps = (np.arange(150) + 0.5) / 150 - 0.5
    share = (text(DEJAVU, "B")(np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)) < 0).mean()
    assert volume == pytest.approx(share * 0.5, rel=0.01)


def test_fonts_are_found_by_name():
    try:
        ImageFont.truetype("DejaVuSans.ttf", 16)
    except OSError:
        pytest.skip("no DejaVuSans.ttf among this machine's fonts")
    assert measure_text("DejaVuSans.ttf", "a") == pytest.approx(measure_text(DEJAVU, "a"), rel=0.01)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("nowhere.ttf", "a"), "text: font 'nowhere.ttf': cannot open resource"),
        ((3, "a"), "text: font_name: expected a path or a name, got int"),
        ((DEJAVU, 3), "text: text: expected a string, got int"),
        ((DEJAVU, "a\nb"), "text: text: expected one line of letters, got 'a\\nb'; make each line a shape of its own"),
        ((DEJAVU, "  "), "text: text: expected letters that can be seen, got '  '"),
        ((DEJAVU, ""), "text: text: expected letters that can be seen, got ''"),
        ((DEJAVU, "a", -1), "text: width: expected a number above 0, got -1"),
    ],
)
def test_what_can_not_be_used_is_told(arguments, message):
    with pytest.raises(InputError) as error:
        text(*arguments)
    assert str(error.value) == message


def test_damaged_fonts_are_told(tmp_path):
    path = tmp_path / "damaged.ttf"
    path.write_bytes(Path(DEJAVU).read_bytes()[:400_000])
    with pytest.raises(InputError, match=r"damaged\.ttf") as error:
        text(path, "ag")
    assert "\n" not in str(error.value)


def test_without_fonttools_it_says_what_to_install(monkeypatch):
    monkeypatch.delitem(sys.modules, "bobrossnet.sdf.glyphs", raising=False)
    monkeypatch.setitem(sys.modules, "fontTools.ttLib", None)
    with pytest.raises(InputError) as error:
        measure_text(DEJAVU, "a")
    assert str(error.value) == "measure_text: this needs fontTools: pip install 'bobrossnet[text]'"
