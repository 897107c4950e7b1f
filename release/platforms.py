"""The platforms with wheels."""

from __future__ import annotations

from dataclasses import dataclass

STABLE_ABI = "cp312-abi3"
"""One wheel for CPython 3.12 and all later versions, as in pyproject.toml."""


@dataclass(frozen=True)
class Platform:
    """A system and a processor.

    Attributes
    ----------
    tag : str
        The platform tag in a wheel's file name.
    target : str
        zig's name for it, with the oldest supported system.
    """

    tag: str
    target: str

    @property
    def system(self) -> str:
        return self.target.split("-")[1].split(".")[0]

    @property
    def musl(self) -> bool:
        return self.target.endswith("musl")


PLATFORMS = [
    Platform("manylinux_2_28_x86_64", "x86_64-linux-gnu.2.28"),
    Platform("manylinux_2_28_aarch64", "aarch64-linux-gnu.2.28"),
    Platform("musllinux_1_2_x86_64", "x86_64-linux-musl"),
    Platform("musllinux_1_2_aarch64", "aarch64-linux-musl"),
    Platform("win_amd64", "x86_64-windows-gnu"),
    Platform("macosx_11_0_arm64", "aarch64-macos.11.0"),
    Platform("macosx_10_15_x86_64", "x86_64-macos.10.15"),
]
