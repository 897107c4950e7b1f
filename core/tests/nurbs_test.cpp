#include "nurbs/nurbs.h"

#include <algorithm>

#include "check.h"
#include "nurbs/extremes.h"

namespace {

using bob::Homogeneous;
using test::Random;

std::size_t pick(Random& random, std::size_t count) {
    return std::min(static_cast<std::size_t>(random() * static_cast<float>(count)), count - 1);
}

/// Knots of any range and distance, inside of multiplicity up to degree + 1, clamped or not, perhaps with empty spans
/// at the ends.
std::vector<double> random_knots(Random& random, int degree) {
    const auto p = static_cast<std::size_t>(degree);
    constexpr double sizes[] = {1, 1e-3, 1e6}, offsets[] = {0, -86.9, 1e6};
    const double size = sizes[pick(random, 3)], offset = offsets[pick(random, 3)];
    double knot = offset;
    const auto step = [&] { knot += size * (random() < 0.1f ? 1e-6 : 0.1 + random()); };
    std::vector<double> knots;
    const bool clamped = random() < 0.5f;
    const auto end = [&](bool begin) {
        const std::size_t extra = random() < 0.2f ? 1 : 0;  // a domain that begins or ends with an empty span
        if (!clamped && !begin) knots.insert(knots.end(), extra, knot);
        for (std::size_t i = 0; i <= p; ++i) {
            knots.push_back(knot);
            if (!clamped) step();
        }
        if (clamped || begin) knots.insert(knots.end(), extra, knot);
    };
    end(true);
    const std::size_t inside = 1 + pick(random, 4);
    for (std::size_t i = 0; i < inside; ++i) {
        step();
        knots.insert(knots.end(), random() < 0.5f ? 1 : 1 + pick(random, p + 1), knot);
    }
    step();
    end(false);
    return knots;
}

template <std::size_t N>
std::vector<Homogeneous<N>> random_points(Random& random, std::size_t count) {
    const bool rational = random() < 0.5f;
    std::vector<Homogeneous<N>> points(count);
    for (auto& point : points) {
        point[N] = rational ? random(0.2f, 3) : 1;
        for (std::size_t i = 0; i < N; ++i) point[i] = point[N] * random(-1, 1) / 3;  // all bits in use
    }
    return points;
}

bob::NurbsCurve<4> random_curve(Random& random) {
    bob::NurbsCurve<4> curve;
    curve.degree = 1 + static_cast<int>(pick(random, bob::max_degree));
    curve.knots = random_knots(random, curve.degree);
    curve.control_points = random_points<4>(random, curve.knots.size() - static_cast<std::size_t>(curve.degree) - 1);
    return curve;
}

bob::NurbsSurface random_surface(Random& random) {
    bob::NurbsSurface surface;
    surface.degree_u = 1 + static_cast<int>(pick(random, bob::max_degree));
    surface.degree_v = 1 + static_cast<int>(pick(random, bob::max_degree));
    surface.knots_u = random_knots(random, surface.degree_u);
    surface.knots_v = random_knots(random, surface.degree_v);
    surface.control_points = random_points<3>(random, surface.size_u() * surface.size_v());
    return surface;
}

/// A parameter of the domain, sometimes a knot.
double random_parameter(Random& random, int degree, std::span<const double> knots) {
    const auto p = static_cast<std::size_t>(degree);
    if (random() < 0.2f) return knots[p + pick(random, knots.size() - 2 * p)];
    const double low = knots[p], high = knots[knots.size() - p - 1];
    return std::min(high, low + (high - low) * random());
}

/// The value at t of a polynomial in Bernstein form.
template <std::size_t D>
std::array<double, D> bernstein(std::span<const std::array<double, D>> points, double t) {
    std::array<double, D> sum{};
    double binomial = 1;
    const int degree = static_cast<int>(points.size()) - 1;
    for (int i = 0; i <= degree; ++i) {
        const double b = binomial * std::pow(t, i) * std::pow(1 - t, degree - i);
        for (std::size_t axis = 0; axis < D; ++axis) sum[axis] += b * points[static_cast<std::size_t>(i)][axis];
        binomial = binomial * (degree - i) / (i + 1);
    }
    return sum;
}

template <std::size_t N>
std::array<double, N> point(const bob::BezierCurve<N>& curve, double t) {
    const auto sum = bernstein(std::span(curve.control_points), t);
    std::array<double, N> result;
    for (std::size_t i = 0; i < N; ++i) result[i] = sum[i] / sum[N];
    return result;
}

std::array<double, 3> point(const bob::BezierPatch& patch, double s, double t) {
    const auto size_v = static_cast<std::size_t>(patch.degree_v) + 1;
    bob::BezierCurve<3> column;
    for (std::size_t i = 0; i < patch.control_points.size(); i += size_v) {
        column.control_points.push_back(bernstein(std::span(patch.control_points).subspan(i, size_v), t));
    }
    return point(column, s);
}

template <std::size_t D>
double distance(const std::array<double, D>& a, const std::array<double, D>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < D; ++i) largest = std::max(largest, std::fabs(a[i] - b[i]));
    return largest;
}

