"""Training from a configuration and a data set to a weight file; deterministic on a CPU.

A step is a function of the configuration, the data set and its number. A checkpoint holds the other state: weights,
their average, the optimizer's state, and the progress. So a resumed run gives the result of an uninterrupted one.

    RUN/config.json                the configuration and the data set's identity, written first
    RUN/checkpoint.safetensors     state for resuming
    RUN/weights.safetensors        of the epoch with the best validation
    RUN/log.csv                    a row for each epoch
    RUN/events.out.tfevents.*      scalars and pictures for TensorBoard
"""

from __future__ import annotations

import copy
import ctypes
import hashlib
import json
import logging
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lightning_fabric import Fabric
from numpy.typing import NDArray
from torch import Tensor, nn

from bobrossnet.completion.weights import weights_path
from bobrossnet.learn import checkpoint
from bobrossnet.learn.config import OPTIMIZERS, TrainConfig
from bobrossnet.learn.dataset.loader import Batch, Batches
from bobrossnet.learn.dataset.plan import STAGES
from bobrossnet.learn.dataset.store import Dataset
from bobrossnet.learn.logs import SSIM_COLUMNS, Events, Row, epoch_line, panels, write_csv
from bobrossnet.learn.losses import LOSSES, ssim
from bobrossnet.learn.networks import NETWORKS, Network
from bobrossnet.support.atomic import write_whole
from bobrossnet.support.errors import InputError
from bobrossnet.support.interrupts import interrupt
from bobrossnet.support.paths import path_of
from bobrossnet.support.progress import progress

WEIGHTS, CHECKPOINT, CONFIG, LOG = "weights.safetensors", "checkpoint.safetensors", "config.json", "log.csv"
PICTURES = 4  # validation patches shown at each stage

logging.getLogger("lightning_fabric").setLevel(logging.ERROR)  # here, so that its child processes are quiet too


@dataclass
class Progress:
    """The progress of a training run."""

    epoch: int = 0  # epochs done, including validation
    step: int = 0  # mini-batches done in the current epoch
    loss: float = 0.0  # sum over the current epoch's samples so far
    seconds: float = 0.0  # spent on the current epoch so far, without validation
    rows: list[Row] = field(default_factory=list)  # rows of log.csv

    def best(self) -> int:
        """Return the first epoch with the best validation, counted from 1; 0 before the first."""
        scores = [row["ssim"] for row in self.rows]
        return scores.index(max(scores)) + 1 if scores else 0

    def finished(self, config: TrainConfig) -> bool:
        """Return whether training is complete."""
        return self.epoch >= config.epochs or self.epoch - self.best() >= config.patience


def train(config: TrainConfig, dataset: Dataset, run: str | os.PathLike[str]) -> None:
    """Train a network, or resume its training.

    Parameters
    ----------
    config : TrainConfig
    dataset : Dataset, whole
    run : folder
        Created if missing. If it holds a checkpoint of the same run, that run is resumed.

    Raises
    ------
    InputError
        Before any work: if the folder can't be written to, the network does not accept the settings, the checkpoint
        belongs to another training run, or the device does not exist.
    KeyboardInterrupt
        On Ctrl-C. The last checkpoint is kept.
    """
    run = path_of(run, "run")
    for name in (WEIGHTS, CHECKPOINT, CONFIG, LOG):
        checkpoint.make_place(run / name)
    gpus = torch.cuda.device_count()
    accelerator = ("cuda" if gpus else "cpu") if config.accelerator == "auto" else config.accelerator
    if accelerator == "cuda" and config.devices > gpus:
        raise InputError(f"devices: expected at most this machine's {gpus} GPUs, got {config.devices}")
    _first_network(config)  # checks the settings
    header = _header(config, dataset)
    if (run / CHECKPOINT).exists():
        checkpoint.read_progress(run / CHECKPOINT, header)
    write_whole(run / CONFIG, (json.dumps(header, indent=2) + "\n").encode())

    fabric = Fabric(
        accelerator=accelerator,
        devices=config.devices,
        strategy="ddp_spawn" if config.devices > 1 else "auto",
        precision=config.precision,  # type: ignore[arg-type]
    )
    try:
        fabric.launch(partial(_train, config=config, dataset=dataset, run=run))  # Fabric inspects other arguments
    except KeyboardInterrupt:
        if config.devices > 1:
            for process in multiprocessing.active_children():
                interrupt(process)
        raise KeyboardInterrupt(f"{run}: the same command resumes from the last checkpoint") from None


