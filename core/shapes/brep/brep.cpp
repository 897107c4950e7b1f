#include "shapes/brep/brep.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <queue>
#include <stdexcept>
#include <utility>

#include "base/mutex.h"
#include "base/thread_memory.h"
#include "base/work.h"
#include "shapes/sphere_around.h"

namespace bob {
namespace {

// Once it is spent, the box or radius is larger than necessary. A cut costs `units_to_cut` for each control point.
constexpr std::uint64_t units_to_search = 2'000'000'000, units_to_cut = 500;

Vec3 euclidean(const Homogeneous<3>& point) {
    const auto& [x, y, z, w] = point;
    return {static_cast<float>(x / w), static_cast<float>(y / w), static_cast<float>(z / w)};
}

/// A patch in double precision, at its place before the shift to its own centre.
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

/// The part of a patch around its visible points.
BezierPatch around_seen(const BezierPatch& bezier, const Patch& patch) {
    const auto& [low_u, high_u, low_v, high_v] = patch.domain;
    const Domain seen = patch.extent(patch.domain);
    if (seen.low_u > seen.high_u || seen.low_v > seen.high_v) return bezier;
    const double size_u = high_u - low_u, size_v = high_v - low_v;
    return part(bezier, (seen.low_u - low_u) / size_u, (seen.high_u - low_u) / size_u, (seen.low_v - low_v) / size_v,
                (seen.high_v - low_v) / size_v);
}

const Homogeneous<3>& corner(const BezierPatch& patch, bool u, bool v) {
    const auto rows = static_cast<std::size_t>(patch.degree_u), columns = static_cast<std::size_t>(patch.degree_v);
    return patch.control_points[(u ? rows * (columns + 1) : 0) + (v ? columns : 0)];
}

/// The longest line of control points along u or v.
double extent_along(const BezierPatch& patch, bool v) {
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

}  // namespace

/// A part of a patch: the points that decide the maxima of convex functions, and its halves, computed on request.
struct Brep::Search::SubPatch {
    using Halves = std::vector<SubPatch>;

    SubPatch(const BezierPatch& bezier, const Patch& from) : patch(bezier), from(&from) {
        Interruption::check();
        const auto coverage = from.coverage({patch.low_u, patch.high_u, patch.low_v, patch.high_v});
        if (coverage == TrimRegion::Coverage::none) return;
        for (const auto& point : patch.control_points) points.push_back(euclidean(point));
        for (const bool u : {false, true}) {
            for (const bool v : {false, true}) {
                if (coverage == TrimRegion::Coverage::all ||
                    from.region->contains(u ? patch.high_u : patch.low_u, v ? patch.high_v : patch.low_v)) {
                    seen.push_back(euclidean(corner(patch, u, v)));
                }
            }
        }
        const double along_u = extent_along(patch, false), along_v = extent_along(patch, true);
        extent = along_u + along_v, longer_along_v = along_v > along_u;
    }
    SubPatch(SubPatch&& other) noexcept
        : patch(std::move(other.patch)), from(other.from), points(std::move(other.points)), seen(std::move(other.seen)),
          extent(other.extent), longer_along_v(other.longer_along_v), halves_(other.halves_.exchange(nullptr)) {}
    SubPatch& operator=(SubPatch&&) = delete;
    ~SubPatch() { delete halves_.load(); }

    [[nodiscard]] bool covered() const { return !points.empty(); }

    /// Thread-safe; all threads get the same halves.
    [[nodiscard]] const Halves& halves() const {
        if (const Halves* const made = halves_.load()) return *made;
        auto halves = std::make_unique<Halves>();
        for (const double low : {0., 0.5}) {
            const double high = low + 0.5;
            halves->emplace_back(longer_along_v ? part(patch, 0, 1, low, high) : part(patch, low, high, 0, 1), *from);
        }
        const Halves* other = nullptr;
        if (halves_.compare_exchange_strong(other, halves.get())) return *halves.release();
        return *other;
    }

