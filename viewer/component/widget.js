// @ts-check
/**
 * The element as a widget of notebooks, for anywidget (src/bobrossnet/page/widget.py is its other half). The widget's
 * state contains everything it needs, so that it works without a kernel.
 *
 * @typedef {{get: (name: string) => any, set: (name: string, value: any) => void, save_changes: () => void,
 *   on: (event: string, listener: () => void) => void, off: (event: string, listener: () => void) => void}} Model
 */
import { BobView } from "./bob-view.js";

const SENDING_MS = 100; // minimum interval between cameras sent to the kernel during a movement

/** @param {{model: Model, el: HTMLElement}} where @returns {() => void} ends it */
function render({ model, el }) {
  const view = new BobView(), [height, width] = model.get("size");
  view.alt = "Picture of the scene";
  view.toggleAttribute("camera-controls", true);
  Object.assign(view.style, { width: `${width}px`, maxWidth: "100%", height: "auto", aspectRatio: `${width} / ${height}` });
  el.dataset.lmSuppressShortcuts = "true"; // otherwise JupyterLab's keys move from cell to cell
  const show = () => {
    view.setAttribute("background", model.get("background"));
    view.setAttribute("light", model.get("light"));
  };
  let isSending = false; // the model also reports values set here; a movement would end there
  const look = () => {
    if (!isSending) view.camera = model.get("camera");
  };
  const open = async () => {
    const stream = new Blob([model.get("scene")]).stream().pipeThrough(new DecompressionStream("deflate"));
    await view.open("scene.bob", await new Response(stream).blob());
  };

  let timer = 0;
  view.addEventListener("camera-change", () => {
    timer ||= setTimeout(() => {
      timer = 0;
      isSending = true;
      model.set("camera", view.camera);
      isSending = false;
      model.save_changes();
    }, SENDING_MS);
  });
  const listeners = { "change:camera": look, "change:background": show, "change:light": show, "change:scene": open };
  for (const [event, listener] of Object.entries(listeners)) model.on(event, listener);
  show();
  look();
  el.append(view);
  open();
  return () => {
    for (const [event, listener] of Object.entries(listeners)) model.off(event, listener);
    clearTimeout(timer);
    view.remove();
  };
}

export default { render };
