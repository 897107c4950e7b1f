"""Networks as ONNX: results of another runtime."""

import subprocess
import sys

import numpy as np
import onnxruntime
import pytest

import bobrossnet as bob
from bobrossnet.completion.network import load_network


def test_onnx_equals_the_core(tree, tmp_path):
    file = tmp_path / "paper.onnx"
    bob.export("paper", file)
    session = onnxruntime.InferenceSession(file, providers=["CPUExecutionProvider"])
    for size in ((64, 96), (61, 47), (3, 5)):
        part = bob.trace(tree, size=size, fraction=0.2)
        (gray,) = session.run(["gray"], {"gbuffer": part.stack()[None]})
        assert gray.shape == (1, 1, *size)
        assert np.abs(gray[0, 0] - load_network("paper").predict(part)).max() < 1e-5


def test_mistakes_are_named(tmp_path):
    with pytest.raises(bob.InputError, match="model: expected one of"):
        bob.export("oil", tmp_path / "oil.onnx")
    with pytest.raises(bob.InputError, match="can't write it"):
        bob.export("paper", tmp_path / "no" / "paper.onnx")
    assert not list(tmp_path.iterdir())


def test_a_missing_torch_is_named():
    code = "import sys; sys.modules['torch'] = None; import bobrossnet as bob; bob.export('paper', 'paper.onnx')"
    failed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "InputError: export: this needs torch: pip install 'bobrossnet[train]'" in failed.stderr
