// @ts-check
/**
 * The workers that trace one scene, and the one that reads it.
 *
 * Each file gets new workers, since a WebAssembly instance never releases memory; the old ones end when the new ones
 * can show the file. One worker traces the first picture alone; starting the others meanwhile would only delay it. If
 * workers may share memory, there is one tracer, and the others lend it their threads.
 *
 * @typedef {import("./tracer.js").Batch} Batch
 * @typedef {Extract<import("./tracer.js").Reply, {kind: "traced"}>} Traced
 * @typedef {{worker: Worker, port: MessagePort, pending: number, edition: number}} Tracer
 *   port: for the reader of the scene; pending: number of scenes sent and not answered yet; edition: of its scene, or
 *   NONE
 */
import { canLendThreads } from "../core/compile.js";
import { startWorker } from "../core/parts.js";

const nothing = () => {};
const AMPLE = 4; // cores; with more, some are free while a page starts
const NONE = -1;
const READ = 0; // edition of the reader's scene

export class Pool {
  /** @type {Tracer[]} */
  #tracers = [];
  /** @type {{resolve: (warnings: string[]) => void, reject: (error: Error) => void}[]} */
  #waiting = [];
  /** @type {Batch | undefined} in progress */
  #batch;
  /** @type {Tracer | undefined} leads the batch, or led the last one */
  #leader;
  /** @type {Tracer[]} */
  #others = [];
  #reader = startWorker("reader");
  /** Workers that lend the tracer their threads. @type {Worker[]} */
  #lenders = [];
  #lendable; // maximum number of further lenders
  /** Starts the missing workers and gives them the scene. */
  #share = nothing;
  #asked = READ; // edition of the newest scene sent to tracers
  #edition = NONE; // edition of the newest scene of a tracer
  #count;
  #module;
  #completing;
  #done;
  #lost;

  /**
   * @param {number} count of tracing threads
   * @param {Promise<WebAssembly.Module>} module of the core
   * @param {Worker} completing receives the samples
   * @param {(traced: Traced) => void} done called after each batch
   * @param {(message: string) => void} lost called after the last worker failed
   */
  constructor(count, module, completing, done, lost) {
    this.#module = module;
    this.#done = done;
    this.#lost = lost;
    this.#count = canLendThreads() ? 1 : count;
    this.#lendable = count - this.#count;
    this.#completing = completing;
    this.#add();
    if (navigator.hardwareConcurrency >= AMPLE) this.lend();
  }

  /** Starts a worker. @returns {Tracer} */
  #add() {
    const worker = startWorker("tracer");
    const samples = new MessageChannel(), scenes = new MessageChannel();
    this.#completing.postMessage({ kind: "connect", tracer: samples.port2 }, [samples.port2]);
    worker.postMessage({ kind: "connect", completing: samples.port1, reading: scenes.port1 }, [samples.port1, scenes.port1]);
    const tracer = { worker, port: scenes.port2, pending: 0, edition: NONE };
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

