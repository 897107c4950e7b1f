/// One thread pool for the whole process. In a WebAssembly module, threads lent by workers (parallel_lent.h), or only
/// the caller's.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace bob {

/// Number of threads that parallel_for uses, including the caller's; initially, all of the machine.
[[nodiscard]] int thread_count();
void set_thread_count(int count);

/// Calls body(begin, end) for pieces of at most `grain` that cover 0..count, from several threads.
///
/// The caller's Interruption is checked before each piece, and while other threads finish theirs; a body may check it
/// too. An exception of a body, or Stopped, is rethrown here after all pieces have ended. A call from a body, or during
/// another thread's call, runs on its own thread only.
void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body);

/// Calls body(y) for the rows `begin` to `end` of an image, from several threads if there are enough pixels.
template <class Body>
void for_rows(int begin, int end, int width, Body body) {
    const auto count = static_cast<std::size_t>(std::max(0, end - begin));
    parallel_for(count, static_cast<std::size_t>(1 + 8192 / width), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) body(begin + static_cast<int>(i));
    });
}

}  // namespace bob
