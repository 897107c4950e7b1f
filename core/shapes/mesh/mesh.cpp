#include "shapes/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "base/interruption.h"
#include "shapes/mesh/shells.h"

namespace bob {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<bool> used_vertices(const Mesh::Arrays& arrays) {
    std::vector<bool> used(arrays.vertices.size());
    for (const Triangle& triangle : arrays.triangles) {
        for (const std::uint32_t vertex : triangle) used[vertex] = true;
    }
    if (std::find(used.begin(), used.end(), false) == used.end()) used.clear();
    return used;
}

/// f(point) for the vertices in use, transformed by a map.
template <class F>
void for_each(std::span<const Mesh::Point> vertices, const std::vector<bool>& used, const AffineMap& map, F f) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (!used.empty() && !used[i]) continue;
        const auto& [x, y, z] = vertices[i];
        Mesh::Point moved;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto& row = map.row[axis];
            moved[axis] = row[0] * x + row[1] * y + row[2] * z + row[3];
        }
        f(moved);
    }
}

Bounds bounds_of(std::span<const Mesh::Point> vertices, const std::vector<bool>& used, const AffineMap& map) {
    Bounds bounds{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
    for_each(vertices, used, map, [&](const Mesh::Point& p) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            bounds.low[axis] = std::min(bounds.low[axis], p[axis]);
            bounds.high[axis] = std::max(bounds.high[axis], p[axis]);
        }
    });
    return bounds;
}

/// The distance from `center` to the farthest point: `largest` is the maximum along an axis, and maximum(square) the
/// maximum of square(p) over the points.
template <class Maximum>
double radius_of(double largest, const double center[3], Maximum maximum) {
    // In units of about the largest coordinate, so that squares stay in range; a power of two rounds nothing.
    int exponent = 0;
    std::frexp(largest, &exponent);
    exponent = std::max(exponent, -1000);  // the unit's reciprocal has to stay in range too
    const double scale = std::ldexp(1, -exponent);
    const double farthest = maximum([&](const Mesh::Point& p) {
        const double x = (p[0] - center[0]) * scale, y = (p[1] - center[1]) * scale, z = (p[2] - center[2]) * scale;
        return x * x + y * y + z * z;
    });
    return std::ldexp(std::sqrt(farthest), exponent);
}

double radius_of(std::span<const Mesh::Point> vertices, const std::vector<bool>& used, const AffineMap& map,
                 const double center[3]) {
    double largest = 0;
    bool finite = true;
    for_each(vertices, used, map, [&](const Mesh::Point& p) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double distance = std::fabs(p[axis] - center[axis]);
            largest = std::max(largest, distance);
            finite = finite && distance < infinity;
        }
    });
    if (!finite) return infinity;
    return radius_of(largest, center, [&](auto square) {
        double farthest = 0;
        for_each(vertices, used, map, [&](const Mesh::Point& p) { farthest = std::max(farthest, square(p)); });
        return farthest;
    });
}

double radius_of(const PointTree& points, const AffineMap& map, const double center[3]) {
    const Bounds bounds = points.bounds(map);
    double largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double end : {bounds.low[axis], bounds.high[axis]}) {
            const double distance = std::fabs(end - center[axis]);
            if (!(distance < infinity)) return infinity;
            largest = std::max(largest, distance);
        }
    }
    return radius_of(largest, center, [&](auto square) { return points.farthest(map, center, square); });
}

/// Prefetch distance, in hits: triangle attributes are rarely in the cache.
constexpr std::size_t ahead = 8;

/// Interpolates a corner attribute by the barycentric weights of a place.
Mesh::Uv blended(const std::array<Mesh::Uv, 3>& corner, float u, float v) {
    const float w = 1 - u - v;
    return {u * corner[0][0] + v * corner[1][0] + w * corner[2][0], u * corner[0][1] + v * corner[1][1] + w * corner[2][1]};
}

/// Holes where the texture's alpha times the vertices' alpha is below a cutoff; either factor is optional.
class CutOut : public Holes {
public:
    CutOut(const Texture* texture, std::span<const Mesh::OnTexture> places, std::vector<std::array<float, 3>> alphas, float cutoff)
        : texture_(texture), places_(places), alphas_(std::move(alphas)), cutoff_(cutoff) {}

