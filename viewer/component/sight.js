// @ts-check
/**
 * Whether anyone sees an element: it is in the window, in a tab that is displayed, and its style does not hide it.
 * Elements that cover it are not noticed.
 */

const LOOK_MS = 250; // between looks at the style of an element that it hides: no event reports its change

export class Sight {
  isSeen = false;
  #element;
  #changed;
  #isInWindow = false;
  #timer = 0;
  #observer = new IntersectionObserver((entries) => {
    this.#isInWindow = /** @type {IntersectionObserverEntry} */ (entries.at(-1)).isIntersecting;
    this.look();
  });

  /** @param {Element} element @param {() => void} changed */
  constructor(element, changed) {
    this.#element = element;
    this.#changed = changed;
  }

  begin() {
    const { left, top, right, bottom } = this.#element.getBoundingClientRect(); // the observer reports later
    this.#isInWindow = right > 0 && bottom > 0 && left < innerWidth && top < innerHeight;
    this.#observer.observe(this.#element);
    document.addEventListener("visibilitychange", this.look);
    this.look();
  }

  end() {
    this.#observer.disconnect();
    document.removeEventListener("visibilitychange", this.look);
    this.#isInWindow = false;
    this.look();
  }

  /** Reports a change, also of the style. */
  look = () => {
    clearTimeout(this.#timer);
    const isPossible = this.#isInWindow && document.visibilityState === "visible";
    const isSeen = isPossible && this.#element.checkVisibility({ opacityProperty: true, visibilityProperty: true });
    if (isPossible && !isSeen) this.#timer = setTimeout(this.look, LOOK_MS);
    if (isSeen === this.isSeen) return;
    this.isSeen = isSeen;
    this.#changed();
  };
}