/// The control points of one edge of a patch: sides 0 and 1 are its lowest and highest u, 2 and 3 its lowest and highest v.
std::vector<Homogeneous<3>> edge(const bob::BezierPatch& patch, int side) {
    const auto size_u = static_cast<std::size_t>(patch.degree_u) + 1;
    const auto size_v = static_cast<std::size_t>(patch.degree_v) + 1;
    std::vector<Homogeneous<3>> points;
    for (std::size_t i = 0; i < (side < 2 ? size_v : size_u); ++i) {
        const std::size_t row = side < 2 ? (side == 0 ? 0 : size_u - 1) : i;
        const std::size_t column = side < 2 ? i : (side == 2 ? 0 : size_v - 1);
        points.push_back(patch.control_points[row * size_v + column]);
    }
    return points;
}

/// Whether the pieces on both sides of a knot have to meet there.
bool joins(int degree, std::span<const double> knots, double knot) {
    return std::count(knots.begin(), knots.end(), knot) <= degree;
}

}  // namespace

TEST(basis_functions_of_the_book) {  // examples 2.3 and 2.4
    const double knots[] = {0, 0, 0, 1, 2, 3, 4, 4, 5, 5, 5};
    const std::size_t span = bob::find_span(2, knots, 2.5);
    CHECK_EQ(span, 4u);
    const auto basis = bob::basis_derivatives(span, 2.5, 2, knots, 3);
    const double expected[][3] = {{0.125, 0.75, 0.125}, {-0.5, 0, 0.5}, {1, -2, 1}, {0, 0, 0}};
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t j = 0; j < 3; ++j) CHECK_EQ(basis[k][j], expected[k][j]);
    }
    CHECK_EQ(bob::find_span(2, knots, -1), 2u);
    CHECK_EQ(bob::find_span(2, knots, 0), 2u);
    CHECK_EQ(bob::find_span(2, knots, 4), 7u);
    CHECK_EQ(bob::find_span(2, knots, 5), 7u);
    CHECK_EQ(bob::find_span(2, knots, 6), 7u);
}

TEST(basis_functions_sum_to_one_and_their_derivatives_to_zero) {
    Random random(1);
    for (int round = 0; round < 2000; ++round) {
        const int degree = 1 + static_cast<int>(pick(random, bob::max_degree));
        const auto knots = random_knots(random, degree);
        const double u = random_parameter(random, degree, knots);
        const std::size_t span = bob::find_span(degree, knots, u);
        CHECK_LT(knots[span], knots[span + 1]);
        CHECK(knots[span] <= u && u <= knots[span + 1]);
        const auto basis = bob::basis_derivatives(span, u, degree, knots, bob::max_degree);
        for (std::size_t k = 0; k < basis.size(); ++k) {
            double sum = 0, size = 0;
            for (const double value : basis[k]) {
                sum += value;
                size += std::fabs(value);
                CHECK(k > 0 || value >= 0);
            }
            CHECK_LT(std::fabs(sum - (k == 0)), 1e-14 * (size + (k == 0)) + 1e-300);
            if (k > static_cast<std::size_t>(degree)) CHECK_EQ(size, 0);
        }
    }
}

