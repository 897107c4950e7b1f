/** Measures in a worker of a page. The server has the settings and takes the messages. */
import { measure } from "./measure.js";

let sent = Promise.resolve();
const report = (message) => { sent = sent.then(() => fetch("messages", { method: "POST", body: JSON.stringify(message) })); };

try {
  const settings = await (await fetch("settings.json")).json();
  await measure(settings, () => new Worker("workers/completing.js", { type: "module" }), report);
  report({ done: true });
} catch (error) {
  report({ error: String(error?.stack ?? error) });
}
