"""The data set: its samples, builds that survive interruptions, and its mini-batches."""

import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from processes import running

import bobrossnet as bob
from bobrossnet.learn.dataset import Dataset, Plan, loader
from bobrossnet.learn.dataset.build import build, views_of
from bobrossnet.learn.dataset.loader import Batches
from bobrossnet.learn.dataset.plan import PATCHES, SIZES, STAGES
from bobrossnet.learn.dataset.store import part_of
from bobrossnet.learn.shapes import KINDS, procedural_scene
from bobrossnet.learn.shapes.colors import LOOKS, colored_scene, is_white, patterns, textured, white
from bobrossnet.learn.shapes.textures import KINDS as TEXTURES
from bobrossnet.learn.shapes.textures import SIDE, some_texture
from bobrossnet.support.errors import InputError, InputWarning

# ---- the plan -----------------------------------------------------------------------------------------------


def test_the_report_s_counts() -> None:
    plan = Plan()
    assert (plan.shapes, PATCHES, len(STAGES), plan.samples) == (479, 21, 5, 50_295)
    splits = {name: plan.split(name) for name in ("train", "validation", "test")}
    assert {name: len(samples) for name, samples in splits.items()} == {
        "train": 44_320,
        "validation": 4_925,
        "test": 1_050,
    }
    assert len(splits["train"]) + len(splits["validation"]) == 49_245
    np.testing.assert_array_equal(np.sort(np.concatenate(list(splits.values()))), np.arange(50_295))

    shapes = {name: {plan.sample(n).shape for n in samples.tolist()} for name, samples in splits.items()}
    assert len(shapes["test"]) == 10
    assert not shapes["test"] & (shapes["train"] | shapes["validation"])
    patches = {name: set((samples // 5).tolist()) for name, samples in splits.items()}
    assert not patches["train"] & patches["validation"]


def test_samples_cover_views_patches_and_stages() -> None:
    plan = Plan(shapes=3, test_shapes=1)
    samples = [plan.sample(n) for n in range(plan.samples)]
    assert len(set(samples)) == plan.samples == 3 * 21 * 5
    assert Counter(s.size for s in samples) == {128: 15, 256: 60, 512: 240}
    assert Counter(s.fraction for s in samples) == dict.fromkeys(STAGES, 63)
    assert {(s.row, s.column) for s in samples if s.size == 512} == {(i, j) for i in range(4) for j in range(4)}
    assert [s.shape for s in samples] == sorted(s.shape for s in samples)


def test_a_plan_is_a_function_of_its_seed() -> None:
    one, again, other = Plan(1), Plan(1), Plan(2)
    for name in ("train", "validation", "test"):
        np.testing.assert_array_equal(one.split(name), again.split(name))
        assert not np.array_equal(one.split(name), other.split(name))
    np.testing.assert_array_equal(one.mask(7, 0.25), again.mask(7, 0.25))
    assert not np.array_equal(one.mask(7, 0.25), other.mask(7, 0.25))
    assert not np.array_equal(one.mask(7, 0.25), one.mask(8, 0.25))
    assert not np.array_equal(one.mask(7, 0.25), one.mask(7, 0.25, turn=1))
    assert one.camera(3, 256) == again.camera(3, 256)
    assert len({one.camera(shape, size) for shape in range(9) for size in SIZES} | {other.camera(3, 256)}) == 28


@pytest.mark.parametrize("fraction", STAGES)
def test_masks_have_their_share_of_the_pixels(fraction: float) -> None:
    mask = Plan().mask(12, fraction)
    assert mask.sum() == round(fraction * 128 * 128)
    assert set(np.unique(mask)) <= {0, 1}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"shapes": 1}, "shapes: expected an integer in 2..1000000, got 1"),
        ({"seed": -1}, "seed: expected an integer in 0..4294967295, got -1"),
        ({"shapes": 10}, "test_shapes: expected fewer than all 10 shapes, got 10"),
    ],
)
def test_plans_that_make_no_sense(arguments: dict[str, int], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Plan(**arguments)
    assert str(caught.value) == message
    with pytest.raises(InputError, match="split: expected one of train, validation, test, got 'all'"):
        Plan().split("all")


# ---- the shapes ---------------------------------------------------------------------------------------------


def test_shapes_of_every_kind_come_up() -> None:
    kinds = Counter(i.shape.kind for seed in range(40) for i in procedural_scene(seed).instances[:1])
    assert {"mesh", "implicit", "brep"} <= set(kinds)
    assert sum(chance for chance, _ in KINDS.values()) == pytest.approx(1)


def test_a_formula_that_is_nowhere_is_drawn_again() -> None:
    assert procedural_scene(1_000_201).instances  # of this seed one is


def test_colored_shapes_are_the_same_in_other_colors() -> None:
    for seed in (1_000_001, 1_000_002, 1_000_009, 1_000_010):
        plain, colored = bob.trace(procedural_scene(seed), size=(48, 48)), bob.trace(colored_scene(seed), size=(48, 48))
        np.testing.assert_array_equal(colored.mask, plain.mask)
        np.testing.assert_allclose(colored.depth, plain.depth, atol=1e-6)
        assert colored_scene(seed).instances[0].digest() == colored_scene(seed).instances[0].digest()


def test_a_quarter_of_the_colored_shapes_is_white() -> None:
    assert sum(LOOKS.values()) == pytest.approx(1)
    assert LOOKS[white] == 0.25
    assert 0.18 < np.mean([is_white(seed) for seed in range(400)]) < 0.32
    for seed in range(8):
        assert is_white(seed) is not colored_scene(seed).is_colored


def test_patterns_and_textures_on_shapes_of_every_kind() -> None:
    rng = np.random.default_rng(4)
    for seed in (1, 2, 5, 9, 10):
        scene = procedural_scene(seed)
        for look in (patterns, textured):
            picture = bob.trace(look(rng, scene), size=(64, 64))
            seen = picture.albedo[picture.depth > 0]
            assert len(np.unique(seen, axis=0)) > 1 or scene.instances[0].shape.kind in ("tube", "brep"), (seed, look)


@pytest.mark.parametrize("kind", TEXTURES, ids=lambda kind: kind.__name__)
def test_textures_have_something_to_see_and_no_seam(kind) -> None:
    for seed in range(3):
        picture = np.clip(kind(np.random.default_rng(seed)), 0, 1)
        assert picture.shape == (SIDE, SIDE, 3)
        assert np.ptp(picture, axis=(0, 1)).max() > 0.02
        steps = np.abs(np.diff(np.concatenate([picture, picture[:1]]), axis=0)).mean(axis=(1, 2))
        assert steps[-1] <= 1.5 * steps.max()  # the last row joins the first as smoothly as others


def test_a_texture_is_a_function_of_its_generator() -> None:
    one, again, other = (some_texture(np.random.default_rng(seed)) for seed in (3, 3, 4))
    assert (one.dtype, one.shape) == (np.uint8, (SIDE, SIDE, 3))
    np.testing.assert_array_equal(one, again)
    assert not np.array_equal(one, other)


# ---- building -----------------------------------------------------------------------------------------------

OBJ = """
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""


def files(folder: Path) -> dict[str, bytes]:
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("built") / "data"
    build(path, shapes=4, test_shapes=1, seed=3)
    return path


def test_views_are_those_of_the_plan(built: Path) -> None:
    dataset = Dataset.open(built)
    assert dataset.plan == Plan(3, 4, 1)
    assert dataset.sources == tuple(f"made {3_000_000 + i}" for i in range(4))
    scene = procedural_scene(3_000_002)
    for size, view in zip(SIZES, views_of(scene, dataset.plan, 2), strict=True):
        np.testing.assert_array_equal(dataset.read(2, size), view)
        full = bob.trace(scene, dataset.plan.camera(2, size), size=(size, size))
        np.testing.assert_allclose(view[0], full.gray, atol=0.00025)
    patches = dataset.patches(2)
    for number in range(2 * 105, 3 * 105, 5):
        _, size, row, column, _ = dataset.plan.sample(number)
        rows, columns = slice(128 * row, 128 * (row + 1)), slice(128 * column, 128 * (column + 1))
        np.testing.assert_array_equal(patches[number // 5 - 42], dataset.read(2, size)[:, rows, columns])


def test_the_files_describe_themselves(built: Path) -> None:
    zarr = pytest.importorskip("zarr")
    group = zarr.open_group(built, mode="r")
    assert group.metadata.zarr_format == 3
    assert group.attrs["channels"] == ["gray", "depth", "normal x", "normal y"]
    view = group["views_256"]
    assert (view.shape, view.dtype, view.chunks, view.shards) == (
        (4, 4, 256, 256),
        np.float16,
        (1, 4, 128, 128),
        (1, 4, 256, 256),
    )
    assert view.metadata.dimension_names == ("shape", "channel", "row", "column")
    size = sum(map(len, files(built).values()))
    assert size / 4 * 479 < 1.5e9


def test_colored_views_half_of_them_in_perspective(tmp_path: Path) -> None:
    dataset = build(tmp_path / "data", shapes=2, test_shapes=1, seed=3, colored=True)
    assert Dataset.open(tmp_path / "data").plan == dataset.plan == Plan(3, 2, 1, colored=True)
    assert dataset.sources == ("colored 3000000", "colored 3000001")
    for size, view in zip(SIZES, views_of(colored_scene(3_000_001), dataset.plan, 1), strict=True):
        np.testing.assert_array_equal(dataset.read(1, size), view)
    views = [(shape, size) for shape in range(100) for size in SIZES]
    cameras = [Plan(3, 100, 1, colored=True).camera(*view) for view in views]
    fovs = np.array([camera.fov for camera in cameras if camera.fov])
    assert 0.4 < len(fovs) / 300 < 0.6
    assert 20 <= fovs.min() < 25
    assert 65 < fovs.max() <= 70
    for camera, view in zip(cameras, views, strict=True):
        assert bob.Camera(camera.azimuth, camera.elevation, camera.roll) == Plan(3, 100, 1).camera(*view)
    with pytest.raises(InputError, match=r"the data set begun there, got another colored, sources$"):
        build(tmp_path / "data", shapes=2, test_shapes=1, seed=3)


def test_a_build_that_was_killed_ends_with_the_same_bytes(built: Path, tmp_path: Path) -> None:
    path = tmp_path / "data"
    command = [sys.executable, "-m", "bobrossnet", "dataset", "build", str(path)]
    command += ["--shapes", "4", "--test-shapes", "1", "--seed", "3"]
    with running(command, stdout=subprocess.DEVNULL) as process:
        deadline = time.monotonic() + 60
        while not list(path.glob("views_*/c/*")) and time.monotonic() < deadline:
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
    before = files(path)
    assert before
    (path / "views_128" / "c" / "3.abc.partial").write_bytes(b"half a view")  # as if killed during a write
    build(path, shapes=4, test_shapes=1, seed=3)
    assert files(path) == files(built)
    times = {file: os.stat(file).st_mtime_ns for file in path.rglob("*") if file.is_file()}
    build(path, shapes=4, test_shapes=1, seed=3)
    assert times == {file: os.stat(file).st_mtime_ns for file in path.rglob("*") if file.is_file()}


def test_files_are_on_the_disk_before_they_have_their_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After a power cut a file can be empty, unless it was synced first."""
    synced = set()

    def fsync(handle: int, of: Callable[[int], None] = os.fsync) -> None:
        of(handle)
        found = os.fstat(handle)
        synced.add((found.st_ino, found.st_size) if stat.S_ISREG(found.st_mode) else found.st_ino)

    monkeypatch.setattr(os, "fsync", fsync)
    path = tmp_path / "data"
    build(path, shapes=2, test_shapes=1)
    for file in [path, *path.rglob("*")]:
        found = file.stat()
        assert (found.st_ino if file.is_dir() else (found.st_ino, found.st_size)) in synced


@pytest.mark.parametrize("damage", ["a byte", "a byte of its index", "empty", "cut"])
def test_damaged_views_are_named_and_rendered_again(damage: str, built: Path, tmp_path: Path) -> None:
    path = tmp_path / "data"
    shutil.copytree(built, path)
    file = path / "views_256" / "c" / "2" / "0" / "0" / "0"
    content = bytearray(file.read_bytes())
    if damage.startswith("a byte"):
        content[len(content) // 2 if damage == "a byte" else -20] ^= 1
    file.write_bytes(content[: {"empty": 0, "cut": 100}.get(damage, len(content))])
    message = f"^{re.escape(str(file))}: expected a view as it was written, got a damaged one; bobrossnet dataset"
    with pytest.raises(InputError, match=message):
        Dataset.open(path).read(2, 256)
    with pytest.raises(InputError, match=message):
        list(Batches(Dataset.open(path), "train", size=32).stream())
    with pytest.warns(InputWarning, match=message):
        build(path, shapes=4, test_shapes=1, seed=3)
    assert files(path) == files(built)


@pytest.mark.parametrize("folder", ["", "views_128"])
@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"{}", b'{"zarr_format": 3, "node_type": "group"}'])
def test_a_damaged_index_is_named(folder: str, content: bytes, built: Path, tmp_path: Path) -> None:
    path = tmp_path / "data"
    shutil.copytree(built, path)
    index = path / folder / "zarr.json"
    index.write_bytes(content)
    with pytest.raises(InputError, match=r"^[^\n]*: expected [^\n]*$") as caught:
        Dataset.open(path)
    assert str(caught.value).startswith(str(path / folder))
    index.unlink()
    build(path, shapes=4, test_shapes=1, seed=3)
    assert files(path) == files(built)


