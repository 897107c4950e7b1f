/// Long work that its caller may want to end.
#pragma once

#include <atomic>
#include <exception>
#include <functional>

namespace bob {

/// Asked now and then, on the caller's thread, whether work shall go on.
using KeepGoing = std::function<bool()>;

/// Thrown by work that shall not go on.
struct Stopped : std::exception {
    [[nodiscard]] const char* what() const noexcept override { return "stopped"; }
};

/// While one lives, what its thread does, and what parallel_for lets other threads do for it, ends by Stopped soon after
/// keep_going has returned false. Work that may take longer than a few hundredths of a second checks now and then.
class Interruption {
public:
    explicit Interruption(const KeepGoing& keep_going) : keep_going_(keep_going), caller_(this_thread()), outer_(current()) {
        current() = this;
    }
    ~Interruption() { current() = outer_; }
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    /// Throws Stopped where this thread's work shall not go on.
    static void check() {
        if (Interruption* const interruption = current(); interruption && !interruption->keeps_going()) throw Stopped();
    }

    /// Asks, if this is the thread that made it. False once the answer was no.
    bool keeps_going() {
        if (keep_going_ && this_thread() == caller_ && !stopped_ && !keep_going_()) stopped_ = true;
        return !stopped_;
    }

    /// That of this thread's work; none where nobody can end it.
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