def _train(fabric: Fabric, config: TrainConfig, dataset: Dataset, run: Path) -> None:
    """Run the training in each process."""
    torch.set_num_threads(config.threads)
    torch.manual_seed(config.seed)
    _keep_memory()
    training = _Training(fabric, config, dataset, run)
    try:
        while not training.progress.finished(config):
            training.epoch()
        training.finish()
    finally:
        training.close()


class _Training:
    """A process's part in a training run. Only the first process prints, logs and writes."""

    def __init__(self, fabric: Fabric, config: TrainConfig, dataset: Dataset, run: Path) -> None:
        self.fabric, self.config, self.dataset, self.run = fabric, config, dataset, run
        make_optimizer, self.learning_rate = OPTIMIZERS[config.optimizer]
        self.plain = _first_network(config)
        self.plain.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.average = copy.deepcopy(self.plain).to(fabric.device).requires_grad_(False)
        # Shares the plain network's weights; its backward pass averages over the processes.
        self.network, self.optimizer = fabric.setup(self.plain, make_optimizer(self.plain, config))

        self.header = _header(config, dataset)
        self.progress = Progress()
        if (run / CHECKPOINT).exists():
            self.progress = Progress(**checkpoint.read_progress(run / CHECKPOINT, self.header))
            checkpoint.load_checkpoint(run / CHECKPOINT, self._networks(), self.optimizer)
        self.steps = len(self._batches("train"))  # mini-batches of an epoch
        self.events = Events(run, self._steps_done()) if fabric.is_global_zero else None
        if self.events and self._steps_done():
            epochs, steps = self.progress.epoch, self.progress.step
            print(f"{run}: resuming after {epochs} epochs and {steps} of {self.steps} steps", flush=True)

    def epoch(self) -> None:
        """Finish the epoch, validate, and write all files."""
        now, config = self.progress, self.config
        batches = self._batches(
            "train", epoch=now.epoch, seed=config.seed, draw=config.draw, fractions=config.fractions
        )  # fmt: skip
        validation = self._batches("validation", shuffle=False)
        whole = self.steps + len(validation) / 3  # validation lacks the backward pass, the longer one
        last = f", SSIM {' '.join(f'{now.rows[-1][name]:.3f}' for name in SSIM_COLUMNS)}" if now.rows else ""
        what = f"epoch {now.epoch + 1} of at most {config.epochs}"
        start, loss, samples = time.monotonic(), 0.0, 0  # since the last checkpoint
        with progress(what) if self.events else nullcontext(_silent) as report:
            for batch in batches.stream(now.step, config.workers):
                count = min(config.batch, len(batches.samples) - now.step * config.batch)  # samples of all processes
                losses = self._step(batch, count)
                now.step += 1
                loss, samples = loss + losses.sum().item(), samples + count
                report(now.step / whole, f"loss {losses.mean():.4f}{last}")
                if now.step % config.checkpoint_every == 0 or now.step == self.steps:
                    loss = self._sum(torch.tensor(loss, dtype=torch.float64)).item()
                    if self.events:
                        self.events.scalars({"training/loss": loss / samples}, self._steps_done())
                    now.loss += loss
                    now.seconds += time.monotonic() - start
                    start, loss, samples = time.monotonic(), 0.0, 0
                    self._save()
            scores = self._validate(validation, lambda done: report((self.steps + done / 3) / whole))
        now.epoch, now.step = now.epoch + 1, 0
        row: Row = {
            "epoch": now.epoch,
            "steps": now.epoch * self.steps,
            "training_loss": now.loss / len(batches.samples),
            **scores,
            "seconds": now.seconds + time.monotonic() - start,
            "samples_per_second": len(batches.samples) / now.seconds,
        }
        now.rows.append(row)
        now.loss = now.seconds = 0.0
        if self.events:
            self.events.scalars({f"validation/{name}": value for name, value in scores.items()}, self._steps_done())
            for name, picture in self._pictures():
                self.events.picture(name, picture, self._steps_done())
            if now.best() == now.epoch:
                self._save_weights()
            left = (config.epochs - now.epoch) * row["seconds"] / 3600
            print(f"{epoch_line(row)}, at most {left:.1f} h left", flush=True)
        self._save()

    def finish(self) -> None:
        """Complete all files, even if an earlier run was interrupted between two of them."""
        if self.events:
            if not self.progress.rows:
                self._save_weights()
            write_csv(self.run / LOG, self.progress.rows)
            print(f"wrote {self.run / WEIGHTS}: epoch {self.progress.best()} of {self.progress.epoch}", flush=True)

    def close(self) -> None:
        """Flush TensorBoard's file."""
        if self.events:
            self.events.close()

    def _step(self, batch: Batch, count: int) -> Tensor:
        """Take one step and return the losses of this process's samples, (n,); `count` covers all processes."""
        config, done = self.config, self._steps_done()
        for group in self.optimizer.param_groups:
            group["lr"] = self.learning_rate(config, done / (config.epochs * self.steps), done)
        partial, reference = self._tensors(batch)
        image = self.network(partial).float()
        if config.keep_known:
            image = keep_known_of_partial(image, partial)
        losses = LOSSES[config.loss](image, reference)
        self.optimizer.zero_grad()
        # The mean over the samples of all processes, which may have different numbers of samples.
        self.fabric.backward(losses.sum() * (self.fabric.world_size / count))
        self.optimizer.step()
        follow(self.average, self.plain, config.average, done + 1)
        return losses.detach()

    @torch.no_grad()
    def _validate(self, batches: Batches, report: Callable[[int], object]) -> dict[str, float]:
        """Return the moving average's mean validation loss and SSIM, and the SSIM of each stage."""
        sums = torch.zeros(3, len(STAGES), dtype=torch.float64)  # sums of loss and SSIM, and sample counts, by stage
        for done, batch in enumerate(batches.stream(0, self.config.workers)):
            partial, reference = self._tensors(batch)
            image = self._complete(partial)
            losses = LOSSES[self.config.loss](image, reference)
            scores = torch.stack([losses, ssim(image.clamp(0, 1), reference), torch.ones_like(losses)])  # (3, n)
            of_stage = torch.from_numpy(batch.fractions[:, None] == np.array(STAGES)).double()  # (n, S)
            sums += scores.cpu().double() @ of_stage
            report(done + 1)
        loss, similarity, count = self._sum(sums)
        by_stage = dict(zip(SSIM_COLUMNS, (similarity / count).tolist(), strict=True))
        total = float(count.sum())
        return {"validation_loss": float(loss.sum()) / total, "ssim": float(similarity.sum()) / total, **by_stage}

    @torch.no_grad()
    def _pictures(self) -> Iterator[tuple[str, NDArray[np.uint8]]]:
        """Yield a picture of several validation patches for each stage, with its name."""
        # Without a shuffle, a patch's samples at all stages are consecutive.
        batches = Batches(
            self.dataset, "validation", size=len(STAGES), shuffle=False, order=self.config.order
        )  # fmt: skip
        steps = np.linspace(0, len(batches) - 1, min(PICTURES, len(batches))).astype(int).tolist()
        parts = [
            (partial, self._complete(partial), reference)
            for partial, reference in (self._tensors(batches[step]) for step in steps)
        ]
        for i, stage in enumerate(STAGES):
            of_stage = [torch.stack([part[i] for part in kind]).cpu().numpy() for kind in zip(*parts, strict=True)]
            yield f"validation/{100 * stage:g}_percent", panels(*of_stage)

    def _complete(self, partial: Tensor) -> Tensor:
        """Complete partial pictures by the moving average, (N, C, H, W) → (N, 1, H, W), not clamped."""
        with self.fabric.autocast():
            image: Tensor = self.average(partial).float()
        return keep_known_of_partial(image, partial) if self.config.keep_known else image

    def _tensors(self, batch: Batch) -> tuple[Tensor, Tensor]:
        """Return a mini-batch's partial pictures and references on this process's device, channels last."""
        device = self.fabric.device
        return batch.partial.to(device, memory_format=torch.channels_last), batch.reference.to(device)

    def _batches(self, split: str, **options: Any) -> Batches:
        """Return this process's mini-batches of a split."""
        config, fabric = self.config, self.fabric
        return Batches(
            self.dataset, split, size=config.batch, order=config.order,
            rank=fabric.global_rank, ranks=fabric.world_size, **options,
        )  # fmt: skip

    def _sum(self, values: Tensor) -> Tensor:
        """Return the sum over the processes, on the CPU."""
        total = self.fabric.all_reduce(values.to(self.fabric.device), reduce_op="sum")
        assert isinstance(total, Tensor)  # as the input
        return total.cpu()

    def _steps_done(self) -> int:
        return self.progress.epoch * self.steps + self.progress.step

    def _networks(self) -> dict[str, Network]:
        return {"network": self.plain, "average": self.average}

    def _save(self) -> None:
        if self.events:
            header = {**self.header, "progress": asdict(self.progress)}
            checkpoint.save_checkpoint(self.run / CHECKPOINT, self._networks(), self.optimizer, header)
            write_csv(self.run / LOG, self.progress.rows)

    def _save_weights(self) -> None:
        metadata = {"epoch": str(self.progress.epoch), "training": json.dumps(asdict(self.config))}
        checkpoint.save(self.run / WEIGHTS, self.average, metadata)


