/// Images of several channels, laid out for 3x3 convolutions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include "completion/rows.h"

namespace bob {

/// Number of blocks of two in `size` pixels; the last may have one only.
constexpr int half(int size) { return (size + 1) / 2; }

struct FreeAligned {
    void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
};
using AlignedFloats = std::unique_ptr<float[], FreeAligned>;

/// Uninitialized memory for `count` floats, aligned to a cache line.
inline AlignedFloats aligned_floats(std::size_t count) { return AlignedFloats(new (std::align_val_t{64}) float[count]); }

/// `channels` planes of float32, each with a border of zeros, so that convolutions need no special case at the edges.
///
/// Rows are padded to whole vectors: kernels may write past the width up to `row_end` and then call `clear_tail`. The
/// border before a row is also the border after the row above. The padding is zero, as are pixels until they are written.
///
/// A large image keeps only a window of rows, which moves down: row y replaces row y - `window`. Two, four or eight
/// rows starting at a multiple of their number are contiguous.
class Planes {
public:
    /// Allocates all rows, or at least `window` of them.
    Planes(int channels, int height, int width, int window)
        : channels_(channels), height_(height), width_(width), window_(std::min((window + 7) / 8 * 8, height)),
          row_end_((width + 31) / 32 * 32), stride_(static_cast<std::size_t>(border + row_end_)),
          plane_(stride_ * static_cast<std::size_t>(window_ + 1)) {
        const std::size_t size = plane_ * static_cast<std::size_t>(channels) + border;
        data_ = aligned_floats(size);
        std::fill_n(data_.get(), size, 0.f);
    }
    Planes(int channels, int height, int width) : Planes(channels, height, width, height) {}

    [[nodiscard]] int channels() const { return channels_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int width() const { return width_; }
    /// Floats from one row to the next, and from one channel to the next.
    [[nodiscard]] std::size_t row_stride() const { return stride_; }
    [[nodiscard]] std::size_t plane_stride() const { return plane_; }

    /// The first pixel of a row. Pixel -1 and row -1 exist, as do the pixel and the row past the far ends.
    [[nodiscard]] float* row(int channel, int y) {
        const int place = y < 0 || y >= height_ ? window_ : y % window_;  // the last row is the border
        return data_.get() + plane_ * static_cast<std::size_t>(channel) + stride_ * static_cast<std::size_t>(place) + border;
    }
    [[nodiscard]] const float* row(int channel, int y) const { return const_cast<Planes*>(this)->row(channel, y); }

    /// Offset in floats from row y to row `other`.
    [[nodiscard]] std::ptrdiff_t offset(int y, int other) const { return row(0, other) - row(0, y); }

    /// Zeroes the padding of a row. In the row below the last, which kernels of two rows may write, zeroes everything.
    void clear_tail(int channel, int y) { clear_tail(channel, y, 0, width_); }
    /// Zeroes only the padding next to or below columns `begin` to `end`, the only ones written.
    void clear_tail(int channel, int y, int begin, int end) {
        float* const first = row(channel, y);
        std::fill(first + (y < height_ ? std::min(end, width_) : begin), first + (end < width_ ? end : row_end_), 0.f);
    }

private:
    static constexpr int border = 16;  // floats: convolutions need one, the rest keeps rows aligned

    int channels_, height_, width_, window_, row_end_;
    std::size_t stride_, plane_;
    AlignedFloats data_;
};

inline ConstRows rows_of(const Planes& planes, int channel, int y) {
    return {planes.row(channel, y), planes.offset(y, y - 1), planes.offset(y, y + 1), planes.plane_stride()};
}
inline Rows rows_of(Planes& planes, int channel, int y) {
    return {planes.row(channel, y), planes.offset(y, y - 1), planes.offset(y, y + 1), planes.plane_stride()};
}

/// Row y and its neighbours, from `column` on, for doubling; the first and the last row repeat past the edges.
inline Doubled doubled_rows(const Planes& planes, int channel, int y, int column = 0) {
    const auto row = [&](int at) { return planes.row(channel, std::clamp(at, 0, planes.height() - 1)) + column; };
    return {row(y - 1), row(y), row(y + 1)};
}

/// Sets the pixels -1 and width of a row for doubling.
inline void repeat_edges(float* row, int width) {
    row[-1] = row[0];
    row[width] = row[width - 1];
}

}  // namespace bob
