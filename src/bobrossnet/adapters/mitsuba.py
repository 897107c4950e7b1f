"""Mitsuba's integrators as tracers. Needs the extra `mitsuba`.

import mitsuba as mi
from bobrossnet.adapters import mitsuba

mi.set_variant("llvm_ad_rgb")
tracer = mitsuba.tracer(mi.load_dict(mi.cornell_box()), spp=16)
for frame in bob.progressive(tracer=tracer, first=0.05, frame_ms=100):
    frame.color
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bobrossnet.picture.guides import Guides
from bobrossnet.picture.order import Size
from bobrossnet.picture.samples import Samples
from bobrossnet.support.errors import InputError, InputTypeError, check_integer

F32 = NDArray[np.float32]

PATHS_PER_CALL = 2**15
"""Light paths per call: with fewer, launching Dr.Jit's kernels dominates; with more, frames are late."""

GUIDE_RAYS = 3
"""Side of the grid of guide rays in each pixel; guides are their mean, as smooth at edges as the picture.

SSIM at 5 % of the pixels of an interior: 0.973, 0.976 and 0.978 with 2, 3 and 4; 0.967 with 4 random rays."""

WAVELENGTHS = (430, 460, 490, 520, 550, 580, 610, 640)
"""Wavelengths in nm for the albedo of spectral variants, four per query. Random ones would add noise."""

OLDEST_LLVM = 17
"""Dr.Jit 1.5 crashes while compiling with LLVM 14 to 16."""


def tracer(scene: Any, sensor: int = 0, spp: int = 16, *, seed: int = 0) -> MitsubaTracer:
    """Make a tracer for `progressive` from a Mitsuba scene and one of its sensors.

    Parameters
    ----------
    scene : mitsuba.Scene
        A scene of any variant; its own integrator is used.
    sensor : int
        Index of the scene's sensor; any type of sensor.
    spp : int
        Light paths per pixel, uniform over the pixel; the film's reconstruction filter is ignored.
    seed : int, 0..2**32 - 1

    Raises
    ------
    InputError
        If mitsuba or the LLVM of its variant is not installed; if `scene` is not a scene of this variant, has no such
        sensor, or an integrator that starts at lamps; or if `spp` or `seed` is out of range.
    """
    mi = _mitsuba()
    if not isinstance(scene, mi.Scene):
        raise InputTypeError(f"scene: expected a scene of mitsuba's variant {mi.variant()}, got {type(scene).__name__}")
    integrator = scene.integrator()
    if not isinstance(integrator, mi.SamplingIntegrator):
        name = integrator.class_name() if integrator else "none"
        raise InputError(f"scene: expected an integrator with light along a ray, such as path, got {name}")
    count = len(scene.sensors())
    if not count:
        raise InputError("scene: expected one with a sensor, got one without")
    check_integer("sensor", sensor, 0, count - 1)
    return MitsubaTracer(scene, sensor, check_integer("spp", spp, 1, 2**20), check_integer("seed", seed, 0, 2**32 - 1))


