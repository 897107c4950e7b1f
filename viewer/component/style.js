// @ts-check
const STYLE = `
:host { position: relative; display: grid; place-items: center; width: 300px; height: 150px; overflow: hidden; background: #000; }

:host([hidden]) { display: none; }

canvas { display: block; grid-area: 1 / 1; user-select: none; }

:host([camera-controls]) canvas { touch-action: none; cursor: grab; }

:host([camera-controls]) canvas:active { cursor: grabbing; }

canvas:focus-visible { outline: 3px solid #7db8ff; outline-offset: -3px; }

img { grid-area: 1 / 1; width: 100%; height: 100%; object-fit: contain; pointer-events: none; z-index: 1; }

#prompt, #wrong {
  position: absolute; bottom: 1rem; max-width: calc(100% - 2rem); margin: 0; padding: 0.3rem 0.8rem; border-radius: 1.2rem;
  background: #222d; color: #fff; font: 0.9rem/1.5 system-ui, sans-serif; pointer-events: none; z-index: 2;
}

#prompt { transition: opacity 0.3s; }

#prompt.unseen { opacity: 0; }

#wrong { overflow-wrap: anywhere; }

[hidden] { display: none; }
`;

/** Of all elements. @type {CSSStyleSheet | undefined} */
let sheet;

/** The element's style, as a constructed sheet: pages whose policy forbids inline styles allow it. */
export function style() {
  if (sheet) return sheet;
  sheet = new CSSStyleSheet();
  sheet.replaceSync(STYLE);
  return sheet;
}
