#include <array>
#include <new>

#include "shapes/bvh_traversal.h"
#include "shapes/mesh/triangles.h"

namespace bob::BOB_ISA {
namespace {

/// Adds the shear that maps the ray to the axis k[2], for triangles.
struct RayToTriangles : RayThroughBoxes {
    int k[3];
    Floats from[3];
    Floats shear_x, shear_y, scale_z;

    explicit RayToTriangles(const Ray& ray) : RayThroughBoxes(ray) {
        for (int axis = 0; axis < 3; ++axis) from[axis] = broadcast<Floats>(origin[axis]);
        // The longest axis, indexed by the comparisons x > y, x > z, y > z.
        constexpr signed char longest[8] = {2, 2, 2, 0, 1, 2, 1, 0};
        constexpr signed char next[5] = {0, 1, 2, 0, 1};
        k[2] = longest[(size[0] > size[1]) + 2 * (size[0] > size[2]) + 4 * (size[1] > size[2])];
        k[0] = next[k[2] + 1];
        k[1] = next[k[2] + 2];
        shear_x = broadcast<Floats>(direction[k[0]] * reciprocal[k[2]]);
        shear_y = broadcast<Floats>(direction[k[1]] * reciprocal[k[2]]);
        scale_z = broadcast<Floats>(reciprocal[k[2]]);
    }
};

/// A ray's intersection with a triangle, as weights of its first and second corner.
struct Crossing {
    float t, u, v;
};

/// The same as below for one triangle, with exact products: their differences have the right sign, and zero is exact.
[[gnu::noinline]] Crossing cross_in_doubles(const std::array<float, 3>& x, const std::array<float, 3>& y, const std::array<float, 3>& z, double scale_z) {
    const auto edge = [&](std::size_t i, std::size_t j) { return double{x[i]} * double{y[j]} - double{y[i]} * double{x[j]}; };
    const double u = edge(2, 1), v = edge(0, 2), w = edge(1, 0), sum = u + v + w;
    const bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
    const double t = (u * double{z[0]} + v * double{z[1]} + w * double{z[2]}) * scale_z / sum;
    if (!inside || sum == 0) return {std::numeric_limits<float>::infinity(), 0, 0};
    return {static_cast<float>(t), static_cast<float>(u / sum), static_cast<float>(v / sum)};
}

/// Intersects eight triangles and keeps the nearest hit accepted by `counts(hit)`.
///
/// In the plane across the ray, an edge function is a difference of two products. Each product is rounded separately
/// (no fma). The difference therefore has the right sign or is zero, and a neighbour's is its exact negation; zero is
/// inside. If a triangle is so thin across the ray that rounding moves the hit, doubles decide: they represent products
/// of floats exactly. So no ray slips between neighbours, and slivers are hit at the right place. A NaN fails every
/// comparison that makes a hit.
template <class Counts>
inline void intersect(const TrianglePacket& packet, const RayToTriangles& ray, Hit& hit, Counts&& counts) {
    // Edge functions err by 2^-23 of their products. Hits err by at most 2^-23 times this limit, relative to the
    // triangle's size.
    constexpr float max_cancellation = 32;
    for (int i = 0; i < 8; i += width) {
        Floats x[3], y[3], z[3];
        for (int corner = 0; corner < 3; ++corner) {
            const auto& vertex = packet.vertex[corner];
            z[corner] = load<Floats>(&vertex[ray.k[2]][i]) - ray.from[ray.k[2]];
            x[corner] = load<Floats>(&vertex[ray.k[0]][i]) - ray.from[ray.k[0]] - ray.shear_x * z[corner];
            y[corner] = load<Floats>(&vertex[ray.k[1]][i]) - ray.from[ray.k[1]] - ray.shear_y * z[corner];
        }
        const Floats product_u = x[2] * y[1], product_v = x[0] * y[2], product_w = x[1] * y[0];
        const Floats u = product_u - y[2] * x[1];
        const Floats v = product_v - y[0] * x[2];
        const Floats w = product_w - y[1] * x[0];
        const Floats zero{};
        const Floats lowest = min(min(u, v), w), highest = max(max(u, v), w);
        const Ints inside = (lowest >= zero) | (highest <= zero);
        if (!bits(inside)) continue;

        const Floats determinant = u + v + w;
        const Floats products = fma(product_u, product_u, fma(product_v, product_v, product_w * product_w));
        const Ints exact = products < broadcast<Floats>(max_cancellation * max_cancellation) * determinant * determinant;
        const Floats t = (u * z[0] + v * z[1] + w * z[2]) * ray.scale_z / determinant;
        const Ints nearer = (t > zero) & (t < broadcast<Floats>(hit.t));
        const unsigned thin = ~bits(exact);
        for (unsigned found = bits(inside) & (bits(nearer) | thin); found; found &= found - 1) {
            const int lane = __builtin_ctz(found);
            Crossing at{t[lane], u[lane] / determinant[lane], v[lane] / determinant[lane]};
            if (thin >> lane & 1) [[unlikely]] {
                const auto corners = [lane](const Floats(&of)[3]) { return std::array{of[0][lane], of[1][lane], of[2][lane]}; };
                at = cross_in_doubles(corners(x), corners(y), corners(z), double{ray.scale_z[lane]});
            }
            if (at.t > 0 && at.t < hit.t) {
                const Hit next{at.t, at.u, at.v, packet.triangle[i + lane]};
                if (counts(next)) hit = next;
            }
        }
    }
}

template <class Counts>
inline void closest_hits_one_by_one(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                                    Hit* hits, Counts&& counts) {
    for (std::size_t i = 0; i < count; ++i) {
        const RayToTriangles ray(rays[i]);
        Hit hit;
        traverse(nodes, ray, hit, [&](std::uint32_t packet) { intersect(packets[packet], ray, hit, counts); });
        hits[i] = hit;
    }
}

/// A ray on its way from leaf to leaf.
struct Way {
    RayToTriangles ray;
    Traversal traversal;
    Hit hit;
    ChildRef leaf;
    std::size_t number;

