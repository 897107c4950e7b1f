#include "shapes/brep.h"

#include <algorithm>
#include <queue>

namespace bob {
namespace {

/// Part of a patch, and how large a function may be over it.
struct Candidate {
    double bound;
    const Patch* patch;
    BezierPatch net;

    bool operator<(const Candidate& other) const { return bound < other.bound; }
};

Vec3 euclidean(const Homogeneous<3>& point) {
    const auto& [x, y, z, w] = point;
    return {static_cast<float>(x / w), static_cast<float>(y / w), static_cast<float>(z / w)};
}

}  // namespace

Brep::Brep(std::span<const Face> faces) {
    std::vector<FacePatches> patches;
    for (const Face& face : faces) {
        const NurbsSurface& s = face.surface;
        const Domain domain{s.knots_u[static_cast<std::size_t>(s.degree_u)], s.knots_u[s.size_u()],
                            s.knots_v[static_cast<std::size_t>(s.degree_v)], s.knots_v[s.size_v()]};
        regions_.push_back(std::make_unique<TrimRegion>(face.loops, domain));
        patches.push_back({decompose(s), regions_.back().get()});
    }
    pieces_ = build_pieces(patches);
}

void Brep::closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    if (pieces_.nodes.empty()) {
        std::fill(hits.begin(), hits.end(), Hit{});
    } else {
        best_piece_kernels().closest_hits(pieces_, rays, hits.data());
    }
}

void Brep::normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const {
    best_piece_kernels().normals(pieces_, rays, hits.data(), normals.data());
}

Place Brep::place(const Hit& hit) const {
    const Patch& patch = pieces_.patches[hit.primitive];
    const Domain& d = patch.domain;
    return {patch.face, d.low_u + static_cast<double>(hit.u) * (d.high_u - d.low_u),
            d.low_v + static_cast<double>(hit.v) * (d.high_v - d.low_v)};
}

std::size_t Brep::bytes() const {
    std::size_t sum = pieces_.bytes();
    for (const auto& region : regions_) sum += region->bytes();
    return sum;
}

double Brep::maximum(const std::function<double(Vec3)>& convex, double tolerance) const {
    // A convex function is nowhere larger than at a control point.
    std::priority_queue<Candidate> candidates;
    double reached = -HUGE_VAL;
    const auto add = [&](const Patch* patch, BezierPatch net) {
        const Domain domain{net.low_u, net.high_u, net.low_v, net.high_v};
        const auto coverage = patch->region->coverage(domain);
        if (coverage == TrimRegion::Coverage::none) return;
        double bound = -HUGE_VAL;
        for (const auto& point : net.control_points) bound = std::max(bound, convex(euclidean(point)));
        const auto rows = static_cast<std::size_t>(net.degree_u), columns = static_cast<std::size_t>(net.degree_v);
        for (const bool high_u : {false, true}) {
            for (const bool high_v : {false, true}) {
                if (coverage == TrimRegion::Coverage::some && !patch->region->contains(high_u ? net.high_u : net.low_u, high_v ? net.high_v : net.low_v)) continue;
                reached = std::max(reached, convex(euclidean(net.control_points[(high_u ? rows * (columns + 1) : 0) + (high_v ? columns : 0)])));
            }
        }
        candidates.push({bound, patch, std::move(net)});
    };
    for (const Patch& patch : pieces_.patches) add(&patch, patch.net());
    ...
}

}  // namespace bob
