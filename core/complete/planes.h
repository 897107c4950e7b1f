/// Images of several channels, laid out for 3x3 convolutions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>

namespace bob {

/// `channels` planes of float32 with a border of zeros around each, so that convolutions need no special case at the
/// edges. Rows are padded to whole vectors: kernels may write beyond the width as far as `row_end` and then call
/// `clear_tail`; the border before a row is also the border after the row above.
class Planes {
public:
    Planes(int channels, int height, int width)
        : channels_(channels), height_(height), width_(width), row_end_((width + 63) / 64 * 64),
          stride_(static_cast<std::size_t>(border + row_end_)),
          plane_(stride_ * static_cast<std::size_t>(height + 2)) {
        const std::size_t size = plane_ * static_cast<std::size_t>(channels) + border;
        data_.reset(new (std::align_val_t{64}) float[size]);
        std::fill_n(data_.get(), size, 0.f);
    }

    [[nodiscard]] int channels() const { return channels_; }
    [[nodiscard]] int height() const { return height_; }
    [[nodiscard]] int width() const { return width_; }
    /// Floats from one row to the next, and from one channel to the next.
    [[nodiscard]] std::size_t row_stride() const { return stride_; }
    [[nodiscard]] std::size_t plane_stride() const { return plane_; }

    /// The first pixel of a row; pixel -1 and row -1 exist, as do those just beyond the far ends.
    [[nodiscard]] float* row(int channel, int y) {
        return data_.get() + plane_ * static_cast<std::size_t>(channel) + stride_ * static_cast<std::size_t>(y + 1) + border;
    }
    [[nodiscard]] const float* row(int channel, int y) const { return const_cast<Planes*>(this)->row(channel, y); }

    /// Makes the padding of a row zero again; all of the row below the last, into which kernels of two rows may write.
    void clear_tail(int channel, int y) {
        std::fill(row(channel, y) + (y < height_ ? width_ : 0), row(channel, y) + row_end_, 0.f);
    }

private:
    static constexpr int border = 16;  // floats: one is needed, more keep rows aligned

    struct Free {
        void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
    };

    int channels_, height_, width_, row_end_;
    std::size_t stride_, plane_;
    std::unique_ptr<float[], Free> data_;
};

}  // namespace bob
