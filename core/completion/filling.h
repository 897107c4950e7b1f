/// A completion without learning; learn/networks/filling.py is the same in PyTorch, under the same names in the same order.
#pragma once

#include <array>

#include "completion/network.h"
#include "completion/spare.h"
#include "completion/weights.h"

namespace bob {

/// Pull-push by Gaussian means, of how likely a pixel shows a surface and of the surface's gray: two pictures, so that silhouettes
/// stay sharp.
class Filling : public Network {
public:
    /// Of the layouts mask and gray, and gray; no tensors. Throws std::invalid_argument if there are any.
    explicit Filling(const Weights& weights);
    ~Filling() override;

    using Network::operator();
    void operator()(const float* planes, int height, int width, float* gray, Band band) const override;

private:
    static constexpr int levels = 6;  // blocks of the coarsest have 64 x 64 pixels

    struct Images;
    struct Pixels;
    class Correction;

    /// For a band of pixels, the rows for which `finish` is called, and then `push` for each level.
    static std::array<Band, levels> needed(Band band);
    /// Counts and sums over the traced pixels of the blocks of level 2 and coarser ones, for rows of the coarsest.
    static void pull(const Pixels& pixels, Images& images, int begin, int end);
    /// The pictures of level 2 or a coarser one, for rows of the coarser level.
    static void push(int level, Images& images, int begin, int end);
    /// Those of level 1, and the completed gray, for rows of level 1.
    static void finish(const Pixels& pixels, Images& images, float* gray, int begin, int end);

    mutable Spare<Images> spare_;
};

}  // namespace bob
