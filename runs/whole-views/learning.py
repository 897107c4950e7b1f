"""Networks that learn side by side from the same mini-batches, on a GPU if there is one."""

from __future__ import annotations

import copy
import json
import math
import os
import time
import traceback
from contextlib import nullcontext
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import torch
from run import HELD_OUT, SETTINGS, SIZE
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.functional import relu

from bobrossnet.completion.weights import WEIGHTS, read_weights
from bobrossnet.learn.losses import dissimilarity, l1, ssim
from bobrossnet.learn.muon import Muon
from bobrossnet.learn.networks import pyramid
from bobrossnet.learn.networks.interpolation import blend, interpolated
from bobrossnet.learn.networks.paper import pad
from bobrossnet.learn.networks.pyramid import SOFTNESS, Pyramid, crop, pull, spread, unshuffle, upsample
from bobrossnet.picture.order import pixel_order

AVERAGE = 0.998
TINY = 1e-6


class Sample(NamedTuple):
    """Partial pictures and what is known of them before any network of these learns."""

    partial: Tensor  # (N, 5, H, W): mask, gray, depth, normal
    reference: Tensor  # (N, 1, H, W)
    value: Tensor  # (N, 1, H, W), interpolated
    weight: Tensor  # (N, 1, H, W), how far that counts
    base: Tensor  # (N, 1, H, W), the shipped network's picture, completed


@lru_cache(maxsize=4)
def gaussian_kernel(device: torch.device) -> Tensor:
    return torch.tensor([[1.0, 2, 1], [2, 4, 2], [1, 2, 1]], device=device)[None, None] / 16


def gaussian_mean(values: Tensor, mask: Tensor) -> Tensor:
    """The package's own, without a copy to the device at each call."""
    kernel = gaussian_kernel(values.device)
    weight, total = (functional.conv2d(plane, kernel, padding=1) for plane in (mask, values))
    return total / (weight + SOFTNESS)


pyramid.gaussian_mean = gaussian_mean


def put_back(image: Tensor, sample: Sample) -> Tensor:
    return torch.where(sample.partial[:, :1] > 0, sample.partial[:, 1:2], image)


# ---- networks -------------------------------------------------------------------------------------------------------


class Same(Pyramid):
    """The shipped network; its picture is blended with the lattice's, as `complete` does."""

    def picture(self, sample: Sample) -> Tensor:
        return blend(self(sample.partial), sample.value, sample.weight)


class Dense(Pyramid):
    """A pyramid of traced and interpolated pixels, which corrects interpolated ones too.

    With `points`, its finest level sees depth and normals of single pixels."""

    def __init__(self, features: str, handed_on: str, points: bool) -> None:
        super().__init__(features, handed_on)
        self.points = points
        if points:
            old = self.features1
            self.features1 = nn.Conv2d(old.in_channels + 10, old.out_channels, 3, padding=1)
            nn.init.kaiming_normal_(self.features1.weight, nonlinearity="relu")
            nn.init.zeros_(self.features1.bias)

    def start_from(self, tensors: dict[str, Tensor]) -> None:
        """Begin with the shipped weights; what is new to the finest level counts for nothing at first."""
        own = self.state_dict()
        for name, tensor in tensors.items():
            if own[name].shape == tensor.shape:
                own[name] = tensor
            else:  # features1 begins with gray; depth and normals of 4 pixels follow
                wider = torch.zeros_like(own[name])
                wider[:, :1] = tensor[:, :1]
                wider[:, 5:9], wider[:, 9:13] = tensor[:, 1:2], tensor[:, 2:3]  # of one traced pixel this is the mean
                wider[:, 13:] = tensor[:, 3:]
                own[name] = wider
        self.load_state_dict(own)

    def picture(self, sample: Sample) -> Tensor:
        pixels, value, weight = sample.partial, sample.value, sample.weight  # even sizes
        mask = pixels[:, :1]
        known = mask + weight  # 0..1
        gray_sum = pixels[:, 1:2] + weight * value
        zeros = torch.zeros_like(mask)
        # known, gray, depth and normals of traced pixels, position, and the mask
        sums = [torch.cat([known, gray_sum, pixels[:, 2:], zeros, zeros], 1)]
        counts = [mask]
        for level in range(1, self.levels + 1):
            sums.append(pull(pad(sums[-1], 2), level))
            counts.append(4 * functional.avg_pool2d(pad(counts[-1], 2), 2))
        gray = torch.zeros_like(sums[self.levels][:, :1])
        surface = torch.ones_like(gray)
        handed: list[Tensor] = []
        for level in range(self.levels, 0, -1):
            count, of_level = sums[level][:, :1], sums[level]
            mean_gray = of_level[:, 1:2] / (count + TINY)
            others = of_level[:, 2:5] / counts[level].clamp(min=1)
            position = of_level[:, 5:] / (count + TINY) / 2**level
            there = count.clamp(max=1)
            surface = surface * spread(((count < 0.5) | (mean_gray > 0)).to(count))
            surprise = there * (mean_gray - gray)
            knows = [gray, surprise, others, count / (count + 1), position]
            finer_size = sums[level - 1].shape[-2:]
            gray = crop(upsample(gray + surprise), finer_size)
            if level == 1:
                surprise = known * (gray_sum / (known + TINY) - gray)
                seen = [unshuffle(pixels[:, c : c + 1]) for c in (2, 3, 4)] if self.points else [others[:, 1:]]
                knows = [knows[0], *seen, unshuffle(known), unshuffle(surprise)]
                gray = blend(gray + gaussian_mean(surprise, known), value, weight)
            features = relu(self.layer("features", level)(torch.cat([*knows, *handed], 1)))
            finer = crop(functional.pixel_shuffle(self.layer("finer", level)(features), 2), finer_size)
            gray = gray + finer[:, :1]
            surface = crop(functional.interpolate(surface, scale_factor=2, mode="nearest"), finer_size)
            handed = [finer]
        return gray * surface


