"""The data set: stored views of many shapes, and the training samples cut from them."""

from bobrossnet.learn.dataset.plan import Plan
from bobrossnet.learn.dataset.store import Dataset

__all__ = ["Dataset", "Plan"]
