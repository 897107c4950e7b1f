// @ts-check
/** How a moving view begins: by dividing squares, where rays are fast, and by carrying along what the views before have seen, where that shows more. */

/** Of a view's pixels, those that the order of squares begins with: it is used where they take half of the time at most. */
export const LATTICE = 1 / 64;
/** A pixel in that order is worth this much of one that was placed by need. */
const WORTH = 2 / 3;
/** A view that carries along what others have seen shows as much as one in that order of this share of the pixels, and so many times its new ones. */
const CARRIED = 0.016, NEW = 2.6;
/** So much better must be what is new after what was carried along, or the other way round: else both would alternate. */
const STICKY = 1.25;

/**
 * What there is time for in a view.
 *
 * @param {number} pixels of the view
 * @param {{squares: number, others: number, first: number}} rates rays a millisecond of one thread: in the order of squares, elsewhere, and in
 *   first rounds; NaN where that is not known
 * @param {number} time milliseconds @param {number} parts threads
 * @param {number} carrying milliseconds before the first ray of a view that carries along what others have seen
 * @param {boolean} carries whether the view before does
 * @returns {{isFast: boolean, share: number, showsMore: boolean}} whether squares fit; the share of its pixels that a new view would have, as if
 *   all were of squares, 1 where they have to be tried; whether carrying along shows more
 */
export function plan(pixels, { squares, others, first }, time, parts, carrying, carries) {
  // As the first round of another order, that of squares seems slower than it is: it is tried once.
  const isKnown = squares > 0, isFast = LATTICE * pixels / first <= time * parts * (isKnown ? 0.5 : 2);
  const share = isFast && !isKnown ? 1 : (isFast ? squares : others / WORTH) * time * parts / pixels;
  const carried = CARRIED + NEW * others * Math.max(0, time - carrying) * parts / pixels;
  return { isFast, share, showsMore: carries ? carried * STICKY > share : carried > share * STICKY };
}
