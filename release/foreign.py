"""Python for other machines, assembled from packages of Debian and PyPI."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import abi3info
from wheels import ROOT, ZIG

KEYS = "/usr/share/keyrings/debian-archive-keyring.gpg"
SUITE = "trixie"
"""A Debian release with a Python new enough for the stable ABI of the wheels."""


def debian_mirror() -> str:
    """Return the mirror from which this machine gets Debian packages."""
    asked = ["apt-get", "indextargets", "--format", "$(SITE)", "Origin: Debian"]
    return subprocess.run(asked, capture_output=True, text=True, check=True).stdout.splitlines()[0]


def debian_python(architecture: str, folder: Path) -> Path:
    """Return the root of a Debian with Python in `folder`, downloaded by a separate apt."""
    root = folder / "root"
    if (root / "usr/bin/python3").exists():
        return root
    for below in ("state/lists/partial", "cache/archives/partial", "etc"):
        (folder / below).mkdir(parents=True, exist_ok=True)
    (folder / "status").touch()
    (folder / "sources").write_text(f"deb [signed-by={KEYS}] {debian_mirror()} {SUITE} main\n")
    options = {
        "APT::Architecture": architecture,
        "APT::Architectures": architecture,
        "APT::Sandbox::User": "root",
        "Dir::Cache": folder / "cache",
        "Dir::State": folder / "state",
        "Dir::State::status": folder / "status",
        "Dir::Etc::sourcelist": folder / "sources",
        "Dir::Etc::sourceparts": "-",
    }
    apt = ["apt-get", "-qq", *(word for name, value in options.items() for word in ("-o", f"{name}={value}"))]
    subprocess.run([*apt, "update"], check=True)
    packages = ["python3", "libstdc++6", "zlib1g"]
    subprocess.run([*apt, "install", "--download-only", "--no-install-recommends", "-y", *packages], check=True)
    # Debian has its libraries below /usr, with links from /.
    root.mkdir(exist_ok=True)
    for name in ("bin", "lib", "sbin"):
        (root / "usr" / name).mkdir(parents=True, exist_ok=True)
        if not (root / name).exists():
            (root / name).symlink_to(f"usr/{name}")
    for package in sorted((folder / "cache/archives").glob("*.deb")):
        subprocess.run(
            f"dpkg-deb --fsys-tarfile '{package}' | tar -x --keep-directory-symlink -C '{root}'", shell=True, check=True
        )
    return root


def install_for(tags: list[str], python: str, wheel: Path, site: Path) -> None:
    """Install a wheel and its dependencies into a folder, for a Python on another machine."""
    platforms = [f"--platform={tag}" for tag in tags]
    command = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--upgrade",
        "--only-binary=:all:",
    ]
    subprocess.run([*command, f"--python-version={python}", *platforms, f"--target={site}", wheel], check=True)


def windows_loader(folder: Path) -> Path:
    """Return a program in `folder` that loads native modules on Windows.

    Next to it is a python3.dll with functions that only end the process.
    """
    stub, library, loader = folder / "python3.c", folder / "python3.dll", folder / "load.exe"
    functions = [
        f"__declspec(dllexport) void {symbol.name}(void) {{ __builtin_trap(); }}" for symbol in abi3info.FUNCTIONS
    ]
    data = [f"__declspec(dllexport) char {symbol.name}[1024];" for symbol in abi3info.DATAS]
    stub.write_text("\n".join([*functions, *data, ""]))
    compiler = [ZIG, "cc", "-target", "x86_64-windows-gnu", "-O3", "-s"]
    subprocess.run([*compiler, "-shared", stub, "-o", library], check=True)
    subprocess.run([*compiler, ROOT / "release/windows/load.c", "-o", loader], check=True)
    return loader
