/// Memory that each thread keeps between calls: allocating it again would take longer than its use.
#pragma once

#include <memory>

namespace bob {

/// This thread's only object of a type; each user has a private type.
///
/// Allocated on first use: threads that never trace need only a pointer, and its alignment does not depend on the
/// system's thread-local storage. Not inlined: otherwise compilers look up the thread's memory at every access, up to a
/// tenth of the time of a loop.
template <class T>
[[gnu::noinline]] T& thread_memory() {
    thread_local const auto memory = std::make_unique<T>();
    return *memory;
}

}  // namespace bob