TEST(derivatives_of_basis_functions_are_curves_of_lower_degree) {  // equation 3.4
    Random random(2);
    for (int round = 0; round < 1000; ++round) {
        const int degree = 1 + static_cast<int>(pick(random, bob::max_degree));
        auto knots = random_knots(random, degree);
        const double u = random_parameter(random, degree, knots);
        const std::size_t span = bob::find_span(degree, knots, u);
        const auto basis = bob::basis_derivatives(span, u, degree, knots, degree);
        std::vector<double> points(knots.size() - static_cast<std::size_t>(degree) - 1);
        for (double& value : points) value = random(-1, 1);
        const std::size_t first = span - static_cast<std::size_t>(degree);
        std::vector<double> local(points.begin() + static_cast<std::ptrdiff_t>(first),
                                  points.begin() + static_cast<std::ptrdiff_t>(span + 1));
        const std::vector<double> given = local;
        for (std::size_t k = 1, p = static_cast<std::size_t>(degree); k <= static_cast<std::size_t>(degree); ++k, --p) {
            for (std::size_t i = 0; i < p; ++i) {  // the control points of the k-th derivative on this span
                const double support = knots[span + 1 + i] - knots[span + 1 + i - p];
                local[i] = static_cast<double>(p) * (local[i + 1] - local[i]) / support;
            }
            const auto lower = bob::basis_derivatives(span, u, static_cast<int>(p) - 1, knots, 0);
            double expected = 0, value = 0, size = 0;
            for (std::size_t i = 0; i < p; ++i) expected += p == 1 ? local[0] : lower[0][i] * local[i];
            for (std::size_t j = 0; j < given.size(); ++j) {
                value += basis[k][j] * given[j];
                size += std::fabs(basis[k][j]);
            }
            CHECK_LT(std::fabs(value - expected), 1e-11 * size);
        }
    }
}

TEST(derivatives_of_surfaces_are_slopes_of_lower_ones) {
    Random random(3);
    constexpr int order = 4;
    constexpr std::size_t n = order + 1;
    for (int round = 0; round < 200; ++round) {
        bob::NurbsSurface surface;
        surface.degree_u = 1 + static_cast<int>(pick(random, 5));
        surface.degree_v = 1 + static_cast<int>(pick(random, 5));
        for (int i = 0; i < 2 * surface.degree_u + 2; ++i) surface.knots_u.push_back(i + 0.5 * random());
        for (int i = 0; i < 2 * surface.degree_v + 2; ++i) surface.knots_v.push_back(i + 0.5 * random());
        surface.control_points = random_points<3>(random, surface.size_u() * surface.size_v());
        const double h = 1e-5;
        const double u = surface.degree_u + 0.75, v = surface.degree_v + 0.75;
        const auto center = bob::surface_derivatives(surface, u, v, order);
        const auto low_u = bob::surface_derivatives(surface, u - h, v, order);
        const auto high_u = bob::surface_derivatives(surface, u + h, v, order);
        const auto low_v = bob::surface_derivatives(surface, u, v - h, order);
        const auto high_v = bob::surface_derivatives(surface, u, v + h, order);
        for (std::size_t k = 0; k < n; ++k) {
            for (std::size_t l = 0; l < n; ++l) {
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const double value = center[k * n + l][axis];
                    const auto slope = [&](const auto& low, const auto& high, std::size_t at) {
                        return (high[at][axis] - low[at][axis]) / (2 * h);
                    };
                    if (k + l > order) {
                        CHECK_EQ(value, 0);
                        continue;
                    }
                    const double tolerance = 1e-5 * (1 + std::fabs(value));
                    if (k > 0) CHECK_NEAR(value, slope(low_u, high_u, (k - 1) * n + l), tolerance);
                    if (l > 0) CHECK_NEAR(value, slope(low_v, high_v, k * n + l - 1), tolerance);
                }
            }
        }
    }
}

