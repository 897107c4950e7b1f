/// The default network; learn/networks/pyramid.py is the same in PyTorch, under the same names in the same order.
#pragma once

#include <cstddef>
#include <vector>

#include "completion/conv3x3.h"
#include "completion/network.h"
#include "completion/spare.h"
#include "completion/weights.h"

namespace bob {

class Pyramid : public Network {
public:
    /// As many levels, and as many channels between them, as the tensors say. What lies between the layers is kept in windows
    /// of rows that move down a large picture, so that at most `memory` bytes are needed; very wide pictures need more. The output is
    /// the same for any `memory`. Throws std::invalid_argument if a tensor is missing or does not fit the others.
    explicit Pyramid(const Weights& weights, std::size_t memory = spare_memory());
    ~Pyramid() override;

    void operator()(const float* gbuffer, int height, int width, float* gray) const override;

    /// Four blocks of the coarsest level, taken in pairs.
    [[nodiscard]] int reach() const override { return 6 << levels(); }
    /// Pairs of blocks of the coarsest level.
    [[nodiscard]] int grid() const override { return 2 << levels(); }

private:
    struct Images;
    struct Pixels;
    struct Progress;
    struct Layers {
        Conv3x3 features, finer;
    };

    [[nodiscard]] int levels() const { return static_cast<int>(layers_.size()); }

    [[nodiscard]] static std::vector<Progress> needed(int finished, int height, int levels);

    // Each goes on from `done` to `next`, which are of the level; rows are the level's.

    /// What the traced pixels say about the blocks of level 2 and coarser, for rows of the coarsest.
    void pull(const Pixels& pixels, Images& images, int begin, int end) const;
    /// The gray, the inputs and the surface of a level, of the coarser level's if there is one.
    void know(int level, const Pixels& pixels, Images& images, const Progress& done, const Progress& next) const;
    /// What is known of each pixel, for level 1.
    void compare_pixels(const Pixels& pixels, Images& images, int begin, int end) const;
    void finish(const Images& images, int begin, int end, int height, int width, float* gray) const;

    std::vector<Layers> layers_;  // of level 1 first
    std::size_t memory_;
    mutable Spare<Images> spare_;
};

}  // namespace bob
