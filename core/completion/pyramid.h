/// The default network; learn/networks/pyramid.py is the same in PyTorch, with the same names in the same order.
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
    /// The tensors determine the number of levels and of channels between them.
    ///
    /// Images between layers are windows of rows that move down a large picture, within `memory` bytes; wide pictures
    /// need more. The output is the same for any `memory`. Throws std::invalid_argument if a tensor is missing or does
    /// not fit the others.
    explicit Pyramid(const Weights& weights, std::size_t memory = 8 << 20);
    ~Pyramid() override;

    using Network::operator();
    void operator()(const float* gbuffer, int height, int width, float* gray, Band band) const override;

private:
    struct Images;
    struct Finest;
    struct Tile;
    struct Pixels;
    struct Progress;
    struct Layers {
        Conv3x3 features, finer;
    };

    [[nodiscard]] int levels() const { return static_cast<int>(layers_.size()); }
    [[nodiscard]] const Layers& layers(int level) const { return layers_[static_cast<std::size_t>(level - 1)]; }

    [[nodiscard]] std::vector<Progress> needed(int finished, int height) const;
    [[nodiscard]] std::vector<Progress> first_needed(int begin) const;

    // Rows are in units of the level.

    /// Sums over the traced pixels of the blocks of level 2 and coarser, for rows of the coarsest.
    void pull(const Pixels& pixels, Images& images, int begin, int end) const;
    /// The surface of level 2 or coarser; from `done` to `next`. It is 0 on certain background.
    void find_surface(int level, Images& images, const Progress& done, const Progress& next) const;
    /// Reduces level 1's needed parts to where the surface of level 2 is not 0; from `done` to `next`, in its rows.
    static void find_needed(Images& images, int done, int next);
    /// The gray and features of level 2 or coarser; from `done` to `next`.
    void know(int level, Images& images, const Progress& done, const Progress& next) const;
    /// Completes a tile of level 1 from the coarser levels.
    void complete(const Tile& tile, const Pixels& pixels, const Images& images, float* gray) const;

    std::vector<Layers> layers_;  // level 1 first
    std::size_t memory_;
    mutable Spare<Images> spare_;
};

}  // namespace bob
