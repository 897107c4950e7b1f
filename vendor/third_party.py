"""Other people's code in the package: its licences, NOTICES.txt, and its list, sbom.cdx.json (CycloneDX).

python vendor/third_party.py     # after a new version of the package, nanobind, ziglang or yyjson
"""

from __future__ import annotations

import json
import re
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import nanobind
import ziglang

ROOT = Path(__file__).parent.parent
NANOBIND, ZIG = Path(nanobind.__path__[0]), Path(ziglang.__path__[0])
YYJSON = ROOT / "vendor/yyjson"
LLVM = "Apache-2.0 WITH LLVM-exception"


class Part(NamedTuple):
    name: str
    version: str
    license: str
    """An SPDX expression."""
    package: str
    """Its package URL, without the version."""
    used_in: str
    notice: str


def parts() -> list[Part]:
    """The libraries that are linked into the package's binaries."""
    zig, config = version("ziglang"), _read(ZIG / "lib/libcxx/include/__config")
    number = int(_found(r"define _LIBCPP_VERSION (\d+)", config))
    llvm = f"{number // 10000}.{number // 100 % 100}.{number % 100}"
    robin, wasi = NANOBIND / "ext/robin_map/include/tsl", ZIG / "lib/libc/wasi"
    growth = _read(robin / "robin_growth_policy.h")
    robin_version = ".".join(_found(rf"TSL_RH_VERSION_{name} (\d+)", growth) for name in ("MAJOR", "MINOR", "PATCH"))
    header = re.sub(r"^ ?\* ?", "", _found(r"/\*\*\n(.*?)\*/", _read(robin / "robin_map.h")), flags=re.MULTILINE)
    wasm, both = "viewer/*.wasm", "viewer/*.wasm, _core of released wheels"
    wasi_licenses = ("LICENSE", "LICENSE-MIT", "libc-bottom-half/cloudlibc/LICENSE", "libc-top-half/musl/COPYRIGHT")
    nanobind_license = _read(next(NANOBIND.parent.glob("nanobind-*.dist-info")) / "licenses/LICENSE")
    return [
        Part("nanobind", version("nanobind"), "BSD-3-Clause", "pkg:pypi/nanobind", "_core", nanobind_license),
        Part("robin-map", robin_version, "MIT", "pkg:github/Tessil/robin-map", "_core", header),
        *(
            Part(name, llvm, LLVM, f"pkg:generic/llvm/{name}", both, _read(ZIG / "lib" / folder / "LICENSE.TXT"))
            for name, folder in (("libc++", "libcxx"), ("libc++abi", "libcxxabi"), ("libunwind", "libunwind"))
        ),
        Part(
            "wasi-libc",
            f"of zig {zig}",
            "MIT AND BSD-2-Clause AND CC0-1.0",
            "pkg:github/WebAssembly/wasi-libc",
            wasm,
            "\n\n".join(_read(wasi / name) for name in wasi_licenses),
        ),
        Part("compiler-rt of zig", zig, "MIT", "pkg:pypi/ziglang", both, _read(ZIG / "LICENSE")),
        Part(
            "mingw-w64",
            f"of zig {zig}",
            "ZPL-2.1",
            "pkg:generic/mingw-w64",
            "_core of released wheels for Windows",
            _read(ZIG / "lib/libc/mingw/COPYING"),
        ),
        Part(
            "yyjson",
            _found(r'YYJSON_VERSION_STRING "(\S+)"', _read(YYJSON / "yyjson.h")),
            "MIT",
            "pkg:github/ibireme/yyjson",
            "_core, viewer/*.wasm",
            _read(YYJSON / "LICENSE"),
        ),
    ]


def notices(parts: list[Part]) -> str:
    """The licences as text."""
    texts = ["BobRossNet's own licence is in LICENSE. It contains these libraries, under their own licences.\n"]
    for part in parts:
        heading = f"{part.name} {part.version}: {part.license}, in {part.used_in}"
        notice = "\n".join(line.rstrip() for line in part.notice.strip("\n").splitlines())
        texts.append(f"{'=' * 80}\n{heading}\n{'=' * 80}\n\n{notice}\n")
    return "\n".join(texts)


def bill_of_materials(parts: list[Part]) -> str:
    """A CycloneDX document, without the time of its making: the same parts give the same bytes."""
    own_version = _found(r'^version = "([^"]+)"$', _read(ROOT / "pyproject.toml"))
    own = _component(Part("bobrossnet", own_version, "MIT", "pkg:pypi/bobrossnet", "", ""))
    document = {
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": own},
        "components": [_component(part) for part in parts],
        "dependencies": [{"ref": own["bom-ref"], "dependsOn": [_component(part)["bom-ref"] for part in parts]}],
    }
    return json.dumps(document, indent=2) + "\n"


def _component(part: Part) -> dict[str, Any]:
    has_version = " " not in part.version
    purl = f"{part.package}@{part.version}" if has_version else part.package
    return {
        "type": "library",
        "bom-ref": part.name,
        "name": part.name,
        "version": part.version,
        "licenses": [{"expression": part.license}],
        "purl": purl.replace("++", "%2B%2B"),
        **({"properties": [{"name": "bobrossnet:used-in", "value": part.used_in}]} if part.used_in else {}),
    }


def files() -> dict[Path, str]:
    """What is written, by its place."""
    own = parts()
    folder = ROOT / "vendor"
    return {folder / "NOTICES.txt": notices(own), folder / "sbom.cdx.json": bill_of_materials(own)}


def _read(file: Path) -> str:
    return file.read_text("utf-8")


def _found(pattern: str, text: str) -> str:
    found = re.search(pattern, text, re.MULTILINE | re.DOTALL)
    assert found is not None, pattern
    return found[1]


if __name__ == "__main__":
    for path, text in files().items():
        path.write_text(text, "utf-8")