class Teacher(nn.Module):
    """A U-Net that corrects the shipped network's completed picture where a correction can help.

    Plain ReLUs and a correction of every pixel die: any offset of a black or interpolated pixel costs more SSIM than
    all others gain, so the first steps turn the last features off, and a ReLU that is off learns nothing.
    """

    def __init__(self, channels: str) -> None:
        super().__init__()
        widths = [int(c) for c in channels.split(",")]
        self.enter = nn.ModuleList()
        before = 9
        for width in widths:
            self.enter.append(
                nn.Sequential(
                    nn.Conv2d(before, width, 3, padding=1),
                    nn.LeakyReLU(0.1),
                    nn.Conv2d(width, width, 3, padding=1),
                    nn.LeakyReLU(0.1),
                )
            )
            before = width
        self.leave = nn.ModuleList()
        for width in widths[-2::-1]:
            self.leave.append(
                nn.Sequential(
                    nn.Conv2d(before + width, width, 3, padding=1),
                    nn.LeakyReLU(0.1),
                    nn.Conv2d(width, width, 3, padding=1),
                    nn.LeakyReLU(0.1),
                )
            )
            before = width
        self.output = nn.Conv2d(before, 1, 3, padding=1)
        for module in self.modules():
            if isinstance(module, nn.Conv2d):
                nn.init.kaiming_normal_(module.weight, nonlinearity="relu")
                nn.init.zeros_(module.bias)
        nn.init.zeros_(self.output.weight)

    def picture(self, sample: Sample) -> Tensor:
        value = sample.value * sample.weight
        error_of_base = sample.partial[:, :1] * (sample.partial[:, 1:2] - sample.base)
        x = torch.cat([sample.partial, value, sample.weight, sample.base, error_of_base], 1)
        x = x.contiguous(memory_format=torch.channels_last)
        kept = []
        for i, block in enumerate(self.enter):
            x = block(x if i == 0 else functional.max_pool2d(x, 2))
            kept.append(x)
        for block, beside in zip(self.leave, kept[-2::-1], strict=True):
            x = block(torch.cat([functional.interpolate(x, scale_factor=2.0, mode="nearest"), beside], 1))
        lit = pyramid.spread((sample.base > 0).float())
        return sample.base + self.output(x).float() * lit * (1 - sample.weight)


# ---- learning -------------------------------------------------------------------------------------------------------


