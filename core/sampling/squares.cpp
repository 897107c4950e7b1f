#include "sampling/squares.h"

#include <algorithm>
#include <utility>

#include "sampling/order.h"

namespace bob {
namespace {

constexpr std::uint32_t strong = 64, visible = 24, faint = 8, any = 0;

}  // namespace

// Details found in squares of low contrast are refined before more such squares are divided.
constexpr SquaresOrder::Division SquaresOrder::by_contrast[] = {
    {8, strong}, {4, strong}, {2, strong}, {8, visible}, {4, visible}, {2, visible}, {8, faint}, {4, faint}, {2, faint},
    {8, any},    {4, faint},  {2, faint},  {4, any},     {2, faint},   {2, any},
};

// Each pass halves the contrast threshold; squares of half the side need 1.5 to 6 times the contrast. At 5 %, over 28
// models, 1 - SSIM is .0109, and .0147 by contrast. It is .0111 with squares of 32 first, and .0120 with one threshold
// for squares of 8, 4 and 2 pixels.
constexpr SquaresOrder::Division SquaresOrder::by_priority[] = {
    {16, 8}, {8, 48}, {4, 96}, {2, 160}, {16, 4}, {8, 24}, {4, 48}, {2, 96}, {16, 1}, {8, 12}, {4, 32}, {2, 48},
    {16, any}, {8, 6}, {4, 16}, {2, 24}, {8, any}, {4, faint}, {2, faint}, {4, any}, {2, any},
};

SquaresOrder::Squares::Squares(std::uint32_t side) : side(side), first(std::uint32_t{lattice_first} % side) {}

SquaresOrder::SquaresOrder(std::uint32_t height, std::uint32_t width, const float* traced, First first)
    : RoundOrder(height, width), is_decided_(std::size_t{height} * width) {
    if (first == First::contrast) divisions_ = by_contrast;
    else divisions_ = by_priority;
    if (traced) std::transform(traced, traced + is_decided_.size(), is_decided_.begin(), [](float mask) { return mask != 0; });
}

std::span<const Pixel> SquaresOrder::next(const Layout& layout, const float* planes) {
    round_.clear();
    if (rounds_ == 0) {
        ++rounds_;
        const Squares squares(divisions_[0].side);
        for (std::uint32_t row = squares.first; row < height_; row += squares.side) {
            for (std::uint32_t column = squares.first; column < width_; column += squares.side) decide(row, column);
        }
    }
    for (; round_.empty() && rounds_ <= divisions_.size(); ++rounds_) {
        const Division& division = divisions_[rounds_ - 1];
        divide(Squares(division.side), division.contrast, layout, planes);
    }
    return round_;
}

void SquaresOrder::divide(const Squares& squares, std::uint32_t contrast, const Layout& layout, const float* planes) {
    const LookReader look_at(layout, planes, is_decided_.size());
    const std::uint32_t lines = squares.lines(height_), across = squares.lines(width_) + 1;
    corners_above_.assign(across + 1, Look{}), corners_below_.assign(across + 1, Look{});
    differs_.assign(across, 0), either_.resize(across);
    for (std::uint32_t y = 0; y <= lines; ++y) {
        differs_above_.swap(differs_);
        compare(squares, y, contrast, look_at);
        const std::uint32_t below = squares.first + y * squares.side, middle = below - squares.side / 2;  // or far outside
        if (y > 0) {
            std::ranges::transform(differs_above_, differs_, either_.begin(), [](std::uint8_t a, std::uint8_t b) { return a | b; });
            decide_row(squares, below - squares.side, either_);
        }
        if (middle < height_) decide_row(squares, middle, differs_);
    }
}

void SquaresOrder::compare(const Squares& squares, std::uint32_t y, std::uint32_t contrast, const LookReader& look_at) {
    differs_.assign(squares.lines(width_) + 1, contrast == any);
    if (contrast == any) return;
    corners_above_.swap(corners_below_);
    const std::uint32_t row = squares.first + y * squares.side;
    for (std::size_t x = 0; x + 1 < differs_.size(); ++x) {
        const std::size_t i = std::size_t{row} * width_ + squares.first + x * squares.side;
        corners_below_[x + 1] = row < height_ && is_decided_[i] != 0 ? look_at(i) : Look{};
    }
    for (std::size_t x = 0; x < differs_.size(); ++x) {
        Look square = corners_above_[x];
        for (const Look& corner : {corners_above_[x + 1], corners_below_[x], corners_below_[x + 1]}) square.add(corner);
        differs_[x] = square.contrast() >= contrast;
    }
}

void SquaresOrder::decide_row(const Squares& squares, std::uint32_t row, const std::vector<std::uint8_t>& divided) {
    for (std::uint32_t x = 0; x < divided.size(); ++x) {
        const std::uint32_t right = squares.first + x * squares.side, left = right - squares.side, middle = right - squares.side / 2;
        if (x > 0 && (divided[x - 1] | divided[x])) decide(row, left);
        if (divided[x] && middle < width_) decide(row, middle);
    }
}

void SquaresOrder::decide(std::uint32_t row, std::uint32_t column) {
    std::uint8_t& is_decided = is_decided_[std::size_t{row} * width_ + column];
    if (is_decided) return;
    is_decided = 1;
    round_.push_back({static_cast<std::int32_t>(row), static_cast<std::int32_t>(column)});
}

std::size_t SquaresOrder::bytes() const {
    return is_decided_.capacity() + round_.capacity() * sizeof(Pixel) + (corners_above_.capacity() + corners_below_.capacity()) * sizeof(Look) +
           differs_.capacity() + differs_above_.capacity() + either_.capacity();
}

}  // namespace bob
