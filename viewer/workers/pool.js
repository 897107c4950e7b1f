// @ts-check
/**
 * The workers that trace: they keep the scenes of several elements, and trace for one at a time. One worker traces the
 * first picture alone; starting the others meanwhile would only delay it. If workers may share memory, there is one
 * tracer, and the others lend it their threads.
 *
 * @typedef {import("./tracer.js").Batch} Batch
 * @typedef {import("../tracing/scene.js").Scene} Scene
 * @typedef {Extract<import("./tracer.js").Reply, {kind: "traced"}>} Traced
 * @typedef {{worker: Worker, pending: Set<number>, editions: Map<number, number>, memory: number}} Tracer
 *   pending: editions sent by the page and not answered yet; editions: of its scenes, by element; memory: bytes of its core
 * @typedef {{edition: number, share: () => void}} Kept an element's scene
 *   edition: the newest of a tracer, or NONE; share: starts the missing workers and gives all of them the scene
 */
import { canLendThreads } from "../core/compile.js";
import { startWorker } from "../core/parts.js";

const nothing = () => {};
const AMPLE = 4; // cores; with more, some are free while a page starts
const NONE = -1;
const LARGE = 128e6; // bytes of all its cores, which never shrink: more is not kept for another scene

export class Pool {
  /** @type {Tracer[]} */
  #tracers = [];
  /** @type {{resolve: (warnings: string[]) => void, reject: (error: Error) => void}[]} */
  #waiting = [];
  /** @type {Batch | undefined} in progress */
  #batch;
  /** Follows the batch in progress, which was cancelled. @type {Batch | undefined} */
  #next;
  /** @type {Tracer | undefined} leads the batch, or led the last one */
  #leader;
  /** @type {Tracer[]} */
  #others = [];
  /** Workers that lend the tracer their threads. @type {Worker[]} */
  #lenders = [];
  #lendable; // maximum number of further lenders
  #question = 0;
  /** Callbacks for the answers of tracers. @type {Map<number, (answer: any) => void>} */
  #questions = new Map();
  #element = 0; // at work
  /** Scenes by element. @type {Map<number, Kept>} */
  #scenes = new Map();
  #asked = 0; // edition of the newest scene sent to tracers
  #count;
  #module;
  #completing;
  #done;
  #lost;

  /**
   * @param {number} size number of tracing threads
   * @param {Promise<WebAssembly.Module>} module of the core
   * @param {Worker} completing receives the samples
   * @param {(traced: Traced) => void} done called after each batch
   * @param {(message: string) => void} lost called after the last worker failed
   */
  constructor(size, module, completing, done, lost) {
    this.size = size;
    this.#module = module;
    this.#done = done;
    this.#lost = lost;
    this.#count = canLendThreads() ? 1 : size;
    this.#lendable = size - this.#count;
    this.#completing = completing;
    this.#add();
    if (navigator.hardwareConcurrency >= AMPLE) this.lend();
  }