    [[nodiscard]] bool at(std::uint32_t triangle, float u, float v) const override {
        float alpha = 1;
        if (texture_) {
            const auto [across, down] = blended(places_[triangle].corner, u, v);
            alpha = texture_->alpha(across, down);
        }
        if (!alphas_.empty()) {
            const auto& [a, b, c] = alphas_[triangle];
            alpha *= c + u * (a - c) + v * (b - c);  // exact for equal values
        }
        return alpha < cutoff_;
    }

private:
    const Texture* texture_;
    std::span<const Mesh::OnTexture> places_;
    std::vector<std::array<float, 3>> alphas_;
    float cutoff_;
};

}  // namespace

Mesh::Extent::Extent(const Arrays& arrays, const std::vector<bool>& used) : bounds(bounds_of(arrays.vertices, used, {})) {
    for (int axis = 0; axis < 3; ++axis) around.center[axis] = bounds.low[axis] / 2 + bounds.high[axis] / 2;
    around.radius = radius_of(arrays.vertices, used, {}, around.center);
}

Mesh::Mesh(Arrays arrays, const std::optional<Sphere>& sphere) : Mesh(arrays, used_vertices(arrays), sphere) {}

Mesh::Mesh(const Arrays& arrays, std::vector<bool> used, const std::optional<Sphere>& sphere) : Mesh(arrays, used, Extent(arrays, used), sphere) {}

Mesh::Mesh(const Arrays& arrays, std::vector<bool> used, const Extent& extent, const std::optional<Sphere>& sphere)
    : SurfaceShape(sphere ? *sphere : extent.sphere()), arrays_(arrays), used_(std::move(used)), extent_(extent) {}

Bounds Mesh::bounds(const AffineMap& map) const {
    if (map == AffineMap{}) return extent_.bounds;
    const PointTree* const outline = outline_.get();
    return outline ? outline->bounds(map) : bounds_of(arrays_.vertices, used_, map);
}

double Mesh::radius(const AffineMap& map, const double center[3]) const {
    if (map == AffineMap{} && std::equal(center, center + 3, extent_.around.center)) return extent_.around.radius;
    if (const PointTree* const outline = outline_.get()) return radius_of(*outline, map, center);
    return radius_of(arrays_.vertices, used_, map, center);
}

void Mesh::prepare_places() const {
    outline_.prepare([&] {
        std::vector<Point> points;
        for_each(arrays_.vertices, used_, {}, [&](const Point& p) {
            if (points.size() % 32768 == 0) Interruption::check();
            points.push_back(p);
        });
        return points;
    });
}

std::vector<Vec3> Mesh::in_unit_sphere() const {
    const auto& [center, size] = sphere();
    std::vector<Vec3> points;
    points.reserve(arrays_.vertices.size());
    for (const Point& p : arrays_.vertices) {  // unused vertices may be anywhere
        if (points.size() % 32768 == 0) Interruption::check();
        points.push_back({static_cast<float>((p[0] - center[0]) / size), static_cast<float>((p[1] - center[1]) / size),
                          static_cast<float>((p[2] - center[2]) / size)});
    }
    return points;
}

std::vector<CornerNormals> Mesh::corner_normals() const {
    const std::vector<Vec3> points = in_unit_sphere();
    return corner_normals(points, bob::face_normals(points, arrays_.triangles));
}

std::vector<CornerNormals> Mesh::corner_normals(std::span<const Vec3> points, std::span<const Vec3> face) const {
    return arrays_.normals.empty() ? crease_normals(points, arrays_.triangles, face)
                                   : stored_normals(points, arrays_.triangles, face, arrays_.normals);
}

void Mesh::prepare() const {
    const std::lock_guard lock(preparing_);
    if (prepared_) return;
    const std::span<const Triangle> triangles = arrays_.triangles;
    const std::vector<Vec3> points = in_unit_sphere();
    auto prepared = std::make_unique<Prepared>();
    prepared->face_normals = bob::face_normals(points, triangles);
    prepared->normals = corner_normals(points, prepared->face_normals);
    prepared->bvh = build_triangle_bvh(points, triangles);
    prepare_colors(points, *prepared);
    prepare_holes(*prepared);
    prepared_ = std::move(prepared);
}

