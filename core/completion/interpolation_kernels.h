/// The inner loops of what follows a network, one variant for each instruction set. Rows are written in whole vectors, as those of
/// `Planes` have room for.
#pragma once

#include <cstddef>

#include "base/isa.h"
#include "completion/rows.h"

namespace bob {

/// In place of a node's contrast.
constexpr float black = -1;

/// A row of what pixels are taken for, so-called nodes: by how much what each was made of differs at most, 0 where traced and infinity
/// where nothing is known, and the values of one component or three in the planes that follow. Where all of that is 0, as the background
/// is, the first may be `black`, so that no values need to be read.
template <class T>
struct NodesIn {
    T* contrast;
    std::size_t plane;  // floats from a plane to the next

    [[nodiscard]] T* value(int component) const { return contrast + static_cast<std::size_t>(component + 1) * plane; }
};
using Nodes = NodesIn<float>;
using ConstNodes = NodesIn<const float>;

/// A row of the G-buffer, or of every so many of its pixels: the mask, and what a channel showed.
struct TracedRow {
    const float *mask, *value;
    std::size_t plane;  // floats from a component to the next
    int columns;
};

/// Nodes at every other pixel of a row, and those between which they lie, opposite ones in pairs: node i lies at 2i + `phase`.
struct NodesBetween {
    int components, phase;
    bool by_pairs;
    ConstNodes corners[4];
    TracedRow traced;
    float weight_per_contrast;
    Nodes to;
};

/// A row of a picture that is improved by the nodes of its even and its odd columns.
struct ImprovedRow {
    int components;
    ConstNodes nodes[2];
    const float* mask;
    float weight_per_contrast;
    float* output;
    std::size_t plane;  // floats from a component to the next
    float* weight;      // how far the nodes count; may be null
    int columns;
    bool put_back;      // whether traced pixels become as they were traced
};

struct InterpolationKernels {
    /// Every other pixel of a row, from the column `phase` on, values where there are traced ones alone: to a plane of the mask and those
    /// of the components, which may be those that are read. `some` of what is written, from whole vectors on, as in all that follow.
    void (*halve)(const TracedRow& from, int components, int phase, float* to, std::size_t plane, Stretch some);
    /// Nodes: of traced pixels these. Of others, by pairs, the mean of the two opposite corners that differ less, unless these differ too
    /// much, a corner is unknown, or the two others lie off on the same side; else the mean of all four, unless these differ too much or
    /// one is unknown.
    void (*between)(const NodesBetween& row, Stretch some);
    /// The values of two rows in turn; `some` of these.
    void (*zip)(const float* even, const float* odd, float* to, Stretch some);
    /// Moves pixels that were not traced towards their nodes, and may put the others back.
    void (*improve)(const ImprovedRow& row, Stretch some);
    /// Puts traced pixels back.
    void (*put_back)(const TracedRow& traced, int components, float* output, std::size_t plane);
    /// Traced pixels keep their values, the others are clamped to a channel's range, and NaN to its low end.
    void (*keep)(const float* mask, const float* traced, float low, float high, float* output, std::size_t pixels);
};

BOB_DECLARE_KERNELS(InterpolationKernels, interpolation_kernels)

}  // namespace bob
