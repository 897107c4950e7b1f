/// A lock that outlives a fork.
#pragma once

#include <atomic>

#ifndef __wasm__
#include <unistd.h>
#endif

namespace bob {

/// A mutex that a forked process takes over from the threads of its parent, which would hold it for ever. Guarded data is therefore
/// built apart and put in place as a whole.
class Mutex {
public:
    void lock() {
        while (!try_lock()) wait();
    }

    /// False also where this very thread holds it.
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
#ifdef __wasm__  // whose library has no waiting for threads of several workers
    static int process() { return 1; }
    void wait() {}
    void wake() {}
#else
    static int process() { return static_cast<int>(getpid()); }
    void wait() { holder_.wait(process()); }
    void wake() { holder_.notify_one(); }
#endif

    std::atomic<int> holder_ = 0;  // a process
};

}  // namespace bob
