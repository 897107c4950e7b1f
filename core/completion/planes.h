/// Images of several channels, laid out for 3x3 convolutions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

#include "completion/rows.h"

namespace bob {

/// Blocks of two in so many pixels; the last one may have one alone.
constexpr int half(int size) { return (size + 1) / 2; }

struct FreeAligned {
    void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
};
using AlignedFloats = std::unique_ptr<float[], FreeAligned>;

/// Memory for so many floats, from the begin of a cache line on, not set.
inline AlignedFloats aligned_floats(std::size_t count) { return AlignedFloats(new (std::align_val_t{64}) float[count]); }

/// `channels` planes of float32 with a border of zeros around each, so that convolutions need no special case at the
/// edges. Rows are padded to whole vectors: kernels may write beyond the width as far as `row_end` and then call
/// `clear_tail`; the border before a row is also the border after the row above. What was not written is not set, but zero beyond
/// the width.
///
/// Of a large image only a window of rows is kept, which moves down it: row y lies where row y - `window` lay. Two, four or eight
/// rows from a multiple of their number on follow each other in memory.
class Planes {
public:
    /// Of all rows, or of at least `window` of them.
    Planes(int channels, int height, int width, int window)
        : channels_(channels), height_(height), width_(width), window_(std::min((window + 7) / 8 * 8, height)),
          row_end_((width + 31) / 32 * 32), stride_(static_cast<std::size_t>(border + row_end_)),
          plane_(stride_ * static_cast<std::size_t>(window_ + 1)) {
        const std::size_t size = plane_ * static_cast<std::size_t>(channels) + border;
        data_ = aligned_floats(size);
        for (int c = 0; c < channels; ++c) {
            for (int y = 0; y < window_; ++y) {
                std::fill(row(c, y) - border, row(c, y), 0.f);
                clear_tail(c, y);
            }
            std::fill_n(row(c, -1) - border, stride_, 0.f);
        }
        std::fill_n(data_.get() + size - border, border, 0.f);
    }
    Planes(int channels, int height, int width) : Planes(channels, height, width, height) {}

    [[nodiscard]] int channels() const { return channels_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int width() const { return width_; }
    /// Floats from one row to the next, and from one channel to the next.
    [[nodiscard]] std::size_t row_stride() const { return stride_; }
    [[nodiscard]] std::size_t plane_stride() const { return plane_; }

    /// The first pixel of a row; pixel -1 and row -1 exist, as do those just beyond the far ends.
    [[nodiscard]] float* row(int channel, int y) {
        const int place = y < 0 || y >= height_ ? window_ : y % window_;  // the last row is the border
        return data_.get() + plane_ * static_cast<std::size_t>(channel) + stride_ * static_cast<std::size_t>(place) + border;
    }
    [[nodiscard]] const float* row(int channel, int y) const { return const_cast<Planes*>(this)->row(channel, y); }

    /// How many floats beyond row y, in memory, row `other` is.
    [[nodiscard]] std::ptrdiff_t offset(int y, int other) const { return row(0, other) - row(0, y); }

    /// Makes the padding of a row zero again; all of the row below the last, into which kernels of two rows may write.
    void clear_tail(int channel, int y) { clear_tail(channel, y, 0, width_); }
    /// The same beside or below some columns alone, for those who write only these.
    void clear_tail(int channel, int y, int begin, int end) {
        float* const first = row(channel, y);
        std::fill(first + (y < height_ ? std::min(end, width_) : begin), first + (end < width_ ? end : row_end_), 0.f);
    }

private:
    static constexpr int border = 16;  // floats: one is needed, more keep rows aligned

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

/// Row y and those beside it, from a column on, to be doubled; the first and the last row stand for what lies beyond.
inline Doubled doubled_rows(const Planes& planes, int channel, int y, int column = 0) {
    const auto row = [&](int at) { return planes.row(channel, std::clamp(at, 0, planes.height() - 1)) + column; };
    return {row(y - 1), row(y), row(y + 1)};
}

/// Makes the pixels -1 and width of a row to be doubled.
inline void repeat_edges(float* row, int width) {
    row[-1] = row[0];
    row[width] = row[width - 1];
}

}  // namespace bob
