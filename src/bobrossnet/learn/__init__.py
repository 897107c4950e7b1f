"""Learning: networks, losses, training shapes, training, evaluation. Only this package imports torch."""

import os

# torch's OpenMP threads spin while they wait. On two cores shared with other programs a training step of 8 patches took
# 1,042 ms; with sleeping threads 298 ms, with a single thread 247 ms. The variable is read at torch's first import.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
