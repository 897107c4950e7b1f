"""What a training run logs: a row of log.csv for each epoch, and scalars and pictures for TensorBoard."""

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
"""An epoch in numbers, by column of log.csv."""

SSIM_COLUMNS = [f"ssim_{100 * stage:g}" for stage in STAGES]
COLUMNS = (
    "epoch",  # counted from 1
    "steps",  # mini-batches of the whole training so far
    "training_loss",  # mean over the epoch's samples, while the weights changed
    "validation_loss",
    "ssim",  # of the validation, mean of the stages
    *SSIM_COLUMNS,  # of the validation, at each percentage of traced pixels
    "seconds",  # with the validation
    "samples_per_second",  # without it
)


def write_csv(path: Path, rows: Sequence[Row]) -> None:
    """Write log.csv, whole or not at all."""
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: f"{value:.6g}" for name, value in row.items()} for row in rows)
    write_whole(path, text.getvalue().encode())


def epoch_line(row: Row) -> str:
    """Tell an epoch in one line."""
    stages = "  ".join(f"{100 * stage:g} % {row[name]:.4f}" for stage, name in zip(STAGES, SSIM_COLUMNS, strict=True))
    losses = f"loss {row['training_loss']:.4f}, in validation {row['validation_loss']:.4f}"
    speed = f"{row['seconds']:.0f} s, {row['samples_per_second']:.0f} samples/s"
    return f"epoch {row['epoch']:.0f}  {losses}  SSIM {row['ssim']:.4f}  {stages}  {speed}"


class Events:
    """TensorBoard's file of events in a folder, which is made when there is something to note.

    Parameters
    ----------
    run : folder
    steps : mini-batches done
        What an interrupted run wrote for later steps is discarded.
    """

    def __init__(self, run: Path, steps: int) -> None:
        self.run, self.steps = run, steps

    @lazy
    def _writer(self) -> Any:
        writer = SummaryWriter(str(self.run), purge_step=self.steps + 1, filename_suffix=f".{self.steps}")
        writer.flush()  # its head, so that it is a file of events even if the training is killed now
        return writer

    def scalars(self, values: Mapping[str, float], steps: int) -> None:
        """Note some numbers by their names, after so many steps."""
        for name, value in values.items():
            self._writer.add_scalar(name, value, steps)

    def picture(self, name: str, picture: NDArray[np.uint8], steps: int) -> None:
        """Note a picture, (H, W, 3) uint8."""
        self._writer.add_image(name, picture, steps, dataformats="HWC")

    def close(self) -> None:
        """Write out what is left."""
        if "_writer" in vars(self):
            self._writer.close()


def panels(partial: NDArray[np.float32], image: NDArray[np.float32], reference: NDArray[np.float32]) -> NDArray[Any]:
    """Return pictures below each other, each as partial, on green | completed | reference.

    Parameters
    ----------
    partial : (N, C, H, W) float32
        mask, gray and what else the network sees.
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
