// @ts-check
/**
 * The lattice that a moving picture begins with. Rays of rows cost much less than rays along edges, and those that see nothing
 * hardly anything: where they are that fast, a denser lattice comes first, and the whole picture where there is time for it.
 */

/** The lattice takes so much of the time at most: with more, too few rays would be left for edges. */
const SHARE = 0.25;

/** A denser one than before must take so much less than there is time for: else both would alternate. */
const STICKY = 0.85;

/**
 * What there is time for in a new picture.
 *
 * @param {number} pixels of the picture
 * @param {{lattice: number, rate: number}} pace of one thread: milliseconds for a pixel of a lattice, NaN where that is not known, and
 *   other rays a millisecond
 * @param {{whole: number, part: number}} time milliseconds of all threads: for a whole picture, which is not completed, and for others
 * @param {number} before the step of the picture before
 * @returns {{firstStep: number, lattice: number, others: number}} the lattice's step: 1 for the whole picture, 2, 4 or 8; 0 where
 *   rays are too slow for a lattice; its pixels, and how many others there is time for
 */
export function plan(pixels, pace, time, before) {
  const milliseconds = (/** @type {number} */ step) => pace.lattice * pixels / step ** 2;
  const fits = (/** @type {number} */ step) =>
    milliseconds(step) <= (before > 0 && before <= step ? 1 : STICKY) * (step === 1 ? time.whole : SHARE * time.part);
  const firstStep = [1, 2, 4, 8].find(fits) ?? 0;
  if (firstStep === 1) return { firstStep, lattice: pixels, others: 0 };
  const lattice = firstStep && Math.ceil(pixels / firstStep ** 2);
  return { firstStep, lattice, others: Math.round(pace.rate * (time.part - (firstStep && milliseconds(firstStep)))) };
}