  /** Starts all missing workers, for the current scene. @returns {Tracer[]} */
  #addOthers() {
    return Array.from({ length: this.#count - this.#tracers.length }, () => this.#add());
  }

  /** Tracers with the newest scene. */
  get ready() {
    return this.#tracers.filter((tracer) => tracer.edition === this.#edition && tracer.edition !== NONE && tracer.pending === 0);
  }

  /** Number of threads for the newest scene. */
  get threads() {
    return this.ready.length + (this.ready.length > 0 ? this.#lenders.length : 0);
  }

  /** Whether all workers have ended. */
  get ended() {
    return this.#tracers.length === 0;
  }

  /**
   * Replaces the scene; if that fails, the previous one stays.
   *
   * @param {import("../tracing/description.js").SceneDescription} scene
   * @returns {Promise<string[]>} warnings, a line each, once a tracer has it
   */
  async open(scene) {
    const shareBefore = this.#share, edition = ++this.#asked;
    /** @param {Tracer} tracer */
    const give = (tracer) => {
      ++tracer.pending;
      tracer.worker.postMessage({ kind: "open", scene, edition });
    };
    this.#share = nothing;
    this.#tracers.forEach(give);
    let warnings;
    try {
      warnings = await this.#opened();
    } catch (error) {
      this.#share = shareBefore;
      throw error;
    }
    this.#reader.terminate();
    this.#share = () => this.#addOthers().forEach(give);
    return warnings;
  }

  /**
   * Opens a file, once.
   *
   * @param {string} name with its ending
   * @param {Blob | string} source or its address
   * @param {boolean} yUp whether y is up in the file
   * @param {File[]} beside files opened together with it
   * @param {Promise<WebAssembly.Module>} module of the core that reads it
   * @returns {Promise<import("./reader.js").Summary>} resolved once a tracer has it
   */
  async read(name, source, yUp, beside, module) {
    const opened = this.#opened(), { port } = this.#tracers[0];
    opened.catch(() => {}); // awaited below
    const reader = this.#reader;
    try {
      /** @type {Promise<import("./reader.js").Summary>} */
      const read = new Promise((resolve, reject) => {
        reader.onmessage = ({ data }) => {
          if (data.kind === "read") resolve(data.summary);
          else if (data.kind === "failed") reject(new Error(data.message));
          else this.#keep(data.tracers);
        };
        reader.onerror = (event) => reject(new Error(event.message ?? "reader.js did not start"));
      });
      reader.postMessage({ kind: "read", name, source, beside, yUp, port, module: await module }, [port]);
      const [summary, warnings] = await Promise.all([read, opened]);
      this.#share = () => {
        const ports = this.#addOthers().map((tracer) => tracer.port);
        reader.postMessage({ kind: "share", ports }, ports);
      };
      return { ...summary, warnings: [...summary.warnings, ...warnings] };
    } catch (error) {
      reader.terminate();
      throw error;
    }
  }

  /** Starts all workers, beginning with the scene's first picture. */
  grow() {
    this.lend();
    this.#share();
    this.#share = nothing;
  }

  /** Ends workers that are no longer needed once a scene was shared. @param {number} count of tracers with the scene */
  #keep(count) {
    this.#count = count;
    this.#reader.terminate();
    for (const { worker } of this.#tracers.splice(count)) worker.terminate();
  }

  /** @returns {Promise<string[]>} warnings, once a tracer has the scene requested last */
  #opened() {
    return new Promise((resolve, reject) => this.#waiting.push({ resolve, reject }));
  }

  /** @param {Batch} batch for `parts` of the ready tracers */
  trace(batch) {
    // The leader of the last batch has the samples of the view.
    const ready = this.ready, leader = this.#leader && ready.includes(this.#leader) ? this.#leader : ready[0];
    this.#batch = batch;
    this.#leader = leader;
    this.#others = ready.filter((tracer) => tracer !== leader).slice(0, batch.parts - 1);
    const ports = this.#others.map(({ worker }) => {
      const { port1, port2 } = new MessageChannel();
      worker.postMessage({ kind: "help", leader: port1 }, [port1]);
      return port2;
    });
    leader.worker.postMessage({ kind: "lead", batch, others: ports }, ports);
  }

  /** Ends the batch soon; its samples are not sent. */
  cancel() {
    if (this.#batch) this.#leader?.worker.postMessage({ kind: "cancel" });
  }

  /** Ends the workers; scenes being opened fail. */
  end() {
    this.#share = nothing;
    this.#reader.terminate();
    for (const { worker } of this.#tracers.splice(0)) worker.terminate();
    for (const lender of this.#lenders.splice(0)) lender.terminate();
    this.#settle(({ reject }) => reject(new Error("another scene was opened")));
  }

  /** @param {Tracer} tracer @param {import("./tracer.js").Reply} reply */
  #receive(tracer, reply) {
    if (reply.kind === "traced") {
      this.#finish(reply);
    } else if (reply.kind === "opened") {
      if (reply.edition) --tracer.pending;
      tracer.edition = reply.edition;
      this.#edition = Math.max(this.#edition, reply.edition);
      if (reply.edition === this.#asked) this.#settle(({ resolve }) => resolve(reply.warnings));
    } else {
      if (reply.edition) --tracer.pending;
      this.#failed(tracer, reply.message, reply.broken);
    }
  }

  /** @param {Traced} traced */
  #finish(traced) {
    this.#batch = undefined;
    this.#done(traced);
  }

  /** @param {Tracer} tracer @param {string} message @param {boolean} broken */
  #failed(tracer, message, broken) {
    if (broken) {
      tracer.worker.terminate();
      this.#tracers = this.#tracers.filter((other) => other !== tracer);
      for (const lender of this.#lenders.splice(0)) lender.terminate();
      if (this.ended) this.#lost(message);
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
