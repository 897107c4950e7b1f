// @ts-check
/**
 * A script, not a module: browsers start no modules of a page from a disk, and old browsers know no modules. Modules have
 * run when the page is loaded.
 */
addEventListener("load", () => {
  if ("bobrossnet" in window) return;
  const message = document.getElementById("message");
  if (!message) return;
  message.textContent = location.protocol === "file:"
    ? "This page needs a server: run bobrossnet view, or python -m http.server here; or make one file that opens from a disk, by bobrossnet view FILE --export page.html"
    : "This page did not start: reload it, check that its server has interface/main.js, or use Chrome 137, Firefox 131, Safari 18.4, or newer";
});
