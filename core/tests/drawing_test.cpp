#include "drawing/curves.h"

#include <algorithm>
#include <vector>

#include "check.h"

TEST(segments_join_to_rings_and_to_curves_between_meetings) {
    // A square, and three arms that meet in a point; one arm is straight but for a hundredth of a pixel.
    const bob::LineNetwork network{{{0, 0}, {0, 4}, {4, 4}, {4, 0}, {10, 10}, {10, 12}, {10.01f, 14}, {10, 16}, {12, 10}, {8, 10}},
                                   {{0, 1}, {2, 1}, {2, 3}, {3, 0}, {4, 5}, {6, 5}, {6, 7}, {4, 8}, {9, 4}}};
    const bob::Curves curves = bob::joined(network, 0.05f);
    CHECK_EQ(curves.ends.size(), std::size_t{4});
    std::vector<std::int64_t> lengths;
    for (std::size_t i = 0; i < curves.ends.size(); ++i) lengths.push_back(curves.ends[i] - (i ? curves.ends[i - 1] : 0));
    std::sort(lengths.begin(), lengths.end());
    CHECK_EQ(lengths[0] + lengths[1] + lengths[2], std::int64_t{6});
    CHECK_EQ(lengths[3], std::int64_t{5});
    const auto ring = static_cast<std::size_t>(curves.ends.back()) - 5;
    CHECK_EQ(curves.points[ring].row, curves.points[ring + 4].row);
    CHECK_EQ(curves.points[ring].column, curves.points[ring + 4].column);
}

TEST(dashes_begin_and_end_with_a_curve) {
    const std::vector<bob::PicturePoint> line{{0, 0}, {0, 7}, {0, 20}};
    const bob::Curves dashes = bob::dashed(line, std::vector<std::int64_t>{3}, 4, 2);
    CHECK_EQ(dashes.ends.size(), std::size_t{4});
    CHECK_NEAR(dashes.points.front().column, 0, 1e-5f);
    CHECK_NEAR(dashes.points.back().column, 20, 1e-4f);
    float covered = 0;
    for (std::size_t i = 0, begin = 0; i < dashes.ends.size(); begin = static_cast<std::size_t>(dashes.ends[i++])) {
        covered += dashes.points[static_cast<std::size_t>(dashes.ends[i]) - 1].column - dashes.points[begin].column;
    }
    CHECK_NEAR(covered, 20 * 16.f / 22, 1e-3f);
}

TEST(strokes_have_their_width_and_do_not_add_up) {
    constexpr int side = 16;
    for (const float width : {0.5f, 1.f, 2.5f}) {
        std::vector<float> coverage(side * side, 0.f);
        const std::vector<bob::PicturePoint> line{{7.3f, -3}, {7.3f, 20}};
        for (int times = 0; times < 2; ++times) bob::draw_strokes(line, std::vector<std::int64_t>{2}, width, side, side, coverage.data());
        for (std::size_t column = 0; column < side; ++column) {
            float sum = 0;
            for (std::size_t row = 0; row < side; ++row) sum += coverage[row * side + column];
            CHECK_NEAR(sum, width, 1e-3f);
        }
    }
}
