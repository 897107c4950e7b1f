/// The work of one parallel_for: each thread takes one piece after the other.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>

#include "base/interruption.h"

namespace bob {

struct Job {
    std::size_t count, grain;
    const std::function<void(std::size_t, std::size_t)>& body;
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stopped{false};
    Interruption* const interruption = Interruption::current();  // of the caller
    std::atomic_flag failed = ATOMIC_FLAG_INIT;
    std::exception_ptr failure{};  // the first exception of a body, rethrown to the caller

    /// Does the remaining pieces on the caller's thread.
    void work() {
        while (step()) {}
    }

    /// Does the remaining pieces on another thread.
    void help() {
        Interruption::current() = interruption;
        work();
        Interruption::current() = nullptr;
    }

private:
    /// Does the next piece; false if all are done.
    bool step() {
        if (stopped.load(std::memory_order_relaxed)) return false;
        const std::size_t begin = next.fetch_add(grain, std::memory_order_relaxed);
        if (begin >= count) return false;
        try {
            Interruption::check();
            body(begin, std::min(begin + grain, count));
        } catch (...) {
            if (!failed.test_and_set()) failure = std::current_exception();
            stopped = true;
        }
        return true;
    }
};

}  // namespace bob