TEST(nine_points_make_a_circle) {  // section 7.5
    const double w = std::sqrt(0.5);
    bob::NurbsCurve<2> circle{2, {0, 0, 0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1, 1, 1}, {}};
    constexpr double corners[][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    for (std::size_t i = 0; i < 9; ++i) {
        const double weight = i % 2 == 0 ? 1 : w;
        circle.control_points.push_back({weight * corners[i][0], weight * corners[i][1], weight});
    }
    for (int i = 0; i <= 1000; ++i) {
        const auto [x, y] = bob::curve_point(circle, i / 1000.0);
        CHECK_NEAR(std::hypot(x, y), 1.0, 1e-15);
    }
    const auto pieces = bob::decompose(circle);
    CHECK_EQ(pieces.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
        CHECK_EQ(pieces[i].low, 0.25 * static_cast<double>(i));
        for (std::size_t j = 0; j < 3; ++j) CHECK(pieces[i].control_points[j] == circle.control_points[2 * i + j]);
    }
}

TEST(bezier_pieces_are_the_curve) {
    Random random(4);
    for (int round = 0; round < 1000; ++round) {
        const auto curve = random_curve(random);
        const auto pieces = bob::decompose(curve);
        const auto p = static_cast<std::size_t>(curve.degree);
        CHECK_EQ(pieces.front().low, curve.knots[p]);
        CHECK_EQ(pieces.back().high, curve.knots[curve.knots.size() - p - 1]);
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const auto& piece = pieces[i];
            CHECK_EQ(piece.degree(), curve.degree);
            CHECK_LT(piece.low, piece.high);
            for (const double wanted : {0.0, 0.2, 0.7}) {
                // t uses the rounded u.
                const double u = piece.low + wanted * (piece.high - piece.low);
                const double t = (u - piece.low) / (piece.high - piece.low);
                CHECK_LT(distance(point(piece, t), bob::curve_point(curve, u)), 1e-11);
            }
            if (i == 0) continue;
            CHECK_EQ(pieces[i - 1].high, piece.low);
            const bool joined = joins(curve.degree, curve.knots, piece.low);
            CHECK_EQ(pieces[i - 1].control_points.back() == piece.control_points.front(), joined);
        }
    }
}

TEST(bezier_patches_are_the_surface_and_share_edges) {
    Random random(5);
    for (int round = 0; round < 150; ++round) {
        const auto surface = random_surface(random);
        const auto patches = bob::decompose(surface);
        std::size_t across = 0;
        while (across < patches.size() && patches[across].low_u == patches[0].low_u) ++across;
        CHECK_EQ(patches.size() % across, 0u);
        for (std::size_t i = 0; i < patches.size(); ++i) {
            const auto& patch = patches[i];
            const double u = patch.low_u + 0.3 * (patch.high_u - patch.low_u);
            const double v = patch.low_v + 0.6 * (patch.high_v - patch.low_v);
            const double s = (u - patch.low_u) / (patch.high_u - patch.low_u);
            const double t = (v - patch.low_v) / (patch.high_v - patch.low_v);
            CHECK_LT(distance(point(patch, s, t), bob::surface_derivatives(surface, u, v, 0)[0]), 1e-11);
            if (i >= across) {
                const bool joined = joins(surface.degree_u, surface.knots_u, patch.low_u);
                CHECK_EQ(edge(patches[i - across], 1) == edge(patch, 0), joined);
            }
            if (i % across > 0) {
                const bool joined = joins(surface.degree_v, surface.knots_v, patch.low_v);
                CHECK_EQ(edge(patches[i - 1], 3) == edge(patch, 2), joined);
            }
        }
    }
}

TEST(what_closes_does_so_to_the_bit) {
    Random random(6);
    for (int round = 0; round < 200; ++round) {
        bob::NurbsSurface tube;  // closed in u, with knots that repeat with the period
        tube.degree_u = 1 + static_cast<int>(pick(random, bob::max_degree));
        tube.degree_v = 2;
        const auto p = static_cast<std::size_t>(tube.degree_u);
        const std::size_t period = p + 1 + pick(random, 5);
        std::vector<double> gaps(period);
        for (double& gap : gaps) gap = random(0.1f, 1);
        tube.knots_u = {-86.9};
        while (tube.knots_u.size() < period + 2 * p + 1) {
            tube.knots_u.push_back(tube.knots_u.back() + gaps[tube.knots_u.size() % period]);
        }
        tube.knots_v = random_knots(random, tube.degree_v);
        tube.control_points = random_points<3>(random, period * tube.size_v());
        tube.control_points.resize(tube.size_u() * tube.size_v());
        std::copy_n(tube.control_points.begin(), p * tube.size_v(),
                    tube.control_points.begin() + static_cast<std::ptrdiff_t>(period * tube.size_v()));
        const auto patches = bob::decompose(tube);
        const std::size_t across = patches.size() / period;
        for (std::size_t i = 0; i < across; ++i) {
            CHECK(edge(patches[i], 0) == edge(patches[patches.size() - across + i], 1));
        }
    }
}

