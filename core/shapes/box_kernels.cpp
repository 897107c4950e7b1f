#include <algorithm>

#include "shapes/boxes.h"
#include "shapes/bvh_traversal.h"

namespace bob::BOB_ISA {
namespace {

// Up to this number, rays test all boxes, one ray per lane.
constexpr std::size_t few_boxes = 2 * lanes;

/// Lists the boxes of a packet that the ray enters.
///
/// As `enter_boxes`, but with identical rounding in all instruction sets: without fma. A ray whose t overflow may find
/// packets twice, but never lists more than the number of boxes.
inline void enter(const BoxPacket& packet, const RayThroughBoxes& ray, std::uint32_t ray_index, const Entrance* end,
                  Entrance*& next) {
    for (int i = 0; i < 8; i += width) {
        Floats enter = broadcast<Floats>(0.f);
        Floats leave = broadcast<Floats>(Box::infinity);
        for (int axis = 0; axis < 3; ++axis) {
            const int near = ray.near_side[axis];
            const Floats from = broadcast<Floats>(ray.origin[axis]);
            const Floats a = load<Floats>(&packet.bounds[near][axis][i]) - from;
            const Floats b = load<Floats>(&packet.bounds[1 - near][axis][i]) - from;
            enter = max(a * ray.inverse[axis], enter);
            leave = min(b * ray.inverse[axis], leave);
        }
        for (unsigned entered = bits(enter <= leave); entered && next != end; entered &= entered - 1) {
            const int lane = __builtin_ctz(entered);
            *next++ = {packet.box[i + lane], ray_index, enter[lane]};
        }
    }
}

/// One ray per lane: origins and directions.
template <int N>
struct RayLanes {
    Vector<N> origin[3], direction[3];

    template <class RayOf>
    RayLanes(std::size_t count, RayOf ray_of) {
        float numbers[6][N];
        for (std::size_t lane = 0; lane < N; ++lane) {
            const Ray& ray = ray_of(lane < count ? lane : 0);
            for (int axis = 0; axis < 3; ++axis) numbers[axis][lane] = ray.origin[axis], numbers[3 + axis][lane] = ray.direction[axis];
        }
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = load<Vector<N>>(numbers[axis]), direction[axis] = load<Vector<N>>(numbers[3 + axis]);
        }
    }
};

/// The same with one ray per lane, one box after the other.
struct RaysThroughBoxes {
    F origin[3], inverse[3];
    M sign[3];

    explicit RaysThroughBoxes(const RayLanes<lanes>& rays) {
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = rays.origin[axis];
            const M direction = (M)rays.direction[axis];
            sign[axis] = direction & INT32_MIN;
            inverse[axis] = 1.f / (F)((M)max((F)(direction ^ sign[axis]), constant(RayThroughBoxes::least_size)) | sign[axis]);
            sign[axis] = sign[axis] < 0;
        }
    }

    /// The entry t of each ray, and a bit for each ray that enters.
    unsigned enter(const BoxPacket& packet, int box, F& enter) const {
        F leave = constant(Box::infinity);
        enter = constant(0);
        for (int axis = 0; axis < 3; ++axis) {
            const F low = constant(packet.bounds[0][axis][box]), high = constant(packet.bounds[1][axis][box]);
            enter = max(((sign[axis] ? high : low) - origin[axis]) * inverse[axis], enter);
            leave = min(((sign[axis] ? low : high) - origin[axis]) * inverse[axis], leave);
        }
        return bits(enter <= leave);
    }
};

std::size_t entrances_by_lanes(const BoxBvh& boxes, const Ray* rays, std::size_t begin, std::size_t end, std::size_t enough,
                               Entrance* entrances, std::size_t& count) {
    for (count = 0; begin < end && count < enough;) {
        const std::size_t room = (enough - count) / boxes.boxes + 1, some = std::min({std::size_t{lanes}, end - begin, room});
        const RaysThroughBoxes through(RayLanes<lanes>(some, [&](std::size_t lane) -> const Ray& { return rays[begin + lane]; }));
        for (const BoxPacket& packet : boxes.packets) {
            for (int box = 0; box < 8 && packet.bounds[0][0][box] <= packet.bounds[1][0][box]; ++box) {
                F t;
                for (unsigned entered = through.enter(packet, box, t) & ((1u << some) - 1); entered; entered &= entered - 1) {
                    const auto lane = static_cast<std::uint32_t>(__builtin_ctz(entered));
                    entrances[count++] = {packet.box[box], static_cast<std::uint32_t>(begin) + lane, t[lane]};
                }
            }
        }
        begin += some;
    }
    return begin;
}

std::size_t entrances(const BoxBvh& boxes, const Ray* rays, std::size_t begin, std::size_t end, std::size_t enough,
                      Entrance* entrances, std::size_t& count) {
    if (boxes.boxes <= few_boxes) return entrances_by_lanes(boxes, rays, begin, end, enough, entrances, count);
    Entrance* next = entrances;
    for (; begin < end && static_cast<std::size_t>(next - entrances) < enough; ++begin) {
        const RayThroughBoxes ray(rays[begin]);
        const Entrance* const last = next + boxes.boxes;
        Hit none;  // without a hit, nothing is culled
        traverse(boxes.nodes.data(), ray, none, [&](std::uint32_t packet) {
            enter(boxes.packets[packet], ray, static_cast<std::uint32_t>(begin), last, next);
        });
    }
    count = static_cast<std::size_t>(next - entrances);
    return begin;
}

void rays_through(const AffineMap& map, const Ray* rays, const Entrance* entrances, const float* start, std::size_t count,
                  Ray* mapped) {
    constexpr int some = lanes / 2;  // one register of doubles
    using Single = Vector<some>;
    using Double [[gnu::vector_size(some * 8)]] = double;
    const auto in_double = [](Single x) { return __builtin_convertvector(x, Double); };
    for (std::size_t begin = 0; begin < count; begin += some) {
        const RayLanes<some> from(some, [&](std::size_t lane) -> const Ray& { return rays[entrances[begin + lane].ray]; });
        const Double t = in_double(load<Single>(start + begin));
        Double origin[3], direction[3];
        for (int axis = 0; axis < 3; ++axis) {
            direction[axis] = in_double(from.direction[axis]);
            origin[axis] = in_double(from.origin[axis]) + t * direction[axis];
        }
        for (int i = 0; i < 3; ++i) {
            const auto& r = map.row[i];
            const Double point = r[0] * origin[0] + r[1] * origin[1] + r[2] * origin[2] + r[3];
            const Double along = r[0] * direction[0] + r[1] * direction[1] + r[2] * direction[2];
            const Single result[2] = {__builtin_convertvector(point, Single), __builtin_convertvector(along, Single)};
            for (std::size_t lane = 0; lane < some; ++lane) {
                mapped[begin + lane].origin[i] = result[0][lane], mapped[begin + lane].direction[i] = result[1][lane];
            }
        }
    }
}

}  // namespace

const BoxKernels box_kernels = {entrances, lanes < 8 ? nullptr : rays_through};

}  // namespace bob::BOB_ISA
