/// Threads that the workers of a page lend to a WebAssembly module whose memory they share.
#pragma once

namespace bob {

/// Does this thread's part of what parallel_for is called for, from now on; never returns.
[[noreturn]] void lend_thread();

}  // namespace bob
