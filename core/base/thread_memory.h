/// Memory that each thread keeps from call to call, since to ask for it anew would take longer than what it is needed for.
#pragma once

#include <memory>

namespace bob {

/// This thread's only object of a type. Each user has a type of its own for it. It is allocated on first use: threads
/// that never trace pay a pointer, and its alignment does not depend on the system's thread-local storage.
/// Not inlined: compilers would look up the thread's memory at every access, up to a tenth of the time of loops around it.
template <class T>
[[gnu::noinline]] T& thread_memory() {
    thread_local const auto memory = std::make_unique<T>();
    return *memory;
}

}  // namespace bob
