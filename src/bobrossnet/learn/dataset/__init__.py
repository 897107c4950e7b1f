"""The data set: views of many shapes on disk, and the samples that are made of them when they are read."""

from bobrossnet.learn.dataset.plan import Plan
from bobrossnet.learn.dataset.store import Dataset

__all__ = ["Dataset", "Plan"]
