// @ts-check
/** A page in a single file: its element shows the scene embedded in the file. */
import { fetchPart } from "../core/parts.js";
import { BobView } from "./bob-view.js";

const view = document.querySelector("bob-view");
if (view instanceof BobView) fetchPart("scene.bob").then(async (response) => view.open("scene.bob", await response.blob()));
