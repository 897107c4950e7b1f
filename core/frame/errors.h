/// 1 - SSIM by the share of the pixels that are traced, as `bench/frame_errors.py --write` measured it.
#pragma once

#include <iterator>

namespace bob::frame_errors {

constexpr float shares[] = {0.00100f, 0.00300f, 0.0100f, 0.0300f, 0.100f, 0.300f};
constexpr float squares_filling[] = {0.332f, 0.293f, 0.173f, 0.0504f, 0.0115f, 0.000353f};
constexpr float adaptive_filling[] = {0.164f, 0.138f, 0.0748f, 0.0346f, 0.00552f, 0.000236f};
constexpr float adaptive_small[] = {0.162f, 0.130f, 0.0699f, 0.0333f, 0.00555f, 0.000236f};
constexpr float adaptive_default[] = {0.158f, 0.128f, 0.0663f, 0.0323f, 0.00553f, 0.000236f};
constexpr float enlarged[] = {0.00f, 0.0166f, 0.0203f, 0.0296f, 0.0357f, 0.0443f, 0.0584f, 0.0706f, 0.0827f, 0.103f};  // by MovingScale::scales
constexpr float parallaxes[] = {0.00410f, 0.0164f, 0.0328f, 0.0816f, 0.236f, 0.497f};
constexpr float reproject[][std::size(shares)] = {
    {0.0808f, 0.0542f, 0.0311f, 0.0117f, 0.00147f, 2.06e-05f},
    {0.0858f, 0.0612f, 0.0386f, 0.0155f, 0.00137f, 9.11e-06f},
    {0.0951f, 0.0721f, 0.0516f, 0.0243f, 0.00212f, 5.19e-06f},
    {0.118f, 0.0923f, 0.0707f, 0.0371f, 0.00394f, 6.22e-05f},
    {0.147f, 0.125f, 0.0952f, 0.0523f, 0.0177f, 0.000276f},
    {0.162f, 0.137f, 0.0749f, 0.0342f, 0.00521f, 0.000200f},
};

}  // namespace bob::frame_errors
