// @ts-check
/** A worker that lends its thread to a tracer's core, whose memory it shares; it sends no messages. */
const PAGE = 65_536; // bytes, WebAssembly's page size
const STACK = 1 << 20;

/** The first message has the port to the tracer. @param {MessageEvent<MessagePort>} event */
onmessage = ({ data: tracer }) => {
  /** @param {MessageEvent<import("./tracer.js").Loan>} event */
  tracer.onmessage = ({ data: { module, memory } }) => {
    const { exports } = new WebAssembly.Instance(module, { env: { memory } });
    const { __stack_pointer, lend_thread } = /** @type {Record<string, any>} */ (exports);
    __stack_pointer.value = PAGE * memory.grow(STACK / PAGE) + STACK;
    lend_thread();
  };
};
