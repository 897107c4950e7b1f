"""SparseBench: its pictures, its entries, its results, its page, at toy size."""

import json
import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet import InputError

ROOT = Path(__file__).parent.parent
BENCH = ROOT / "bench/sparse"
SIZE = (32, 32)
SHARES = (0.05, 0.25)


@pytest.fixture(scope="module")
def bench():
    """Return the benchmark's modules by name."""
    names = ("protocol", "inputs", "asking", "methods", "measure", "page", "run")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(BENCH)
        yield {name: import_module(name) for name in names}


@pytest.fixture
def toy(bench):
    """Measure an entry on two small pictures."""
    before = bob.thread_count()

    def measured(name, limit=2):
        return bench["measure"].measure(*bench["methods"].entry_of(str(name)), "made", limit, shares=SHARES, size=SIZE)

    yield measured
    bob.set_thread_count(before)


def examples():
    """Return the examples of methods in the README."""
    return re.findall(r"```python\n(.*?)```", (BENCH / "README.md").read_text(), re.DOTALL)


def test_the_protocol_is_as_the_readme_says(bench):
    protocol, text = bench["protocol"], (BENCH / "README.md").read_text()
    assert f"## Protocol {protocol.VERSION}\n" in text
    shares = [f"{100 * share:g}" for share in protocol.SHARES]
    assert f"**Shares** of known pixels: {', '.join(shares)} %" in text
    assert f"{protocol.SIZE[1]}x{protocol.SIZE[0]}" in text
    assert all(f"`{mask}`" in text for mask in protocol.MASKS)
    assert f"{protocol.ORBIT_FRAMES} frames with steps of {protocol.ORBIT_STEP:g} degrees" in text


def test_pictures_are_made_by_seed(bench):
    made = list(bench["inputs"].made(5, SIZE))
    assert [picture.name.split()[0] for picture in made] == list(bench["protocol"].KINDS)
    again = list(bench["inputs"].made(5, SIZE))
    assert all(a.full == b.full for a, b in zip(made, again, strict=True))
    assert all(picture.full.mask.all() and picture.full.alpha.any() for picture in made)
    assert "albedo" in made[2].full.channels


def test_examples_of_methods_are_measured(bench, toy, tmp_path):
    for name, code in zip(("given.py", "free.py"), examples(), strict=True):
        (tmp_path / name).write_text(code)
    assert len(examples()[0].strip().splitlines()) - examples()[0].count("\n\n") <= 12
    given, free = toy(tmp_path / "given.py"), toy(tmp_path / "free.py")
    assert list(given["masks"]) == ["uniform", "lattice"]
    assert list(free["masks"]) == ["free"]
    for of_mask in (*given["masks"].values(), *free["masks"].values()):
        assert np.shape(of_mask["ssim"]) == np.shape(of_mask["ms"]) == (2, 2)
        assert np.shape(of_mask["flicker"]) == (1,)
    assert np.mean(given["masks"]["lattice"]["ssim"]) > np.mean(free["masks"]["free"]["ssim"])


def test_onnx_files_are_methods(bench, toy, tmp_path):
    """A network that returns the second plane: the known pixels, and black elsewhere."""
    import onnx

    weights = onnx.helper.make_tensor("weights", onnx.TensorProto.FLOAT, (1, 2, 1, 1), [0.0, 1.0])
    sizes = [
        onnx.helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, (1, planes, "H", "W"))
        for name, planes in (("gbuffer", 2), ("gray", 1))
    ]
    node = onnx.helper.make_node("Conv", ["gbuffer", "weights"], ["gray"])
    graph = onnx.helper.make_graph([node], "known", sizes[:1], sizes[1:], [weights])
    opset = onnx.helper.make_opsetid("", 17)
    onnx.save(onnx.helper.make_model(graph, opset_imports=[opset], ir_version=9), tmp_path / "known.onnx")
    found = toy(tmp_path / "known.onnx", 1)
    full = next(bench["inputs"].made(1, SIZE)).full
    expected = bob.psnr(full.sample(SHARES[0], order="lattice").gray, full.gray)
    assert found["masks"]["lattice"]["psnr"][0][0] == pytest.approx(expected, rel=1e-5)


def test_every_entry_of_ours_runs(bench, toy):
    optional = {"progiso", "FAST", "oidn of nearest", "biharmonic", "telea"}
    for name, entry in bench["methods"].ENTRIES.items():
        if name not in optional:
            found = toy(name, 1)["masks"]
            assert list(found) == (["free"] if entry.places else ["uniform", "lattice"])
            assert all(0 < score <= 1 for of_mask in found.values() for row in of_mask["ssim"] for score in row)


def test_pixels_beyond_the_budget_are_refused(bench):
    full = next(bench["inputs"].made(1, SIZE)).full
    ask = bench["asking"].Ask(full, 0.01)
    pixels = bob.pixel_order(SIZE)[: ask.budget]
    ask(pixels)
    assert np.array_equal(ask(pixels).gray, full.gray[tuple(pixels.T)])  # asking again is free
    with pytest.raises(InputError, match="pixels: expected at most 10 distinct ones, got 11"):
        ask(bob.pixel_order(SIZE)[10:11])


def test_missing_files_and_wrong_names_are_reasons(bench, monkeypatch, tmp_path):
    monkeypatch.delenv("SPARSEBENCH_PROGISO", raising=False)
    reason, _ = bench["run"].measured("progiso", "made", 1, [])
    assert reason.startswith("SPARSEBENCH_PROGISO: expected a path")
    with pytest.raises(InputError, match=r"methods: expected files ending in .*, or some of default"):
        bench["methods"].entry_of("oil")
    (tmp_path / "empty.py").write_text("")
    with pytest.raises(InputError, match=r"expected a function complete\(part\) or place\(ask\), got neither"):
        bench["methods"].entry_of(str(tmp_path / "empty.py"))
    with pytest.raises(InputError, match="measured: expected image files in --images, got none"):
        next(bench["inputs"].pictures("measured", 1))


def test_image_files_are_measured(bench, toy, tmp_path):
    import cv2

    y, x = np.indices((40, 60))
    cv2.imwrite(str(tmp_path / "a.tif"), 5 + np.sin(x / 9.0) * y)
    (picture,) = bench["inputs"].pictures("measured", 1, [str(tmp_path / "a.tif")])
    assert picture.full.gray.shape == (40, 60)
    assert (picture.full.gray.min(), picture.full.gray.max()) == (0, 1)


def test_results_become_a_page(bench, toy, tmp_path, monkeypatch):
    monkeypatch.setattr(bench["protocol"], "ORBIT_SHARE", 0.05)
    for name in ("default", "nearest", "delaunay-linear", "adaptive, filling", "adaptive, delaunay-linear"):
        bench["run"].write(tmp_path, name, "made", toy(name))
    slow = toy("pull-push", 1)
    bench["run"].write(tmp_path, "pull-push", "made", slow)
    text = bench["page"].page([*bench["page"].read_results(tmp_path)])
    assert "| method" in text
    assert "slow methods included" in text
    assert "change from delaunay-linear with the same mask" in text
    assert "change from adaptive, delaunay-linear" in text
    file = tmp_path / "nearest.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "protocol": 0}))
    with pytest.raises(InputError, match=r"nearest\.json: expected protocol \d+, got 0"):
        bench["page"].read_results(tmp_path)


def test_the_page_is_current(bench):
    page = bench["page"]
    assert page.PAGE.read_text("utf-8") == page.page(page.read_results(page.RESULTS)), "run bench/sparse/run.py --page"
