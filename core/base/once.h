/// Values that are made once, when first asked for.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include "base/mutex.h"

namespace bob {

template <class T>
class Once {
public:
    Once() = default;
    Once(Once&& other) noexcept : value_(std::move(other.value_)), made_(other.made_.load()) {}

    /// Makes the value from make(), unless it is there. Safe to call from any thread, repeatedly.
    template <class Make>
    void prepare(Make make) {
        const std::lock_guard lock(making_);
        if (value_) return;
        value_ = std::make_unique<const T>(make());
        made_ = value_.get();
    }

    /// Null until prepared.
    [[nodiscard]] const T* get() const { return made_; }

private:
    Mutex making_;
    std::unique_ptr<const T> value_;
    std::atomic<const T*> made_ = nullptr;
};

}  // namespace bob