class Learner:
    """A network, its moving average and its optimizer; its rate falls by a cosine over its part of the time."""

    def __init__(self, name, network, device, rate, *, bf16=False, begin=0.0, muon=True, warmup=200, teacher=None):
        self.name, self.device, self.rate, self.bf16, self.begin, self.warmup = name, device, rate, bf16, begin, warmup
        self.network = network.to(device).to(memory_format=torch.channels_last)
        self.average = copy.deepcopy(self.network).requires_grad_(False)
        self.muon, self.teacher = muon, teacher
        self.failed = 0
        self._renew()

    def _renew(self):
        self.steps = 0
        parameters = self.network.parameters()
        if self.muon:
            self.optimizer = Muon(parameters, self.rate)
        else:
            self.optimizer = torch.optim.AdamW(
                parameters, self.rate, weight_decay=1e-3, fused=self.device.type == "cuda"
            )

    def take(self, other):
        """Begin anew with the average weights of another."""
        self.network.load_state_dict(other.average.state_dict())
        self.average.load_state_dict(other.average.state_dict())
        self._renew()

    def autocast(self):
        return torch.autocast(self.device.type, dtype=torch.bfloat16) if self.bf16 else nullcontext()

    def step(self, sample, importance, share):
        done = (share - self.begin) / (1 - self.begin)
        rise = min((self.steps + 1) / self.warmup, 1)
        for group in self.optimizer.param_groups:
            group["lr"] = self.rate * rise * 0.5 * (1 + math.cos(math.pi * min(max(done, 0), 1)))
        with self.autocast():
            image = self.network.picture(sample).float()
        image = put_back(image, sample)
        losses = dissimilarity(image, sample.reference) + l1(image, sample.reference)
        if self.teacher is not None:
            target = self.teacher.complete(sample).clamp(0, 1)
            losses = 0.5 * losses + 0.5 * (dissimilarity(image, target) + l1(image, target))
        loss = (losses * importance).mean()
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()
        if not self.muon:
            nn.utils.clip_grad_norm_(self.network.parameters(), 1.0)
        self.optimizer.step()
        self.steps += 1
        decay = min(AVERAGE, (1 + self.steps) / (10 + self.steps))
        with torch.no_grad():
            torch._foreach_lerp_(list(self.average.parameters()), list(self.network.parameters()), 1 - decay)
        return loss.detach()

    @torch.no_grad()
    def complete(self, sample):
        with self.autocast():
            return put_back(self.average.picture(sample).float(), sample)

    def recover(self, good):
        """Go back to weights that were finite, more slowly."""
        self.failed += 1
        self.rate *= 0.4
        self.network.load_state_dict(good)
        self.average.load_state_dict(good)
        self._renew()


