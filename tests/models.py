"""The folder of shared models, for tests that read them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

MODELS = Path(os.environ.get("BOBROSSNET_MODELS", Path(__file__).parents[2] / "shared" / "models"))

needs_models = pytest.mark.skipif(
    not MODELS.is_dir(), reason=f"no models at {MODELS}; name their folder in BOBROSSNET_MODELS"
)
