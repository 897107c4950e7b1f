/// The default network; learn/networks/pyramid.py is the same in PyTorch, under the same names in the same order.
#pragma once

#include <vector>

#include "complete/conv3x3.h"
#include "complete/spare.h"
#include "complete/weights.h"

namespace bob {

class Pyramid {
public:
    /// As many levels, and as many channels between them, as the tensors say. Throws std::invalid_argument if a tensor is
    /// missing or does not fit the others.
    explicit Pyramid(const Weights& weights);
    ~Pyramid();

    /// gbuffer: (5, height, width), mask, gray, depth, normal x, normal y; gray: (height, width), the network's own
    /// output at every pixel. Any size; from several threads at once.
    void operator()(const float* gbuffer, int height, int width, float* gray) const;

    /// Bands of a picture that start at a multiple of so many rows have the same blocks, computed in the same pairs of rows.
    [[nodiscard]] int rows() const { return 2 << levels(); }
    /// How many rows away, at most, an input can change the output: two convolutions at each level reach two of its
    /// blocks, and a third at level 1 is where the doubled picture comes from. With the blocks' own rows, 4 of the coarsest.
    [[nodiscard]] int reach() const { return 4 << levels(); }
    /// Of memory while it runs.
    [[nodiscard]] int bytes_per_pixel() const;

private:
    struct Images;
    struct Layers {
        Conv3x3 features, finer;
    };

    [[nodiscard]] int levels() const { return static_cast<int>(layers_.size()); }

    /// What the traced pixels say about the blocks of every level.
    void pull(const float* gbuffer, int height, int width, Images& images) const;
    /// The gray, the inputs and the surface of a level, of the coarser level's if there is one.
    void know(int level, Images& images) const;
    /// What is known of each pixel, for level 1.
    void compare_pixels(Images& images) const;
    void finish(const Images& images, int height, int width, float* gray) const;

    std::vector<Layers> layers_;  // of level 1 first
    mutable Spare<Images> spare_;
};

}  // namespace bob
