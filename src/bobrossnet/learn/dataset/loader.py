"""Mini-batches of a data set, shuffled, from disk, any of them by its number.

An epoch goes through the shapes in blocks: the patches of some shapes are read, and their samples are shuffled among
each other. So a view is read once an epoch, instead of a patch at a time, at a few milliseconds each; and a mini-batch
is a function of (seed, epoch, step), whoever makes it.
"""

from __future__ import annotations
