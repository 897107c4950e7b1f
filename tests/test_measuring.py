"""Measuring by few dwells: the page's microscope, and the example."""

import re
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def example():
    return run_path(str(ROOT / "examples/measuring.py"))


def test_the_microscope_of_the_page_stops():
    (microscope,) = re.findall(r"```python\n(.*?)```", (ROOT / "docs/measuring.md").read_text(), re.DOTALL)
    names = {}
    exec(microscope.replace(".repeat(20, 0).repeat(20, 1)", ".repeat(5, 0).repeat(5, 1)"), names)
    assert names["frame"].error <= 0.02


def test_a_sample_is_measured_until_its_error_is_small(example, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    example["measure"]()
    dwells, *_, predicted, _, _, _ = capsys.readouterr().out.splitlines()[-1].split()
    assert float(predicted) <= example["ENOUGH"]
    assert int(dwells) < 0.2 * example["SIZE"][0] * example["SIZE"][1]
    assert (tmp_path / "measuring.png").exists()


def test_placing_beats_uniform_places(example, tmp_path, capsys):
    image = tmp_path / "flakes.png"
    Image.fromarray(np.rint(255 * example["flakes"]()).astype(np.uint8)).save(image)
    example["compare"](str(image))
    uniform, adaptive = map(float, re.findall(r", 10 %: NRMSE ([\d.]+),", capsys.readouterr().out))
    assert adaptive < uniform
