/** What the page takes from three.js: `make vendor` joins it to viewer/vendor/three/loaders.js. */
export { GLTFLoader } from "./package/examples/jsm/loaders/GLTFLoader.js";
export { STLLoader } from "./package/examples/jsm/loaders/STLLoader.js";
export { Material } from "three";
