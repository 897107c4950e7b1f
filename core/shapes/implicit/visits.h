/// Rays through cells, ordered so that many of them search for roots with the same code together.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "base/thread_memory.h"
#include "shapes/implicit/cells.h"
#include "shapes/implicit/walk.h"

namespace bob {

/// Numbers of rays.
using Rays = std::span<const std::uint32_t>;

/// Rays waiting in cells, grouped by the cells' code. A group continues as soon as it is large, or when no ray waits in an earlier
/// cell. So early rays wait for later ones.
class WaitingRays {
public:
    /// Empties the queue, and sets its capacity.
    void reset(std::size_t rays, std::uint32_t codes) {
        if (left_) *this = {};  // after an interruption
        if (waiting_.size() < codes) waiting_.resize(codes);
        if (behind_.size() < rays) behind_.resize(rays);
    }

    /// `place` is smaller for cells that rays reach earlier.
    void add(std::uint32_t ray, std::uint32_t code, std::uint32_t place) {
        Waiting& waiting = waiting_[code];
        if (waiting.count == 0 || place < waiting.place) {
            waiting.place = place;
            foremost_.push(std::uint64_t{place} << 32 | code);
        }
        ++left_;
        behind_[ray] = waiting.last;
        waiting.last = ray;
        if (++waiting.count == many) many_.push_back(code);
    }

    /// Calls body(code, rays) for the next codes with all their waiting rays, and prefetch(code) before that. Returns false if no
    /// ray waits.
    template <class Prefetch, class Body>
    bool next(Prefetch prefetch, Body body) {
        turn_.clear();
        if (!many_.empty()) {
            turn_.swap(many_);
        } else {
            while (!foremost_.empty() && (turn_.empty() || place_of(foremost_.top()) == waiting_[turn_.front()].place)) {
                const std::uint64_t top = foremost_.top();
                foremost_.pop();
                const Waiting& waiting = waiting_[code_of(top)];
                // Otherwise these rays have continued, and others may wait.
                if (waiting.count && waiting.place == place_of(top)) turn_.push_back(code_of(top));
            }
        }
        for (std::size_t i = 0; i < turn_.size(); ++i) {
            if (i + 1 < turn_.size()) prefetch(turn_[i + 1]);
            const std::uint32_t code = turn_[i];
            rays_.clear();
            for (std::uint32_t ray = waiting_[code].last; rays_.size() < waiting_[code].count; ray = behind_[ray]) rays_.push_back(ray);
            waiting_[code] = {};
            left_ -= rays_.size();
            if (!rays_.empty()) body(code, Rays(rays_));
        }
        return !turn_.empty();
    }

private:
    /// Enough for lanes to be full nearly always.
    static constexpr std::uint32_t many = 64;

    struct Waiting {
        std::uint32_t count = 0, place = 0, last = 0;
    };
    static std::uint32_t place_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 32); }
    static std::uint32_t code_of(std::uint64_t key) { return static_cast<std::uint32_t>(key); }

    std::size_t left_ = 0;
    std::vector<Waiting> waiting_;       // of each code
    std::vector<std::uint32_t> behind_;  // of each ray: the one that came before it
    std::priority_queue<std::uint64_t, std::vector<std::uint64_t>, std::greater<>> foremost_;  // places and codes
    std::vector<std::uint32_t> many_, turn_, rays_;
};

/// Calls visit(code, rays) for rays in cells of one code, until every ray has left the last of its cells; a ray whose
/// walk's cell becomes `Walk::none` ends there. Each ray visits its cells in order. walks: one for each of `rays`.
template <class Visit>
void visit_cells(const Cells& cells, std::span<const Ray> rays, std::vector<Walk>& walks, Visit visit) {
    struct Memory {
        WaitingRays waiting;
        std::vector<std::uint32_t> going;
    };
    auto& [waiting, going] = thread_memory<Memory>();
    walks.resize(rays.size());
    if (rays.empty()) return;
    const CellGrid grid = cells.grid_view();
    // How far a cell's nearest corner is on the way of rays that go in the first one's octant, in steps between cells' faces.
    const Vec3 direction = rays[0].direction;
    const auto place_of = [&](const Cells::Cell& cell) {
        int way = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const int low = cell.at[static_cast<std::size_t>(axis)];
            way += direction[axis] < 0 ? Cells::grid - Cells::side(cell.level) - low : low;
        }
        return static_cast<std::uint32_t>(way / Cells::side(Cells::max_levels - 1));
    };
    waiting.reset(rays.size(), cells.codes());
    best_walk_kernels().start(grid, rays.data(), rays.size(), walks.data());
    going.resize(rays.size());
    for (std::uint32_t i = 0; i < rays.size(); ++i) going[i] = i;
    do {
        best_walk_kernels().next(grid, walks.data(), going.data(), going.size());
        for (const std::uint32_t ray : going) {
            if (walks[ray].cell != Walk::none) __builtin_prefetch(&cells.cells()[walks[ray].cell]);
        }
        for (const std::uint32_t ray : going) {
            if (walks[ray].cell == Walk::none) continue;
            const Cells::Cell& cell = cells.cells()[walks[ray].cell];
            waiting.add(ray, cell.code, place_of(cell));
        }
        going.clear();
    } while (waiting.next([&](std::uint32_t code) { cells.prefetch(code); }, [&](std::uint32_t code, Rays some) {
        visit(code, some);
        std::copy_if(some.begin(), some.end(), std::back_inserter(going), [&](std::uint32_t ray) { return walks[ray].cell != Walk::none; });
    }));
}

}  // namespace bob