void Mesh::prepare_colors(const std::vector<Vec3>& points, Prepared& prepared) const {
    const auto at_corners = [&](const auto& values, auto& corners) {
        corners.reserve(arrays_.triangles.size());
        for (const Triangle& t : arrays_.triangles) corners.push_back({values[t[0]], values[t[1]], values[t[2]]});
    };
    prepared.face_colors.assign(arrays_.face_colors.begin(), arrays_.face_colors.end());
    if (!arrays_.colors.empty()) at_corners(arrays_.colors, prepared.corner_colors);
    if (!arrays_.texture) return;
    const Picture& picture = arrays_.texture->picture();
    const auto area = static_cast<float>(picture.height()) * static_cast<float>(picture.width());
    prepared.on_texture.reserve(arrays_.triangles.size());
    for (const Triangle& t : arrays_.triangles) {
        const Uv a = arrays_.uv[t[0]], b = arrays_.uv[t[1]], c = arrays_.uv[t[2]];
        const float covered = std::fabs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) * area;
        const float surface = length(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]));
        prepared.on_texture.push_back({{a, b, c}, surface > 0 ? std::sqrt(covered / surface) : 0});
    }
}

void Mesh::prepare_holes(Prepared& prepared) const {
    const std::span<const float> alphas = arrays_.alphas;
    const float of_texture = arrays_.texture ? arrays_.texture->picture().least_alpha() : 1;
    const float of_vertices = alphas.empty() ? 1 : *std::min_element(alphas.begin(), alphas.end());
    if (!(of_texture * of_vertices < arrays_.alpha_cutoff)) return;
    std::vector<std::array<float, 3>> corners;
    if (of_vertices < 1) {
        corners.reserve(arrays_.triangles.size());
        for (const Triangle& t : arrays_.triangles) corners.push_back({alphas[t[0]], alphas[t[1]], alphas[t[2]]});
    }
    const Texture* const texture = of_texture < 1 ? arrays_.texture.get() : nullptr;
    prepared.holes = std::make_unique<CutOut>(texture, prepared.on_texture, std::move(corners), arrays_.alpha_cutoff);
}

void Mesh::colors(std::span<const Ray> rays, std::span<const Hit> hits, std::span<const float> widths,
                  std::span<Vec3> colors) const {
    const auto& [normals, face_normals, bvh, corner_colors, face_colors, on_texture, holes] = *prepared_;
    const auto times = [](Vec3 a, Vec3 b) { return Vec3{a.x * b.x, a.y * b.y, a.z * b.z}; };
    const Texture* const texture = arrays_.texture.get();
    std::array<Texture::Lookup, ahead> lookups;  // for the last hits
    const auto use_texture = [&](std::size_t i) { colors[i] = times(colors[i], texture->color(lookups[i % ahead])); };
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (texture && i >= ahead) use_texture(i - ahead);
        if (i + ahead < hits.size()) {
            const std::uint32_t next = hits[i + ahead].primitive;
            if (texture) __builtin_prefetch(&on_texture[next]);
            if (!corner_colors.empty()) __builtin_prefetch(&corner_colors[next]);
        }
        const auto& [t, u, v, triangle] = hits[i];
        Vec3 color{1, 1, 1};
        if (!corner_colors.empty()) {
            const auto& corner = corner_colors[triangle];
            color = u * corner[0] + v * corner[1] + (1 - u - v) * corner[2];
        }
        if (!face_colors.empty()) color = times(color, face_colors[triangle]);
        colors[i] = color;
        if (texture) {
            // A pixel's footprint is elongated on slanted surfaces: the square root is a compromise between blur and
            // noise.
            const float size = length(rays[i].direction);
            const float slant = std::max(0.05f, std::fabs(dot(face_normals[triangle], rays[i].direction)) / size);
            const float width = widths[i] * size * on_texture[triangle].texels / std::sqrt(slant);
            const auto [across, down] = blended(on_texture[triangle].corner, u, v);
            lookups[i % ahead] = texture->look_up(across, down, width);
        }
    }
    if (!texture) return;
    for (std::size_t i = std::max(ahead, hits.size()) - ahead; i < hits.size(); ++i) use_texture(i);
}

void Mesh::closest_hits(std::span<const Ray> rays, std::span<Hit> hits) const {
    const auto& [nodes, packets, packet_size] = prepared_->bvh;
    const TriangleKernels& kernels = best_triangle_kernels();
    const bool apart = lie_apart(prepared_->bvh, rays);
    if (const Holes* const holes = prepared_->holes.get()) {
        kernels.closest_hits_around(*holes, nodes.data(), packets.data(), rays.data(), rays.size(), apart, hits.data());
    } else {
        kernels.closest_hits(nodes.data(), packets.data(), rays.data(), rays.size(), apart, hits.data());
    }
}

