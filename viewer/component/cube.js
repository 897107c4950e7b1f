// @ts-check
/** The view cube: its sides are named, turn with the scene, and show their view when clicked. Fetched where it is wanted. */
import { HOME } from "../picture/camera.js";
import { axesOf } from "../picture/projection.js";
import { addStyle } from "./made.js";
import { VIEWS, VIEW_NAMES } from "./views.js";

/** @typedef {import("../picture/camera.js").Camera} Camera */

const HALF = 22; // CSS pixels of half a side, as in STYLE

const STYLE = `
#cube { position: absolute; top: 16px; right: 16px; width: 76px; height: 76px; perspective: 300px; z-index: 2; pointer-events: none; }

#cube > div { position: absolute; top: 50%; left: 50%; transform-style: preserve-3d; }

#cube button {
  position: absolute; top: -22px; left: -22px; box-sizing: border-box; width: 44px; height: 44px; padding: 0; border: 1px solid #767676;
  background: #fff; color: #1b1b1a; font: 600 11px/1 system-ui, sans-serif; cursor: pointer; backface-visibility: hidden; pointer-events: auto;
}

#cube button:hover { background: #d5e8dc; }

@media (forced-colors: active) { #cube button { border-color: ButtonText; background: ButtonFace; color: ButtonText; } }
`;

/** A map from the axes of a plane, right and down, and towards the viewer. @param {number[][]} axes @param {number} out */
const matrix = ([right, up, toward], out) =>
  `matrix3d(${[...right, 0, ...up.map((value) => -value), 0, ...toward, 0, ...toward.map((value) => out * value), 1]})`;

/**
 * Adds the cube to an element.
 *
 * @param {ShadowRoot} root
 * @param {(name: import("./views.js").ViewName) => void} choose
 * @returns {{show: (camera: Camera) => void, remove: () => void}}
 */
export function createCube(root, choose) {
  const cube = document.createElement("div"), turning = document.createElement("div"), sheet = addStyle(root, STYLE);
  cube.id = "cube";
  cube.setAttribute("part", "view-cube");
  cube.append(turning);
  turning.append(...VIEW_NAMES.map((name) => {
    const side = document.createElement("button");
    Object.assign(side, { type: "button", textContent: name[0].toUpperCase() + name.slice(1), tabIndex: -1 }); // keys 1 to 6 do the same
    side.style.transform = matrix(axesOf({ ...HOME, ...VIEWS[name] }), HALF);
    side.addEventListener("click", () => choose(name));
    return side;
  }));
  root.append(cube);
  return {
    show(camera) {
      const [right, up, toward] = axesOf(camera), rows = [right, up.map((value) => -value), toward];
      turning.style.transform = `matrix3d(${[0, 1, 2].map((k) => [...rows.map((row) => row[k]), 0].join()).join()},0,0,0,1)`;
    },
    remove() {
      cube.remove();
      root.adoptedStyleSheets = root.adoptedStyleSheets.filter((other) => other !== sheet);
    },
  };
}