@torch.no_grad()
def follow(average: nn.Module, network: nn.Module, decay: float, steps: int) -> None:
    """Move the averaged weights towards the network's, after `steps` steps.

    The decay is at most (1 + steps) / (10 + steps), as in TensorFlow's ExponentialMovingAverage, so that the initial
    weights are soon forgotten.
    """
    decay = min(decay, (1 + steps) / (10 + steps))
    for mine, theirs in zip(average.parameters(), network.parameters(), strict=True):
        mine.lerp_(theirs, 1 - decay)


def keep_known(image: Tensor, partial: Tensor) -> Tensor:
    """Return pictures, (N, 1, H, W), with the traced pixels restored.

    Unlike the core's function of this name it does not clamp the other pixels: a loss needs their full error.
    """
    return torch.where(partial[:, :1] > 0, partial[:, 1:2], image)


def keep_known_of_partial(image: Tensor, partial: Tensor) -> Tensor:
    """Restore the traced pixels, except in wholly traced pictures, which would then teach the network nothing."""
    whole = partial[:, :1].amin((1, 2, 3), keepdim=True) > 0  # (N, 1, 1, 1)
    return torch.where(whole, image, keep_known(image, partial))


def _silent(share: float, note: str = "") -> None:
    """Ignore progress, in all processes except the first."""


