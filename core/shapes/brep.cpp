#include "shapes/brep.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <stdexcept>

#include "shapes/sphere_around.h"
#include "work.h"

namespace bob {
namespace {

Vec3 euclidean(const Homogeneous<3>& point) {
    const auto& [x, y, z, w] = point;
    return {static_cast<float>(x / w), static_cast<float>(y / w), static_cast<float>(z / w)};
}

/// A patch in double precision, where it was before it was moved to its own centre.
BezierPatch bezier_patch(const Pieces& pieces, const Patch& patch) {
    const auto& [low_u, high_u, low_v, high_v] = patch.domain;
    BezierPatch result{low_u, high_u, low_v, high_v, patch.degree_u, patch.degree_v, {}};
    const std::size_t count = (patch.degree_u + 1u) * (patch.degree_v + 1u);
    for (std::size_t i = 0; i < count; ++i) {
        const auto& [x, y, z, w] = pieces.control_points[patch.control_points + i];
        const auto moved = [w = double{w}](double relative, double center) { return relative + w * center; };
        result.control_points.push_back(
            {moved(x, patch.center[0]), moved(y, patch.center[1]), moved(z, patch.center[2]), w});
    }
    return result;
}

/// Where the largest value of a convex function is looked for.
class Search {
public:
    explicit Search(const std::function<double(Vec3)>& convex) : convex_(convex) {}

    void add(BezierPatch patch, const Patch& from) {
        Interruption::check();
        const auto coverage = from.coverage({patch.low_u, patch.high_u, patch.low_v, patch.high_v});
        if (coverage == TrimRegion::Coverage::none) return;
        // Nowhere is it larger than at a control point.
        double bound = -HUGE_VAL;
        for (const auto& point : patch.control_points) bound = std::max(bound, convex_(euclidean(point)));
        for (const bool u : {false, true}) {
            for (const bool v : {false, true}) {
                if (coverage == TrimRegion::Coverage::all ||
                    from.region->contains(u ? patch.high_u : patch.low_u, v ? patch.high_v : patch.low_v)) {
                    reached_ = std::max(reached_, convex_(euclidean(corner(patch, u, v))));
                }
            }
        }
        open_.push({bound, std::move(patch), &from});
    }

    double run(double tolerance) {
        while (!open_.empty()) {
            const Candidate top = open_.top();
            if (top.bound <= reached_ + tolerance || extent(top.patch) <= tolerance || work_.is_spent()) return top.bound;
            work_.spend(units_to_cut * top.patch.control_points.size());
            open_.pop();
            const bool along_v = extent_along(top.patch, true) > extent_along(top.patch, false);
            for (const double low : {0., 0.5}) {
                const double high = low + 0.5;
                add(along_v ? part(top.patch, 0, 1, low, high) : part(top.patch, low, high, 0, 1), *top.from);
            }
        }
        return reached_;
    }

private:
    struct Candidate {
        double bound;
        BezierPatch patch;
        const Patch* from;

        bool operator<(const Candidate& other) const { return bound < other.bound; }
    };

    static const Homogeneous<3>& corner(const BezierPatch& patch, bool u, bool v) {
        const auto rows = static_cast<std::size_t>(patch.degree_u), columns = static_cast<std::size_t>(patch.degree_v);
        return patch.control_points[(u ? rows * (columns + 1) : 0) + (v ? columns : 0)];
    }

    /// The longest line of control points along u or v.
    static double extent_along(const BezierPatch& patch, bool v) {
        const auto columns = static_cast<std::size_t>(patch.degree_v) + 1;
        const std::size_t count = patch.control_points.size(), step = v ? 1 : columns;
        std::vector<double> lengths(v ? count / columns : columns);
        for (std::size_t i = 0; i + step < count; ++i) {
            if (v && i % columns == columns - 1) continue;
            const Vec3 d = euclidean(patch.control_points[i + step]) - euclidean(patch.control_points[i]);
            lengths[v ? i / columns : i % columns] += static_cast<double>(length(d));
        }
        return *std::max_element(lengths.begin(), lengths.end());
    }
    static double extent(const BezierPatch& patch) { return extent_along(patch, false) + extent_along(patch, true); }

    // Where it is spent, the box or radius is larger than it need be.
    static constexpr std::uint64_t budget = 2'000'000'000, units_to_cut = 500;

    const std::function<double(Vec3)>& convex_;
    Work work_{budget};
    double reached_ = -HUGE_VAL;
    std::priority_queue<Candidate> open_;
};

}  // namespace

Brep::Brep(std::span<const Face> faces, double tolerance, const Sphere& sphere) : Shape(sphere) {
    std::vector<FacePatches> patches;
    for (const Face& face : faces) {
        const NurbsSurface& s = face.surface;
        const Domain domain{s.knots_u[static_cast<std::size_t>(s.degree_u)], s.knots_u[s.size_u()],
                            s.knots_v[static_cast<std::size_t>(s.degree_v)], s.knots_v[s.size_v()]};
        regions_.push_back(std::make_unique<TrimRegion>(face.loops, domain));
        patches.push_back({decompose(s), regions_.back().get()});
    }
    pieces_ = build_pieces(patches, tolerance);
}

Brep Brep::of_weighted_points(std::vector<Face> faces, double tolerance) {
    const Sphere sphere = sphere_around([&](auto add) {
        for (const Face& face : faces) {
            for (const auto& point : face.surface.control_points) add(point.data(), 0);
        }
    });
    for (Face& face : faces) {
        make_homogeneous<3>(face.surface.control_points, sphere.center, sphere.radius);
        for (TrimLoop& loop : face.loops) {
            for (NurbsCurve<2>& curve : loop) make_homogeneous<2>(curve.control_points);
        }
    }
    Brep brep(faces, faces.size() > 1 ? tolerance / sphere.radius : 0, sphere);
    if (brep.pieces_.count == 0) throw std::invalid_argument("faces: expected at least one face of which the trims leave an area, got none");
    return brep;
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
    return {patch.face, patch.face_u(hit.u), patch.face_v(hit.v)};
}

std::size_t Brep::bytes() const {
    std::size_t sum = pieces_.bytes();
    for (const auto& region : regions_) sum += region->bytes();
    return sum;
}

double Brep::maximum(const std::function<double(Vec3)>& convex, double tolerance) const {
    Search search(convex);
    for (const Patch& patch : pieces_.patches) search.add(bezier_patch(pieces_, patch), patch);
    return search.run(tolerance);
}

}  // namespace bob
