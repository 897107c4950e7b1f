"""Logs of a training run: log.csv with a row for each epoch, and scalars and pictures for TensorBoard."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tensorboardX import SummaryWriter

from bobrossnet.learn.dataset.plan import STAGES
from bobrossnet.picture.files import UNTRACED, to_8_bit
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.threads import lazy

Row = dict[str, float]
"""An epoch's numbers, by column of log.csv."""

SSIM_COLUMNS = [f"ssim_{100 * stage:g}" for stage in STAGES]
COLUMNS = (
    "epoch",  # counted from 1
    "steps",  # mini-batches since the start of training
    "training_loss",  # mean over the epoch's samples, during its weight updates
    "validation_loss",
    "ssim",  # of the validation, mean over the stages
    *SSIM_COLUMNS,  # of the validation, at each percentage of traced pixels
    "seconds",  # including validation
    "samples_per_second",  # excluding validation
)


def write_csv(path: Path, rows: Sequence[Row]) -> None:
    """Write log.csv; a failed write leaves the old file."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: f"{value:.6g}" for name, value in row.items()} for row in rows)
    write_whole(path, text.getvalue().encode())


def epoch_line(row: Row) -> str:
    """Return an epoch's numbers as one line of text."""
    stages = "  ".join(f"{100 * stage:g} % {row[name]:.4f}" for stage, name in zip(STAGES, SSIM_COLUMNS, strict=True))
    losses = f"loss {row['training_loss']:.4f}, in validation {row['validation_loss']:.4f}"
    speed = f"{row['seconds']:.0f} s, {row['samples_per_second']:.0f} samples/s"
    return f"epoch {row['epoch']:.0f}  {losses}  SSIM {row['ssim']:.4f}  {stages}  {speed}"


class Events:
    """TensorBoard's event file in a folder, created at the first event.

    Parameters
    ----------
    run : folder
    steps : mini-batches done
        An interrupted run's events for later steps are discarded.
    """

    def __init__(self, run: Path, steps: int) -> None:
        self.run, self.steps = run, steps

    @lazy
    def _writer(self) -> Any:
        writer = SummaryWriter(str(self.run), purge_step=self.steps + 1, filename_suffix=f".{self.steps}")
        writer.flush()  # its header, so that it is valid even if the training is killed now
        return writer

    def scalars(self, values: Mapping[str, float], steps: int) -> None:
        """Log numbers by name, for the given number of steps done."""
        for name, value in values.items():
            self._writer.add_scalar(name, value, steps)

    def picture(self, name: str, picture: NDArray[np.uint8], steps: int) -> None:
        """Log a picture, (H, W, 3) uint8."""
        self._writer.add_image(name, picture, steps, dataformats="HWC")

    def close(self) -> None:
        """Flush and close the event file."""
        if "_writer" in vars(self):
            self._writer.close()


def panels(partial: NDArray[np.float32], image: NDArray[np.float32], reference: NDArray[np.float32]) -> NDArray[Any]:
    """Return a column of pictures, each as partial over green | completed | reference.

    Parameters
    ----------
    partial : (N, C, H, W) float32
        mask, gray and the network's further inputs.
    image, reference : (N, 1, H, W) float32, shown clamped to 0..1

    Returns
    -------
    (N H, 3 W, 3) uint8
    """
    traced, gray, completed, whole = (
        to_8_bit(x)[..., None] for x in (*partial[:, :2].swapaxes(0, 1), image[:, 0], reference[:, 0])
    )
    on_green = np.where(traced > 0, gray, np.array(UNTRACED, np.uint8))  # (N, H, W, 3)
    row = np.concatenate([on_green, *(np.repeat(x, 3, -1) for x in (completed, whole))], 2)  # (N, H, 3 W, 3)
    return row.reshape(-1, *row.shape[2:])
