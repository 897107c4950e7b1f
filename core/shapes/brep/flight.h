/// The state of a ray between pieces. Only for *_kernels.cpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "shapes/brep/beam.h"
#include "shapes/brep/subdivision.h"

namespace bob::BOB_ISA {

/// A ray on its way from piece to piece. At each piece whose box it enters, it waits for the results of Newton's
/// method.
class Flight {
public:
    /// Starts with the subtrees of a beam that this ray enters; false if it enters no subtree.
    bool begin(const Pieces& pieces, const Ray& ray, std::uint32_t number, const Beam& beam, std::size_t in_beam) {
        left_ = beam.enter(in_beam, entry_t_);
        if (!left_) return false;
        std::copy_n(beam.entries().child, 8, entries_);
        way_.clear();
        set_out(pieces, ray, number);
        return true;
    }

    /// Starts with the whole tree.
    void begin(const Pieces& pieces, const Ray& ray, std::uint32_t number) {
        left_ = 0;
        go_down(pieces.nodes[0], ray);
        set_out(pieces, ray, number);
    }

    [[nodiscard]] std::uint32_t number() const { return number_; }
    [[nodiscard]] Hit result() const { return nearest_.result(); }

    /// Continues until a part of a patch has to be searched; false at the end.
    bool go_on(const Pieces& pieces) {
        while (true) {
            if (open_count_ && enter_[lane_] < nearest_.hit.t) return true;
            open_count_ = 0;
            if (!next_piece(pieces)) return false;
            const PiecePacket& packet = pieces.packets[packet_ - 1];
            open_[open_count_++] = {whole(packet), 0};
            looks_ = !(std::fabs(d_[2][lane_]) > may_fold(packet));
        }
    }

    [[nodiscard]] const Patch& patch(const Pieces& pieces) const { return pieces.patches[patch_index(pieces)]; }

    [[nodiscard]] bool looks() const { return looks_; }

    void ask(const Pieces& pieces, Newton<lanes>& newton) const {
        const int k = lane_;
        const UvRange& part = open_[open_count_ - 1].part;
        const auto to = [&](float x, int along) { return part.low[along] + (0.5f + 0.5f * x) * part.size[along]; };
        const std::uint32_t index = patch_index(pieces);
        if (looks_) {
            const Float4 normal = this->normal(pieces);
            newton.add(*ray_, LocalRay(*ray_, pieces.patches[index], enter_[k]), index, part, to(0, 0), to(0, 1), &normal);
        } else {
            const float t = clamp(-o_[2][k] / d_[2][k], enter_[k], leave_[k]);
            const float x = clamp(o_[0][k] + t * d_[0][k], -1, 1), y = clamp(o_[1][k] + t * d_[1][k], -1, 1);
            newton.add(*ray_, LocalRay(*ray_, pieces.patches[index], t), index, part, to(x, 0), to(y, 1));
        }
    }

    /// Takes the result for the part that the ray waits for.
    void take(const Pieces& pieces, Workspace& workspace, const Newton<lanes>& newton, int lane) {
        const Open last = open_[--open_count_];
        const auto found = newton.found(lane);
        if (found == Newton<lanes>::Found::hit) return nearest_.offer(piece(pieces, last.part), newton.solution(lane));
        if (!looks_) {
            // Near tangency, a root outside may be the second of two.
            const bool only_root = std::fabs(d_[2][lane_]) > 2 * may_fold(pieces.packets[packet_ - 1]);
            if (found == Newton<lanes>::Found::nothing && only_root) return;
            looks_ = true;
            ++open_count_;
        } else if (found == Newton<lanes>::Found::unclear) {
            if (last.cuts == most_cuts) return subdivide(pieces, last.part, workspace);
            const int along = newton.cut_along_v(lane);
            for (int half = 0; half < 2; ++half) {
                Open& part = open_[open_count_++] = last;
                ++part.cuts;
                part.part.size[along] *= 0.5f;
                if (half) part.part.low[along] += part.part.size[along];
            }
        }
    }

private:
    [[nodiscard]] float may_fold(const PiecePacket& packet) const {
        return packet.lean[0][lane_] * std::fabs(d_[0][lane_]) + packet.lean[1][lane_] * std::fabs(d_[1][lane_]);
    }

    [[nodiscard]] std::uint32_t patch_index(const Pieces& pieces) const { return pieces.packets[packet_ - 1].patch[lane_]; }

    [[nodiscard]] UvRange whole(const PiecePacket& packet) const {
        return {{packet.low[0][lane_], packet.low[1][lane_]}, {packet.size[0][lane_], packet.size[1][lane_]}};
    }

    [[nodiscard]] Piece piece(const Pieces& pieces, const UvRange& part) const {
        const PiecePacket& packet = pieces.packets[packet_ - 1];
        const std::uint32_t patch = packet.patch[lane_], trim = packet.trim[lane_];
        return {pieces.patches[patch], patch, 8 * (packet_ - 1) + static_cast<std::uint32_t>(lane_),
                trim == PiecePacket::no_trim ? nullptr : &pieces.trims[trim], whole(packet), part};
    }