def learn(options, deadline, views, done, delaunay, refs, real_scores):
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    torch.set_num_threads(4 if device.type == "cuda" else 1)
    torch.manual_seed(0)
    torch.backends.cudnn.benchmark = True
    torch.backends.cudnn.allow_tf32 = True
    clock = lambda: time.time() - options.start  # noqa: E731
    log_file = (options.out / "log.txt").open("w", buffering=1)

    def say(*words):
        line = f"{clock():7.1f} " + " ".join(map(str, words))
        print(line, flush=True)
        log_file.write(line + "\n")

    def synchronize():
        if device.type == "cuda":
            torch.cuda.synchronize()

    say(
        torch.__version__,
        device,
        torch.cuda.get_device_name() if device.type == "cuda" else "",
        os.cpu_count(),
        "cores",
    )
    metadata, arrays = read_weights(WEIGHTS / "default.safetensors")
    shipped = {name: torch.from_numpy(np.array(array)) for name, array in arrays.items()}
    default = Same()
    default.load_state_dict(shipped)
    default = default.to(device).to(memory_format=torch.channels_last).requires_grad_(False)

    # What has been made so far, on the device.
    on_device = torch.empty((len(views) - HELD_OUT, *views.shape[1:]), dtype=torch.int16, device=device)
    from_workers = torch.from_numpy(views.view(np.int16))
    count, taken = 0, np.zeros(len(views), bool)

    def ingest():
        nonlocal count
        new = np.flatnonzero((done > 0) & ~taken)
        new = new[new >= HELD_OUT]
        if not len(new):
            return
        for run in np.split(new, np.flatnonzero(np.diff(new) > 1) + 1):
            on_device[count : count + len(run)] = from_workers[int(run[0]) : int(run[-1]) + 1].to(device)
            taken[run] = True
            count += len(run)

    lattice = np.empty((SIZE, SIZE), np.int32)
    pixels = pixel_order((SIZE, SIZE), order="lattice")
    lattice[pixels[:, 0], pixels[:, 1]] = np.arange(SIZE * SIZE)
    lattice_places = torch.from_numpy(lattice).to(device)
    uniform_places = torch.from_numpy(
        np.random.default_rng(5).permutation(SIZE * SIZE).reshape(SIZE, SIZE).astype(np.int32)
    ).to(device)

    @torch.no_grad()
    def sample_of(planes, places, counts):
        """(N, 4, H, W) float32, (N, H, W) and (N,) how many pixels are traced."""
        mask = (places < counts[:, None, None]).float()[:, None]
        partial = torch.cat([mask, planes * mask], 1)
        value, weight = interpolated(partial[:, 1:2], mask)
        sample = Sample(partial, planes[:, :1].contiguous(), value, weight, mask)
        base = put_back(default.picture(sample), sample).clamp(0, 1)
        return sample._replace(base=base)

    def planes_of(bits):
        return bits[:, :4].view(torch.float16).float(), bits[:, 4].to(torch.int32) & 0xFFFF

    size_of_batch = options.batch

    def batch():
        n = size_of_batch
        planes, places = planes_of(on_device[torch.randint(count, (n,), device=device)])
        few = torch.rand(n, device=device) < 0.7
        low, high = torch.where(few, 0.008, 0.004), torch.where(few, 0.12, 0.5)
        shares = low * (high / low) ** torch.rand(n, device=device)
        counts = (shares * SIZE**2).round().clamp(min=1).to(torch.int32)
        # Orders in blocks of the batch: lattice, uniform, and adaptive for the rest.
        others = round(0.17 * n)
        places[:others] = lattice_places
        places[others : 2 * others] = (torch.rand((others, SIZE, SIZE), device=device) * SIZE**2).to(torch.int32)
        return sample_of(planes, places, counts)

    # ---- scores
    def held_out_own():
        ready = np.flatnonzero(done[: options.held_out] > 0)
        return planes_of(torch.from_numpy(views[ready].view(np.int16)).to(device)), ready

    real = torch.from_numpy(refs[0]).float(), torch.from_numpy(refs[1].astype(np.int32))

    @torch.no_grad()
    def scores_on(planes, places):
        """SSIM by network: (S, P), and seconds."""
        result = {}
        for order, share in SETTINGS:
            lines: dict[str, list] = {}
            for i in range(0, len(planes), 32):
                part, at = planes[i : i + 32].to(device), places[i : i + 32].to(device)
                if order != "adaptive":
                    at = (lattice_places if order == "lattice" else uniform_places).expand(len(part), -1, -1)
                counts = torch.full((len(part),), round(share * SIZE**2), device=device)
                sample = sample_of(part, at, counts)
                lines.setdefault("default", []).append(ssim(sample.base, sample.reference))
                for learner in learners:
                    if learner.steps:
                        image = learner.complete(sample).clamp(0, 1)
                        lines.setdefault(learner.name, []).append(ssim(image, sample.reference))
            for name, parts in lines.items():
                result.setdefault(name, []).append(torch.cat(parts).double().cpu().numpy())
        return {name: np.array(rows) for name, rows in result.items()}

    history = []
    good: dict[str, dict] = {}
    times: dict[str, float] = {}

    def validate(last=False):
        started = time.time()
        torch.backends.cudnn.benchmark = False  # for a few sizes that come up once
        row = {"seconds": clock(), "views": count, "steps": {x.name: x.steps for x in learners}, "milliseconds": times}
        try:
            own, ready = held_out_own()
            by_picture = {}
            for place, pictures in (("own", own), ("real", real)):
                if not len(pictures[0]):
                    continue
                scores = scores_on(*pictures)
                if place == "own":
                    scores["delaunay"] = np.where(
                        np.array([order == "adaptive" for order, _ in SETTINGS])[:, None], delaunay[ready].T, np.nan
                    )
                else:
                    ready = real_scores[:, -1, 2] > 0
                    if ready.all():  # by the package itself
                        found = np.where(real_scores > 0, real_scores, np.nan).transpose(2, 1, 0)
                        scores |= dict(zip(("delaunay", "filling", "core"), found, strict=True))
                row[place] = {name: np.round(s.mean(1), 6).tolist() for name, s in scores.items()}
                by_picture[place] = {name: np.round(s, 6).tolist() for name, s in scores.items()}
                for name, means in row[place].items():
                    say(place, f"{name:12}", " ".join(f"{x:.4f}" for x in means))
            if last:
                row["by_picture"] = by_picture
        except Exception:
            say("validation failed", traceback.format_exc(limit=4))
        history.append(row)
        weights = {}
        for learner in learners:
            state = {k: v.detach().float().cpu().clone() for k, v in learner.average.state_dict().items()}
            if all(bool(torch.isfinite(v).all()) for v in state.values()):
                good[learner.name] = state
            elif learner.name in good:
                say(learner.name, "not finite: back to the last that was")
                learner.recover(good[learner.name])
            weights[learner.name] = good.get(learner.name)
        for name, write in (
            ("weights.pt", lambda path: torch.save({k: v for k, v in weights.items() if v is not None}, path)),
            ("log.json", lambda path: path.write_text(json.dumps({"settings": SETTINGS, "history": history}))),
        ):
            try:
                path = options.out / f"{name}.new"
                write(path)
                path.replace(options.out / name)
            except Exception:
                say("can't write", name, traceback.format_exc(limit=2))
        torch.backends.cudnn.benchmark = True
        say("validated in", round(time.time() - started, 1), "s")

    # ---- who learns
    features, handed_on = metadata.get("features", default.features), metadata.get("handed_on", default.handed_on)
    same = Same(features, handed_on)
    same.load_state_dict(shipped)
    distilled = Same(features, handed_on)
    distilled.load_state_dict(shipped)
    dense, points = Dense(features, handed_on, False), Dense(features, handed_on, True)
    dense.start_from(shipped)
    points.start_from(shipped)
    wide = Dense(options.wide, "12,16,16,16,16", True)
    teacher = Learner(
        "teacher", Teacher(options.teacher), device, 3e-4, bf16=device.type == "cuda", muon=False, warmup=300
    )
    learners = [
        teacher,
        Learner("same", same, device, 0.01),
        Learner("points", points, device, 0.01),
        Learner("dense", dense, device, 0.01),
        Learner("wide", wide, device, 0.02),
        Learner("distilled", distilled, device, 0.005, begin=0.45, teacher=teacher),
    ]
    for learner in learners:
        say(learner.name, sum(p.numel() for p in learner.network.parameters()), "parameters")

    # ---- the loop
    while count < options.least and (clock() < options.until / 3 or count == 0) and time.time() < deadline:
        ingest()
        time.sleep(0.2)
    say("begin with", count, "views")
    if count == 0:
        raise RuntimeError("no views were made")
    first, last_ingest, next_validation, steps = time.time(), 0.0, time.time() + 60, 0
    end = deadline - options.finish
    while time.time() < end:
        share = (time.time() - first) / (end - first)
        if time.time() - last_ingest > 1.5 and count < len(on_device):
            try:
                ingest()
            except Exception:
                say("ingest failed", traceback.format_exc(limit=2))
            last_ingest = time.time()
        try:
            measured = steps in (20, 60, 300, 1500, 4000)
            mark = time.time()

            def lap(name, mark, measured=measured):
                if measured:
                    synchronize()
                    times[name] = round(1000 * (time.time() - mark), 1)
                return time.time()

            if measured:
                synchronize()
                mark = time.time()
            sample = batch()
            own = dissimilarity(sample.base, sample.reference) + l1(sample.base, sample.reference)
            importance = (own + 0.004) ** -0.5
            importance = importance / importance.mean()
            mark = lap("batch", mark)
        except Exception:
            say("batch failed", traceback.format_exc(limit=3))
            time.sleep(0.5)
            continue
        for learner in learners:
            if share < learner.begin or learner.failed > 3:
                continue
            try:
                if learner.teacher is not None and learner.steps == 0:
                    learner.take(learners[1])
                loss = learner.step(sample, importance, share)
                if measured:
                    times[f"{learner.name} loss"] = round(float(loss), 5)
            except Exception:
                learner.failed += 1
                say(learner.name, "failed", traceback.format_exc(limit=4))
            mark = lap(learner.name, mark)
        steps += 1
        # Are larger mini-batches hardly slower? Then the device was waiting.
        if steps == 100:
            synchronize()
            trial = time.time()
        elif steps == 130:
            synchronize()
            of_small = (time.time() - trial) / 30
            size_of_batch = 2 * options.batch
        elif steps == 145:
            synchronize()
            trial = time.time()
        elif steps == 165:
            synchronize()
            of_large = (time.time() - trial) / 20
            if of_large > 1.45 * of_small:
                size_of_batch = options.batch
            say("seconds of a step", round(of_small, 4), "of a double one", round(of_large, 4), "batch", size_of_batch)
        if measured:
            say("step", steps, "views", count, json.dumps(times))
            if device.type == "cuda":
                say("memory", round(torch.cuda.max_memory_allocated() / 2**30, 1), "GiB")
        if time.time() > next_validation:
            say("step", steps, "views", count, "share", round(share, 3))
            synchronize()
            validate()
            next_validation = time.time() + options.validate_every
    say("steps", steps)
    validate(last=True)
    say("done")
