// @ts-check
/**
 * The lattice that a moving picture begins with. Rays of rows cost much less than rays along edges, and those that see nothing
 * hardly anything: where they are that fast, a denser lattice comes first, and the whole picture where there is time for it.
 */

/** The lattice takes so much of the time at most: with more, too few rays would be left for edges. */
const SHARE = 0.25;

/**
 * What so much of a whole picture's time is enough for has no less to show: what is left then lies where corners agree (core/picture/adaptive.h).
 * SSIM is .9997 and more after half of the pixels, those that cost most.
 */
const ENOUGH = 0.8;

/** A denser one than before must take so much less than there is time for: else both would alternate. */
const STICKY = 0.85;

/**
 * What there is time for in a new picture.
 *
 * @param {number} pixels of the picture
 * @param {{whole: number, lattice: number, rate: number}} pace of one thread: milliseconds for a pixel of a whole picture and of a lattice,
 *   NaN where that is not known, and other rays a millisecond
 * @param {{whole: number, part: number}} time milliseconds of all threads: for a whole picture, which is not completed, and for others
 * @param {number} before the step of the picture before
 * @returns {{firstStep: number, lattice: number, others: number}} the lattice's step: 1 for the whole picture, or most of it, 2, 4 or 8; 0 where
 *   rays are too slow for a lattice; its pixels, and how many others there is time for
 */
export function plan(pixels, pace, time, before) {
  const milliseconds = (/** @type {number} */ step) => (step === 1 ? pace.whole : pace.lattice) * pixels / step ** 2;
  const fits = (/** @type {number} */ step) =>
    milliseconds(step) <= (before > 0 && before <= step ? 1 : STICKY) *
      (step === 1 ? Math.max(time.whole, time.part / ENOUGH) : SHARE * time.part);
  const firstStep = [1, 2, 4, 8].find(fits) ?? 0;
  if (firstStep === 1) return { firstStep, lattice: pixels, others: 0 };
  const lattice = firstStep && Math.ceil(pixels / firstStep ** 2);
  return { firstStep, lattice, others: Math.round(pace.rate * (time.part - (firstStep && milliseconds(firstStep)))) };
}

/** What a pixel of a sparse lattice takes, times that of a whole picture, before both were seen, and the most. */
const RATIO = 1.5, MOST_RATIO = 3;

/** What pixels of lattices and whole pictures take one thread: what was not traced last is judged by the ratio that was seen. */
export class LatticePace {
  /** Milliseconds for a pixel; NaN before the first picture. */
  whole = NaN;
  lattice = NaN;
  #ratio = RATIO;
  #wasWhole = false;

  /** @param {number} milliseconds for a pixel @param {boolean} isWhole whether of a whole picture */
  measured(milliseconds, isWhole) {
    const before = this.#wasWhole ? this.whole : this.lattice;
    if (isWhole !== this.#wasWhole && before > 0) {
      const ratio = isWhole ? before / milliseconds : milliseconds / before;
      this.#ratio = Math.min(MOST_RATIO, Math.max(1, ratio));
    }
    this.whole = isWhole ? milliseconds : milliseconds / this.#ratio;
    this.lattice = isWhole ? milliseconds * this.#ratio : milliseconds;
    this.#wasWhole = isWhole;
  }
}
