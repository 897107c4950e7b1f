/// The extreme points of a shape, found once for all its places.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <utility>

#include "base/mutex.h"
#include "shapes/point_tree.h"

namespace bob {

class Outline {
public:
    Outline() = default;
    Outline(Outline&& other) noexcept : tree_(std::move(other.tree_)), made_(other.made_.load()) {}

    /// Builds the tree from the points of find(), once. Safe to call from any thread, repeatedly.
    template <class Find>
    void prepare(Find find) {
        const std::lock_guard lock(making_);
        if (tree_) return;
        tree_ = std::make_unique<const PointTree>(find());
        made_ = tree_.get();
    }

    /// Null until prepared.
    [[nodiscard]] const PointTree* get() const { return made_; }

private:
    Mutex making_;
    std::unique_ptr<const PointTree> tree_;
    std::atomic<const PointTree*> made_ = nullptr;
};

}  // namespace bob
