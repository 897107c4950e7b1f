// @ts-check
/** Fetches files; each error suggests a remedy. */
import { brief } from "./errors.js";

/**
 * @param {string} name of the file, for errors
 * @param {URL | string} address
 * @param {string} [advice] for a file that is not there
 * @returns {Promise<Response>} with the file
 * @throws {Error} of one sentence
 */
export async function fetched(name, address, advice = "check the address") {
  const url = new URL(address);
  let response;
  try {
    response = await fetch(url);
  } catch {
    throw new Error(`${name}: ${unreachable(url)}`);
  }
  const shown = short(url);
  if (!response.ok) throw new Error(`${name}: expected a file at ${shown}, got ${response.status} ${response.statusText}; ${advice}`);
  if (response.headers.get("Content-Type")?.startsWith("text/html")) {
    throw new Error(`${name}: expected a file at ${shown}, got a web page; ${advice}`);
  }
  return response;
}

/** Addresses with data are long. @param {URL} url */
const short = ({ href }) => (href.length <= 120 ? href : `${href.slice(0, 117)}...`);

/** Browsers do not reveal the reason. @param {URL} url */
function unreachable(url) {
  const { protocol, host } = url, shown = short(url), { origin } = globalThis;
  if (protocol === "file:" || origin === "null" && protocol !== "data:") {
    return `expected a server, got ${shown}, which this page may not fetch; serve the folder, or make one file: bobrossnet view FILE --export page.html`;
  }
  if (protocol === "data:" || protocol === "blob:") {
    return `expected data, got ${brief(shown)}, which is damaged, revoked, or forbidden by connect-src of the page's Content-Security-Policy`;
  }
  if (!navigator.onLine) return `expected a network to fetch ${shown}, got none; connect this machine and try again`;
  if (origin.startsWith("https:") && protocol === "http:") return `expected an address with https:, as this page has, got ${shown}`;
  if (url.origin !== origin) return `${host} did not send ${shown}; check the address, and that the server sends Access-Control-Allow-Origin`;
  return `${host} did not answer for ${shown}; check that the server runs`;
}
