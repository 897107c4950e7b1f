/// A completion without learned weights; learn/networks/filling.py is the same in PyTorch, with the same names in the
/// same order.
#pragma once

#include <array>

#include "completion/network.h"
#include "completion/spare.h"
#include "completion/weights.h"

namespace bob {

/// Pull-push by Gaussian means of surface coverage and of the surface's gray: two pictures, so that silhouettes stay
/// sharp.
class Filling : public Network {
public:
    /// Inputs: mask and gray; output: gray; no tensors. Throws std::invalid_argument if there are any.
    explicit Filling(const Weights& weights);
    ~Filling() override;

    using Network::operator();
    void operator()(const float* planes, int height, int width, float* gray, Band band) const override;

private:
    static constexpr int levels = 6;  // the coarsest blocks have 64 x 64 pixels

    struct Images;
    struct Pixels;
    class Correction;

    /// The rows of each level that a band of pixels needs. First for `finish`, then for `push` from level to level.
    static std::array<Band, levels> needed(Band band);
    /// Counts and sums over the traced pixels of the blocks of level 2 and coarser, for rows of the coarsest.
    static void pull(const Pixels& pixels, Images& images, int begin, int end);
    /// The pictures of level 2 or coarser, for rows of the coarser level.
    static void push(int level, Images& images, int begin, int end);
    /// The pictures of level 1 and the completed gray, for rows of level 1.
    static void finish(const Pixels& pixels, Images& images, float* gray, int begin, int end);

    mutable Spare<Images> spare_;
};

}  // namespace bob
