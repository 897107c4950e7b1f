// @ts-check
/** A page of a single file: its element shows the scene that the file brings. */
import { fetchPart } from "../core/parts.js";
import { BobView } from "./bob-view.js";

const view = document.querySelector("bob-view");
if (view instanceof BobView) fetchPart("scene.bob").then(async (response) => view.open("scene.bob", await response.blob()));
