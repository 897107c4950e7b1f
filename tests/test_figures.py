"""The report's figures: their data, their drawings, and their files."""

from itertools import pairwise
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.text import Text
from PIL import Image
from torch import nn

import bobrossnet as bob
from bobrossnet.command_line import cli
from bobrossnet.learn import figures
from bobrossnet.learn.checks import FIGURE_NAMES, check_figures
from bobrossnet.learn.dataset import Dataset, Plan
from bobrossnet.learn.dataset.plan import SIZES, STAGES
from bobrossnet.learn.figures import FIGURES, Drawing, Sources, architecture, draw_figures, timing
from bobrossnet.learn.figures.convergence import FRACTIONS
from bobrossnet.learn.figures.graph import INPUT, layers_of
from bobrossnet.learn.figures.style import COLUMN, DPI, PAGE, new_figure, picture_grid, save, show_picture, style
from bobrossnet.learn.networks import Paper
from bobrossnet.picture.files import UNTRACED, color_to_8_bit, to_8_bit
from bobrossnet.support.errors import InputError


def texts(file):
    """Return an SVG file's text."""
    return [element.text for element in ElementTree.parse(file).iter("{http://www.w3.org/2000/svg}text")]


def words_of(drawing):
    """Return a figure's text, line by line."""
    return [line for text in drawing.figure.findobj(Text) for line in text.get_text().split("\n")]


