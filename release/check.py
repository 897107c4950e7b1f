"""Checks of the wheels in dist: each is installed and run from an empty folder, as far as this machine can.

`make check-wheels` runs it. Every line names a wheel, a question and the answer, or the reason why it can't run here.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path

import lief
from foreign import debian_python, install_for, windows_loader
from platforms import PLATFORMS, STABLE_ABI, Platform
from wheels import BUILD, ROOT, environment

sys.path.append(str(ROOT / "tests"))
from instruction_set import best_instruction_set

WORK = ROOT / "build/check-wheels"
MOST_BYTES = 8_000_000

ON_ARM = [
    "adaptive",
    "arrange",
    "complet",
    "corner",
    "edge",
    "expression",
    "interpolat",
    "layout",
    "loop",
    "network",
    "nurbs",
    "order",
    "pixel",
    "point",
    "seen",
    "size",
    "texture",
    "trac",
    "vm",
]
"""Parts of the names of the core's tests that run under qemu; --whole runs all of them, for 16 minutes."""


class Report:
    """Prints and counts the answers."""

    def __init__(self) -> None:
        self.passed, self.failed, self.absent = 0, 0, 0

    def say(self, wheel: str, what: str, answer: str, ok: bool = True) -> None:
        self.passed += ok
        self.failed += not ok
        print(f"{'ok    ' if ok else 'FAILED'} {wheel:24} {what}: {answer}", flush=True)

    def cannot(self, wheel: str, what: str, why: str) -> None:
        self.absent += 1
        print(f"not run {wheel:23} {what}: {why}", flush=True)


PROCESSORS = {"x86_64": "X86_64", "aarch64": "ARM64"}
"""Names of zig's processors in lief."""

LIBRARIES = {
    "linux": r"lib(c|m|dl|pthread|rt)\.so(\.\d)?|ld-linux-\w+-?\w*\.so\.\d",
    "windows": r"python3\.dll|KERNEL32\.dll|api-ms-win-crt-\w+-l1-1-0\.dll",
    "macos": r"/usr/lib/libSystem\.B\.dylib",
}
"""Libraries present on every installation of each system."""


def tool(name: str, *arguments: str | Path) -> dict:
    """Return the JSON output of a tool of this environment."""
    return json.loads(
        subprocess.run([sys.executable, "-m", name, *arguments], stdout=subprocess.PIPE, text=True).stdout
    )


def glibc(tag: str) -> int:
    """Return the minor version of glibc, such as the 28 of manylinux_2_28_x86_64."""
    return int(re.match(r"manylinux_2_(\d+)_", tag)[1])


def check_contents(report: Report, platform: Platform, wheel: Path, files: set[str]) -> None:
    """Check size, files, libraries and symbols, on every platform, without running code."""
    size = wheel.stat().st_size
    report.say(platform.tag, "size", f"{size / 1e6:.2f} MB", size <= MOST_BYTES)
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        own = sorted(names - files)
        native = archive.read(own[0])
        machine_paths = [n for n in names if os.fsencode(ROOT) in archive.read(n)]
    expected = "_core.pyd" if platform.system == "windows" else "_core.abi3.so"
    report.say(platform.tag, "files that not all wheels have", ", ".join(own), own == [f"bobrossnet/{expected}"])
    report.say(platform.tag, "files with paths of this machine", ", ".join(machine_paths) or "none", not machine_paths)
    module = lief.parse(native).abstract
    processor = module.header.architecture.name
    report.say(platform.tag, "processor", processor, PROCESSORS[platform.target.split("-")[0]] == processor)
    libraries = sorted({*map(str, module.libraries)} - {expected})  # macOS modules name themselves
    usual = all(re.fullmatch(LIBRARIES[platform.system], library) for library in libraries)
    report.say(platform.tag, "libraries", ", ".join(libraries), usual)
    (audit,) = tool("abi3audit", "--strict", "--report", wheel)["specs"].values()
    (found,) = (module["result"] for module in audit["wheel"])
    others = [*found["non_abi3_symbols"], *found["future_abi3_objects"]]
    answer = f"{len(others)} symbols that the stable ABI of Python {found['baseline']} lacks"
    report.say(platform.tag, "abi3audit", answer, not others)
    if platform.system == "linux" and not platform.musl:
        oldest = tool("auditwheel", "show", "--json", wheel)["overall_tag"]
        report.say(platform.tag, "auditwheel", oldest, glibc(oldest) <= glibc(platform.tag))
    if platform.system == "macos":
        macho = lief.MachO.parse(native).at(0)
        oldest = macho.build_version.minos if macho.build_version else macho.version_min.version
        shown = f"{oldest[0]}.{oldest[1]}"
        report.say(platform.tag, "oldest macOS", shown, platform.target.endswith(f"macos.{shown}"))
        signed = macho.has_code_signature
        report.say(platform.tag, "signature", "ad hoc" if signed else "none", signed)


