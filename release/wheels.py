"""Builds the wheels of all platforms on one Linux machine, by the clang of the wheel `ziglang`, and the sdist.

`make wheels` runs it in an environment with release/requirements.txt, by Python 3.12 or later, for its headers of the
stable ABI. Objects stay in build/wheels/TAG. Files have the time of the last commit.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import abi3info
import nanobind
import ziglang
from platforms import PLATFORMS, STABLE_ABI, Platform

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/wheels"
ZIG = Path(ziglang.__file__).parent / "zig"


def environment() -> dict[str, str]:
    """Return an environment with the tools first in the path, and the last commit's time as the clock."""
    commit = subprocess.run(["git", "log", "-1", "--format=%ct"], cwd=ROOT, capture_output=True, text=True)
    return {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "SOURCE_DATE_EPOCH": os.environ.get("SOURCE_DATE_EPOCH") or commit.stdout.strip() or "1577836800",
    }


def build_modules() -> Path:
    """Return the folder of the WebAssembly modules, shared by all wheels and compiled by the same zig."""
    folder, quiet = BUILD / "modules", {"stdout": subprocess.DEVNULL, "env": environment(), "check": True}
    found = [f"-DPython_EXECUTABLE={sys.executable}", f"-Dnanobind_DIR={nanobind.cmake_dir()}"]
    subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", "-DSKBUILD=ON", *found], **quiet)
    subprocess.run(["cmake", "--build", folder, "--target", "wasm"], **quiet)
    return folder / "wasm"


def windows_python() -> dict[str, Path]:
    """Return CMake's paths of Python for Windows: headers with another pyconfig.h, and python3.dll's import library."""
    folder = BUILD / "python-windows"
    include, library, names = folder / "include", folder / "libpython3.a", folder / "python3.def"
    named = (
        folder / f"libpython{sys.version_info.major}{sys.version_info.minor}.a"
    )  # CMake takes versions from names alone
    shutil.copytree(sysconfig.get_path("include"), include, dirs_exist_ok=True)
    shutil.copy(ROOT / "release/windows/pyconfig.h", include)
    functions = sorted(symbol.name for symbol in abi3info.FUNCTIONS)
    data = sorted(symbol.name for symbol in abi3info.DATAS)
    names.write_text("\n".join(["LIBRARY python3.dll", "EXPORTS", *functions, *(f"{name} DATA" for name in data), ""]))
    subprocess.run([ZIG, "dlltool", "-m", "i386:x86-64", "-D", "python3.dll", "-d", names, "-l", library], check=True)
    shutil.copy(library, named)
    return {"Python_INCLUDE_DIR": include, "Python_LIBRARY": named, "Python_SABI_LIBRARY": library}


def build_wheel(platform: Platform, modules: Path, out: Path) -> Path:
    """Build a wheel like `pip install .`, except for the compiler and the platform's name."""
    folder = BUILD / platform.tag
    defines = {"ZIG": ZIG, "ZIG_TARGET": platform.target, "BOBROSSNET_WASM": modules}
    if platform.system == "windows":
        defines |= windows_python()
    subprocess.run(
        [
            *(sys.executable, "-m", "pip", "wheel", ".", "--no-deps", "--no-build-isolation", "--wheel-dir", out),
            *("--quiet", "--disable-pip-version-check"),
            f"-Cbuild-dir={folder}",
            f"-Ccmake.toolchain-file={ROOT / 'release/zig.cmake'}",
            *(f"-Ccmake.define.{name}={value}" for name, value in defines.items()),
        ],
        cwd=ROOT,
        env={**environment(), "_PYTHON_HOST_PLATFORM": platform.tag},
        check=True,
    )
    (wheel,) = out.glob(f"bobrossnet-*-{STABLE_ABI}-{platform.tag}.whl")
    return wheel


def build_sdist(modules: Path, out: Path) -> Path:
    """Build the source distribution, with the WebAssembly modules, so that users need not compile them."""
    viewer = ROOT / "viewer"
    before = set(viewer.glob("*.wasm"))  # from an editable install
    for module in modules.glob("*.wasm"):
        shutil.copy(module, viewer)
    subprocess.run(
        [sys.executable, "-m", "build", "--sdist", "--no-isolation", "--quiet", "--outdir", out],
        cwd=ROOT,
        env=environment(),
        check=True,
    )
    for module in set(viewer.glob("*.wasm")) - before:
        module.unlink()
    (sdist,) = out.glob("bobrossnet-*.tar.gz")
    return sdist


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "tags", nargs="*", help="platforms, such as win_amd64; if omitted, all, and the source distribution"
    )
    parser.add_argument("--modules", type=Path, help="folder of the WebAssembly modules; if omitted, they are built")
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    arguments = parser.parse_args()
    known = {platform.tag: platform for platform in PLATFORMS}
    for tag in arguments.tags:
        if tag not in known:
            parser.error(f"tags: expected one of {', '.join(known)}, got {tag}")
    modules, out = (arguments.modules or build_modules()).resolve(), arguments.out.resolve()
    if not any(modules.glob("*.wasm")):
        parser.error(f"--modules: expected a folder of WebAssembly modules, got {modules}, which has none")
    for tag in arguments.tags or known:
        begin = time.monotonic()
        wheel = build_wheel(known[tag], modules, out)
        print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.2f} MB, {time.monotonic() - begin:.0f} s", flush=True)
    if not arguments.tags:
        sdist = build_sdist(modules, out)
        print(f"{sdist.name}: {sdist.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
