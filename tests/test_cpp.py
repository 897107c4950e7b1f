"""The core as a C++ library: the example of docs/how-to/cpp.md."""

import os
import platform
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from bobrossnet.metrics import ssim

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def preview(tmp_path_factory):
    """Return the example as a program that writes preview.pgm to its folder."""
    library = next((file for build in ("native", "dev") if (file := ROOT / f"build/{build}/libcore.a").is_file()), None)
    compiler = os.environ.get("CXX") or shutil.which("c++")
    if library is None or compiler is None:
        pytest.skip("no compiler, or no build of the core in build/")
    program = tmp_path_factory.mktemp("cpp") / "preview"
    strict = ["-std=c++20", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    if platform.machine() in ("x86_64", "AMD64"):
        strict.append("-DBOB_X86")
    source = [ROOT / "examples/cpp/preview.cpp", "-I", ROOT / "core"]
    subprocess.run([compiler, *strict, *source, library, "-pthread", "-o", program], check=True)
    return program


def picture(program, *arguments):
    subprocess.run([program, *arguments], cwd=program.parent, check=True)
    head, pixels = (program.parent / "preview.pgm").read_bytes().split(b"\n", 1)
    assert head == b"P5 640 480 255"
    return np.frombuffer(pixels, np.uint8).reshape(480, 640).astype(np.float32) / 255


def test_the_example_completes_a_tracer_of_its_own(preview):
    few, all_of_them = picture(preview), picture(preview, "1")
    assert all_of_them.std() > 0.2
    assert ssim(few, all_of_them) > 0.97
    assert (few != all_of_them).mean() > 0.05  # many pixels were completed
