/// Interruption of long work by its caller.
#pragma once

#include <atomic>
#include <exception>
#include <functional>

namespace bob {

/// Called now and then on the caller's thread; false stops the work.
using KeepGoing = std::function<bool()>;

/// Thrown by interrupted work.
struct Stopped : std::exception {
    [[nodiscard]] const char* what() const noexcept override { return "stopped"; }
};

/// During its lifetime, work on its thread ends by Stopped soon after keep_going returned false. So does work that
/// parallel_for gives to other threads. Work that may take longer than a few hundredths of a second calls `check`
/// regularly.
class Interruption {
public:
    explicit Interruption(const KeepGoing& keep_going) : keep_going_(keep_going), caller_(this_thread()), outer_(current()) {
        current() = this;
    }
    ~Interruption() { current() = outer_; }
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    /// Throws Stopped if this thread's work is interrupted.
    static void check() {
        if (Interruption* const interruption = current(); interruption && !interruption->keeps_going()) throw Stopped();
    }

    /// Calls keep_going on the thread that constructed this. Stays false after the first false.
    bool keeps_going() {
        if (keep_going_ && this_thread() == caller_ && !stopped_ && !keep_going_()) stopped_ = true;
        return !stopped_;
    }

    /// The interruption of this thread's work; null if it cannot be interrupted.
    static Interruption*& current() {
        thread_local Interruption* interruption = nullptr;
        return interruption;
    }

private:
    static const void* this_thread() {
        thread_local const char here = 0;
        return &here;
    }

    const KeepGoing keep_going_;
    const void* caller_;
    Interruption* outer_;
    std::atomic<bool> stopped_ = false;
};

}  // namespace bob
