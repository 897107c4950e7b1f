import pytest

import bobrossnet as bob


@pytest.fixture(scope="session")
def tree():
    """The built-in scene."""
    return bob.Scene(bob.happy_tree())


@pytest.fixture
def every_instruction_set():
    """The instruction sets of this machine; whichever a test has set, the best is in use again after it."""
    from bobrossnet import _core

    best = _core.isa()
    yield [name for name in ("baseline", "avx2", "avx512") if _core.set_isa(name)]
    _core.set_isa(best)
