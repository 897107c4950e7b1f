/// parallel.h in a WebAssembly module with memory shared by several workers. Each lends its thread, and may join at any
/// time.
#include "base/parallel_lent.h"

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "base/job.h"
#include "base/parallel.h"

namespace bob {
namespace {

constexpr std::int64_t forever = -1, milliseconds = 1'000'000;

std::atomic<int> wanted{1}, lent{0};
std::atomic_flag in_use = ATOMIC_FLAG_INIT;  // a flag, since its holder may call parallel_for from a body

std::atomic<Job*> job{nullptr};
std::atomic<int> generation{0};  // of jobs
std::atomic<int> places{0};      // free places in the job
std::atomic<int> busy{0};        // threads that may access the job, except the caller's

int* address(std::atomic<int>& value) { return reinterpret_cast<int*>(&value); }

/// Waits until a value differs from `as`, another thread wakes this one, or the time has passed.
void wait_while(std::atomic<int>& value, int as, std::int64_t nanoseconds) {
    __builtin_wasm_memory_atomic_wait32(address(value), as, nanoseconds);
}

void wake(std::atomic<int>& value, int threads) {
    __builtin_wasm_memory_atomic_notify(address(value), static_cast<unsigned>(threads));
}

void share(Job& shared, int others) {
    job = &shared;
    places = others;
    ++generation;
    wake(generation, others);
    shared.work();
    job = nullptr;  // late threads find no job
    while (const int still = busy) {
        wait_while(busy, still, 10 * milliseconds);
        if (shared.interruption) shared.interruption->keeps_going();  // on behalf of the others
    }
}

}  // namespace

void lend_thread() {
    ++lent;
    for (int seen = 0;;) {
        wait_while(generation, seen, forever);
        seen = generation;
        ++busy;
        Job* const shared = job;
        if (shared && places-- > 0) shared->help();
        if (--busy == 0) wake(busy, 1);
    }
}

int thread_count() { return std::min<int>(wanted, 1 + lent); }

void set_thread_count(int count) { wanted = std::max(1, count); }

void parallel_for(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
    Job shared{count, std::max<std::size_t>(1, grain), body};
    const int threads = thread_count();
    if (threads > 1 && count > shared.grain && !in_use.test_and_set()) {
        share(shared, threads - 1);
        in_use.clear();
    } else {
        shared.work();
    }
    if (shared.failure) std::rethrow_exception(shared.failure);
}

}  // namespace bob
