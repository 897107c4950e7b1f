/// Images reused from call to call: fresh memory costs more than the arithmetic of a layer.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/mutex.h"

namespace bob {

/// Lends images of any size to several threads; keeps the last `most` returned.
template <class Images>
class Spare {
public:
    explicit Spare(std::size_t most = 1) : most_(most) {}

    /// Kept images of this size if available, else `Images(height, width, more...)`.
    template <class... More>
    [[nodiscard]] std::unique_ptr<Images> take(int height, int width, const More&... more) {
        {
            const std::lock_guard lock(mutex_);
            if (!kept_.empty() && kept_.back()->height == height && kept_.back()->width == width) {
                auto images = std::move(kept_.back());
                kept_.pop_back();
                return images;
            }
        }
        return std::make_unique<Images>(height, width, more...);
    }

    void give_back(std::unique_ptr<Images> images) {
        const std::lock_guard lock(mutex_);
        if (kept_.size() == most_) kept_.erase(kept_.begin());
        kept_.push_back(std::move(images));
    }

private:
    std::size_t most_;
    Mutex mutex_;
    std::vector<std::unique_ptr<Images>> kept_;
};

}  // namespace bob
