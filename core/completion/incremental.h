/// Completing a picture again of which only parts have changed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <vector>

#include "completion/network.h"
#include "parallel.h"

namespace bob {

/// Pixels from (x0, y0) to before (x1, y1).
struct Rectangle {
    int x0, y0, x1, y1;

    [[nodiscard]] double area() const { return static_cast<double>(x1 - x0) * (y1 - y0); }
    [[nodiscard]] Rectangle united(const Rectangle& b) const {
        return {std::min(x0, b.x0), std::min(y0, b.y0), std::max(x1, b.x1), std::max(y1, b.y1)};
    }
    /// Enlarged by so much on each side and rounded outwards to multiples of `grid`, within the picture.
    [[nodiscard]] Rectangle grown(int margin, int grid, int height, int width) const {
        const auto down = [&](int at) { return std::max(0, (at - margin) / grid * grid); };
        const auto up = [&](int at, int size) { return std::min(size, (at + margin + grid - 1) / grid * grid); };
        return {down(x0), down(y0), up(x1, width), up(y1, height)};
    }
};

/// What a network makes of a picture, recomputed only where it may have changed since the last call: in tiles of the
/// picture that differ, and as far around them as the network reaches. A piece of the picture is completed by itself, with
/// as much around it as it needs, and from a multiple of the network's grid on: to the bit what the network makes of the
/// whole picture. Keeps the last picture and its G-buffer. For one thread at a time.
class Incremental {
public:
    explicit Incremental(const Network& network)
        : network_(network), inputs_(network.inputs().width()), outputs_(network.outputs().width()) {}

    [[nodiscard]] const Network& network() const { return network_; }

    /// As the network.
    void operator()(const float* gbuffer, int height, int width, float* output) {
        const std::size_t pixels = static_cast<std::size_t>(height) * static_cast<std::size_t>(width);
        if (height != height_ || width != width_) {
            height_ = height, width_ = width;
            gbuffer_.clear();
        }
        const Rectangle all{0, 0, width, height};
        auto changed = gbuffer_.empty() ? std::vector{all} : changes(gbuffer);
        double area = 0;
        for (const Rectangle& piece : changed) area += cost(piece);
        if (area > worthwhile * all.area()) changed = {all};

        gbuffer_.resize(static_cast<std::size_t>(inputs_) * pixels);
        output_.resize(static_cast<std::size_t>(outputs_) * pixels);
        try {
            for (const Rectangle& piece : changed) {
                complete(gbuffer, reached(piece));
                keep(gbuffer, piece);
            }
        } catch (...) {
            gbuffer_.clear();  // some of the output is of the last picture, some of this one
            throw;
        }
        for (int channel = 0; channel < outputs_; ++channel) {
            for_rows(0, height, width, [&](int y) {
                std::copy_n(output_.data() + place(channel, y), width, output + place(channel, y));
            });
        }
    }

private:
    static constexpr int tile = 32;
    static constexpr double worthwhile = 0.6;  // share of the picture: pieces have to be cut out, which costs too

    [[nodiscard]] Rectangle reached(const Rectangle& changed) const {
        return changed.grown(network_.reach(), 1, height_, width_);
    }
    [[nodiscard]] Rectangle needed(const Rectangle& reached) const {
        return reached.grown(network_.reach(), network_.grid(), height_, width_);
    }
    [[nodiscard]] double cost(const Rectangle& changed) const { return needed(reached(changed)).area(); }

    /// Rectangles that hold all that differs from the last G-buffer.
    [[nodiscard]] std::vector<Rectangle> changes(const float* gbuffer) const {
        const int rows = (height_ + tile - 1) / tile;
        std::vector<std::vector<Rectangle>> in_row(static_cast<std::size_t>(rows));
        parallel_for(in_row.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row) {
                const int y0 = static_cast<int>(row) * tile, y1 = std::min(y0 + tile, height_);
                for (int x = 0; x < width_; x += tile) {
                    const Rectangle here{x, y0, std::min(x + tile, width_), y1};
                    if (differs(gbuffer, here)) add(in_row[row], here);
                }
            }
        });
        std::vector<Rectangle> result;
        for (const auto& row : in_row) {
            for (const Rectangle& changed : row) add(result, changed);
        }
        return result;
    }

    /// Compares bits, so that 0 differs from -0, and NaN equals NaN.
    [[nodiscard]] bool differs(const float* gbuffer, const Rectangle& r) const {
        for (int channel = 0; channel < inputs_; ++channel) {
            for (int y = r.y0; y < r.y1; ++y) {
                const std::size_t at = place(channel, y) + static_cast<std::size_t>(r.x0);
                if (std::memcmp(gbuffer + at, gbuffer_.data() + at, 4 * static_cast<std::size_t>(r.x1 - r.x0)) != 0) return true;
            }
        }
        return false;
    }

    /// Adds a rectangle, united with those that are cheaper to complete together with it.
    void add(std::vector<Rectangle>& pieces, Rectangle added) const {
        for (std::size_t i = 0; i < pieces.size();) {
            const Rectangle both = pieces[i].united(added);
            if (cost(both) <= cost(pieces[i]) + cost(added)) {
                added = both;
                pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(i));
                i = 0;
            } else {
                ++i;
            }
        }
        pieces.push_back(added);
    }

    void keep(const float* gbuffer, const Rectangle& changed) {
        for_rows(changed.y0, changed.y1, inputs_ * (changed.x1 - changed.x0), [&](int y) {
            for (int channel = 0; channel < inputs_; ++channel) {
                const std::size_t at = place(channel, y) + static_cast<std::size_t>(changed.x0);
                std::copy_n(gbuffer + at, changed.x1 - changed.x0, gbuffer_.data() + at);
            }
        });
    }

    [[nodiscard]] std::size_t place(int channel, int y) const {
        return (static_cast<std::size_t>(channel) * static_cast<std::size_t>(height_) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(width_);
    }

    void complete(const float* gbuffer, const Rectangle& piece) {
        const Rectangle from = needed(piece);
        if (from.area() == Rectangle{0, 0, width_, height_}.area()) {
            network_(gbuffer, height_, width_, output_.data());
            return;
        }

        const int height = from.y1 - from.y0, width = from.x1 - from.x0;
        const auto columns = static_cast<std::size_t>(width), pixels = static_cast<std::size_t>(height) * columns;
        std::vector<float> part(static_cast<std::size_t>(inputs_) * pixels), result(static_cast<std::size_t>(outputs_) * pixels);
        for_rows(0, height, inputs_ * width, [&](int y) {
            for (int channel = 0; channel < inputs_; ++channel) {
                std::copy_n(gbuffer + place(channel, from.y0 + y) + from.x0, columns,
                            part.data() + static_cast<std::size_t>(channel * height + y) * columns);
            }
        });
        network_(part.data(), height, width, result.data());
        for (int channel = 0; channel < outputs_; ++channel) {
            for (int y = piece.y0; y < piece.y1; ++y) {
                std::copy_n(result.data() + static_cast<std::size_t>(channel * height + y - from.y0) * columns + (piece.x0 - from.x0),
                            static_cast<std::size_t>(piece.x1 - piece.x0), output_.data() + place(channel, y) + piece.x0);
            }
        }
    }

    const Network& network_;
    int inputs_, outputs_;  // planes
    int height_ = 0, width_ = 0;
    std::vector<float> gbuffer_, output_;  // of the last call; empty if there was none
};

}  // namespace bob
