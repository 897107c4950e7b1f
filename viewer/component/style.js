// @ts-check
const STYLE = `
:host { position: relative; display: grid; place-items: center; width: 300px; height: 150px; overflow: hidden; background: var(--bob-view-behind, #000); }

:host([hidden]) { display: none; }

canvas { display: block; grid-area: 1 / 1; user-select: none; }

:host([camera-controls]) canvas { touch-action: pan-y; cursor: grab; }

:host([touch-action="pan-x"]) canvas { touch-action: pan-x; }

:host([touch-action="none"]) canvas { touch-action: none; }

:host([camera-controls]) canvas:active { cursor: grabbing; }

canvas:focus { outline: none; }

#ring { display: none; position: absolute; inset: 0; border: 3px solid #fff; outline: 2px solid #000; outline-offset: -5px; pointer-events: none; z-index: 3; }

canvas:focus-visible ~ #ring { display: block; }

#where { position: absolute; top: 0; width: 1px; height: 1px; margin: 0; overflow: hidden; clip-path: inset(50%); }

img { grid-area: 1 / 1; width: 100%; height: 100%; object-fit: contain; pointer-events: none; z-index: 1; }

#prompt, #wrong {
  position: absolute; bottom: 1rem; max-width: calc(100% - 2rem); margin: 0; padding: 0.3rem 0.8rem; border-radius: 1.2rem;
  background: var(--prompt-background, #222d); color: var(--prompt-color, #fff); font: 0.9rem/1.5 system-ui, sans-serif; pointer-events: none; z-index: 2;
}

#prompt { transition: opacity 0.3s; }

#prompt.unseen { opacity: 0; }

#wrong { overflow-wrap: anywhere; }

[hidden] { display: none; }

@media (prefers-reduced-motion: reduce) { #prompt { transition: none; } }

@media (forced-colors: active) {
  #prompt, #wrong { border: 1px solid CanvasText; background: Canvas; color: CanvasText; }

  #ring { border-color: Highlight; outline-color: Canvas; }
}
`;

/** The style sheet that all elements share. @type {CSSStyleSheet | undefined} */
let sheet;

/** The element's style, as a constructed sheet: pages whose policy forbids inline styles allow it. */
export function style() {
  if (sheet) return sheet;
  sheet = new CSSStyleSheet();
  sheet.replaceSync(STYLE);
  return sheet;
}
