// @ts-check
/** Registers elements of pages that load their modules several times, as notebooks do: one for each scene. */

/**
 * Registers an element's class, unless one of this version is registered. If another version has the name, the element
 * gets a name with its version, so that nothing of two versions mixes.
 *
 * @template {CustomElementConstructor & {version: string}} T
 * @param {string} name
 * @param {T} type
 * @returns {T} the registered class of this version; outside browsers, `type`
 */
export function define(name, type) {
  if (typeof customElements === "undefined") return type;
  const own = `${name}-${type.version.toLowerCase().replace(/[^a-z0-9.-]/g, "-")}`;
  for (const free of [name, own]) {
    const known = /** @type {T | undefined} */ (customElements.get(free));
    if (known?.version === type.version) return known;
    if (known) continue;
    customElements.define(free, type);
    if (free === own) {
      const version = /** @type {T | undefined} */ (customElements.get(name))?.version ?? "unknown";
      console.warn(`<${name}> has version ${version} on this page, and <${own}> has version ${type.version}; load one version only`);
    }
    return type;
  }
  return type;
}