def _keep_memory() -> None:
    """Keep freed memory in this process. Only glibc supports this; elsewhere nothing changes.

    Returning large tensors to the system and allocating them again took a fifth of each step.
    """
    trim_threshold, mmap_max = -1, -4  # constants of malloc.h
    with suppress(OSError, AttributeError):
        libc = ctypes.CDLL("libc.so.6")
        libc.mallopt(mmap_max, 0)
        libc.mallopt(trim_threshold, -1)  # never


def _first_network(config: TrainConfig) -> Network:
    """Return the network at the start of training."""
    if not config.start:
        return NETWORKS[config.network].from_settings(asdict(config))
    network, _ = checkpoint.load(weights_path(config.start))
    wanted = NETWORKS[config.network]
    if type(network) is not wanted or any(getattr(config, name) != value for name, value in network.settings().items()):
        raise InputError(f"start: expected weights of network={config.network} with these settings, got {config.start}")
    return network


def _header(config: TrainConfig, dataset: Dataset) -> dict[str, dict[str, Any]]:
    """Return all inputs of a training run as JSON values: the configuration and the data set's identity."""
    sources = hashlib.sha256("\n".join(dataset.sources).encode()).hexdigest()
    # Omit empty fields, as in data sets older than these fields.
    plan = {name: value for name, value in asdict(dataset.plan).items() if value or name != "colored"}
    header = {"training": asdict(config), "dataset": {**plan, "sources": sources}}
    if config.start:
        header["start"] = {"sha256": hashlib.sha256(weights_path(config.start).read_bytes()).hexdigest()}
    return header