def test_a_file_in_a_folder_named_like_a_source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("made things/a.obj", "colored 5/b.obj"):
        Path(name).parent.mkdir()
        Path(name).write_text(OBJ)
    dataset = build("data", files=["made things", "colored 5"], test_shapes=1)
    assert dataset.sources == ("made things/a.obj", "colored 5/b.obj")


def test_files_instead_of_shapes_and_beside_them(tmp_path: Path) -> None:
    folder = tmp_path / "shapes"
    folder.mkdir()
    for name in ("b.obj", "a.obj"):
        (folder / name).write_text(OBJ)
    (folder / "broken.obj").write_text("v 0 0\n")
    (folder / "notes.txt").write_text("not a shape")
    with pytest.warns(InputWarning, match=r"left out: broken\.obj: ") as warned:
        dataset = build(tmp_path / "data", files=[folder], test_shapes=1)
    assert dataset.sources == (str(folder / "a.obj"), str(folder / "b.obj"))
    assert len(warned) == 1
    np.testing.assert_array_equal(dataset.read(1, 128), views_of(bob.load(folder / "b.obj"), dataset.plan, 1)[0])
    both = build(tmp_path / "both", shapes=1, files=[folder / "a.obj"], test_shapes=1)
    assert both.sources == ("made 0", str(folder / "a.obj"))


