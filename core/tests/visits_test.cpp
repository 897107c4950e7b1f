/// Rays that wait for each other in cells, and come to all of theirs in order.
#include "shapes/implicit/visits.h"

#include <map>
#include <set>

#include "base/interruption.h"
#include "check.h"
#include "formulas.h"

namespace {

using bob::Cells;
using bob::Rays;
using bob::Vec3;
using bob::Walk;

struct Turn {
    std::uint32_t code;
    std::set<std::uint32_t> rays;

    friend bool operator==(const Turn&, const Turn&) = default;
};

/// The codes whose turn it is next.
std::vector<Turn> next(bob::WaitingRays& waiting) {
    std::vector<Turn> turns;
    std::set<std::uint32_t> ahead;
    const bool any = waiting.next([&](std::uint32_t code) { ahead.insert(code); },
                                  [&](std::uint32_t code, Rays rays) {
                                      CHECK(turns.empty() || ahead.contains(code));
                                      CHECK_EQ(std::set(rays.begin(), rays.end()).size(), rays.size());
                                      turns.push_back({code, {rays.begin(), rays.end()}});
                                  });
    CHECK_EQ(any, !turns.empty());
    return turns;
}

/// Many small balls, so that cells have many codes.
Cells balls() {
    bob::Graph g;
    const bob::Value z = g.z(), y = g.y(), x = g.x();
    bob::Value nearest = g.constant(1);
    for (int i = 0; i < 90; ++i) {
        const double a = std::sin(3 * i), b = std::sin(5 * i + 1), c = std::sin(7 * i + 2);
        nearest = min(nearest, hypot(hypot(x - 0.8 * a, y - 0.8 * b), z - 0.8 * c) - (0.07 + 0.001 * i));
    }
    return Cells(g.expression(nearest));
}

/// Parallel rays from beyond the cube, side by side.
std::vector<bob::Ray> bundle(Vec3 direction) {
    const Vec3 across = normalized(cross(direction, Vec3{0.3f, 0.5f, 0.8f})), up = normalized(cross(direction, across));
    std::vector<bob::Ray> rays;
    for (int i = 0; i < 900; ++i) {
        const float u = 0.06f * static_cast<float>(i % 30 - 15), v = 0.06f * static_cast<float>(i / 30 - 15);
        rays.push_back({u * across + v * up - 2.f * normalized(direction), direction});
    }
    return rays;
}

}  // namespace

TEST(rays_wait_for_those_that_come_later) {
    bob::WaitingRays waiting;
    waiting.reset(8, 10);
    CHECK(next(waiting).empty());
    waiting.add(0, 5, 3), waiting.add(1, 7, 1), waiting.add(2, 5, 2), waiting.add(3, 2, 1), waiting.add(4, 3, 9);
    CHECK(next(waiting) == (std::vector<Turn>{{2, {3}}, {7, {1}}}));
    waiting.add(1, 5, 8), waiting.add(3, 3, 4);
    CHECK(next(waiting) == (std::vector<Turn>{{5, {0, 1, 2}}}));
    waiting.add(0, 5, 5), waiting.add(1, 5, 6);  // now farther than where 5 has waited before, and than 3
    CHECK(next(waiting) == (std::vector<Turn>{{3, {3, 4}}}));
    waiting.add(2, 6, 4), waiting.add(3, 5, 3);  // nearer than who waits already
    CHECK(next(waiting) == (std::vector<Turn>{{5, {0, 1, 3}}}));
    CHECK(next(waiting) == (std::vector<Turn>{{6, {2}}}));
    CHECK(next(waiting).empty());
}

TEST(many_rays_wait_for_nobody) {
    bob::WaitingRays waiting;
    waiting.reset(200, 10);
    waiting.add(199, 1, 0);
    for (std::uint32_t i = 0; i < 63; ++i) waiting.add(i, 9, 50 + i);
    CHECK(next(waiting) == (std::vector<Turn>{{1, {199}}}));
    waiting.add(199, 1, 1), waiting.add(63, 9, 50);
    const std::vector<Turn> many = next(waiting);
    CHECK_EQ(many.size(), 1u);
    CHECK_EQ(many[0].code, 9u);
    CHECK_EQ(many[0].rays.size(), 64u);
    CHECK(next(waiting) == (std::vector<Turn>{{1, {199}}}));
    CHECK(next(waiting).empty());
}

TEST(rays_that_were_left_waiting_are_forgotten) {
    bob::WaitingRays waiting;
    waiting.reset(100, 4);
    for (std::uint32_t i = 0; i < 99; ++i) waiting.add(i, i % 3, 5);
    bool stopped = false;
    try {
        waiting.next([](std::uint32_t) {}, [](std::uint32_t, Rays) { throw bob::Stopped(); });
    } catch (const bob::Stopped&) {
        stopped = true;
    }
    CHECK(stopped);
    waiting.reset(2, 6);
    waiting.add(1, 1, 7), waiting.add(0, 5, 7);
    CHECK(next(waiting) == (std::vector<Turn>{{1, {1}}, {5, {0}}}));
    CHECK(next(waiting).empty());
}

TEST(rays_come_to_their_cells_in_order_and_meet_in_them) {
    const Cells cells = balls();
    std::vector<Walk> walks;
    for (int octant = 0; octant < 8; ++octant) {
        const auto sign = [octant](int axis) { return octant >> axis & 1 ? -1.f : 1.f; };
        const std::vector<bob::Ray> rays = bundle({0.8f * sign(0), 1.1f * sign(1), 0.6f * sign(2)});
        std::vector<std::vector<std::uint32_t>> came(rays.size());
        std::size_t visits = 0;
        bob::visit_cells(cells, rays, walks, [&](std::uint32_t code, Rays some) {
            ++visits;
            for (const std::uint32_t ray : some) {
                CHECK_EQ(cells.cells()[walks[ray].cell].code, code);
                came[ray].push_back(walks[ray].cell);
                if (ray % 5 == 0 && came[ray].size() == 2) walks[ray].cell = Walk::none;  // as where it has hit
            }
        });
        std::vector<std::set<std::uint32_t>> rounds;  // the codes of each ray's first cells, of their second ones, and so on
        for (std::size_t i = 0; i < rays.size(); ++i) {
            std::vector<std::uint32_t> alone;
            bob::visit_cells(cells, {&rays[i], 1}, walks, [&](std::uint32_t, Rays) {
                alone.push_back(walks[0].cell);
                if (i % 5 == 0 && alone.size() == 2) walks[0].cell = Walk::none;
            });
            CHECK(came[i] == alone);
            for (std::size_t k = 0; k < alone.size(); ++k) {
                if (rounds.size() <= k) rounds.emplace_back();
                rounds[k].insert(cells.cells()[alone[k]].code);
            }
        }
        std::size_t by_rounds = 0;
        for (const auto& codes : rounds) by_rounds += codes.size();
        CHECK_LT(100u, by_rounds);
        CHECK_LT(4 * visits, 3 * by_rounds);
    }
}
