#include "shapes/boxes.h"

namespace bob {
namespace {

// A packet is eight boxes, like a node.
constexpr float node_cost = 1;

}  // namespace

BoxBvh build_box_bvh(std::span<const Box> boxes) {
    Bvh bvh = build_bvh(boxes, node_cost);
    std::vector<BoxPacket> packets(bvh.packets.size());
    for (std::size_t i = 0; i < packets.size(); ++i) {
        for (std::size_t lane = 0; lane < bvh.packets[i].size(); ++lane) {
            const std::uint32_t index = bvh.packets[i][lane];
            const bool absent = lane > 0 && index == bvh.packets[i][0];
            const Box box = absent ? Box{} : boxes[index];
            packets[i].box[lane] = index;
            for (int axis = 0; axis < 3; ++axis) {
                packets[i].bounds[0][axis][lane] = box.low[axis];
                packets[i].bounds[1][axis][lane] = box.high[axis];
            }
        }
    }
    return {std::move(bvh.nodes), std::move(packets), boxes.size()};
}

}  // namespace bob