def smoke(command: Sequence[str | Path], variables: dict[str, str] | None = None) -> dict[str, object]:
    """Return the answers of release/smoke.py, run in an empty folder."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [*command, ROOT / "release/smoke.py"],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": "", **(variables or {})},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
    return json.loads(done.stdout.splitlines()[-1])


def check_pictures(report: Report, wheel: str, how: str, got: dict, source: dict) -> None:
    """Check that pictures equal the source build's, to the bit."""
    for isa, pictures in got["pictures"].items():
        other = [name for name, bits in pictures.items() if source["pictures"].get(isa, {}).get(name) != bits]
        answer = f"{len(pictures) - len(other)} of {len(pictures)} digests are the source build's"
        answer += f", not {'; '.join(other)}" if other else ""
        report.say(wheel, f"pictures, {how}, {isa}", answer, not other)


def check_installed(report: Report, platform: Platform, wheel: Path, python: Path, source: dict) -> None:
    """Check the wheel installed by pip with its dependencies, in a new environment."""
    folder = WORK / f"{platform.tag}-{python.name}-{python.parent.parent.name}"
    own = folder / "bin/python"
    if not own.exists():
        subprocess.run([python, "-m", "venv", folder], check=True)
    subprocess.run([own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel], check=True)
    reinstall = ["--force-reinstall", "--no-deps"]  # replaces an earlier build of the same version
    subprocess.run(
        [own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *reinstall, wheel], check=True
    )
    got = smoke([own])
    how = f"Python {got['python']}"
    report.say(platform.tag, f"installed, {how}", str(got["package"]), str(folder) in str(got["package"]))
    best = best_instruction_set()
    report.say(
        platform.tag, f"instruction set, {how}", f"{got['isa']}, and /proc/cpuinfo has {best}", got["isa"] == best
    )
    check_pictures(report, platform.tag, how, got, source)


