// @ts-check
/** The package's version; src/bobrossnet/page/joining.py generates this module for joined modules. */
export const VERSION = "source";
