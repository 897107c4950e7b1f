/// Inner loops after a network, one variant for each instruction set. Rows are written in whole vectors, into the
/// padding of `Planes`.
#pragma once

#include <cstddef>

#include "base/isa.h"
#include "completion/rows.h"

namespace bob {

/// Replaces the contrast of a black node.
constexpr float black = -1;

/// A row of nodes, the estimates of pixels. The first plane is the maximum contrast of a node's sources: 0 where
/// traced, infinity where unknown. The next planes are the values of one component or three. If all of them are 0, as
/// in the background, the first may be `black`, and the values need not be read.
template <class T>
struct NodesIn {
    T* contrast;
    std::size_t plane;  // floats from plane to plane

    [[nodiscard]] T* value(int component) const { return contrast + static_cast<std::size_t>(component + 1) * plane; }
};
using Nodes = NodesIn<float>;
using ConstNodes = NodesIn<const float>;

/// A row of the G-buffer, or every n-th of its pixels: the mask, and the values of a channel.
struct TracedRow {
    const float *mask, *value;
    std::size_t plane;  // floats from component to component
    int columns;
};

/// Nodes at every other pixel of a row, and the rows around them in opposite pairs. Node i lies at 2i + `phase`.
struct NodesBetween {
    int components, phase;
    bool by_pairs;
    ConstNodes corners[4];
    TracedRow traced;
    float weight_per_contrast;
    Nodes to;
};

/// A row of a picture, blended with the nodes of its even and its odd columns.
struct ImprovedRow {
    int components;
    ConstNodes nodes[2];
    const float* mask;
    float weight_per_contrast;
    float* output;
    std::size_t plane;  // floats from component to component
    float* weight;      // weights of the nodes; may be null
    int columns;
    bool put_back;      // whether traced pixels are restored
};

struct InterpolationKernels {
    /// Copies every other pixel of a row, from column `phase` on, to planes of the mask and components. Values are
    /// copied only where traced, and may overlap the source. `some` is the range written, from a whole vector on, here
    /// and below.
    void (*halve)(const TracedRow& from, int components, int phase, float* to, std::size_t plane, Stretch some);
    /// Computes nodes. A traced pixel is its own node. By pairs, other nodes are the mean of the opposite pair of lower
    /// contrast; unknown if that contrast is too large, a corner is unknown, or the other pair lies off to one side.
    /// Otherwise they are the mean of all four corners; unknown if their contrast is too large or a corner is unknown.
    void (*between)(const NodesBetween& row, Stretch some);
    /// Interleaves the values of two rows.
    void (*zip)(const float* even, const float* odd, float* to, Stretch some);
    /// Moves untraced pixels towards their nodes; optionally restores the others.
    void (*improve)(const ImprovedRow& row, Stretch some);
    /// Restores traced pixels.
    void (*put_back)(const TracedRow& traced, int components, float* output, std::size_t plane);
    /// Keeps the values of traced pixels; clamps others to the channel's range, and NaN to its low end.
    void (*keep)(const float* mask, const float* traced, float low, float high, float* output, std::size_t pixels);
};

BOB_DECLARE_KERNELS(InterpolationKernels, interpolation_kernels)

}  // namespace bob