def test_a_dask_cluster_renders_the_same_bytes(built: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp", host="127.0.0.1"
    ) as cluster:
        build(tmp_path / "data", shapes=4, test_shapes=1, seed=3, scheduler=cluster.scheduler_address)
    assert files(tmp_path / "data") == files(built)


def test_builds_that_are_refused(built: Path, tmp_path: Path) -> None:
    before = files(built)
    with pytest.raises(InputError, match=r"the data set begun there, got another seed, sources$"):
        build(built, shapes=4, test_shapes=1, seed=4)
    assert files(built) == before
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match="expected an empty folder or a data set, got other files"):
        build(tmp_path, shapes=4, test_shapes=1)
    with pytest.raises(InputError, match="expected a shape file or a folder of them, got no such file"):
        build(tmp_path / "data", files=[tmp_path / "none"])
    with pytest.raises(InputError, match="scheduler: expected a Dask scheduler's address, got 'nonsense'"):
        build(tmp_path / "data", shapes=4, test_shapes=1, scheduler="nonsense")
    assert [file.name for file in tmp_path.iterdir()] == ["letter.txt"]
    with pytest.raises(InputError, match="expected a data set, got none"):
        Dataset.open(tmp_path)
    Dataset.create(tmp_path / "begun", Plan(0, 4, 1), ["made 0", "made 1", "made 2", "made 3"])
    with pytest.raises(InputError, match="expected all 12 views, got 12 fewer; bobrossnet dataset build completes it"):
        Dataset.open(tmp_path / "begun")


