/// A lock that survives a fork.
#pragma once

#include <atomic>

#ifndef __wasm__
#include <unistd.h>
#endif

namespace bob {

/// A mutex that a forked process takes over from threads of its parent, which would hold it for ever. Guarded data is
/// therefore built separately and put in place as a whole.
class Mutex {
public:
    void lock() {
        while (!try_lock()) wait();
    }

    /// Also false if this thread already holds it.
    [[nodiscard]] bool try_lock() {
        const int own = process();
        int holder = holder_.load(std::memory_order_relaxed);
        return holder != own && holder_.compare_exchange_strong(holder, own, std::memory_order_acquire);
    }

    void unlock() {
        holder_.store(0, std::memory_order_release);
        wake();
    }

private:
#ifdef __wasm__  // the library cannot wait for threads of several workers
    static int process() { return 1; }
    void wait() {}
    void wake() {}
#else
    static int process() { return static_cast<int>(getpid()); }
    void wait() { holder_.wait(process()); }
    void wake() { holder_.notify_one(); }
#endif

    std::atomic<int> holder_ = 0;  // process id
};

}  // namespace bob
