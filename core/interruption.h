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

/// Lets all threads of some work end soon after keep_going, if there is one, has returned false.
class Interruption {
public:
    explicit Interruption(const KeepGoing& keep_going) : keep_going_(keep_going), caller_(this_thread()) {}

    /// Asks, if this is the thread that made it. False once the answer was no.
    bool keeps_going() {
        if (keep_going_ && this_thread() == caller_ && !stopped_ && !keep_going_()) stopped_ = true;
        return !stopped_;
    }

    /// Throws Stopped where the work shall not go on.
    void check() {
        if (!keeps_going()) throw Stopped();
    }

private:
    static const void* this_thread() {
        thread_local const char here = 0;
        return &here;
    }

    const KeepGoing& keep_going_;
    const void* caller_;
    std::atomic<bool> stopped_ = false;
};

}  // namespace bob