TEST(what_is_flat_stays_flat) {
    Random random(7);
    for (int round = 0; round < 100; ++round) {
        auto surface = random_surface(random);
        for (auto& control_point : surface.control_points) control_point[2] = 0.3, control_point[3] = 1;
        for (const auto& patch : bob::decompose(surface)) {
            for (const auto& control_point : bob::part(patch, 0.1, 0.7, 0.2, 0.9).control_points) {
                CHECK_EQ(control_point[2], 0.3);
                CHECK_EQ(control_point[3], 1);
            }
        }
    }
}

TEST(parts_are_the_curve_or_patch_and_share_ends) {
    Random random(8);
    for (int round = 0; round < 500; ++round) {
        const std::size_t degree = 1 + pick(random, bob::max_degree);
        const bob::BezierCurve<2> curve{-3, 5, random_points<2>(random, degree + 1)};
        CHECK(bob::part(curve, 0, 1).control_points == curve.control_points);
        const double a = random(-0.05f, 0.9f), b = random(static_cast<float>(a), 1.05f), c = random();
        const auto piece = bob::part(curve, a, b), after = bob::part(curve, b, c);
        CHECK_NEAR(piece.low, -3 + 8 * a, 1e-14);
        CHECK_NEAR(piece.high, -3 + 8 * b, 1e-14);
        CHECK(piece.control_points.back() == after.control_points.front());
        for (const double t : {0.0, 0.4, 1.0}) {
            CHECK_LT(distance(point(piece, t), point(curve, a + t * (b - a))), 1e-11);
        }

        const std::size_t degree_v = 1 + pick(random, bob::max_degree);
        const bob::BezierPatch patch{0, 1, 2, 4, static_cast<int>(degree), static_cast<int>(degree_v),
                                     random_points<3>(random, (degree + 1) * (degree_v + 1))};
        CHECK(bob::part(patch, 0, 1, 0, 1).control_points == patch.control_points);
        const auto low = bob::part(patch, 0, c, a, b), high = bob::part(patch, c, 1, a, b);
        CHECK(edge(low, 1) == edge(high, 0));
        CHECK_NEAR(low.high_u, c, 1e-15);
        CHECK_NEAR(low.low_v, 2 + 2 * a, 1e-14);
        CHECK_EQ(high.high_u, 1);
        CHECK_LT(distance(point(low, 0.3, 0.8), point(patch, 0.3 * c, a + 0.8 * (b - a))), 1e-11);
        CHECK(edge(bob::part(patch, a, b, 0, c), 3) == edge(bob::part(patch, a, b, c, 1), 2));
    }
}

TEST(extremes_between_samples_are_found) {
    for (int i = 0; i <= 320; ++i) {
        const double top = i / 320.0, start = 1 - top * top, end = 1 - (1 - top) * (1 - top);
        bob::NurbsSurface arch{2, 1, {0, 0, 0, 1, 1, 1}, {0, 0, 1, 1}, {}};  // of height 1 - (u - top)^2
        for (const auto& [x, z] : {std::pair{0., start}, {0.5, start + top}, {1., end}}) {
            for (const double y : {0., 2.}) arch.control_points.push_back({x, y, z, 1});
        }
        const std::array<double, 3> directions[] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 1}};
        const auto found = bob::extremes(arch, {}, directions);
        CHECK_NEAR(found[0][0], std::min(start, end), 1e-12);
        CHECK_NEAR(found[0][1], 1, 1e-12);
        CHECK_NEAR(found[1][0], 0, 1e-12);
        CHECK_NEAR(found[1][1], 2, 1e-12);
        const double leaning = std::min(top + 0.5, 1.);  // where u + height is largest
        CHECK_NEAR(found[2][1], leaning + 1 - (leaning - top) * (leaning - top), 1e-12);
    }
}