def shown(drawing):
    """Return the pictures in a figure, in the order of its axes."""
    return [image.get_array() for axes in drawing.figure.axes for image in axes.get_images()]


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Return a data set of three shapes, with views of known values."""
    path = tmp_path_factory.mktemp("figures") / "data"
    dataset = Dataset.create(path, Plan(shapes=3, test_shapes=1), ["made 0", "made 1", "some/folder/teapot.stl"])
    for shape in range(3):
        for size in SIZES:
            view = np.full((4, size, size), 0.5, np.float16)
            view[0] = np.linspace(0, 1, size)
            dataset.write(shape, size, view)
    return Dataset.open(path)


# ---- each figure --------------------------------------------------------------------------------------------


def test_convergence_shows_what_is_traced():
    drawing = FIGURES["2.1"](Sources(size=48))
    full = bob.trace(bob.happy_tree(), bob.Camera(azimuth=30, elevation=20), size=(48, 48))
    pictures = shown(drawing)
    assert len(pictures) == len(FRACTIONS)
    for picture, fraction in zip(pictures, FRACTIONS, strict=True):
        green = (picture == UNTRACED).all(-1)
        assert np.count_nonzero(~green) == max(1, round(fraction * 48 * 48))
        np.testing.assert_array_equal(picture[~green][:, 0], color_to_8_bit(full.gray)[~green])


def test_samples_are_the_data_sets(data):
    drawing = FIGURES["5.2"](Sources(data=data))
    pictures = np.array(shown(drawing)[len(STAGES) :: len(STAGES) + 1])
    assert len(shown(drawing)) == 3 * (len(STAGES) + 1)
    words = [text.get_text() for axes in drawing.figure.axes for text in axes.texts]
    assert words == ["shape 0\n128 x 128", "shape 1\n256 x 256", "teapot\n512 x 512"]
    for picture, size in zip(pictures, SIZES, strict=True):  # a patch of a larger picture shows a part of the ramp
        assert int(picture[0, -1, 0]) - int(picture[0, 0, 0]) == pytest.approx(255 * 127 / (size - 1), abs=1.5)
    for stage, fraction in enumerate(STAGES):
        green = (shown(drawing)[stage] == UNTRACED).all(-1)
        assert np.count_nonzero(~green) == round(fraction * 128 * 128)
    assert "data set of 315:" in drawing.caption


def test_the_u_net_is_the_network():
    drawing = FIGURES["4.1"](Sources())
    words = words_of(drawing)
    for name, layer in Paper().named_children():
        assert name in words
        assert f"{layer.in_channels} → {layer.out_channels}" in words
        assert f"{sum(parameter.numel() for parameter in layer.parameters()):,} parameters" in words
    assert {"skip, 5 channels", "skip, 20 channels", "shuffle", "H × W"} <= set(words)
    assert "10,346" in drawing.caption


@pytest.mark.parametrize(("name", "groups", "total"), [("4.2", 1, "31,946"), ("4.3", 4, "10,346")])
def test_channels_are_the_networks(name, groups, total):
    drawing = FIGURES[name](Sources())
    words = words_of(drawing)
    assert total in words
    assert total in drawing.caption
    assert words.count("4 groups") == (2 if groups == 4 else 0)
    assert words.count("shuffle") == (1 if groups == 4 else 0)
    for layer in Paper(groups=groups).children():
        assert f"{sum(parameter.numel() for parameter in layer.parameters()):,} parameters" in words


class Wide(Paper):
    """Another network, wider at first and with other groups."""

    def __init__(self):
        super().__init__(groups=2)
        self.encode1 = nn.Conv2d(5, 24, 3, padding=1)
        self.encode2 = nn.Conv2d(24, 80, 3, padding=1, groups=2)
        self.decode2 = nn.Conv2d(29, 5, 3, padding=1)


def test_another_network_makes_another_figure(monkeypatch):
    monkeypatch.setattr(architecture, "Paper", Wide)
    for name in ("4.1", "4.3"):
        drawing = FIGURES[name](Sources())
        assert {"5 → 24", "24 → 80", "29 → 5"} <= set(words_of(drawing))
        assert f"{sum(parameter.numel() for parameter in Wide().parameters()):,}" in drawing.caption


def test_graph_of_the_network():
    layers = {layer.name: layer for layer in layers_of(Paper())}
    assert [layer.scale for layer in layers.values()] == [1, 2, 4, 4, 2, 1]
    assert [name for name, layer in layers.items() if layer.shuffled] == ["encoded"]
    assert layers["encode1"].reads == ((INPUT, 5),)
    assert layers["decode2"].reads == (("decode1", 5), ("encode1", 20))
    assert layers["output"].reads == (("decode2", 5), (INPUT, 5))
    assert layers["encode1"].after == ("max pool 2×2", "ReLU")
    assert layers["decode1"].after == ("ReLU", "upsample 2×2")
    assert layers["output"].after == ()
    assert sum(layer.parameters for layer in layers.values()) == 10_346


def test_times_are_measured_and_drawn(monkeypatch):
    sizes = ((8, 8), (16, 16))
    assert (timing.measure(Sources(), sizes, runs=2) > 0).all()
    elapsed_ms = np.array([[64e-3, 1e-3, 99.0], [256e-3, 256e-3, 256e-3]])  # 1,000 ms a megapixel, in the median
    monkeypatch.setattr(timing, "measure", lambda *_: elapsed_ms)
    drawing = timing.draw_timing(Sources(), sizes, 3)
    (axes,) = drawing.figure.axes
    assert axes.get_xlim()[0] == axes.get_ylim()[0] == 0
    assert "1e+03 ms a megapixel" in [text.get_text() for text in axes.get_legend().get_texts()]
    assert f"threads: {bob.thread_count()}" in drawing.caption
    assert "16 x 16" in drawing.caption


# ---- files --------------------------------------------------------------------------------------------------


def simple_figure():
    with style():
        figure = new_figure(COLUMN, 1)
        axes = figure.subplots()
        axes.plot([0, 1], [0, 1])
        axes.set_xlabel("pixels & traced")
    return figure


def test_files_are_the_same_every_time(tmp_path):
    for name in "ab":
        save(simple_figure(), tmp_path / name, "a < b")
    for ending in (".svg", ".png"):
        assert (tmp_path / f"a{ending}").read_bytes() == (tmp_path / f"b{ending}").read_bytes()
    assert "pixels & traced" in texts(tmp_path / "a.svg")
    assert "a &lt; b" in (tmp_path / "a.svg").read_text()
    with Image.open(tmp_path / "a.png") as image:
        assert image.size == (COLUMN * DPI, DPI)
        assert image.info["Description"] == "a < b"


def test_matplotlibs_settings_stay(tmp_path):
    names = matplotlib.rcParams.keys() - {"backend"}  # set by the caller
    before = {name: matplotlib.rcParams[name] for name in names}
    save(simple_figure(), tmp_path / "a")
    assert {name: matplotlib.rcParams[name] for name in names} == before


def test_pixels_are_squares_of_whole_pixels(tmp_path):
    picture = np.random.default_rng(1).random((40, 60)).astype(np.float32)
    with style():
        figure, axes = picture_grid(2, 3, picture.shape, left=0.2)
        for panel in axes.flat:
            show_picture(panel, picture, "title")
    save(figure, tmp_path / "grid")
    with Image.open(tmp_path / "grid.png") as image:
        pixels = np.asarray(image.convert("L"))
    assert PAGE * DPI - 3 * 60 < pixels.shape[1] <= PAGE * DPI
    scale = int((PAGE - 0.2 - 0.1) / 3 * DPI) // 60
    large = np.kron(to_8_bit(picture), np.ones((scale, scale), np.uint8))
    np.testing.assert_array_equal(pixels[-40 * scale :, -60 * scale :], large)  # the last panel
    top = round(0.16 * DPI)
    np.testing.assert_array_equal(pixels[top : top + 40 * scale, 60 : 60 + 60 * scale], large)  # the first


def test_a_wide_picture_is_shrunk():
    figure, axes = picture_grid(1, 4, (100, 1000))
    assert figure.get_figwidth() == pytest.approx(PAGE)
    right_edges = [panel.get_position().x1 for panel in axes[0]]
    assert all(panel.get_position().x0 > edge for edge, panel in zip(right_edges, axes[0, 1:], strict=False))
    assert all(a < b for a, b in pairwise(right_edges))


# ---- all of them, and the command ---------------------------------------------------------------------------


def test_every_figure_is_written_or_left_out(tmp_path):
    lines = []
    captions = draw_figures(tmp_path / "out", Sources(size=16), only=["2.1", "4.2", "5.2"], report=lines.append)
    assert list(captions) == ["2.1", "4.2"]
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert written == {"figure-2.1.svg", "figure-2.1.png", "figure-4.2.svg", "figure-4.2.png"}
    assert len(lines) == 3
    assert lines[-1] == "figure 5.2 left out: it needs a data set (--data DIR)"
    assert "1 %" in texts(tmp_path / "out/figure-2.1.svg")
    assert "31,946" in texts(tmp_path / "out/figure-4.2.svg")


def test_names_are_in_the_reports_order():
    assert list(FIGURES)[:4] == ["2.1", "4.1", "4.2", "4.3"]
    assert tuple(FIGURES) == FIGURE_NAMES
    assert check_figures(["6.1", "2.1"]) == ["2.1", "6.1"]


def test_places_are_checked_before_anything_is_drawn(tmp_path, monkeypatch):
    def draw(sources: Sources) -> Drawing:
        raise AssertionError("drawn in vain")

    monkeypatch.setitem(figures.FIGURES, "2.1", draw)
    (tmp_path / "figure-2.1.png").mkdir()
    with pytest.raises(InputError, match="expected a file to write"):
        draw_figures(tmp_path, only=["2.1"])
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="can't make this folder"):
        draw_figures(tmp_path / "file")


def test_command(tmp_path, data, capsys):
    shape = tmp_path / "triangle.obj"
    shape.write_text("v 0 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")
    out = tmp_path / "out"
    arguments = ["figures", str(out), "--data", str(data.path), "--shape", str(shape), "--up", "y", "--only", "2.1,5.2"]
    assert cli.main(arguments) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in lines] == [f"wrote {out}/figure-{n}.svg and .png" for n in (2.1, 5.2)]
    assert "reference" in texts(out / "figure-5.2.svg")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "2.1,7.5"], "only: expected some of 2.1, 4.1"),
        (["--data", "nowhere"], "expected a data set"),
        (["--weights", "nothing"], "expected one of default, filling, paper"),
        (["--shape", "nowhere.obj"], "nowhere.obj"),
    ],
)
def test_mistakes_are_one_line(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["figures", "out", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()
