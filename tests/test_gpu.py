"""Networks on a page's GPU, in software: the core's pictures, and fallbacks without a GPU or after its loss."""

import numpy as np
import pytest
from browser import launch

import bobrossnet as bob
from bobrossnet.completion.network import load_network
from bobrossnet.picture.channels import TRACED

OPTIONS = ("--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader")

SIZES = ((1, 1), (1, 2), (3, 5), (7, 4), (33, 61), (17, 1000), (480, 640))

WORKER = """
import { Completer } from "./completion/completer.js";
import { createGpuNetwork, GpuNetwork } from "./completion/gpu.js";
import { Network } from "./completion/network.js";
import { readWeights } from "./completion/weights.js";
import { loadCore } from "./core/load.js";
import { GBuffer } from "./picture/gbuffer.js";

const fetched = async (path) => (await fetch(path)).arrayBuffer();
const floats = async (path) => new Float32Array(await fetched(path));
const weightsOf = async (name) => readWeights(await fetched(`weights/${name}.safetensors`));
const networkOf = async (name) => createGpuNetwork(await weightsOf(name), { software: true });
const message = (promise) => promise.then(() => "kept", (error) => error.message);
const difference = (a, b) => a.reduce((most, gray, i) => Math.max(most, Math.abs(gray - b[i])), 0);
const networks = new Map(), errors = [];

const calls = {
  /** From planes.bin, the largest difference to gray.bin. */
  async compare(name, height, width) {
    if (!networks.has(name)) networks.set(name, await networkOf(name));
    const network = networks.get(name);
    network.device.onuncapturederror = ({ error }) => errors.push(error.message);
    const gray = await network.complete(await floats("planes.bin"), height, width);
    return { difference: difference(gray, await floats("gray.bin")), errors };
  },

  async create(name, change) {
    const weights = { ...await weightsOf(name), ...change };
    if (change?.without) weights.tensors.delete(change.without);
    return (await createGpuNetwork(weights, { software: change?.software ?? true })) && "network";
  },

  /** Where a page has no WebGPU, or no adapter. */
  async createWith(gpu) {
    const weights = await weightsOf("paper"), own = navigator.gpu;
    const set = (value) => Object.defineProperty(navigator, "gpu", { configurable: true, value });
    set(gpu && { requestAdapter: async () => gpu.adapter });
    try {
      return await createGpuNetwork(weights, { software: true });
    } finally {
      set(own);
    }
  },

  async refused(height, width, values) {
    const device = await (await navigator.gpu.requestAdapter()).requestDevice(); // with WebGPU's least limits
    const network = new GpuNetwork(device, await weightsOf("paper"));
    return message(network.complete(new Float32Array(values), height, width));
  },

  async lose(name) {
    const network = await networkOf(name);
    await network.complete(new Float32Array(5), 1, 1);
    const pending = message(network.complete(new Float32Array(5), 1, 1));
    network.free();
    return [await network.lost, await pending, await message(network.complete(new Float32Array(5), 1, 1))];
  },

  /** Pictures beside such a rival: what completed each, the rival's calls, the largest difference to the core's. */
  async race(rival, height, width, pictures) {
    const core = await loadCore("complete"), weights = await weightsOf("default");
    const gbuffer = new GBuffer(core, height, width);
    gbuffer.planes.set(await floats("planes.bin"));
    const network = new Network(core, weights);
    const filled = network.fill(gbuffer).slice(), expected = network.complete(gbuffer).slice();
    let calls = 0, left = Infinity, running;
    const software = rival === "software" && await createGpuNetwork(weights, { software: true });
    const rivals = {
      software: () => software.complete(gbuffer.planes.slice(), height, width),
      fast: () => filled,
      slow: () => new Promise((resolve) => { setTimeout(() => resolve(filled), 400); }),
      wrong: () => filled.map((gray) => gray + 2e-4),
      failing: () => { throw new Error("no memory"); },
      lost: () => { if (--left < 0) throw new Error("lost"); return filled; },
    };
    const complete = () => {
      ++calls;
      const picture = (async () => rivals[rival]())();
      running = picture.catch(() => {});
      return picture;
    };
    const completer = new Completer(core, weights, async () => (rival === "none" ? null : { complete, free() {} }));
    const backends = [];
    let most = 0;
    for (let i = 0; i < pictures; ++i) {
      if (i === pictures - 2) left = 0;
      most = Math.max(most, difference(expected, await completer.complete(gbuffer)));
      backends.push(completer.backend);
      gbuffer.image.fill(NaN);
      await running;
    }
    completer.free();
    return { backends, calls, difference: most };
  },
};

onmessage = async ({ data: [call, ...values] }) => {
  try {
    postMessage({ value: await calls[call](...values) });
  } catch (error) {
    postMessage({ error: error.message });
  }
};
"""

