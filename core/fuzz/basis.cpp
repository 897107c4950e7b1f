/// Basis functions and points of NURBS, at any parameter.
#include <cmath>
#include <utility>

#include "fuzz/splines.h"

FUZZ(basis) {
    const int n = source.between(2, 20), m = source.between(2, 4);
    const int p = source.between(1, std::min(n - 1, bob::max_degree)), q = source.between(1, m - 1);
    bob::NurbsSurface surface{p, q, fuzz::knots(source, n, p), fuzz::knots(source, m, q), {}};
    if (!fuzz::are_knots(surface.knots_u, n, p) || !fuzz::are_knots(surface.knots_v, m, q)) return;
    surface.control_points = fuzz::points<3>(source, static_cast<std::size_t>(n * m));
    if (!fuzz::are_points<3>(surface.control_points)) return;
    bob::make_homogeneous<3>(surface.control_points);
    const auto& u_knots = surface.knots_u;
    const double low = u_knots[static_cast<std::size_t>(p)], high = u_knots[static_cast<std::size_t>(n)];
    // Reciprocals of knots that are almost equal would leave the range of numbers.
    const auto too_close = [](double a, double b) { return b > a && b - a < 1e-290; };
    if (std::adjacent_find(u_knots.begin(), u_knots.end(), too_close) != u_knots.end()) return;
    for (int i = 0; i < 4; ++i) {
        const bool inside = source.flag();
        const double u = inside ? source.within(low, high) : source.number(), v = source.number();
        const int order = source.between(0, 12);
        const std::size_t span = bob::find_span(p, u_knots, u);
        fuzz::expect(span >= static_cast<std::size_t>(p) && span < static_cast<std::size_t>(n), "a span of the domain");
        const bob::BasisDerivatives basis = bob::basis_derivatives(span, u, p, u_knots, order);
        double sum = 0;
        for (std::size_t j = 0; j <= static_cast<std::size_t>(p); ++j) sum += basis[0][j];
        fuzz::expect(!inside || std::fabs(sum - 1) < 1e-9, "basis functions that add up to 1");
        (void)bob::surface_derivatives(surface, u, v, order % 4);
    }
}
