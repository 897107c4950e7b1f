"""The C++ core (bindings/). Arrays are C-contiguous; none is converted or copied."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
I32 = NDArray[np.int32]

def thread_count() -> int: ...
def set_thread_count(count: int) -> None: ...
def isa() -> str: ...
def set_isa(name: str) -> bool: ...

class Shape:
    @property
    def bytes(self) -> int: ...

class Mesh(Shape):
    def __init__(self, vertices: F32, triangles: I32, normals: F32 | None) -> None: ...
    @property
    def bvh_bytes(self) -> int: ...

class Scene:
    """`to_shape` (n, 3, 4); `boxes` (n, 2, 3): low, high; `materials` (n, 7): linear RGB, ambient, diffuse, specular,
    shininess. Where instances coincide, the first is seen."""

    def __init__(self, shapes: Sequence[Shape], to_shape: NDArray[np.float64], boxes: F32, materials: F32) -> None: ...
    def closest_hits(self, origins: F32, directions: F32, t: F32, instance: I32, primitive: I32) -> None: ...
    def trace(
        self,
        azimuth: float,
        elevation: float,
        roll: float,
        zoom: float,
        height: int,
        width: int,
        pixels: I32,
        gray: F32,
        depth: F32,
        normal: F32,
        hit: NDArray[np.bool_],
    ) -> None: ...
    @property
    def bytes(self) -> int: ...

def scatter(pixels: I32, gray: F32, depth: F32, normal: F32, hit: NDArray[np.bool_], planes: F32) -> None: ...
def uniform_order(seed: int, height: int, width: int, start: int, pixels: I32) -> None: ...

class Paper:
    def __init__(self, tensors: Mapping[str, F32]) -> None: ...
    def __call__(self, gbuffer: F32, gray: F32) -> None: ...

def keep_known(gbuffer: F32, gray: F32) -> None: ...
