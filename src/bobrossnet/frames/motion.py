"""Moving views: samples of earlier frames are reprojected."""

from __future__ import annotations

import time
from typing import NoReturn

from bobrossnet.completion.network import NetworkLike
from bobrossnet.frames.frame import Frame
from bobrossnet.frames.lit_frames import LitFrames
from bobrossnet.frames.planner import AUTO, Planner
from bobrossnet.frames.traced_frames import CameraTracer, TracedFrames
from bobrossnet.measuring.picking import Pick, pick
from bobrossnet.picture.camera import CameraLike, as_camera, check_camera
from bobrossnet.picture.order import ADAPTIVE, SizeLike, check_order, check_size, pixel_count
from bobrossnet.support.errors import InputError, InputTypeError, check_number
from bobrossnet.support.threads import Turns
from bobrossnet.tracing.light import LightLike
from bobrossnet.tracing.lit import lights_and_ground
from bobrossnet.tracing.scene import SceneLike, as_scene
from bobrossnet.tracing.section import SectionLike


class View:
    """A scene seen by a camera that moves from frame to frame.

    Samples of earlier frames are reprojected: surfaces, which are shaded again, and background. They are shown at
    pixels that this camera has not traced. New rays go to disoccluded and doubtful pixels. A view at rest ends with
    every pixel exact, like `progressive`. Threads that share a view take turns.

    Parameters
    ----------
    scene : Scene, Shape, Instance or iterable of these, optional
    size : (height, width) or "WIDTHxHEIGHT"
    tracer : callable, optional
        Instead of a scene: from a `Camera` and pixels, (n, 2) int32 rows and columns, read-only, to `Samples` of the
        same length. Their depth is over the unit sphere, which the camera sees. Their gray and colour are reprojected
        unchanged. It may return a future of its samples, and have the attributes `batch` and `in_flight`, as in
        `progressive`. When the camera moves, waiting calls are cancelled. Running calls stay in
        flight until they end, but their samples are dropped.
    model : str or path
        As in `progressive`.
    light, ground
        As in `render`. Light and its paths stay on their surfaces when the camera moves. "studio" is placed relative
        to the first frame's camera.
    section : Section, text such as "x=0", or up to six of them, optional
        As in `Scene`; by default the scene's.
    seed : int, 0..2**64 - 1

    Raises
    ------
    InputError
        If an argument is out of range.

    Examples
    --------
    >>> import bobrossnet as bob
    >>> view = bob.View(bob.happy_tree(), size=(120, 160))
    >>> for azimuth in (30, 32, 34):
    ...     frame = view.frame(bob.Camera(azimuth=azimuth), fraction=0.05)
    >>> frame.image.shape, round(frame.fraction, 2)
    ((120, 160), 0.05)
    """

    def __init__(
        self,
        scene: SceneLike | None = None,
        *,
        size: SizeLike = (480, 640),
        tracer: CameraTracer | None = None,
        model: NetworkLike = AUTO,
        light: LightLike = None,
        ground: bool | None = None,
        section: SectionLike = None,
        seed: int = 0,
    ) -> None:
        if (scene is None) == (tracer is None):
            got = "both" if scene is not None else "neither"
            raise InputError(f"View: expected either a scene or a tracer, got {got}")
        if tracer is not None and not callable(tracer):
            raise InputTypeError(f"tracer: expected a callable, got {type(tracer).__name__}")
        self.size = check_size(size)
        if tracer is not None and section is not None:
            raise InputError("section: expected none with a tracer, which has its own scene")
        if tracer is not None and (light is not None or ground is not None):
            raise InputError("light: expected none with a tracer, which has its own")
        self._scene = None if scene is None else as_scene(scene, section)
        self._camera = as_camera(None, self._scene)
        planner = Planner(self.size, model)
        check_order(ADAPTIVE, seed)
        lights = None if self._scene is None else lights_and_ground(self._scene, light, ground)
        self._frames: LitFrames | TracedFrames
        if self._scene is not None and lights is not None:
            network = next(iter(planner.networks.values()))
            self._frames = LitFrames(self._scene, self.size, *lights, int(seed), network)
        else:
            source = self._scene if tracer is None else tracer
            assert source is not None
            self._frames = TracedFrames(source, self.size, self._camera, planner, int(seed))
        self._turns = Turns("View")

    def frame(
        self, camera: CameraLike | None = None, *, ms: float | None = None, fraction: float | None = None
    ) -> Frame:
        """Trace some pixels and complete the picture.

        Parameters
        ----------
        camera : Camera, optional
            By default the previous frame's, at first the default camera of the scene.
        ms : float above 0, optional
            Time for the frame in milliseconds, as `frame_ms` of `progressive`; 33 if neither this nor `fraction` is
            given. If it suffices for a dense picture, samples are not reprojected. If rays are fast, the picture is
            refined in squares, row by row, and complete if there is time for all pixels. While the camera of a scene
            moves, a frame is made smaller and enlarged if that has the smaller expected error, because few of its
            pixels can be traced; under lights, if its first hits would take too long.
        fraction : float in (0, 1], optional
            Share of the pixels that this frame traces.

        Returns
        -------
        Frame
            `gbuffer` and `fraction` include only pixels traced with this camera; `image` also shows reprojected
            samples. `error` is predicted from the former. Under lights, a pixel's paths of earlier cameras stay in its
            mean until the camera rests. `gbuffer` and `shown` of a frame that was enlarged have its smaller size;
            `fraction` counts pixels of the image.

        Raises
        ------
        InputError
            If an argument is out of range, or the tracer returns anything but its samples. Exceptions of the tracer
            propagate, also from a future; the next frame then starts without samples.
        """
        if ms is not None and fraction is not None:
            raise InputError("frame: expected ms or fraction, got both")
        budget = check_number("ms", 33 if ms is None else ms, 0, above=True) / 1000
        count = None if fraction is None else pixel_count(fraction, self.size)
        camera = None if camera is None else check_camera(camera)
        with self._turns:
            start = time.perf_counter()
            self._camera = camera or self._camera
            try:
                return self._frames.frame(start, camera, budget, count)
            except BaseException:  # requested pixels never returned
                self._frames.forget()
                raise

    def pick(self, row: int, column: int, *, snap: float = 0) -> Pick | None:
        """Return the surface at a pixel of the last frame; None at the background.

        Before the first frame, the default camera is used.

        Parameters
        ----------
        row, column : int
            Pixel, from the picture's top left.
        snap : float
            Pixels within which the point snaps to corners, edges and centres, as in `bobrossnet.pick`.
        """
        if self._scene is None:
            raise InputError("pick: expected a view of a scene, got one of a tracer, whose surfaces are not known")
        return pick(self._scene, row, column, self._camera, size=self.size, snap=snap)

    def forget(self) -> None:
        """Discard all samples: for tracers whose shapes or lights have changed."""
        with self._turns:
            self._frames.forget()

    def close(self) -> None:
        """Cancel waiting calls of the tracer, wait for running ones, and discard all samples."""
        with self._turns:
            self._frames.close()

    def __reduce__(self) -> NoReturn:
        raise InputTypeError(
            "View: expected to stay where it was made, as its tracer may be running; make another of the same scene"
        )