class MitsubaTracer:
    """A tracer of a Mitsuba scene, made by `tracer`.

    Colours are linear RGB of any range, with their variance if `samples_per_pixel` is at least 2. Call it with `batch`
    pixels: for any other number, Dr.Jit compiles for a quarter of a second.
    """

    def __init__(self, scene: Any, sensor: int, spp: int, seed: int) -> None:
        self._scene, self._sensor = scene, scene.sensors()[sensor]
        width, height = (int(side) for side in self._sensor.film().crop_size())
        self.size: Size = (height, width)
        self.samples_per_pixel = spp
        self.batch = min(max(64, PATHS_PER_CALL // spp), height * width)
        self._seed, self._calls = seed, 0
        self._sampler = _mitsuba().load_dict({"type": "independent"})
        self._integrator = scene.integrator()
        matrix = np.array(self._sensor.world_transform().matrix, np.float64).reshape(4, 4)[:3, :3]
        self._axes = (matrix / np.linalg.norm(matrix, axis=0)).T[:2]  # the camera's left and up directions
        self._guides: Guides | None = None

    def __call__(self, pixels: NDArray[np.int32]) -> Samples:
        """Trace `samples_per_pixel` new paths per pixel."""
        n = self.samples_per_pixel
        color = self._gather(pixels, np.zeros((n, 2)), self._light)  # (n, spp, 3)
        mean = np.maximum(color.mean(axis=1), 0)  # spectra may be more saturated than the primaries
        variance = color.var(axis=1, ddof=1) / n if n > 1 else None
        guides, (row, column) = self.guides(), pixels.T
        hit = guides.hit[row, column] > 0
        geometry = {name: guides.channel(name)[row, column] for name in ("depth", "normal", "albedo")}
        return Samples(color=mean, hit=hit, variance=variance, **geometry)

    def guides(self) -> Guides:
        """Return first hits of all pixels, means of a few rays: distances, normals, and albedos, 1 if not diffuse."""
        if self._guides is None:
            pixels = np.argwhere(np.ones(self.size)).astype(np.int32)
            sums = np.zeros((len(pixels), 7), np.float32)
            for inside in (np.argwhere(np.ones((GUIDE_RAYS, GUIDE_RAYS))) + 0.5) / GUIDE_RAYS:
                sums += self._gather(pixels, inside[None], self._first_hit)[:, 0]
            rays = GUIDE_RAYS**2
            surface = sums[:, 1:4] / np.maximum(sums[:, :1], 1)
            self._guides = Guides(
                surface[:, 0].reshape(self.size),
                np.clip(surface[:, 1:], -1, 1).reshape(*self.size, 2),
                np.clip(sums[:, 4:] / rays, 0, 1).reshape(*self.size, 3),
                (sums[:, 0] / rays).reshape(self.size),
            )
        return self._guides

    def _gather(self, pixels: NDArray[np.int32], inside: NDArray[Any], along: Callable[..., Sequence[Any]]) -> F32:
        """Evaluate a function at each of the places, (count, 2) rows and columns within a pixel, of each pixel.

        Returns (n, count, numbers)."""
        mi = _mitsuba()
        self._calls += 1
        seed = (self._seed + 0x9E3779B9 * self._calls) % 2**32
        y, x = (pixels[:, None] + inside.astype(np.float32)).reshape(-1, 2).astype(np.float32).T
        if mi.variant().startswith("scalar"):
            self._sampler.seed(seed)
            rows = [along(mi, float(column), float(row)) for column, row in zip(x, y, strict=True)]
            found = np.asarray(rows, np.float32)
        else:
            self._sampler.seed(seed, len(x))
            columns = along(mi, mi.Float(np.ascontiguousarray(x)), mi.Float(np.ascontiguousarray(y)))
            _drjit().eval(*columns)  # together, since each alone would trace all rays again
            arrays = [np.broadcast_to(np.array(column, np.float32).ravel(), len(x)) for column in columns]
            found = np.stack(arrays, axis=-1)
        return found.reshape(len(pixels), len(inside), -1)

    def _ray(self, mi: Any, x: Any, y: Any) -> tuple[Any, Any]:
        """Return a ray through a position in the picture, in pixels, and its weight."""
        height, width = self.size
        time = self._sensor.shutter_open() + self._sensor.shutter_open_time() * self._sampler.next_1d()
        color, aperture = self._sampler.next_1d(), self._sampler.next_2d()
        ray, weight = self._sensor.sample_ray_differential(time, color, mi.Point2f(x / width, y / height), aperture)
        return ray, weight

    def _light(self, mi: Any, x: Any, y: Any) -> Sequence[Any]:
        """Return red, green and blue of one path through a pixel."""
        inside = self._sampler.next_2d()
        ray, weight = self._ray(mi, x + inside.x, y + inside.y)
        light = self._along(mi, ray)
        light = mi.unpolarized_spectrum(light * weight)
        if mi.is_spectral:
            light = mi.xyz_to_srgb(mi.spectrum_to_xyz(light, ray.wavelengths, True))
        return [light[0]] * 3 if mi.is_monochromatic else [light[0], light[1], light[2]]

    def _along(self, mi: Any, ray: Any) -> Any:
        """Return radiance along a ray from the sensor, which may be in a medium."""
        if not isinstance(self._integrator, mi.CppADIntegrator):  # integrators in Python have other arguments
            return self._integrator.sample(self._scene, self._sampler, ray, self._sensor.get_medium(), True)[0]
        return self._integrator.sample(
            mode=_drjit().ADMode.Primal,
            scene=self._scene,
            sampler=self._sampler,
            ray=ray,
            depth=mi.UInt32(0),
            δL=None,
            δaovs=None,
            state_in=None,
            active=mi.Bool(True),
        )[0]

    def _first_hit(self, mi: Any, x: Any, y: Any) -> Sequence[Any]:
        """Return hit, distance and screen-space normal of one ray, 0 for a miss, and the albedo."""
        ray, _ = self._ray(mi, x, y)
        found = self._scene.ray_intersect(ray)
        hit = found.is_valid()
        if hit is False:  # in scalar variants, a miss has no BSDF to query
            return [0, 0, 0, 0, 1, 1, 1]
        bsdf, normal = found.bsdf(ray), found.sh_frame.n
        rgb = _diffuse_reflectance(mi, bsdf, found, hit)
        # Light of black or non-diffuse surfaces and of lamps is not demodulated. Lamps have no normal, so they differ
        # from all neighbours.
        shines = found.emitter(self._scene) != None  # noqa: E711  in most variants it is an array of pointers
        is_diffuse = mi.has_flag(bsdf.flags(), mi.BSDFFlags.Diffuse) & (rgb[0] + rgb[1] + rgb[2] > 0)
        dull, zero = _select(shines, False, True), found.t * 0
        albedo = [_select(hit & is_diffuse & dull, each, zero + 1) for each in rgb]
        facing = _select(ray.d.x * normal.x + ray.d.y * normal.y + ray.d.z * normal.z > 0, zero - 1, zero + 1)
        left, up = self._axes
        on_screen = [sum(float(a) * n for a, n in zip(axis, normal, strict=True)) * facing for axis in (-left, up)]
        shown = [_select(hit & dull, each, zero) for each in on_screen]
        return [_select(hit, zero + 1, zero), _select(hit, found.t, zero), *shown, *albedo]


def _diffuse_reflectance(mi: Any, bsdf: Any, found: Any, hit: Any) -> Sequence[Any]:
    """Return red, green and blue of a spectrum under an equal-energy illuminant."""
    if not mi.is_spectral:
        color = mi.unpolarized_spectrum(bsdf.eval_diffuse_reflectance(found, hit))
        return [color[0]] * 3 if mi.is_monochromatic else [color[0], color[1], color[2]]
    seen = np.array([mi.xyz_to_srgb(mi.cie1931_xyz(wavelength)) for wavelength in WAVELENGTHS], float).reshape(-1, 3)
    shares = seen / seen.sum(axis=0)  # so that white is 1
    rgb: list[Any] = [0, 0, 0]
    for first in range(0, len(WAVELENGTHS), 4):
        found.wavelengths = type(found.wavelengths)(list(WAVELENGTHS[first : first + 4]))
        values = mi.unpolarized_spectrum(bsdf.eval_diffuse_reflectance(found, hit))
        for value, share in zip(values, shares[first : first + 4], strict=True):
            rgb = [sum_ + float(part) * value for sum_, part in zip(rgb, share, strict=True)]
    return rgb


def _select(mask: Any, here: Any, there: Any) -> Any:
    """Select between numbers or Dr.Jit's arrays."""
    return _drjit().select(mask, here, there)


def _drjit() -> Any:
    import drjit

    return drjit


def _mitsuba() -> Any:
    """Import mitsuba, and check its variant and compiler."""
    try:
        import drjit
        import mitsuba as mi
    except ModuleNotFoundError as error:
        raise InputError(f"mitsuba: this needs {error.name}: pip install 'bobrossnet[mitsuba]'") from None
    if mi.variant() is None:
        raise InputError("mitsuba: expected a variant, such as mitsuba.set_variant('llvm_ad_rgb'), got none")
    if mi.variant().startswith("llvm"):
        version = drjit.detail.llvm_version() if drjit.has_backend(drjit.JitBackend.LLVM) else ()
        if version < (OLDEST_LLVM,):
            found = ".".join(map(str, version)) or "none"
            raise InputError(
                f"mitsuba: expected LLVM {OLDEST_LLVM} or newer for the variant {mi.variant()}, got {found}; "
                "the environment variable DRJIT_LIBLLVM_PATH names its library"
            )
    return mi
