"""Training at toy size: it learns, resumes after interruption, and logs its progress."""

import copy
import csv
import hashlib
import json
import math
import struct
from collections.abc import Iterator
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from tensorboardX.proto.event_pb2 import Event

from bobrossnet.command_line import cli
from bobrossnet.learn import checkpoint, logs
from bobrossnet.learn import train as training
from bobrossnet.learn.config import OPTIMIZERS, TrainConfig, config_from_settings
from bobrossnet.learn.dataset import Dataset, Plan
from bobrossnet.learn.dataset.plan import SIZES
from bobrossnet.learn.muon import orthogonal
from bobrossnet.learn.train import CHECKPOINT, CONFIG, LOG, WEIGHTS, follow, keep_known, keep_known_of_partial, train
from bobrossnet.support.errors import InputError

TOY = TrainConfig(epochs=2, batch=8, checkpoint_every=2, threads=1)
STEPS = 4  # of an epoch: 29 samples, so that two processes have different shares of the last mini-batch


class SmallPlan(Plan):
    """A few of the samples, for a short epoch."""

    def split(self, name: str) -> Any:
        return super().split(name)[: 29 if name == "train" else 10]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a complete data set of two shapes, balls."""
    path = tmp_path_factory.mktemp("data")
    dataset = Dataset.create(path, Plan(shapes=2, test_shapes=1), ["ball", "larger ball"])
    for shape in range(2):
        for size in SIZES:
            y, x = np.mgrid[:size, :size] / size * 2 - 1
            height = (0.5 + 0.3 * shape) ** 2 - x**2 - y**2
            dataset.write(shape, size, (np.stack([0.1 + height, 0.5 + height / 2, x, y]) * (height > 0)).astype("f2"))
    return path


@pytest.fixture(scope="module")
def dataset(folder: Path) -> Dataset:
    dataset = Dataset.open(folder)
    dataset.plan = SmallPlan(**asdict(dataset.plan))
    return dataset


@pytest.fixture(scope="module")
def whole(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of an uninterrupted training run."""
    run = tmp_path_factory.mktemp("whole") / "made" / "run"
    train(TOY, dataset, run)
    return run


