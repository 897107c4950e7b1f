"""Methods of others that need files of theirs, each named by a variable of the environment.

SPARSEBENCH_PROGISO: ml-models/noof640-ultraminiv12.onnx of https://github.com/ldyken53/TVCG-progiso
SPARSEBENCH_FAST: a clone of https://github.com/saugatkandel/fast_smart_scanning; needs scikit-learn and joblib, and its
weights are a pickle, which may run any code.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import warnings
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from asking import F32, Ask, Placement

import bobrossnet as bob
from bobrossnet.learn.evaluation.methods import Method
from bobrossnet.support.errors import InputError


def file_of(variable: str) -> Path:
    """Return the path in a variable of the environment. InputError if nothing is there."""
    path = Path(os.environ.get(variable, ""))
    if not (os.environ.get(variable) and path.exists()):
        raise InputError(f"{variable}: expected a path, as bench/sparse/others.py says, got none")
    return path


def onnx_session(path: Path) -> Any:
    """Return an ONNX file ready to run in the calling thread."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])


# ---- Dyken, Usher, Kumar, "Interactive isosurface visualization in memory constrained environments", 2024 ------------

BASE = np.array([0.3, 0.3, 0.9], np.float32)  # colour of their surfaces; 0.2 to 0.8 of it by the angle of the light
UNKNOWN = np.array([1, 0, 0], np.float32)


def progiso() -> Method:
    """Return their network: surfaces are blue on white, and unknown pixels are red."""
    session = onnx_session(file_of("SPARSEBENCH_PROGISO"))
    picture, *states = session.get_inputs()
    empty = {state.name: np.zeros(state.shape, np.float32) for state in states}  # of their first frame
    height, width = picture.shape[2:]

    def complete(part: bob.GBuffer) -> F32:
        if part.size[0] > height or part.size[1] > width:
            raise InputError(f"part: expected at most {width}x{height} pixels, got {part.size[1]}x{part.size[0]}")
        canvas = np.ones((height, width, 3), np.float32)
        top, left = (height - part.size[0]) // 2, (width - part.size[1]) // 2
        inside = (slice(top, top + part.size[0]), slice(left, left + part.size[1]))
        surface = (0.2 + 0.6 * part.gray)[..., None] * BASE
        shown = np.where(part.alpha[..., None] > 0, surface, np.float32(1))
        canvas[inside] = np.where(part.mask[..., None] > 0, shown, UNKNOWN)
        image = session.run(None, {picture.name: canvas.transpose(2, 0, 1)[None], **empty})[0]
        red, green, blue = image[0][(slice(None), *inside)]
        # Of a pixel covered by a share a, at brightness s: red = 1 - a + 0.3 a s, blue = 1 - a + 0.9 a s.
        lit = (blue - (red + green) / 2) / 0.6
        covered = 1 - blue + 0.9 * lit
        gray = np.clip((lit - 0.2 * covered) / 0.6, 0, 1)
        return np.where(part.mask > 0, part.gray, gray)

    return complete


# ---- Kandel et al., "Demonstration of an AI-driven workflow for autonomous scanning microscopy", 2023 ----------------

FIRST = 0.01  # share of their initial scan
ROUND = 50  # pixels of a round in their script
WEIGHTS = "work_directory/training/cameraman/c_2/erd_model_relu.pkl"


def fast() -> Placement:
    """Return their program with their weights: its initial scan, its rounds, and its own reconstruction."""
    folder = file_of("SPARSEBENCH_FAST")
    sys.path.insert(0, str(folder))
    with contextlib.redirect_stdout(io.StringIO()):  # it prints which optional packages it lacks
        create_sample = import_module("fast.s26_analysis.utils").create_experiment_sample
        first_pixels = import_module("fast.utils.generate_scan_pattern").generate_scan_pattern

    def place(ask: Ask) -> F32:
        height, width = ask.size
        count = min(round(FIRST * height * width), ask.budget)
        pixels = np.unique(first_pixels(width, height, num_scan_points=count, verbose=False), axis=0)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its weights are of an older scikit-learn
            sample = create_sample(
                numx=width,
                numy=height,
                initial_idxs=pixels,
                inner_batch_size=ROUND,
                erd_model_file_path=str(folder / WEIGHTS),
            )
        low, high = np.inf, -np.inf
        while True:
            gray = ask(pixels).gray
            low, high = min(low, float(gray.min())), max(high, float(gray.max()))
            sample.measurement_interface.finalize_external_measurement(gray)
            sample.perform_measurements(pixels)
            sample.reconstruct_and_compute_erd()
            left = ask.budget - int(sample.mask.sum())
            if left <= 0:
                break
            pixels = sample.find_new_measurement_idxs()[: min(ROUND, left)]
        scale = float(sample.measurement_info.measured_values.max()) or 1  # it works with values from 0 to this
        image: F32 = (sample.recon_image / scale * (high - low) + low).astype(np.float32)
        return image

    return place
