"""Mitsuba as a tracer, mostly in a variant without a compiler; and its EXR files."""

import subprocess
import sys

import mitsuba as mi
import numpy as np
import pytest

import bobrossnet as bob
from bobrossnet.adapters import mitsuba
from bobrossnet.completion.exr import completed_channels
from bobrossnet.picture.exr import read_exr

SIZE = (24, 32)


@pytest.fixture(scope="module", autouse=True)
def variant():
    mi.set_variant("scalar_rgb")


def scene_of(sensor="perspective", integrator="path", crop=None, **further):
    """Return a ball of red plastic in front of a wall as bright as the sky."""
    at = mi.ScalarTransform4f().look_at(origin=[0, 0, 5], target=[0, 0, 0], up=[0, 1, 0])
    film = {"type": "hdrfilm", "height": SIZE[0], "width": SIZE[1], "rfilter": {"type": "box"}}
    if crop:
        film |= dict(zip(("crop_offset_x", "crop_offset_y", "crop_width", "crop_height"), crop, strict=True))
    lens = {"fov": 40.0} if sensor == "perspective" else {}
    at = at if lens else at @ mi.ScalarTransform4f().scale([1.8, 1.8, 1])
    red = {"type": "rgb", "value": [0.8, 0.1, 0.2]}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": integrator if isinstance(integrator, dict) else {"type": integrator},
            "sensor": {"type": sensor, "to_world": at, "film": film, **lens},
            "ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": red}},
            "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [2.0, 1.0, 0.5]}},
            **further,
        }
    )


EVERYWHERE = np.argwhere(np.ones(SIZE)).astype(np.int32)


@pytest.mark.parametrize("sensor", ["perspective", "orthographic"])
def test_colours_are_those_that_mitsuba_renders(sensor):
    scene = scene_of(sensor)
    tracer = mitsuba.tracer(scene, spp=16)
    samples = tracer(EVERYWHERE)
    expected = np.array(mi.render(scene, spp=256)).reshape(-1, 3)
    # In standard deviations of each pixel; along silhouettes, a few pixels have all paths on one side.
    deviation = np.sqrt(samples.channel("variance") * (1 + 1 / 16)) + 0.01
    within = np.abs(samples.color - expected) @ [0.2126, 0.7152, 0.0722] < 5 * deviation
    assert within.mean() > 0.98
    assert np.abs(samples.color.mean(axis=0) / expected.mean(axis=0) - 1).max() < 0.03


@pytest.fixture
def other_variant(request):
    mi.set_variant(request.param)
    try:
        mitsuba.tracer(None)
    except bob.InputError as error:
        if "LLVM" in str(error):
            mi.set_variant("scalar_rgb")
            pytest.skip(str(error))
    yield request.param
    mi.set_variant("scalar_rgb")


@pytest.mark.parametrize(
    "other_variant", ["scalar_spectral", "llvm_ad_mono", "llvm_ad_spectral_polarized"], indirect=True
)
def test_any_variant_finds_what_it_renders(other_variant):
    scene = scene_of()
    tracer = mitsuba.tracer(scene, spp=8)
    samples = tracer(EVERYWHERE)
    color, expected = samples.color, np.array(mi.render(scene, spp=8)).reshape(len(EVERYWHERE), -1)
    deviation = np.sqrt(2 * samples.channel("variance")) + 0.02
    gray = expected @ [0.2126, 0.7152, 0.0722] if expected.shape[1] == 3 else expected[:, 0]
    assert (np.abs(samples.gray - gray) < 4 * deviation).mean() > 0.98
    assert np.allclose(color.mean(axis=0), expected.mean(axis=0), rtol=0.03)
    albedo = tracer.guides().albedo[SIZE[0] // 2 - 2 : SIZE[0] // 2 + 2, SIZE[1] // 2 - 2 : SIZE[1] // 2 + 2]
    assert albedo.std(axis=(0, 1)).max() < 1e-5  # exact, though spectra are sampled at random
    if "mono" in other_variant:
        assert np.allclose(albedo, np.mean(albedo))
    else:
        assert np.allclose(albedo, (0.8, 0.1, 0.2), atol=0.05)
    first = next(bob.progressive(tracer=tracer, first=0.3))
    assert np.abs(first.color.mean(axis=(0, 1)) / expected.mean(axis=0) - 1).max() < 0.1


@pytest.mark.parametrize("sensor", ["perspective", "orthographic"])
def test_guides_are_the_first_hits(sensor):
    tracer = mitsuba.tracer(scene_of(sensor), spp=1)
    guides = tracer.guides()
    assert guides.size == tracer.size == SIZE
    middle = (SIZE[0] // 2, SIZE[1] // 2)
    assert guides.hit[0, 0] == 0
    assert guides.hit[middle] == 1
    assert guides.depth[middle] == pytest.approx(4, abs=0.3)
    assert np.allclose(guides.albedo[middle], (0.8, 0.1, 0.2), atol=1e-5)
    assert (guides.albedo[0, 0] == 1).all()
    x, y = np.moveaxis(guides.normal, -1, 0)  # right and up, for any axes of Mitsuba's
    inside = guides.hit == 1
    row, column = np.indices(SIZE)
    assert np.corrcoef(x[inside], column[inside])[0, 1] > 0.9
    assert np.corrcoef(y[inside], -row[inside])[0, 1] > 0.9
    assert np.abs(guides.normal[middle]).max() < 0.3


def test_pictures_converge():
    tracer = mitsuba.tracer(scene_of(), spp=4)
    assert 0 < tracer.batch <= SIZE[0] * SIZE[1]
    first, *_, last = bob.progressive(tracer=tracer, first=0.2, fraction=0.2)
    assert last.fraction == 1
    assert last.gbuffer.guides is not None
    expected = np.array(mi.render(scene_of(), spp=128))
    errors = [np.abs(frame.color - expected).mean() for frame in (first, last)]
    assert errors[1] < errors[0] < 0.1
    assert last.gbuffer.alpha[0, 0] == 0
    assert np.allclose(last.color[0, 0], (2, 1, 0.5), atol=0.01)


def test_each_call_draws_other_paths():
    tracer = mitsuba.tracer(scene_of(), spp=1)
    one, other = tracer(EVERYWHERE), tracer(EVERYWHERE)
    assert not np.array_equal(one.color, other.color)
    again = mitsuba.tracer(scene_of(), spp=1)
    assert np.array_equal(again(EVERYWHERE).color, one.color)
    assert "variance" not in one.layout.places


def test_films_may_be_cropped():
    tracer = mitsuba.tracer(scene_of(crop=(8, 4, 16, 12)), spp=1)
    whole = mitsuba.tracer(scene_of(), spp=1).guides()
    assert tracer.size == (12, 16)
    assert np.abs(tracer.guides().hit - whole.hit[4:16, 8:24]).mean() < 0.05


def test_files_of_its_aovs_open_without_options(tmp_path):
    aovs = {"type": "aov", "aovs": "dd:depth,nn:sh_normal,albedo:albedo,pp:position", "img": {"type": "path"}}
    scene = scene_of(integrator=aovs)
    mi.render(scene, spp=16)
    path = tmp_path / "aovs.exr"
    mi.util.write_bitmap(str(path), scene.sensors()[0].film().bitmap(), write_async=False)
    file = read_exr(path)
    letters = ["X", "Y", "Z"]
    assert file.roles["color"] == ["R", "G", "B"]
    assert file.roles["depth"] == ["dd.T"]
    assert file.roles["normal"] == [f"nn.{letter}" for letter in letters]
    assert file.roles["albedo"] == [f"albedo.{letter}" for letter in "RGB"]
    whole = completed_channels(file)
    assert all(np.array_equal(whole[name], file.planes[name]) for name in file.planes)  # nothing is missing


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scene": 5}, "scene: expected a scene of mitsuba's variant scalar_rgb, got int"),
        ({"sensor": 1}, "sensor: expected an integer in 0..0, got 1"),
        ({"spp": 0}, "spp: expected an integer in 1..1048576, got 0"),
        ({"seed": -1}, "seed: expected an integer in 0.."),
    ],
)
def test_wrong_arguments_are_named(arguments, message):
    with pytest.raises(bob.InputError) as error:
        mitsuba.tracer(**({"scene": scene_of()} | arguments))
    assert str(error.value).startswith(message)