def rows(run: Path) -> list[dict[str, float]]:
    with open(run / LOG, newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def events(run: Path) -> Iterator[Event]:
    for path in sorted(run.glob("events.out.tfevents.*")):
        content, place = path.read_bytes(), 0
        while place < len(content):  # TFRecord: length, its checksum, the event, its checksum
            (length,) = struct.unpack_from("<Q", content, place)
            yield Event.FromString(content[place + 12 : place + 12 + length])
            place += length + 16


# ---- files --------------------------------------------------------------------------------------------------


def test_it_learns(whole: Path) -> None:
    first, second = rows(whole)
    assert second["training_loss"] < first["training_loss"]
    assert second["validation_loss"] < first["validation_loss"]
    assert second["ssim"] > first["ssim"]
    assert {path.name for path in whole.iterdir() if not path.name.startswith("events")} == {
        WEIGHTS,
        CHECKPOINT,
        CONFIG,
        LOG,
    }


def test_log(whole: Path) -> None:
    header = (whole / LOG).read_text().splitlines()[0]
    stages = "ssim_1,ssim_25,ssim_50,ssim_75,ssim_100"
    assert header == f"epoch,steps,training_loss,validation_loss,ssim,{stages},seconds,samples_per_second"
    for number, row in enumerate(rows(whole), 1):
        assert (row["epoch"], row["steps"]) == (number, number * STEPS)
        assert row["ssim"] == pytest.approx(np.mean([row[name] for name in logs.SSIM_COLUMNS]), abs=1e-5)
        assert 0 < 29 / row["samples_per_second"] < row["seconds"]


def test_validation_is_of_the_shipped_weights(whole: Path, dataset: Dataset) -> None:
    """The loss in the log is computed from the raw output of weights.safetensors on the validation samples."""
    network, header = checkpoint.load(whole / WEIGHTS)
    assert header["epoch"] == "2"
    batch = training.Batches(dataset, "validation", shuffle=False)[0]
    with torch.no_grad():
        losses = training.LOSSES[TOY.loss](network(batch.partial), batch.reference)
    assert rows(whole)[1]["validation_loss"] == pytest.approx(losses.mean().item(), abs=1e-5)


def test_tensorboard(whole: Path) -> None:
    scalars, pictures = set(), {}
    for event in events(whole):
        for value in event.summary.value:
            if value.image.encoded_image_string:
                pictures[value.tag] = (value.image.height, value.image.width)
            else:
                scalars.add((value.tag, event.step))
    assert scalars == {
        (f"validation/{name}", step)
        for name in ("validation_loss", "ssim", *logs.SSIM_COLUMNS)
        for step in (STEPS, 2 * STEPS)
    } | {("training/loss", step) for step in range(2, 2 * STEPS + 1, 2)}
    names = [f"validation/{percent}_percent" for percent in (1, 25, 50, 75, 100)]
    assert pictures == dict.fromkeys(names, (2 * 128, 3 * 128))  # two patches: partial, completed, reference


def test_no_file_of_events_is_empty(tmp_path: Path) -> None:
    """So that training may be killed at any time."""
    log = logs.Events(tmp_path, 0)
    assert not list(tmp_path.iterdir())
    log.scalars({"training/loss": 0.5}, 1)
    assert next(events(tmp_path)).file_version == "brain.Event:2"
    log.close()
    assert [value.tag for event in events(tmp_path) for value in event.summary.value] == ["training/loss"]
    logs.Events(tmp_path, 1).close()
    assert len(list(tmp_path.iterdir())) == 1


def test_panels() -> None:
    partial = np.zeros((2, 5, 3, 4), np.float32)
    partial[0, :2, 0, 0] = 1, 0.4
    image, reference = np.full((2, 1, 3, 4), 1.5, np.float32), np.full((2, 1, 3, 4), 0.2, np.float32)
    sheet = logs.panels(partial, image, reference)
    assert (sheet.shape, sheet.dtype) == ((6, 12, 3), np.uint8)
    assert sheet[0, 0].tolist() == [102, 102, 102]
    assert sheet[3, 0].tolist() == sheet[0, 1].tolist() == [0, 150, 70]
    assert (sheet[:, 4:8] == 255).all()
    assert (sheet[:, 8:] == 51).all()


# ---- resuming and stopping ----------------------------------------------------------------------------------


@pytest.mark.parametrize("optimizer", ["adadelta", "muon"])
def test_it_goes_on_mid_epoch_to_the_same_bits(
    optimizer: str, whole: Path, dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, cut = TOY, tmp_path / "cut"
    if optimizer != TOY.optimizer:
        config, whole = replace(TOY, optimizer=optimizer, learning_rate=0.02), tmp_path / "whole"
        train(config, dataset, whole)
    step, calls = training._Training._step, 0

    def stop(self: Any, *arguments: Any) -> Any:
        nonlocal calls
        calls += 1
        if calls == STEPS + 4:  # three steps into the second epoch, one after its checkpoint
            raise KeyboardInterrupt
        return step(self, *arguments)

    monkeypatch.setattr(training._Training, "_step", stop)
    with pytest.raises(KeyboardInterrupt, match="resumes from the last checkpoint"):
        train(config, dataset, cut)
    assert len(rows(cut)) == 1
    calls = 2 * STEPS
    train(replace(config, workers=0), dataset, cut)
    assert calls == 2 * STEPS + 2  # two of the second epoch were in the checkpoint

    assert (cut / WEIGHTS).read_bytes() != (whole / WEIGHTS).read_bytes()  # workers differ, in its header
    for name in (WEIGHTS, CHECKPOINT):
        expected, got = (checkpoint.read_tensors(run / name)[0] for run in (whole, cut))
        assert expected.keys() == got.keys()
        for key, tensor in expected.items():
            assert torch.equal(tensor, got[key]), key
    for ours, theirs in zip(rows(whole), rows(cut), strict=True):
        for name in logs.COLUMNS[:-2]:  # except the measured times
            assert ours[name] == theirs[name]
    # TensorBoard drops events after the step of a later session's start.
    starts = [event.step for event in events(cut) if event.HasField("session_log")]
    assert starts == [1, STEPS + 2 + 1]


def test_it_stops_early(dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scores = iter([0.5, 0.6, 0.6, 0.55])
    steps = 0

    def validate(self: Any, *_: Any) -> dict[str, float]:
        return dict.fromkeys(["validation_loss", "ssim", *logs.SSIM_COLUMNS], next(scores))

    def count(self: Any, batch: Any, _: int) -> Any:
        nonlocal steps
        steps += 1
        return torch.ones(len(batch.numbers))

    monkeypatch.setattr(training._Training, "_validate", validate)
    monkeypatch.setattr(training._Training, "_step", count)
    monkeypatch.setattr(training._Training, "_pictures", lambda self: iter(()))
    config = replace(TOY, epochs=10, patience=2)
    train(config, dataset, tmp_path)
    assert steps == 4 * STEPS
    assert checkpoint.load(tmp_path / WEIGHTS)[1]["epoch"] == "2"  # the first of the equally good ones
    train(config, dataset, tmp_path)  # nothing is left to do
    assert steps == 4 * STEPS


def test_two_processes_share_each_mini_batch(whole: Path, dataset: Dataset, tmp_path: Path) -> None:
    train(replace(TOY, epochs=1, devices=2, accelerator="cpu"), dataset, tmp_path / "two")
    train(replace(TOY, epochs=1), dataset, tmp_path / "one")
    one, two = (checkpoint.read_tensors(tmp_path / name / CHECKPOINT)[0] for name in ("one", "two"))
    for name, tensor in one.items():
        if name.startswith(("network", "average")):
            # Gradients are summed in another order; AdaDelta's first steps have the same length for any gradient.
            torch.testing.assert_close(two[name], tensor, atol=1e-4, rtol=1e-3)
    (alone,), (shared,) = rows(tmp_path / "one"), rows(tmp_path / "two")
    for column in logs.COLUMNS[:-2]:
        assert shared[column] == pytest.approx(alone[column], abs=1e-4)
    assert len(list((tmp_path / "two").glob("events*"))) == 1


@pytest.mark.parametrize(
    "change",
    [
        {"precision": "bf16-mixed"},
        {"optimizer": "adamw", "learning_rate": 4e-3, "keep_known": True},
        {"network": "pyramid", "optimizer": "muon", "learning_rate": 0.02, "order": "lattice+uniform"},
    ],
)
def test_other_choices(
    dataset: Dataset, tmp_path: Path, change: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    # bfloat16 is slow on processors without it.
    monkeypatch.setattr(SmallPlan, "split", lambda self, name: Plan.split(self, name)[: 6 if name == "train" else 5])
    config = replace(TOY, epochs=1, batch=3, average=0.0, fractions="log-uniform", **change)
    train(config, dataset, tmp_path)
    (row,) = rows(tmp_path)
    assert all(math.isfinite(value) for value in row.values())
    tensors, _ = checkpoint.read_tensors(tmp_path / CHECKPOINT)
    for name, tensor in tensors.items():
        if name.startswith("average."):  # of decay 0
            assert torch.equal(tensor, tensors[name.replace("average", "network")])
            assert tensor.dtype == torch.float32


# ---- errors -------------------------------------------------------------------------------------------------


def test_it_begins_with_given_weights(whole: Path, dataset: Dataset, tmp_path: Path) -> None:
    start = whole / WEIGHTS
    train(replace(TOY, start=str(start), epochs=0), dataset, tmp_path / "none")
    given, _ = checkpoint.read_tensors(start)
    written, _ = checkpoint.read_tensors(tmp_path / "none" / WEIGHTS)
    assert all(written[name].equal(tensor) for name, tensor in given.items())
    train(replace(TOY, start=str(start)), dataset, tmp_path / "more")
    assert rows(tmp_path / "more")[-1]["ssim"] > rows(whole)[-1]["ssim"]
    assert json.loads((tmp_path / "more" / CONFIG).read_text())["start"]["sha256"]

    for wrong, message in (({"network": "pyramid"}, "network=pyramid"), ({"groups": 1}, "these settings")):
        with pytest.raises(InputError, match=message):
            train(replace(TOY, start=str(start), **wrong), dataset, tmp_path / "wrong")
    with pytest.raises(InputError, match=r"expected one of default, filling, paper, small or a \.safetensors file"):
        train(replace(TOY, start="nothing"), dataset, tmp_path / "wrong")


def test_means_of_weights(whole: Path, tmp_path: Path) -> None:
    """Of the initial and the trained weights; the header is the latter's."""
    first, second, path = tmp_path / "first.safetensors", whole / WEIGHTS, tmp_path / "mean.safetensors"
    network, header = checkpoint.load(second)
    other = copy.deepcopy(network)
    for parameter in other.parameters():
        parameter.data *= 0.5
    checkpoint.save(first, other)
    checkpoint.mix(first, second, 0.25, path)
    mean, of_mean = checkpoint.load(path)
    for got, trained in zip(mean.parameters(), network.parameters(), strict=True):
        torch.testing.assert_close(got, 0.625 * trained)
    digest = hashlib.sha256(first.read_bytes()).hexdigest()
    assert json.loads(of_mean.pop("mixed")) == {"share": 0.25, "with": {"sha256": digest}}
    assert of_mean == header
    for bad, message in (
        ((first, "default", 0.5), "second: expected weights of the same network as"),
        ((first, second, 1.5), "share: expected"),
    ):
        with pytest.raises(InputError, match=message):
            checkpoint.mix(*bad, path)


def test_a_checkpoint_older_than_a_field_goes_on(dataset: Dataset, tmp_path: Path) -> None:
    train(replace(TOY, epochs=1), dataset, tmp_path)
    tensors, header = checkpoint.read_tensors(tmp_path / CHECKPOINT)
    trained = json.loads(header["training"])
    del trained["start"], trained["draw"]
    changed = {**header, "training": json.dumps({**trained, "epochs": 2})}
    checkpoint.write_tensors(tmp_path / CHECKPOINT, tensors, changed)
    train(TOY, dataset, tmp_path)
    assert len(rows(tmp_path)) == 2
    with pytest.raises(InputError, match="draw 'each' instead of 'by-detail'"):
        train(replace(TOY, draw="by-detail"), dataset, tmp_path)


def test_refused_before_any_work(whole: Path, dataset: Dataset, folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"one of batch 8 instead of 4, average 0\.999 instead of 0\.5; move the"):
        train(replace(TOY, batch=4, average=0.5), dataset, whole)
    other = Dataset(dataset.path, dataset.plan, ["ball", "cube"], {})
    with pytest.raises(InputError, match="expected a checkpoint of this training, got one of sources"):
        train(TOY, other, whole)
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="can't make its folder"):
        train(TOY, dataset, tmp_path / "file")
    with pytest.raises(InputError, match="groups: expected a divisor of 20, got 3"):
        train(replace(TOY, groups=3), dataset, tmp_path / "new")
    too_many = torch.cuda.device_count() + 1
    with pytest.raises(InputError, match=f"devices: expected at most this machine's .* GPUs, got {too_many}"):
        train(replace(TOY, accelerator="cuda", devices=too_many), dataset, tmp_path / "new")
    assert not list((tmp_path / "new").iterdir())
    (tmp_path / CHECKPOINT).write_bytes((whole / WEIGHTS).read_bytes())
    with pytest.raises(InputError, match="expected a checkpoint, got a file without its progress"):
        train(TOY, dataset, tmp_path)


# ---- parts --------------------------------------------------------------------------------------------------


def test_adadelta_is_zeilers() -> None:
    """Algorithm 1 of Zeiler 2012, with his settings, on a gradient of 3x²."""
    x = torch.nn.Parameter(torch.tensor([1.0, -2.0]))
    module = torch.nn.Module()
    module.x = x
    make, _ = OPTIMIZERS["adadelta"]
    optimizer = make(module, TrainConfig())
    expected, square, change = np.array([1.0, -2.0]), np.zeros(2), np.zeros(2)
    for _ in range(5):
        optimizer.zero_grad()
        (x**3).sum().backward()
        optimizer.step()
        gradient = 3 * expected**2
        square = 0.95 * square + 0.05 * gradient**2
        delta = -np.sqrt(change + 1e-6) / np.sqrt(square + 1e-6) * gradient
        change = 0.95 * change + 0.05 * delta**2
        expected += delta
        np.testing.assert_allclose(x.detach().numpy(), expected, rtol=1e-6)


def test_muon_turns_every_direction_alike() -> None:
    generator = torch.Generator().manual_seed(0)
    left, right = (torch.linalg.qr(torch.randn(n, n, generator=generator))[0] for n in (8, 18))
    for values in (torch.logspace(-2, 0, 8), torch.ones(8)):
        gradient = left @ torch.diag(values) @ right[:8]  # (8, 18), with these singular values
        turned = left.T @ orthogonal(gradient) @ right[:8].T
        assert (turned.diagonal() > 0.6).all()
        assert (turned.diagonal() < 1.25).all()
        assert (turned - torch.diag(turned.diagonal())).abs().max() < 1e-4
        torch.testing.assert_close(orthogonal(gradient.T), orthogonal(gradient).T)


def test_muon_goes_down_at_its_own_pace() -> None:
    """Matrix-shaped weights move by orthogonalised Nesterov momentum, others by Adam."""
    network = torch.nn.Conv2d(2, 3, 3)
    make, _ = OPTIMIZERS["muon"]
    optimizer = make(network, TrainConfig(learning_rate=0.1))
    weight, bias = network.weight.detach().clone(), network.bias.detach().clone()  # type: ignore[union-attr]
    momentum, mean, square = torch.zeros_like(weight), torch.zeros_like(bias), torch.zeros_like(bias)
    for step in range(1, 4):
        optimizer.zero_grad()
        ((network.weight**2).sum() + (network.bias**4).sum()).backward()  # type: ignore[operator]
        optimizer.step()
        momentum = 0.95 * momentum + 0.05 * 2 * weight
        ahead = (0.05 * 2 * weight + 0.95 * momentum).reshape(3, 18)
        weight -= 0.1 * orthogonal(ahead).reshape(weight.shape)
        torch.testing.assert_close(network.weight.detach(), weight)
        gradient = 4 * bias**3
        mean, square = 0.9 * mean + 0.1 * gradient, 0.99 * square + 0.01 * gradient**2
        bias -= 0.1 * 0.2 * (mean / (1 - 0.9**step)) / ((square / (1 - 0.99**step)).sqrt() + 1e-8)
        torch.testing.assert_close(network.bias, bias, check_dtype=False)


def test_schedules() -> None:
    _, cosine = OPTIMIZERS["adamw"]
    config = replace(TOY, learning_rate=1e-2, warmup=5)
    rates = [cosine(config, step / 100, step) for step in range(100)]
    assert np.argmax(rates) == 4
    assert 0 < rates[-1] < rates[0] < config.learning_rate
    assert cosine(replace(config, warmup=0), 0.5, 10) == pytest.approx(config.learning_rate / 2)
    few = [cosine(replace(config, warmup=200), step / 20, step) for step in range(20)]  # a run shorter than the rise
    assert np.argmax(few) == 2
    assert max(few) > 0.9 * config.learning_rate
    _, constant = OPTIMIZERS["adadelta"]
    assert {constant(config, step / 20, step) for step in range(20)} == {config.learning_rate}


def test_the_average_follows() -> None:
    average, network = torch.nn.Linear(1, 1), torch.nn.Linear(1, 1)
    for values in (average.weight, network.weight):
        torch.nn.init.constant_(values, 1.0 if values is network.weight else 0.0)
    follow(average, network, 0.999, 1)
    assert average.weight.item() == pytest.approx(1 - 2 / 11)  # the initial weights are soon forgotten
    follow(average, network, 0.999, 10**6)
    assert average.weight.item() == pytest.approx(1 - 2 / 11 * 0.999)
    follow(average, network, 0.0, 10**6)
    assert torch.equal(average.weight, network.weight)
    assert network.weight.item() == 1


def test_keep_known() -> None:
    partial = torch.zeros(2, 5, 2, 2)
    partial[0, :2, 0, 0] = torch.tensor([1, 0.5])
    partial[1, 0] = 1  # wholly traced
    image = torch.full((2, 1, 2, 2), 9.0)
    assert keep_known(image, partial).flatten(1).tolist() == [[0.5, 9, 9, 9], [0, 0, 0, 0]]
    assert keep_known_of_partial(image, partial).flatten(1).tolist() == [[0.5, 9, 9, 9], [9, 9, 9, 9]]


# ---- the configuration --------------------------------------------------------------------------------------


def test_the_defaults_are_the_reports() -> None:
    config = TrainConfig()
    assert (config.network, config.groups, config.batch, config.loss) == ("paper", 4, 32, "ssim+l2")
    assert (config.optimizer, config.learning_rate, config.fractions) == ("adadelta", 1.0, "stages")
    assert not config.keep_known


def test_the_configuration_is_saved_and_printed(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["train", str(folder), str(tmp_path), "epochs=0", "seed=3", "--precision", "bf16-mixed"]
    assert cli.main(command) == 0
    assert capsys.readouterr().out == f"wrote {tmp_path / WEIGHTS}: epoch 0 of 0\n"
    config = TrainConfig(epochs=0, seed=3, precision="bf16-mixed")
    assert TrainConfig(**json.loads((tmp_path / CONFIG).read_text())["training"]) == config
    for what in (tmp_path, tmp_path / WEIGHTS):
        assert cli.main(["info", str(what)]) == 0
        printed = [line.split() for line in capsys.readouterr().out.splitlines()]
        for name, value in asdict(config).items():
            assert [name, *str(value).split()] in printed
    (tmp_path / CONFIG).write_text("[1]")
    assert cli.main(["info", str(tmp_path)]) == 2
    assert "expected a training's configuration, got other JSON" in capsys.readouterr().err


NAN = math.nan


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("loss", "l3", r"loss: expected one of l1, l2, ssim, ssim\+l1, ssim\+l2, ssim\+visible, got 'l3'"),
        ("network", "papper", "network: expected one of paper, pyramid, got 'papper'"),
        (
            "order",
            ["uniform"],
            r"order: expected one of uniform, lattice, adaptive, squares, priority, or several joined by \+",
        ),
        ("optimizer", None, "optimizer: expected one of adadelta, adamw, muon, got None"),
        ("fractions", "all", "fractions: expected one of stages, log-uniform, sparse, got 'all'"),
        ("precision", "16", "precision: expected one of 32-true, bf16-mixed, got '16'"),
        ("accelerator", "tpu", "accelerator: expected one of auto, cpu, cuda, got 'tpu'"),
        ("groups", 0, "groups: expected an integer in 1"),
        ("seed", -1, "seed: expected an integer in 0"),
        ("epochs", -1, "epochs: expected an integer in 0"),
        ("patience", 0, "patience: expected an integer in 1"),
        ("batch", 0, "batch: expected an integer in 1"),
        ("batch", 4.0, "batch: expected an integer, got float 4.0"),
        ("warmup", -1, "warmup: expected an integer in 0"),
        ("checkpoint_every", 0, "checkpoint_every: expected an integer in 1"),
        ("devices", 0, "devices: expected an integer in 1"),
        ("threads", 0, "threads: expected an integer in 1..1024, got 0"),
        ("workers", -1, "workers: expected an integer in 0..1024, got -1"),
        ("learning_rate", NAN, "learning_rate: expected a number above 0, got nan"),
        ("learning_rate", 0, "learning_rate: expected a number above 0, got 0"),
        ("weight_decay", -1e-4, "weight_decay: expected a number of at least 0, got -0.0001"),
        ("weight_decay", math.inf, "weight_decay: expected a number of at least 0, got inf"),
        ("average", 1.1, r"average: expected a number in \[0, 1\], got 1\.1"),
        ("keep_known", "no", "keep_known: expected True or False, got 'no'"),
    ],
)
def test_a_configuration_that_cannot_be(field: str, value: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(TOY, **{field: value})


def test_no_field_goes_unchecked() -> None:
    for field in fields(TrainConfig):
        with pytest.raises(InputError, match=f"^{field.name}: expected"):
            replace(TOY, **{field.name: None})  # type: ignore[arg-type]


def test_numbers_of_numpy_can_be_written_to_a_header() -> None:
    config = replace(TOY, seed=np.int64(3), learning_rate=np.float32(0.5))
    assert (config.seed, type(config.seed), type(config.learning_rate)) == (3, int, float)


def test_settings() -> None:
    config = config_from_settings(["epochs=20", "keep_known=true", "learning_rate=1", "loss=l1"])
    assert config == TrainConfig(epochs=20, keep_known=True, learning_rate=1.0, loss="l1")
    assert config_from_settings([]) == TrainConfig()
    for setting, message in {
        "epoch=20": "epoch=20: expected NAME=VALUE with a name of network, start, groups, features, handed_on, seed",
        "epochs=2e3": "epochs=2e3: expected a value of type int",
        "keep_known=1": "keep_known=1: expected true or false",
        "batch=0": "batch: expected an integer in 1..2147483647, got 0",
        "learning_rate=nan": "learning_rate: expected a number above 0, got nan",
    }.items():
        with pytest.raises(InputError, match=message):
            config_from_settings([setting])