ASK = """
(request) => new Promise((resolve) => {
  globalThis.worker ??= new Worker("/gpu_worker.js", { type: "module" });
  worker.onmessage = ({ data }) => resolve(data);
  worker.onerror = ({ message }) => resolve({ error: message });
  worker.postMessage(request);
})
"""


@pytest.fixture(scope="module")
def gpu(browser, viewer):
    """Return a function that asks a worker of a browser with a GPU; {value} or {error} come back."""
    viewer.files["gpu_worker.js"] = WORKER.encode()
    with launch(browser.browser_type, *OPTIONS) as with_gpu:
        page = with_gpu.new_page()
        page.goto(viewer.url + "gallery/index.json")
        yield lambda *request: page.evaluate(ASK, request)


def noise(size, density):
    random = np.random.default_rng(0)
    stack = random.random((TRACED.width, *size), dtype=np.float32)
    stack[3:] = 2 * stack[3:] - 1
    stack[0] = 1
    stack[1:, :, : size[1] // 2] = 0  # background, which the default network detects
    return np.ascontiguousarray(stack * (random.random(size) < density))


def gbuffer(stack):
    return bob.GBuffer.from_stack(stack.copy(), TRACED)


# ---- Pictures --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["paper", "default", "small"])
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_networks_fill_in_as_in_the_core(gpu, viewer, tree, name, size):
    if size == SIZES[-1]:
        stacks = [bob.trace(tree, size=size, fraction=0.05).planes]
    else:
        stacks = [noise(size, density) for density in (0, 0.05, 0.5, 1)]
    for stack in stacks:
        viewer.files["planes.bin"] = stack.tobytes()
        part = gbuffer(stack)
        filled = np.where(part.mask > 0, part.gray, np.clip(load_network(name).predict(part), 0, 1))
        viewer.files["gray.bin"] = filled.tobytes()
        found = gpu("compare", name, *size)["value"]
        assert found["difference"] < 1e-4
        assert not found["errors"]


# ---- Without a GPU ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("found", [None, {"adapter": None}], ids=["WebGPU", "adapter"])
def test_no_network_without(gpu, found):
    assert gpu("createWith", found) == {"value": None}


def test_no_network_on_a_software_gpu(gpu):
    assert gpu("create", "default", {"software": False}) == {"value": None}
    assert gpu("create", "default") == {"value": "network"}


def test_no_network_of_another_name(gpu):
    assert gpu("create", "default", {"network": "toString"}) == {"value": None}


def test_weights_that_do_not_fit(gpu):
    assert gpu("create", "paper", {"without": "encoded.bias"}) == {
        "error": "encoded: expected a weight and a bias among the weights, not found"
    }
    assert gpu("create", "default", {"network": "paper"})["error"].startswith("encode1: expected a weight")


def test_pictures_that_do_not_fit(gpu):
    assert gpu("refused", 2, 3, 6)["value"] == f"planes: expected shape ({TRACED.width}, 2, 3), got 6 values"
    most = gpu("refused", 4, 600_000, 12_000_000)["value"]
    assert most == "picture: expected at most 524280 rows and columns for the GPU, got 4 and 600000"
    most = gpu("refused", 4000, 2000, 40_000_000)["value"]
    assert most == "picture: expected at most 134217728 bytes of 5 channels for the GPU, got 160000000"


def test_lost(gpu):
    reason, pending, later = gpu("lose", "paper")["value"]
    assert pending == later == f"the GPU was lost: {reason}"


# ---- The faster one --------------------------------------------------------------------------------------


SIZE = (240, 320)


@pytest.fixture
def planes(viewer, tree):
    viewer.files["planes.bin"] = bob.trace(tree, size=SIZE, fraction=0.05).planes.tobytes()


@pytest.mark.parametrize(("rival", "calls"), [("none", 0), ("failing", 1), ("wrong", 1), ("slow", 2), ("software", 2)])
def test_webassembly_completes_unless_the_gpu_is_right_and_faster(gpu, planes, rival, calls):
    """The first call is checked, not timed; without a chance, the second call decides."""
    found = gpu("race", rival, *SIZE, 10)["value"]
    assert found == {"backends": 10 * ["wasm"], "calls": calls, "difference": 0}


def test_gpu_completes_where_it_is_faster(gpu, planes):
    """After six untimed pictures, the last with the GPU's first, and five completed by both."""
    found = gpu("race", "fast", *SIZE, 16)["value"]
    assert found == {"backends": 11 * ["wasm"] + 5 * ["gpu"], "calls": 1 + 5 + 5, "difference": 0}


def test_webassembly_goes_on_when_the_gpu_is_lost(gpu, planes):
    found = gpu("race", "lost", *SIZE, 16)["value"]
    assert found == {"backends": 11 * ["wasm"] + 3 * ["gpu"] + 2 * ["wasm"], "calls": 1 + 5 + 4, "difference": 0}