def test_a_variant_is_needed():
    code = "from bobrossnet.adapters import mitsuba\ntry: mitsuba.tracer(None)\nexcept ValueError as e: print(e)"
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert printed == "mitsuba: expected a variant, such as mitsuba.set_variant('llvm_ad_rgb'), got none\n"


@pytest.mark.parametrize(("version", "found"), [((15, 0, 6), "15.0.6"), (None, "none")])
def test_compilers_that_would_end_the_process_are_found_before(version, found, monkeypatch):
    import drjit

    monkeypatch.setattr(mi, "variant", lambda: "llvm_ad_rgb")
    monkeypatch.setattr(drjit, "has_backend", lambda backend: version is not None)
    monkeypatch.setattr(drjit.detail, "llvm_version", lambda: version)
    with pytest.raises(
        bob.InputError, match=rf"^mitsuba: expected LLVM 17 or newer for the variant llvm_ad_rgb, got {found};"
    ):
        mitsuba.tracer(None)


# ---- Media and other integrators -------------------------------------------------------------------------


def in_fog():
    """A ball, seen by a sensor in the fog around it."""
    at = mi.ScalarTransform4f()
    fog = {"type": "ref", "id": "fog"}
    film = {"type": "hdrfilm", "width": 24, "height": 24, "rfilter": {"type": "box"}}
    red = {"type": "rgb", "value": [0.8, 0.3, 0.2]}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": 12},
            "fog": {"type": "homogeneous", "albedo": {"type": "rgb", "value": [0.2, 0.5, 0.9]}, "sigma_t": 0.15},
            "sensor": {
                "type": "perspective",
                "fov": 45,
                "to_world": at.look_at([0, 1, 5], [0, 0, 0], [0, 1, 0]),
                "medium": fog,
                "film": film,
            },
            "ball": {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": red}},
            "around": {"type": "cube", "to_world": at.scale(8), "bsdf": {"type": "null"}, "interior": fog},
            "sky": {"type": "constant", "radiance": 0.7},
        }
    )


@pytest.mark.parametrize("other_variant", ["scalar_rgb", "llvm_ad_rgb"], indirect=True)
def test_a_sensor_in_a_medium(other_variant):
    tracer = mitsuba.tracer(in_fog(), spp=32)
    pixels = np.argwhere(np.ones(tracer.size)).astype(np.int32)
    assert np.allclose(tracer(pixels).color.mean(axis=0), (0.124, 0.204, 0.481), atol=0.02)


def test_integrators_that_start_at_lamps_are_refused():
    with pytest.raises(bob.InputError, match=r"^scene: expected an integrator .* such as path, got ParticleTracer"):
        mitsuba.tracer(scene_of(integrator="ptracer"))


@pytest.mark.parametrize("other_variant", ["llvm_ad_rgb"], indirect=True)
def test_integrators_that_differentiate(other_variant):
    light = {
        name: mitsuba.tracer(scene_of(integrator=name), spp=16)(EVERYWHERE).color.mean(axis=0)
        for name in ("path", "prb")
    }
    assert np.allclose(light["prb"], light["path"], atol=0.03)