    Way(const BvhNode* nodes, const Ray* rays, std::size_t number) : ray(rays[number]), number(number) {
        traversal.begin(nodes[0], ray);
    }
};

/// Interleaves several rays: each advances to its next leaf, whose triangles are prefetched while the others advance.
template <class Counts>
inline void closest_hits_in_turn(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                                 Hit* hits, Counts&& counts) {
    constexpr std::size_t most = 4;  // six are no faster
    union Memory {
        Memory() {}
        Way ways[most];
    } memory;
    Way* open[most];
    std::size_t left = 0, next = 0;
    const auto goes_on = [&](Way& way) {
        if (!way.traversal.next_leaf(nodes, way.ray, way.hit.t, way.leaf)) return false;
        const auto* const first = reinterpret_cast<const char*>(packets + way.leaf.first_packet());
        constexpr std::size_t line = 64;
        for (std::size_t i = 0; i < way.leaf.packets() * sizeof(TrianglePacket); i += line) __builtin_prefetch(first + i);
        return true;
    };
    const auto begins = [&](Way* way) {
        for (; next < count; hits[way->number] = way->hit) {
            if (goes_on(*new (way) Way(nodes, rays, next++))) return true;
        }
        return false;
    };
    for (; left < most && begins(&memory.ways[left]); ++left) open[left] = &memory.ways[left];
    for (std::size_t i = 0; left; i = i + 1 < left ? i + 1 : 0) {
        Way& way = *open[i];
        const std::uint32_t first = way.leaf.first_packet(), end = first + way.leaf.packets();
        for (std::uint32_t packet = first; packet != end; ++packet) intersect(packets[packet], way.ray, way.hit, counts);
        if (goes_on(way)) continue;
        hits[way.number] = way.hit;
        if (!begins(&way)) open[i] = open[--left];
    }
}

template <class Counts>
inline void closest_hits_of(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count, bool apart,
                            Hit* hits, Counts&& counts) {
    if (fetches_ahead && apart) {
        closest_hits_in_turn(nodes, packets, rays, count, hits, counts);
    } else {
        closest_hits_one_by_one(nodes, packets, rays, count, hits, counts);
    }
}

// flatten: a traversal instantiated twice would be called instead of inlined, which costs 5 % of all time.
[[gnu::flatten]] void closest_hits(const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays, std::size_t count,
                                   bool apart, Hit* hits) {
    closest_hits_of(nodes, packets, rays, count, apart, hits, [](const Hit&) { return true; });
}

void closest_hits_around(const Holes& holes, const BvhNode* nodes, const TrianglePacket* packets, const Ray* rays,
                         std::size_t count, bool apart, Hit* hits) {
    closest_hits_of(nodes, packets, rays, count, apart, hits, [&](const Hit& hit) { return !holes.at(hit.primitive, hit.u, hit.v); });
}

}  // namespace

const TriangleKernels triangle_kernels = {closest_hits, closest_hits_around};

}  // namespace bob::BOB_ISA