    [[nodiscard]] Float4 normal(const Pieces& pieces) const {
        const auto& z = pieces.packets[packet_ - 1].to_box[2];
        return Float4{z[0][lane_], z[1][lane_], z[2][lane_], 0};
    }

    void subdivide(const Pieces& pieces, const UvRange& part, Workspace& workspace) {
        const Piece piece = this->piece(pieces, part);
        const LocalRay local(*ray_, piece.patch, enter_[lane_]);
        Subdivision(pieces, piece, *ray_, local, nearest_, normal(pieces), workspace).find();
    }

    void set_out(const Pieces& pieces, const Ray& ray, std::uint32_t number) {
        ray_ = &ray, number_ = number;
        new (&nearest_) Nearest(pieces, ray);
        packet_ = end_ = 0;
        entered_ = 0;
        open_count_ = 0;
    }

    void go_down(const BvhNode& node, const Ray& ray) {
        new (&boxes_) RayThroughBoxes(ray);  // in place: after partial stores, copying it whole is slow
        way_.begin(node, boxes_);
    }

    bool next_leaf(const Pieces& pieces, ChildRef& leaf) {
        while (!way_.next_leaf(pieces.nodes.data(), boxes_, nearest_.hit.t, leaf)) {
            if (!left_) return false;
            const int entry = __builtin_ctz(left_);
            left_ &= left_ - 1;
            if (entry_t_[entry] > nearest_.hit.t) continue;
            leaf = entries_[entry];
            if (leaf.is_leaf()) return true;
            go_down(pieces.nodes[leaf.node_index()], *ray_);
        }
        return true;
    }

    /// The next piece whose box the ray enters before its nearest hit.
    bool next_piece(const Pieces& pieces) {
        while (true) {
            while (entered_) {
                lane_ = __builtin_ctz(entered_);
                for (unsigned others = entered_ & (entered_ - 1); others; others &= others - 1) {
                    const int other = __builtin_ctz(others);
                    if (enter_[other] < enter_[lane_]) lane_ = other;
                }
                entered_ &= ~(1u << lane_);
                if (enter_[lane_] < nearest_.hit.t) return true;
            }
            if (packet_ == end_) {
                ChildRef leaf;
                if (!next_leaf(pieces, leaf)) return false;
                packet_ = leaf.first_packet(), end_ = packet_ + leaf.packets();
            }
            enter_boxes_of(pieces.packets[packet_++]);
        }
    }

    void enter_boxes_of(const PiecePacket& packet) {
        entered_ = 0;
        for (int i = 0; i < 8; i += width) {
            Floats enter = broadcast<Floats>(0.f), leave = broadcast<Floats>(std::numeric_limits<float>::infinity());
            for (int axis = 0; axis < 3; ++axis) {
                const auto& row = packet.to_box[axis];
                Floats o = load<Floats>(&row[3][i]), d{};
                for (int k = 2; k >= 0; --k) {
                    const Floats x = load<Floats>(&row[k][i]);
                    o = fma(x, broadcast<Floats>(ray_->origin[k]), o);
                    d = fma(x, broadcast<Floats>(ray_->direction[k]), d);
                }
                const Floats half = axis < 2 ? load<Floats>(&packet.half[axis][i]) : broadcast<Floats>(1.f);
                const Floats inverse = 1.f / d;
                const Floats a = (-half - o) * inverse, b = (half - o) * inverse;
                enter = max(min(a, b), enter);
                leave = min(max(a, b), leave);
                store(&o_[axis][i], o), store(&d_[axis][i], d);
            }
            store(&enter_[i], enter), store(&leave_[i], leave);
            entered_ |= bits((enter <= leave) & (enter < broadcast<Floats>(nearest_.hit.t))) << i;
        }
    }

    const Ray* ray_ = nullptr;
    Nearest nearest_{};
    std::uint32_t number_ = 0;
    // The beam's subtrees that the ray enters, and a bit for each one left.
    ChildRef entries_[8]{};
    unsigned left_ = 0;
    alignas(32) float entry_t_[8];
    // The traversal of one of them, or of the whole tree.
    RayThroughBoxes boxes_{Ray{}};
    // In the current leaf: the next packet, and the end.
    std::uint32_t packet_ = 0, end_ = 0;
    // In the last packet: the boxes entered and their t, and the current lane. Also the ray's origin and direction
    // relative to the boxes.
    unsigned entered_ = 0;
    int lane_ = 0;
    // In the current piece: its open parts, and whether the ray may intersect it more than once. After this number of
    // cuts, subdivision takes over: it derives the control points of smaller parts from larger ones.
    static constexpr int most_cuts = 4;
    struct Open {
        UvRange part;
        int cuts;
    };
    Open open_[most_cuts + 1];
    int open_count_ = 0;
    bool looks_ = false;
    alignas(32) float enter_[8], leave_[8], o_[3][8], d_[3][8];
    Traversal way_;
};

}  // namespace bob::BOB_ISA