    BezierPatch patch;
    const Patch* from;
    std::vector<Vec3> points;  // a convex function has its maximum at a corner; empty if the part is trimmed away
    std::vector<Vec3> seen;    // corners that the trims leave
    double extent = 0;
    bool longer_along_v = false;

private:
    mutable std::atomic<const Halves*> halves_ = nullptr;
};

struct Brep::Search::Kept {
    Mutex making;
    std::vector<SubPatch> parts;  // whole patches
};

Brep::Search::Search() : kept_(std::make_unique<Kept>()) {}
Brep::Search::Search(Search&&) noexcept = default;
Brep::Search::~Search() = default;

double Brep::Search::maximum(const Pieces& pieces, const std::function<double(Vec3)>& convex, double tolerance) const {
    struct Candidate {
        double bound;
        const SubPatch* part;

        bool operator<(const Candidate& other) const { return bound < other.bound; }
    };
    {
        const std::lock_guard lock(kept_->making);
        if (kept_->parts.empty()) {
            std::vector<SubPatch> parts;
            for (const Patch& patch : pieces.patches) parts.emplace_back(around_seen(bezier_patch(pieces, patch), patch), patch);
            kept_->parts = std::move(parts);
        }
    }
    double reached = -HUGE_VAL;
    std::priority_queue<Candidate> open;
    const auto add = [&](const SubPatch& part) {
        if (!part.covered()) return;
        double bound = -HUGE_VAL;
        for (const Vec3 point : part.points) bound = std::max(bound, convex(point));
        for (const Vec3 point : part.seen) reached = std::max(reached, convex(point));
        open.push({bound, &part});
    };
    for (const SubPatch& part : kept_->parts) add(part);
    Work work(units_to_search);
    while (!open.empty()) {
        const Candidate top = open.top();
        if (top.bound <= reached + tolerance || top.part->extent <= tolerance || work.is_spent()) return top.bound;
        work.spend(units_to_cut * top.part->patch.control_points.size());
        open.pop();
        for (const SubPatch& half : top.part->halves()) add(half);
    }
    return reached;
}

void make_homogeneous(Face& face, const Sphere& sphere) {
    make_homogeneous<3>(face.surface.control_points, sphere.center, sphere.radius);
    for (TrimLoop& loop : face.loops) {
        for (NurbsCurve<2>& curve : loop) make_homogeneous<2>(curve.control_points);
    }
}

Brep::Brep(std::span<const Face> faces, double tolerance, const Sphere& sphere)
    : SurfaceShape(sphere), faces_(faces.begin(), faces.end()), tolerance_(tolerance) {
    std::vector<FacePatches> patches;
    for (const Face& face : faces) {
        const NurbsSurface& s = face.surface;
        const Domain domain{s.knots_u[static_cast<std::size_t>(s.degree_u)], s.knots_u[s.size_u()],
                            s.knots_v[static_cast<std::size_t>(s.degree_v)], s.knots_v[s.size_v()]};
        regions_.push_back(std::make_unique<TrimRegion>(face.loops, domain));
        numbers_.push_back(face.number.value_or(static_cast<std::uint32_t>(patches.size())));
        patches.push_back({decompose(s), regions_.back().get()});
    }
    pieces_ = build_pieces(patches, tolerance);
    if (std::any_of(faces.begin(), faces.end(), [](const Face& face) { return face.color.has_value(); })) {
        for (const Face& face : faces) colors_.push_back(face.color.value_or(Vec3{1, 1, 1}));
    }
}

Brep Brep::of_weighted_points(std::vector<Face> faces, double tolerance) {
    const Sphere sphere = sphere_around([&](auto add) {
        for (const Face& face : faces) {
            for (const auto& point : face.surface.control_points) add(point.data(), 0);
        }
    });
    for (Face& face : faces) make_homogeneous(face, sphere);
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
    best_piece_kernels().normals(pieces_, hits, normals.data());
    for (std::size_t i = 0; i < hits.size(); ++i) normals[i] = dot(normals[i], rays[i].direction) > 0 ? -normals[i] : normals[i];
}

void Brep::sides(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Side> sides) const {
    struct Memory {
        std::vector<Vec3> normals;
    };
    auto& [normals] = thread_memory<Memory>();
    normals.resize(hits.size());
    best_piece_kernels().normals(pieces_, hits, normals.data());
    for (std::size_t i = 0; i < hits.size(); ++i) sides[i] = {pieces_.patches[hits[i].primitive].face, dot(normals[i], rays[i].direction) <= 0};
}

Solid Brep::find_solid() const {
    constexpr std::size_t least_lines = 2048, most_lines = 32768, least_in_face = 8;
    const std::size_t faces = regions_.size(), in_face = std::clamp(least_lines / faces, least_in_face, most_lines);
    std::vector<std::vector<const Patch*>> patches(faces);
    for (const Patch& patch : pieces_.patches) patches[patch.face].push_back(&patch);
    std::vector<Ray> lines;
    for (const auto& of_face : patches) {
        // Points of the face on a sequence that fills its patches evenly, at most some tries for each line.
        std::size_t found = 0;
        for (std::size_t i = 0; i < 8 * in_face && found < in_face && lines.size() < most_lines && !of_face.empty(); ++i) {
            const auto share = [&](double step) { return std::fmod(0.5 + step * static_cast<double>(i), 1.0); };
            const Patch& patch = *of_face[i % of_face.size()];
            const double u = share(0.7548776662), v = share(0.5698402910);
            if (patch.coverage(u, v) != TrimRegion::Coverage::all) continue;
            const BezierPatch bezier = bezier_patch(pieces_, patch);
            const Hit at{0, static_cast<float>(u), static_cast<float>(v), static_cast<std::uint32_t>(&patch - pieces_.patches.data())};
            Vec3 normal;
            best_piece_kernels().normals(pieces_, {&at, 1}, &normal);
            lines.push_back(line_through(euclidean(part(bezier, u, 1, v, 1).control_points[0]), normal, static_cast<std::uint32_t>(lines.size())));
            ++found;
        }
    }
    return bob::find_solid(*this, faces, lines, [&](std::span<const Ray> rays, std::span<const Hit> hits, std::span<Side> at) { sides(rays, hits, at); });
}

void Brep::vote(std::span<const Ray> rays, std::span<const Hit> hits, std::span<int> votes) const {
    struct Memory {
        std::vector<Vec3> normals;
        std::vector<std::uint8_t> inside;
    };
    auto& [normals, inside] = thread_memory<Memory>();
    normals.resize(hits.size()), inside.resize(hits.size());
    SurfaceShape::starts_inside(rays, hits, inside);
    best_piece_kernels().normals(pieces_, hits, normals.data());
    constexpr float edge_on = 1e-3f;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const Patch& patch = pieces_.patches[hits[i].primitive];
        const bool is_doubtful = std::fabs(dot(normals[i], rays[i].direction)) < edge_on * length(rays[i].direction) ||
                                 patch.coverage(double{hits[i].u}, double{hits[i].v}) != TrimRegion::Coverage::all;
        votes[i] = is_doubtful ? 0 : inside[i] ? 1 : -1;
    }
}

void Brep::starts_inside(std::span<const Ray> rays, std::span<const Hit> hits, std::span<std::uint8_t> inside) const {
    std::vector<int> sums(rays.size());
    vote(rays, hits, sums);
    // Edges may gape by the tolerance, and faces extend beyond their trims. So two directions have to agree.
    constexpr Vec3 back{}, ways[] = {back, {-0.31f, 0.83f, 0.47f}, {0.23f, -0.59f, 0.77f}, {0.41f, 0.29f, -0.86f}};
    std::vector<Ray> tried;
    std::vector<Hit> met;
    std::vector<std::uint32_t> of;
    std::vector<int> votes;
    for (const Vec3& way : ways) {
        tried.clear(), of.clear();
        for (std::uint32_t i = 0; i < rays.size(); ++i) {
            if (std::abs(sums[i]) >= 2) continue;
            const Vec3 direction = rays[i].direction;
            tried.push_back({rays[i].origin, &way == ways ? -direction : length(direction) * way}), of.push_back(i);
        }
        if (of.empty()) break;
        met.resize(tried.size());
        closest_hits(tried, met);
        std::size_t count = 0;
        for (std::size_t j = 0; j < tried.size(); ++j) {
            if (met[j].primitive == no_primitive) {
                --sums[of[j]];
            } else {
                of[count] = of[j], tried[count] = tried[j], met[count] = met[j], ++count;
            }
        }
        votes.assign(count, 0);
        vote({tried.data(), count}, {met.data(), count}, votes);
        for (std::size_t j = 0; j < count; ++j) sums[of[j]] += votes[j];
    }
    for (std::size_t i = 0; i < rays.size(); ++i) inside[i] = sums[i] > 0;
}

void Brep::colors(std::span<const Ray>, std::span<const Hit> hits, std::span<const float>, std::span<Vec3> colors) const {
    for (std::size_t i = 0; i < hits.size(); ++i) colors[i] = colors_[pieces_.patches[hits[i].primitive].face];
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
    return search_.maximum(pieces_, convex, tolerance);
}

}  // namespace bob