def check_sdist(report: Report, sdist: Path, python: Path, source: dict) -> None:
    """Check the source distribution, compiled by pip in a new environment, with its WebAssembly modules."""
    folder = WORK / "sdist"
    own = folder / "bin/python"
    subprocess.run([python, "-m", "venv", "--clear", folder], check=True)
    subprocess.run([own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", sdist], check=True)
    got = smoke([own])
    how = f"Python {got['python']}"
    package = Path(str(got["package"]))
    report.say("sdist", f"installed, {how}", str(package), folder in package.parents)
    check_pictures(report, "sdist", how, got, source)
    with tarfile.open(sdist) as archive:
        modules = {Path(f.name).name: archive.extractfile(f).read() for f in archive if f.name.endswith(".wasm")}
    same = [n for n, data in modules.items() if (package / "viewer" / n).read_bytes() == data]
    answer = f"{len(same)} of {len(modules)} are the source distribution's"
    report.say("sdist", "WebAssembly modules", answer, bool(modules) and len(same) == len(modules))


def check_core(report: Report, platform: Platform, runner: Sequence[str | Path], names: Sequence[str] = ()) -> None:
    """Run the core's tests, built by the same compiler from the same objects."""
    folder = BUILD / platform.tag
    quiet = {"stdout": subprocess.DEVNULL, "env": environment(), "check": True}
    subprocess.run(["cmake", "-DBOBROSSNET_TESTS=ON", folder], **quiet)
    subprocess.run(["cmake", "--build", folder, "--target", "core_tests"], **quiet)
    suffix = ".exe" if platform.system == "windows" else ""
    done = subprocess.run(
        [*runner, folder / f"core_tests{suffix}", *names], stdout=subprocess.PIPE, text=True, errors="replace"
    )
    last = (done.stdout.strip().splitlines() or ["no answer"])[-1]
    some = " of those that this check selects" if names else ""
    report.say(
        platform.tag, f"core tests{', ' + Path(runner[0]).name if runner else ''}", last + some, done.returncode == 0
    )


def check_musl_loader(report: Report, platform: Platform, wheel: Path) -> None:
    """Check that musl's loader finds every symbol of the module except Python's, which an interpreter provides."""
    loader = Path("/lib/ld-musl-x86_64.so.1")
    if not loader.exists():
        return report.cannot(platform.tag, "loaded by musl", "needs musl's loader (Debian: musl)")
    with zipfile.ZipFile(wheel) as archive:
        module = Path(archive.extract("bobrossnet/_core.abi3.so", WORK / platform.tag))
    module.chmod(0o755)
    asked = subprocess.run([loader, "--list", module], capture_output=True, text=True)
    missing = re.findall(r"(\w+): symbol not found", asked.stdout + asked.stderr)
    others = [name for name in missing if not re.match(r"_?Py", name)]
    answer = f"{len(missing) - len(others)} symbols of Python are missing, others: {', '.join(others) or 'none'}"
    report.say(platform.tag, "loaded by musl, without Python", answer, bool(missing) and not others)


def check_on_arm(report: Report, platform: Platform, wheel: Path, source: dict, names: Sequence[str]) -> None:
    """Check under qemu: the core's tests, and with glibc also the wheel in Debian's Python."""
    if not shutil.which("qemu-aarch64"):
        return report.cannot(platform.tag, "core tests, installed", "needs qemu-aarch64 (Debian: qemu-user)")
    if platform.musl:
        return check_core(report, platform, ["qemu-aarch64"], names)
    root = debian_python("arm64", WORK / "debian-arm64")
    qemu = ["qemu-aarch64", "-L", root]
    python, site = root / "usr/bin/python3", WORK / f"{platform.tag}-site"
    version = python.resolve().name.removeprefix("python")
    shutil.rmtree(site, ignore_errors=True)
    install_for(
        [f"manylinux_2_{minor}_aarch64" for minor in range(28, 16, -1)] + ["manylinux2014_aarch64"],
        version,
        wheel,
        site,
    )
    got = smoke([*qemu, python], {"PYTHONPATH": str(site)})
    report.say(
        platform.tag, f"installed, qemu, Python {got['python']}", str(got["package"]), str(site) in str(got["package"])
    )
    # Its one instruction set has fused multiply-adds, like AVX2. A library's acos enters the meshes' normals.
    exact = {name: bits for name, bits in got["pictures"]["baseline"].items() if name.startswith(("formula", "nurbs"))}
    pictures = {"pictures": {"avx2": exact}}
    check_pictures(report, platform.tag, "qemu", pictures, source)
    check_core(report, platform, qemu, names)


def check_on_windows(report: Report, platform: Platform, wheel: Path) -> None:
    """Check under wine: the core's tests, and the module without Python, which no package provides."""
    wine = shutil.which("wine64-stable") or shutil.which("wine64") or "/usr/lib/wine/wine64"
    if not Path(wine).exists():
        return report.cannot(platform.tag, "core tests, loaded", "needs wine (Debian: wine64)")
    os.environ.update(WINEDEBUG="-all", WINEPREFIX=str(WORK / "wine"))
    with zipfile.ZipFile(wheel) as archive:
        module = Path(archive.extract("bobrossnet/_core.pyd", WORK / platform.tag))
    loaded = subprocess.run([wine, windows_loader(module.parent), module], stdout=subprocess.PIPE, text=True)
    report.say(platform.tag, "loaded, wine", loaded.stdout.strip() or "no answer", loaded.returncode == 0)
    check_core(report, platform, [wine])
    report.cannot(platform.tag, "installed", "needs Python for Windows")


def check_as_run(
    report: Report, platform: Platform, wheel: Path, pythons: Sequence[Path], whole: bool, source: dict
) -> None:
    """Run the checks of a wheel that this machine can run."""
    if platform.system == "macos":
        report.cannot(platform.tag, "core tests, installed", "needs macOS")
    elif platform.system == "windows":
        check_on_windows(report, platform, wheel)
    elif platform.target.startswith("aarch64"):
        check_on_arm(report, platform, wheel, source, () if whole else ON_ARM)
    elif platform.musl:
        check_musl_loader(report, platform, wheel)
        check_core(report, platform, [])
        report.cannot(platform.tag, "installed", "needs a Python that is linked to musl")
    else:
        for python in pythons:
            check_installed(report, platform, wheel, python, source)
        if not pythons:
            report.cannot(platform.tag, "installed", "needs Python 3.12 or later")
        check_core(report, platform, [])


def files_of_all(wheels: Sequence[Path]) -> set[str]:
    """Return the files common to all wheels, without the native module."""
    common = set.intersection(*(set(zipfile.ZipFile(wheel).namelist()) for wheel in wheels))
    return common - {"bobrossnet/_core.abi3.so", "bobrossnet/_core.pyd"}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tags", nargs="*", help="platforms, such as win_amd64, or sdist; if omitted, all")
    parser.add_argument("--dist", type=Path, default=ROOT / "dist")
    parser.add_argument(
        "--source", type=Path, default=ROOT / ".venv/bin/python", help="a Python with the package built from source"
    )
    parser.add_argument(
        "--python", type=Path, action="append", default=[], help="a Python 3.12 or later of this machine"
    )
    parser.add_argument(
        "--whole", action="store_true", help="all of the core's tests under qemu, not only some: 16 minutes"
    )
    arguments = parser.parse_args()
    report = Report()
    built = {p: wheel for p in PLATFORMS for wheel in arguments.dist.glob(f"bobrossnet-*-{STABLE_ABI}-{p.tag}.whl")}
    wanted = [p for p in PLATFORMS if not arguments.tags or p.tag in arguments.tags]
    WORK.mkdir(parents=True, exist_ok=True)
    common = files_of_all(list(built.values()))
    source = smoke([arguments.source])
    print(f"{'':31} source build, Python {source['python']}: {source['package']}, {source['isa']}")
    for platform in wanted:
        if platform not in built:
            report.say(platform.tag, "wheel", f"none in {arguments.dist}", False)
            continue
        wheel = built[platform]
        check_contents(report, platform, wheel, common)
        check_as_run(report, platform, wheel, arguments.python, arguments.whole, source)
    if not arguments.tags or "sdist" in arguments.tags:
        sdists = list(arguments.dist.glob("bobrossnet-*.tar.gz"))
        report.say("sdist", "source distributions", str(len(sdists)), len(sdists) == 1)
        for sdist in sdists:
            check_sdist(report, sdist, arguments.source, source)
    print(f"wheels: {report.passed} passed, {report.failed} failed, {report.absent} not run")
    return report.failed > 0


if __name__ == "__main__":
    sys.exit(main())