  /** Starts a worker. @returns {Tracer} */
  #add() {
    const worker = startWorker("tracer"), tracer = { worker, pending: new Set(), editions: new Map(), memory: 0 };
    const { port1, port2 } = new MessageChannel();
    this.#completing.postMessage({ kind: "connect", tracer: port2 }, [port2]);
    worker.postMessage({ kind: "connect", completing: port1 }, [port1]);
    this.#module.then((module) => worker.postMessage({ kind: "start", module }),
                      (error) => this.#failed(tracer, error.message, true));
    worker.onmessage = ({ data }) => this.#receive(tracer, data);
    worker.onerror = (event) => this.#failed(tracer, event.message ?? "a worker did not start", true);
    this.#tracers.push(tracer);
    return tracer;
  }

  /** Starts the workers that lend the tracer their threads, if necessary: it also builds scenes with them. */
  lend() {
    const [tracer] = this.#tracers;
    if (!tracer || this.#lendable === 0) return;
    const ports = Array.from({ length: this.#lendable }, () => {
      const worker = startWorker("thread"), { port1, port2 } = new MessageChannel();
      worker.postMessage(port1, [port1]);
      worker.onerror = (event) => this.#failed(tracer, event.message ?? "a worker did not start", true);
      this.#lenders.push(worker);
      return port2;
    });
    this.#lendable = 0;
    tracer.worker.postMessage({ kind: "borrow", lenders: ports }, ports);
  }

  /** All tracers but the first, after starting the missing ones. @returns {Tracer[]} */
  #allOthers() {
    while (this.#tracers.length < this.#count) this.#add();
    return this.#tracers.slice(1);
  }

  /** Tracers with the element's newest scene. */
  get ready() {
    const element = this.#element, edition = this.#scenes.get(element)?.edition ?? NONE;
    if (edition === NONE) return [];
    return this.#tracers.filter(({ editions, pending }) => editions.get(element) === edition && pending.size === 0);
  }

  /** Number of threads for the element's newest scene. */
  get threads() {
    return this.ready.length + (this.ready.length > 0 ? this.#lenders.length : 0);
  }

  /** Whether all workers have ended. */
  get ended() {
    return this.#tracers.length === 0;
  }

  /** Bytes of all its cores. */
  get memory() {
    return this.#tracers.reduce((sum, tracer) => sum + tracer.memory, 0);
  }

  /** Whether its memory is small enough, and all its workers are there, for another scene. */
  get isReusable() {
    return !this.ended && this.memory <= LARGE && this.#count === (canLendThreads() ? 1 : this.size);
  }

  /** Whether it has a scene of an element. @param {number} element */
  has(element) {
    return !this.ended && (this.#scenes.get(element)?.edition ?? NONE) !== NONE;
  }

  /** Batches are for this element from now on. @param {number} element */
  turnTo(element) {
    this.#element = element;
  }

  /** Frees an element's scene. @param {number} element */
  forget(element) {
    this.#scenes.delete(element);
    for (const { worker, editions } of this.#tracers) {
      editions.delete(element);
      worker.postMessage({ kind: "forget", element });
    }
  }

  /** @param {number} element @returns {Kept} */
  #kept(element) {
    const kept = this.#scenes.get(element) ?? { edition: NONE, share: nothing };
    this.#scenes.set(element, kept);
    return kept;
  }

  /**
   * Replaces an element's scene; if that fails, the previous one stays.
   *
   * @param {number} element
   * @param {import("../tracing/description.js").SceneDescription} scene
   * @returns {Promise<string[]>} warnings, a line each, once a tracer has it
   */
  async open(element, scene) {
    const kept = this.#kept(element), shareBefore = kept.share, edition = ++this.#asked;
    /** @param {Tracer} tracer */
    const give = (tracer) => {
      tracer.pending.add(edition);
      tracer.worker.postMessage({ kind: "open", element, edition, scene });
    };
    kept.share = nothing;
    const given = [...this.#tracers];
    given.forEach(give);
    let warnings;
    try {
      warnings = await this.#opened();
    } catch (error) {
      kept.share = shareBefore;
      throw error;
    }
    kept.share = () => this.#allOthers().filter((tracer) => !given.includes(tracer)).forEach(give);
    return warnings;
  }

  /**
   * Replaces an element's scene by a file's; if that fails, the previous one stays.
   *
   * @param {number} element
   * @param {import("./reading.js").ReadFile} file
   * @returns {import("./reading.js").ReadFile["summary"]} resolved once a tracer has it
   */
  async read(element, { port, summary: reading, share }) {
    const kept = this.#kept(element), edition = ++this.#asked, shareBefore = kept.share;
    /** @param {Tracer} tracer @param {MessagePort} reading its scene comes through it */
    const give = ({ worker }, reading) => worker.postMessage({ kind: "read", element, edition, reading }, [reading]);
    kept.share = nothing;
    try {
      give(this.#tracers[0], port);
      const [summary, warnings] = await Promise.all([reading, this.#opened()]);
      kept.share = () => {
        const ports = this.#allOthers().map((tracer) => {
          const { port1, port2 } = new MessageChannel();
          give(tracer, port1);
          return port2;
        });
        share(ports).then((count) => count !== null && edition === kept.edition && this.#keep(count));
      };
      return { ...summary, warnings: [...summary.warnings, ...warnings] };
    } catch (error) {
      kept.share = shareBefore;
      throw error;
    }
  }

  /** Starts all workers, beginning with the scene's first picture. */
  grow() {
    const kept = this.#kept(this.#element), { share } = kept;
    this.lend();
    kept.share = nothing;
    share();
  }

  /** Ends the tracers without a scene, when it does not fit all of them. @param {number} count tracers with the scene */
  #keep(count) {
    this.#count = count;
    for (const { worker } of this.#tracers.splice(count)) worker.terminate();
  }

  /** @returns {Promise<string[]>} warnings, once a tracer has the scene requested last */
  #opened() {
    return new Promise((resolve, reject) => this.#waiting.push({ resolve, reject }));
  }

  /** @param {Batch} batch for `parts` of the ready tracers */
  trace(batch) {
    if (this.#batch) {
      this.#next = batch;
      return;
    }
    // The leader of the last batch has the samples of the view.
    const ready = this.ready, leader = this.#leader && ready.includes(this.#leader) ? this.#leader : ready[0];
    this.#batch = batch;
    this.#leader = leader;
    this.#others = ready.filter((tracer) => tracer !== leader).slice(0, batch.parts - 1);
    const ports = this.#others.map(({ worker }) => {
      const { port1, port2 } = new MessageChannel();
      worker.postMessage({ kind: "help", element: this.#element, leader: port1, cutaway: batch.cutaway }, [port1]);
      return port2;
    });
    leader.worker.postMessage({ kind: "lead", element: this.#element, batch, others: ports }, ports);
  }

  /**
   * Asks an element's scene: calls a method of Scene in a tracer that displays it.
   *
   * @template {import("./tracer.js").Question} Q
   * @param {number} element
   * @param {Q} question
   * @param {Parameters<Scene[Q]>} values
   * @returns {Promise<ReturnType<Scene[Q]> | null>} null if there is no scene, or no longer
   */
  ask(element, question, ...values) {
    const edition = this.#scenes.get(element)?.edition ?? NONE, id = ++this.#question, leader = this.#leader;
    const known = this.#tracers.filter(({ editions }) => editions.get(element) === edition);
    const tracer = leader && known.includes(leader) ? leader : known[0];
    if (!tracer) return Promise.resolve(null);
    return new Promise((resolve) => {
      this.#questions.set(id, resolve);
      tracer.worker.postMessage({ kind: "ask", element, id, question, values });
    });
  }

  /** Ends the batch soon; its samples are not sent. */
  cancel() {
    this.#next = undefined;
    if (this.#batch) this.#leader?.worker.postMessage({ kind: "cancel" });
  }

  /** Ends the workers; scenes being opened fail. */
  end() {
    this.#scenes.clear();
    for (const { worker } of this.#tracers.splice(0)) worker.terminate();
    for (const lender of this.#lenders.splice(0)) lender.terminate();
    this.#endQuestions();
    this.#settle(({ reject }) => reject(new Error("another scene was opened")));
  }

  /** @param {Tracer} tracer @param {import("./tracer.js").Reply} reply */
  #receive(tracer, reply) {
    if (reply.kind === "traced") {
      this.#finish(reply);
    } else if (reply.kind === "answered") {
      this.#questions.get(reply.id)?.(reply.answer);
      this.#questions.delete(reply.id);
    } else if (reply.kind === "opened") {
      tracer.pending.delete(reply.edition);
      tracer.memory = reply.memory;
      const kept = this.#scenes.get(reply.element);
      if (kept) {
        tracer.editions.set(reply.element, reply.edition);
        kept.edition = Math.max(kept.edition, reply.edition);
      }
      if (reply.edition === this.#asked) this.#settle(({ resolve }) => resolve(reply.warnings));
    } else {
      const { edition = this.#asked, message, broken } = reply;
      tracer.pending.delete(edition);
      if (edition === this.#asked || broken) this.#failed(tracer, message, broken); // else a scene that was given up
    }
  }

  #endQuestions() {
    for (const resolve of this.#questions.values()) resolve(null);
    this.#questions.clear();
  }

  /** @param {Traced} traced */
  #finish(traced) {
    const next = this.#next;
    this.#batch = this.#next = undefined;
    this.#done(traced);
    if (next && !this.#batch && this.threads > 0) this.trace(next);
  }

  /** @param {Tracer} tracer @param {string} message @param {boolean} broken */
  #failed(tracer, message, broken) {
    if (broken) {
      tracer.worker.terminate();
      this.#tracers = this.#tracers.filter((other) => other !== tracer);
      for (const lender of this.#lenders.splice(0)) lender.terminate();
      if (this.ended) this.#lost(message);
      this.#endQuestions();
      // The others trace the batch again.
      const batch = this.#batch;
      if (batch && tracer === this.#leader) {
        this.#finish({ kind: "traced", batch, cancelled: true, left: 0, rays: 0, milliseconds: 0 });
      } else if (this.#others.includes(tracer)) {
        this.cancel();
      }
    }
    this.#settle(({ reject }) => reject(new Error(message)));
  }

  /** @param {(waiting: {resolve: (warnings: string[]) => void, reject: (error: Error) => void}) => void} how */
  #settle(how) {
    this.#waiting.splice(0).forEach(how);
  }
}
