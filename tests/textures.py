"""Meshes with textures, and scene files that share them."""

import numpy as np

import bobrossnet as bob
from bobrossnet.adapters.container import layout, sealed

PLACES = np.array([(0, 0), (1, 0), (0, 1)], float)


def mesh(texture, at=0.0, **more):
    return bob.Mesh(np.eye(3) + at, [(0, 1, 2)], uv=PLACES, texture=texture, **more)


def texels(height=64, width=64, channels=3):
    return np.random.default_rng(0).integers(0, 256, (height, width, channels), np.uint8)


def shared_scene(number, dtype=np.int32, **changes):
    """Return a file of two meshes; the second uses the texture of shape `number`."""
    first, second = mesh(texels(4, 6)), mesh(texels(4, 6), 1)
    tensors = {f"0.{name}": tensor for name, tensor in first.tensors().items()}
    own = second.tensors_apart() | {"texture_of": np.array([number], dtype)} | changes
    tensors |= {f"1.{name}": tensor for name, tensor in own.items()}
    look = {"color": [1, 1, 1], "ambient": 0.1, "diffuse": 0.7, "specular": 0.2, "shininess": 32}
    instance = {"transform": np.eye(4).tolist(), "name": None, "material": look}
    instances = [{"shape": i, **instance} for i in range(2)]
    return sealed(layout({"shapes": ["mesh"] * 2, "instances": instances}, tensors, "5"))


OTHERS = [
    {"texture": np.zeros((24, 3), np.uint8)},
    {"texture_layout": np.array([6, 4, 0, 0], np.int32)},
    {"texture_alpha": np.zeros(24, np.uint8), "alpha_cutoff": np.zeros(1)},
    {"alpha_cutoff": np.zeros(1)},
]
"""Tensors of the second mesh that conflict with a texture of the first."""
