#include "shapes/boxes.h"
#include "shapes/bvh_traversal.h"

namespace bob::BOB_ISA {
namespace {

/// Adds the boxes of a packet that the ray enters.
///
/// As `enter_boxes`, but rounded alike in all instruction sets: without fma. A ray whose t overflow may find packets twice;
/// never does it list more than there are boxes.
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

std::size_t entrances(const BoxBvh& boxes, const Ray* rays, std::size_t begin, std::size_t end, std::size_t enough,
                      Entrance* entrances, std::size_t& count) {
    Entrance* next = entrances;
    for (; begin < end && static_cast<std::size_t>(next - entrances) < enough; ++begin) {
        const RayThroughBoxes ray(rays[begin]);
        const Entrance* const last = next + boxes.boxes;
        if (boxes.packets.size() == 1) {  // a tree would cost few boxes a fifth
            enter(boxes.packets[0], ray, static_cast<std::uint32_t>(begin), last, next);
            continue;
        }
        Hit none;  // no hit rules out what lies behind it
        traverse(boxes.nodes.data(), ray, none, [&](std::uint32_t packet) {
            enter(boxes.packets[packet], ray, static_cast<std::uint32_t>(begin), last, next);
        });
    }
    count = static_cast<std::size_t>(next - entrances);
    return begin;
}

}  // namespace

const BoxKernels box_kernels = {entrances};

}  // namespace bob::BOB_ISA
