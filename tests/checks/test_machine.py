"""Failures of the machine: full disks, files of other users. Both need root."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import COMMAND

NOBODY = 65534

pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason="needs root, to mount a disk and to act as another user")


def complaint(*arguments: str, **options: int) -> str:
    """Return the command's error message, one line."""
    done = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, timeout=120, **options)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    return done.stderr


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 64 KiB."""
    place = tmp_path / "disk"
    place.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", place], capture_output=True)
    if mounted.returncode:
        pytest.skip("this machine mounts no disks")
    yield place
    subprocess.run(["umount", place], check=True)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["render", "--size", "640x480", "--fraction", "100%", "--out"], "picture.png"),
        (["pack"], "scene.bob"),
        (["view", "--export"], "page"),
        (["dataset", "build", "--shapes", "3", "--test-shapes", "1"], "data"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_full_disk_keeps_what_is_on_it(arguments: list[str], name: str, small_disk: Path, tmp_path: Path) -> None:
    scene = tmp_path / "scene.stl"
    corners = "vertex 0 0 0\nvertex {i} 1 0\nvertex 0 1 {i}\n"
    faces = "".join(
        f"facet normal 0 0 1\nouter loop\n{corners.format(i=i + 1)}endloop\nendfacet\n" for i in range(3000)
    )
    scene.write_text(f"solid a\n{faces}endsolid a\n")
    filler, kept = small_disk / "filler", small_disk / name
    filler.write_bytes(bytes(48 << 10))
    if "." in name:
        kept.write_bytes(b"what was here before")
    message = complaint(*arguments, str(kept), *([str(scene)] if arguments[0] in ("pack", "view") else []))
    assert "No space left on device" in message
    assert filler.stat().st_size == 48 << 10
    if "." in name:
        assert kept.read_bytes() == b"what was here before"
        assert sorted(path.name for path in small_disk.iterdir()) == sorted([filler.name, kept.name])


def test_files_that_may_not_be_read_or_written(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("others")
    for parent in [folder, *folder.parents[:3]]:
        os.chmod(parent, 0o755)
    secret, scene = folder / "secret.ply", folder / "scene.sdf"
    secret.write_text("ply\n")
    scene.write_text("f = sphere(1)\n")
    secret.chmod(0o600)
    scene.chmod(0o644)
    try:
        allowed = subprocess.run([*COMMAND, "info", str(scene)], capture_output=True, text=True, user=NOBODY)
    except PermissionError:
        pytest.skip("another user can't run Python here")
    if allowed.returncode:
        pytest.skip("another user can't read the package here")
    assert "Permission denied" in complaint("info", str(secret), user=NOBODY)
    assert "read-only" in complaint("pack", str(folder / "scene.bob"), str(scene), user=NOBODY)
    assert not (folder / "scene.bob").exists()
