/// Chains of segments between numbered points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "base/interruption.h"

namespace bob {

using Link = std::pair<std::uint32_t, std::uint32_t>;

/// The segments that meet at each point: at[start[point]] to at[start[point + 1]].
struct Meetings {
    std::vector<std::uint32_t> start, at;

    Meetings(std::size_t count, std::span<const Link> segments) : start(count + 1, 0) {
        for (const auto& [a, b] : segments) ++start[a + 1], ++start[b + 1];
        for (std::size_t i = 0; i < count; ++i) start[i + 1] += start[i];
        at.resize(start.back());
        std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
        for (std::uint32_t s = 0; s < segments.size(); ++s) {
            at[next[segments[s].first]++] = s;
            at[next[segments[s].second]++] = s;
        }
    }

    [[nodiscard]] std::uint32_t count(std::uint32_t point) const { return start[point + 1] - start[point]; }
};

/// Calls `walked` with the points of each chain, a vector. Chains end at points that `passes` does not let through, which it may
/// only where two segments meet. Closed ones end where they begin.
template <class Passes, class Walked>
void for_each_chain(const Meetings& meetings, std::span<const Link> segments, Passes passes, Walked walked) {
    const auto& [start, at] = meetings;
    const auto count = static_cast<std::uint32_t>(start.size() - 1);
    std::vector<bool> used(segments.size());
    std::vector<std::uint32_t> chain;
    const auto walk = [&](std::uint32_t point, std::uint32_t segment) {
        chain.assign(1, point);
        while (!used[segment]) {
            used[segment] = true;
            const auto& [a, b] = segments[segment];
            point = a == point ? b : a;
            chain.push_back(point);
            if (!passes(point)) break;
            segment = at[start[point]] == segment ? at[start[point] + 1] : at[start[point]];
        }
        walked(chain);
    };
    for (std::uint32_t point = 0; point < count; ++point) {
        if (point % 32768 == 0) Interruption::check();
        if (passes(point)) continue;
        for (std::uint32_t i = start[point]; i < start[point + 1]; ++i) {
            if (!used[at[i]]) walk(point, at[i]);
        }
    }
    for (std::uint32_t s = 0; s < segments.size(); ++s) {  // the rest are rings
        if (!used[s]) walk(segments[s].first, s);
    }
}

}  // namespace bob
