/// 1 - SSIM by the share of the pixels that are traced, as `bench/frame_errors.py --write` measured it.
#pragma once

#include <iterator>

namespace bob::frame_errors {

constexpr double shares[] = {0.001, 0.003, 0.01, 0.03, 0.1, 0.3};
constexpr double squares_filling[] = {0.332, 0.293, 0.173, 0.0504, 0.0115, 0.000353};
constexpr double adaptive_filling[] = {0.164, 0.138, 0.0748, 0.0346, 0.00552, 0.000236};
constexpr double adaptive_small[] = {0.162, 0.13, 0.0699, 0.0333, 0.00555, 0.000236};
constexpr double adaptive_default[] = {0.158, 0.128, 0.0663, 0.0323, 0.00553, 0.000236};
constexpr double parallaxes[] = {0.0041, 0.0164, 0.0328, 0.0816};
constexpr double reproject[][std::size(shares)] = {
    {0.0808, 0.0542, 0.0311, 0.0117, 0.00147, 2.06e-05},
    {0.0858, 0.0612, 0.0386, 0.0155, 0.00137, 9.11e-06},
    {0.0951, 0.0721, 0.0516, 0.0243, 0.00212, 5.19e-06},
    {0.118, 0.0923, 0.0707, 0.0371, 0.00394, 6.22e-05},
};

}  // namespace bob::frame_errors
