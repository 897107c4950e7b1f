"""Learning: networks, losses, shapes to learn from, training, evaluation. Torch is imported only here."""

import os

# torch's OpenMP threads spin while they wait. On two cores shared with other programs a training step of 8 patches
# took 1,042 ms; with threads that sleep 298 ms, with a single thread 247 ms. Read when torch is first imported.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
