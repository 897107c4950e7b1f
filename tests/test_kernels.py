"""Properties of the compiled kernels and of the networks, besides their results."""

import shutil
import subprocess
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from instruction_set import best_instruction_set

from bobrossnet import _core
from bobrossnet.learn import networks
from bobrossnet.support.machine import extra_memory

BUILD = Path(__file__).parent.parent / "build/native"
OBJECTS = sorted(
    file for isa in ("baseline", "avx2", "avx512") for file in BUILD.glob(f"CMakeFiles/bobrossnet_{isa}.dir/**/*.o")
)


def test_the_best_instruction_set_of_the_machine_is_in_use():
    """A wrong choice would be silent: equal pictures, at half the speed."""
    best = best_instruction_set()
    if best is None:
        pytest.skip("needs Linux on x86-64, which lists the processor's features")
    assert _core.isa() == best


def kernels_of(file):
    """Return the folder of an instruction set's objects."""
    return next(part for part in file.parts if part.startswith("bobrossnet_"))


@pytest.mark.skipif(
    not BUILD.is_dir() or shutil.which("nm") is None, reason="needs nm, and the package built here by make"
)
def test_kernels_share_no_code():
    """The linker keeps one copy of a function emitted by several objects: perhaps one with AVX-512, on any machine."""
    of_each = Counter(kernels_of(file) for file in OBJECTS)
    assert of_each
    assert len(set(of_each.values())) == 1, of_each
    for file in OBJECTS:
        symbols = subprocess.run(["nm", "--demangle", str(file)], capture_output=True, text=True, check=True).stdout
        assert "kernels" in symbols
        # Symbols in the instruction set's namespace are unique; a pointer to the C++ runtime is no code.
        own = f"bob::{kernels_of(file).removeprefix('bobrossnet_').removesuffix('.dir')}::"
        shared = [line for line in symbols.splitlines() if line[17:18] in "WVu" and own not in line]
        assert not [line for line in shared if "DW.ref.__gxx_personality" not in line], file


@pytest.mark.measures
@pytest.mark.parametrize("name", networks.NETWORKS)
def test_a_4k_picture_needs_32_mb(name):
    """In addition to the input and output, with pages touched in advance."""
    tensors = networks.NETWORKS[name]().state_dict()
    layout, inputs = _core.gbuffer_layout(), _core.Layout(networks.NETWORKS[name].inputs)
    arrays = {key: tensor.numpy() for key, tensor in tensors.items()}
    network = _core.Network(name, arrays, inputs, _core.Layout("gray"))
    stack, gray = np.ones((5, 2160, 3840), np.float32), np.full((1, 2160, 3840), 2, np.float32)
    needed = extra_memory(lambda: network(layout, stack, gray))
    if needed is None:
        pytest.skip("this system does not report how much memory a process needs")
    assert needed < 32 * 2**20
    assert (gray != 2).any()
