/// Threads lent by the workers of a page to a WebAssembly module with shared memory.
#pragma once

namespace bob {

/// Works for parallel_for on this thread; never returns.
[[noreturn]] void lend_thread();

}  // namespace bob
