#include "base/work.h"

#include <vector>

#include "check.h"
#include "formula/expression.h"
#include "interrupted.h"
#include "shapes/implicit/cells.h"

namespace {

/// A thousand waves that no cell decides.
bob::Expression waves(int count) {
    bob::Graph graph;
    bob::Value sum = graph.constant(0.25);
    const bob::Value x = graph.x(), y = graph.y(), z = graph.z();
    for (int i = 1; i <= count; ++i) {
        const bob::Value phase = x * (3 + i * 0.37) + y * (5 - i * 0.23);
        sum = sum + sin(phase + z * (i * 0.11));
    }
    return graph.expression(sum);
}

}  // namespace

TEST(cells_past_their_budget_are_coarse_and_the_same_for_any_number_of_threads) {
    const bob::Expression f = waves(600);
    const int threads = bob::thread_count();
    bob::set_thread_count(1);
    const bob::Cells one(f);
    bob::set_thread_count(3);
    const bob::Cells three(f);
    bob::set_thread_count(threads);
    CHECK(one.is_coarse());
    CHECK_EQ(one.cells().size(), three.cells().size());
    CHECK_EQ(one.bytes(), three.bytes());
}

TEST(cells_stop_whenever_they_are_asked_to) {
    const bob::Expression f = waves(40);
    for (const int answered : {0, 1, 7, 60}) CHECK(stops_after(answered, [&] { const bob::Cells cells(f); }));
}