# ---- mini-batches -------------------------------------------------------------------------------------------


def test_a_batch_is_what_the_plan_says(built: Path) -> None:
    dataset = Dataset.open(built)
    batch = Batches(dataset, "train", size=6)[2]
    assert batch.partial.shape == (6, 5, 128, 128)
    assert batch.reference.shape == (6, 1, 128, 128)
    for i, number in enumerate(batch.numbers.tolist()):
        sample = dataset.plan.sample(number)
        patch = dataset.patches(sample.shape)[number // 5 % 21].astype(np.float32)
        mask = dataset.plan.mask(number, sample.fraction)
        assert batch.fractions[i] == sample.fraction
        np.testing.assert_array_equal(batch.partial[i, 0], mask)
        np.testing.assert_array_equal(batch.partial[i, 1:], patch * mask)
        np.testing.assert_array_equal(batch.reference[i, 0], patch[0])


@pytest.mark.parametrize("shuffle", [True, False])
def test_an_epoch_has_every_sample_once(built: Path, shuffle: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loader, "BLOCK", 2)
    dataset = Dataset.open(built)
    batches = Batches(dataset, "train", size=32, shuffle=shuffle)
    numbers = np.concatenate([batch.numbers for batch in batches.stream()])
    assert np.array_equal(numbers, dataset.plan.split("train")) is not shuffle
    np.testing.assert_array_equal(np.sort(numbers), dataset.plan.split("train"))
    assert len(batches) == -(-len(numbers) // 32)


def test_batches_are_functions_of_seed_epoch_and_step(built: Path) -> None:
    dataset = Dataset.open(built)
    batches = Batches(dataset, "train", size=16, seed=5, epoch=2)
    for workers in (0, 1, 3):
        streamed = list(batches.stream(3, workers))
        assert len(streamed) == len(batches) - 3
        for batch, step in ((streamed[0], 3), (streamed[-1], len(batches) - 1)):
            again = Batches(dataset, "train", size=16, seed=5, epoch=2)[step]
            assert batch.partial.equal(again.partial)
            assert batch.reference.equal(again.reference)
    for other in ({"seed": 6, "epoch": 2}, {"seed": 5, "epoch": 1}):
        assert not np.array_equal(Batches(dataset, "train", size=16, **other)[3].numbers, batches[3].numbers)


def test_ranks_share_a_mini_batch(built: Path) -> None:
    dataset = Dataset.open(built)
    whole = Batches(dataset, "train", size=7)[1]
    parts = [Batches(dataset, "train", size=7, rank=rank, ranks=2)[1] for rank in range(2)]
    assert [len(part.numbers) for part in parts] == [4, 3]
    for rank, part in enumerate(parts):
        assert part.partial.equal(whole.partial[rank::2])


def test_detail_is_where_gray_changes(built: Path) -> None:
    dataset = Dataset.open(built)
    shape, patch = 1, 3
    gray = dataset.patches(shape)[patch, 0].astype(float)
    expected = np.abs(gray[1:] - gray[:-1]).mean() + np.abs(gray[:, 1:] - gray[:, :-1]).mean()
    assert dataset.detail[shape, patch] == pytest.approx(expected)
    assert dataset.detail.shape == (dataset.plan.shapes, 21)


def test_detail_of_a_colored_data_set_is_the_root(built: Path) -> None:
    dataset, colored = Dataset.open(built), Dataset.open(built)
    colored.plan = replace(dataset.plan, colored=True)
    np.testing.assert_allclose(colored.detail, np.sqrt(dataset.detail))


def test_patches_drawn_by_their_detail(built: Path) -> None:
    dataset = Dataset.open(built)
    batches = Batches(dataset, "train", size=32, draw="by-detail", fractions="sparse", epoch=1)
    drawn = list(batches.stream())
    numbers = np.concatenate([batch.numbers for batch in drawn])
    samples = dataset.plan.split("train")
    assert len(numbers) == len(samples)
    patches = samples[::5] // 5
    weights = dataset.detail.ravel()[patches]
    weights += loader.FLAT * weights.mean()
    counts = np.bincount(numbers // 5, minlength=dataset.detail.size)
    assert np.abs(counts[patches] - weights / weights.sum() * len(samples)).max() < 1
    assert counts.sum() == counts[patches].sum()  # of no patch for validation or testing
    # A repeated sample has a different mask.
    most = np.bincount(numbers).argmax()
    masks = [
        part[0] for batch in drawn for part, number in zip(batch.partial, batch.numbers, strict=True) if number == most
    ]
    assert len(masks) > 1
    assert not masks[0].equal(masks[1])
    again = Batches(dataset, "train", size=32, draw="by-detail", fractions="sparse", epoch=1)[2]
    assert again.partial.equal(drawn[2].partial)
    with pytest.raises(InputError, match="draw: expected one of each, by-detail, got 'twice'"):
        Batches(dataset, "train", draw="twice")


def test_orders_take_turns(built: Path) -> None:
    dataset = Dataset.open(built)
    for epoch in range(2):
        batch = Batches(dataset, "train", size=6, shuffle=True, epoch=epoch, order="lattice+uniform")[1]
        for number, mask, fraction in zip(batch.numbers.tolist(), batch.partial[:, 0], batch.fractions, strict=True):
            order = ("lattice", "uniform")[(number + epoch) % 2]
            expected = dataset.plan.mask(number, fraction, turn=epoch, order=order)
            np.testing.assert_array_equal(mask, expected)


def test_adaptive_masks_go_through_the_whole_view(built: Path) -> None:
    dataset = Dataset.open(built)
    batch = Batches(dataset, "train", size=40, order="adaptive", fractions="sparse")[0]
    sizes = set()
    for number, mask, fraction in zip(batch.numbers.tolist(), batch.partial[:, 0], batch.fractions, strict=True):
        sample = dataset.plan.sample(number)
        view = part_of(dataset.read(sample.shape, sample.size).astype(np.float32), np.ones((sample.size,) * 2))
        row, column = 128 * sample.row, 128 * sample.column
        whole = view.sample(float(fraction), order="adaptive", seed=dataset.plan.seed)
        traced = whole.mask[row : row + 128, column : column + 128]
        np.testing.assert_array_equal(mask, traced)
        sizes.add(sample.size)
    assert len(sizes) > 1


def test_fractions_of_all_sizes(built: Path) -> None:
    batches = Batches(Dataset.open(built), "train", fractions="log-uniform", epoch=1)
    fractions = np.concatenate([batch.fractions for batch in batches.stream()])
    assert 0.01 <= fractions.min() < 0.015
    assert (fractions == 1).mean() == pytest.approx(0.1, abs=0.07)
    assert np.median(fractions[fractions < 1]) == pytest.approx(0.1, abs=0.04)
    assert len(np.unique(fractions)) > 200
    for epoch, most in ((1, 0.9), (5, 0.9), (6, 0.3), (9, 0.3)):
        sparse = Batches(batches.dataset, "train", fractions="sparse", epoch=epoch)
        fractions = np.concatenate([batch.fractions for batch in sparse.stream()])
        assert 0.005 <= fractions.min() < 0.01
        assert 0.7 * most < fractions.max() <= most
    with pytest.raises(InputError, match="fractions: expected one of stages, log-uniform, sparse, got 'all'"):
        Batches(batches.dataset, "train", fractions="all")
    with pytest.raises(IndexError):
        batches[len(batches)]