void Mesh::normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const {
    for (std::size_t i = 0; i < hits.size(); ++i) {
        if (i + ahead < hits.size()) {
            const std::uint32_t next = hits[i + ahead].primitive;
            __builtin_prefetch(&prepared_->normals[next]), __builtin_prefetch(&prepared_->normals[next][2].z);
            __builtin_prefetch(&prepared_->face_normals[next]);
        }
        normals[i] = shading_normal(hits[i], rays[i].direction);
    }
}

void Mesh::face_normals(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Vec3> normals) const {
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const Vec3 face = prepared_->face_normals[hits[i].primitive];
        normals[i] = dot(face, rays[i].direction) > 0 ? -face : face;
    }
}

Vec3 Mesh::shading_normal(const Hit& hit, Vec3 ray_direction) const {
    const CornerNormals& corner = prepared_->normals[hit.primitive];
    const Vec3 smooth = normalized(hit.u * corner[0] + hit.v * corner[1] + (1 - hit.u - hit.v) * corner[2]);
    const Vec3 face = prepared_->face_normals[hit.primitive];
    // Files disagree about the outside, and open meshes show both sides: use the side that was hit.
    const Vec3 facing = dot(face, ray_direction) > 0 ? -face : face;
    if (dot(smooth, smooth) == 0) return facing;
    return dot(smooth, facing) < 0 ? -smooth : smooth;
}

void Mesh::sides(std::span<const Ray> rays, std::span<const Hit> hits, std::span<Side> sides) const {
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const std::uint32_t triangle = hits[i].primitive;
        sides[i] = {triangle, dot(prepared_->face_normals[triangle], rays[i].direction) <= 0};
    }
}

Solid Mesh::find_solid() const {
    const std::vector<Vec3> points = in_unit_sphere();
    const std::span<const Triangle> triangles = arrays_.triangles;
    const Shells shells = find_shells(points, triangles);
    // Through triangles all over the mesh, and through some of each shell.
    constexpr std::size_t most_lines = 2048, most_in_shells = 16384, most_in_shell = 4;
    std::vector<Ray> lines;
    const auto add = [&](std::size_t triangle) {
        const auto& [a, b, c] = triangles[triangle];
        const Vec3 middle = (1.f / 3) * (points[a] + points[b] + points[c]);
        lines.push_back(line_through(middle, prepared_->face_normals[triangle], static_cast<std::uint32_t>(lines.size())));
    };
    for (std::size_t i = 0; i < most_lines; ++i) add(i * triangles.size() / most_lines);
    if (shells.count > 1) {
        std::vector<std::uint8_t> counts(shells.count);
        for (std::size_t t = 0; t < triangles.size() && lines.size() < most_lines + most_in_shells; ++t) {
            if (counts[shells.of[t]] < most_in_shell) ++counts[shells.of[t]], add(t);
        }
    }
    Solid solid = bob::find_solid(*this, shells.count, lines, [&](std::span<const Ray> rays, std::span<const Hit> hits, std::span<Side> at) {
        sides(rays, hits, at);
        for (Side& side : at) side = {shells.of[side.part], side.is_front != (shells.reversed[side.part] != 0)};
    });
    // Turned shells become turned triangles.
    std::vector<std::uint8_t> turned(triangles.size());
    bool any = false;
    for (std::size_t t = 0; t < turned.size(); ++t) {
        turned[t] = (!solid.turned.empty() && solid.turned[shells.of[t]]) != (shells.reversed[t] != 0);
        any = any || turned[t];
    }
    if (!any) turned.clear();
    solid.turned = std::move(turned);
    return solid;
}

std::size_t Mesh::bytes() const {
    const std::lock_guard lock(preparing_);
    if (!prepared_) return 0;
    const auto& [normals, face_normals, bvh, corner_colors, face_colors, on_texture, holes] = *prepared_;
    return bvh.bytes() + normals.size() * sizeof(CornerNormals) + face_normals.size() * sizeof(Vec3) +
           corner_colors.size() * sizeof(corner_colors[0]) + face_colors.size() * sizeof(Vec3) +
           on_texture.size() * sizeof(OnTexture) +
           (holes && !arrays_.alphas.empty() ? 3 * arrays_.triangles.size() * sizeof(float) : 0);
}

std::size_t Mesh::bvh_bytes() const {
    const std::lock_guard lock(preparing_);
    return prepared_ ? prepared_->bvh.bytes() : 0;
}

}  // namespace bob
