#include "files/draco/walk.h"

#include <algorithm>
#include <array>
#include <utility>

#include "base/interruption.h"
#include "files/text.h"

namespace bob::files::draco {
namespace {

/// A walk over triangles.
class Walk {
public:
    explicit Walk(const Corners& corners) : corners_(corners), is_met_(corners.leftmost.size()), is_done_(corners.vertex.size() / 3) {
        result_.corners = &corners;
        result_.value_of.resize(corners.leftmost.size());
        result_.first.reserve(corners.leftmost.size());
    }

    void depth_first();
    void by_degree();

    [[nodiscard]] Sequence result() && {
        result_.count = result_.first.size();
        return std::move(result_);
    }

private:
    static constexpr auto next = Corners::next, previous = Corners::previous;

    bool is_done(std::int32_t c) const { return c < 0 || is_done_[static_cast<std::size_t>(c) / 3]; }
    void finish(std::int32_t c) {
        if (++finished_ % 65536 == 0) Interruption::check();
        is_done_[static_cast<std::size_t>(c) / 3] = true;
    }
    bool is_met(std::int32_t c) const { return is_met_[static_cast<std::size_t>(corners_.vertex_of(c))]; }
    void meet(std::int32_t c) {
        const auto vertex = static_cast<std::size_t>(corners_.vertex_of(c));
        if (is_met_[vertex]) return;
        is_met_[vertex] = true;
        result_.value_of[vertex] = static_cast<std::int32_t>(result_.first.size());
        result_.first.push_back(c);
    }
    std::int32_t to_right(std::int32_t c) const { return corners_.across(next(c)); }
    std::int32_t to_left(std::int32_t c) const { return corners_.across(previous(c)); }

    const Corners& corners_;
    std::vector<bool> is_met_, is_done_;  // of vertices and triangles
    std::size_t finished_ = 0;
    Sequence result_;
};

void Walk::depth_first() {
    std::vector<std::int32_t> stack;
    for (std::int32_t start = 0; start < static_cast<std::int32_t>(corners_.vertex.size()); start += 3) {
        if (is_done(start)) continue;
        stack.assign(1, start);
        meet(next(start));
        meet(previous(start));
        while (!stack.empty()) {
            std::int32_t c = stack.back();
            if (is_done(c)) {
                stack.pop_back();
                continue;
            }
            while (true) {
                finish(c);
                if (!is_met(c)) {
                    meet(c);
                    if (!corners_.is_on_boundary(corners_.vertex_of(c))) {
                        c = to_right(c);
                        if (c < 0) refuse({"expected triangles that fit together, got others"});
                        continue;
                    }
                }
                const std::int32_t right = to_right(c), left = to_left(c);
                if (is_done(right) && is_done(left)) {
                    stack.pop_back();
                    break;
                }
                if (!is_done(right) && !is_done(left)) {
                    stack.back() = left;
                    stack.push_back(right);
                    break;
                }
                c = is_done(right) ? left : right;
            }
        }
    }
}

void Walk::by_degree() {
    std::array<std::vector<std::int32_t>, 3> stacks;  // by priority
    std::vector<int> degrees(corners_.leftmost.size());
    std::size_t best = 0;
    const auto priority = [&](std::int32_t c) -> std::size_t {
        if (is_met(c)) return 0;
        return ++degrees[static_cast<std::size_t>(corners_.vertex_of(c))] > 1 ? 1 : 2;
    };
    const auto push = [&](std::int32_t c, std::size_t level) {
        stacks[level].push_back(c);
        best = std::min(best, level);
    };
    const auto pop = [&] {
        for (; best < stacks.size(); ++best) {
            if (stacks[best].empty()) continue;
            const std::int32_t c = stacks[best].back();
            stacks[best].pop_back();
            return c;
        }
        return -1;
    };
    for (std::int32_t start = 0; start < static_cast<std::int32_t>(corners_.vertex.size()); start += 3) {
        stacks[0].push_back(start);
        best = 0;
        for (const std::int32_t c : {next(start), previous(start), start}) meet(c);
        for (std::int32_t c = pop(); c >= 0; c = pop()) {
            if (is_done(c)) continue;
            while (true) {
                finish(c);
                meet(c);
                const std::int32_t right = to_right(c), left = to_left(c);
                const bool is_right_done = is_done(right);
                if (!is_done(left)) {
                    const std::size_t level = priority(left);
                    if (is_right_done && level <= best) {
                        c = left;
                        continue;
                    }
                    push(left, level);
                }
                if (is_right_done) break;
                const std::size_t level = priority(right);
                if (level > best) {
                    push(right, level);
                    break;
                }
                c = right;
            }
        }
    }
}

}  // namespace

Sequence walk(const Corners& corners, bool is_by_degree) {
    Walk walk(corners);
    if (is_by_degree) {
        walk.by_degree();
    } else {
        walk.depth_first();
    }
    return std::move(walk).result();
}

}  // namespace bob::files::draco
