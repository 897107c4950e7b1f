#include "completion/conv3x3_kernels.h"

#include <algorithm>

#include "simd.h"

namespace bob::BOB_ISA {
namespace {

using V = Vector<lanes>;

constexpr int vectors = 2;             // side by side
constexpr int step = vectors * lanes;  // pixels
constexpr int scratch_row = conv_scratch / 4;

// Two rows at once need 20 sums for five channels: as many registers, and some for pixels.
constexpr bool in_pairs = lanes == 16;

template <int Block, int Rows>
struct Sums {
    V at[Block][Rows][vectors];
};

/// The convolution at `step` pixels of one row, from column x on.
template <int Block>
inline Sums<Block, 1> convolve(const ConvRow& row, int y, int x) {
    // One channel has too few sums to keep the multipliers busy: one for each row of taps then.
    constexpr int apart = Block == 1 ? 3 : 1;
    V part[apart][Block][vectors];
    for (int channel = 0; channel < Block; ++channel) {
        for (int i = 0; i < vectors; ++i) {
            part[0][channel][i] = broadcast<V>(row.bias[channel]);
            for (int k = 1; k < apart; ++k) part[k][channel][i] = V{};
        }
    }
    const float* corner = row.input + x - 1;
    const float* weight = row.weight;
    for (int input = 0; input < row.inputs; ++input) {
#pragma GCC unroll 9
        for (int tap = 0; tap < 9; ++tap) {
            const float* p = corner + row.rows[y + tap / 3] + tap % 3;
            V pixels[vectors];
            for (int i = 0; i < vectors; ++i) pixels[i] = load<V>(p + i * lanes);
#pragma GCC unroll 5
            for (int channel = 0; channel < Block; ++channel) {
                const V w = broadcast<V>(weight[tap * Block + channel]);
                V* sum = part[tap / 3 % apart][channel];
                for (int i = 0; i < vectors; ++i) sum[i] = fma(pixels[i], w, sum[i]);
            }
        }
        corner += row.plane_stride;
        weight += 9 * Block;
    }
    Sums<Block, 1> sum;
    for (int channel = 0; channel < Block; ++channel) {
        for (int i = 0; i < vectors; ++i) {
            sum.at[channel][0][i] = part[0][channel][i];
            for (int k = 1; k < apart; ++k) sum.at[channel][0][i] += part[k][channel][i];
        }
    }
    return sum;
}

/// The same in two rows with two thirds of the multiplications: Winograd's F(2, 3) down the columns (Lavin and Gray, "Fast
/// Algorithms for Convolutional Neural Networks", 2016). On a Zen 4 core it takes 4.0 and 4.1 ms for the first two layers
/// of the report's network at 640x480, multiplying as defined 5.8 and 5.9.
template <int Block>
inline Sums<Block, 2> convolve_pair(const ConvRow& row, int x) {
    // One channel has too few sums to keep the multipliers busy: both vectors at once then.
    constexpr int together = Block == 1 ? vectors : 1;
    Sums<Block, 2> sum;
    for (int first = 0; first < vectors; first += together) {
        V m[Block][4][together];
        for (int channel = 0; channel < Block; ++channel) {
            for (int i = 0; i < together; ++i) {
                m[channel][0][i] = m[channel][2][i] = m[channel][3][i] = V{};
                m[channel][1][i] = broadcast<V>(row.bias[channel]);
            }
        }
        const float* corner = row.input + x + first * lanes - 1;
        const float* weight = row.weight_pair;
        for (int input = 0; input < row.inputs; ++input) {
#pragma GCC unroll 3
            for (int kx = 0; kx < 3; ++kx) {
                V d[4][together];
                for (int i = 0; i < together; ++i) {
                    const float* p = corner + kx + i * lanes;
                    const V above = load<V>(p + row.rows[0]), upper = load<V>(p + row.rows[1]);
                    const V lower = load<V>(p + row.rows[2]), below = load<V>(p + row.rows[3]);
                    d[0][i] = above - lower, d[1][i] = upper + lower, d[2][i] = lower - upper, d[3][i] = upper - below;
                }
#pragma GCC unroll 4
                for (int tap = 0; tap < 4; ++tap) {
#pragma GCC unroll 5
                    for (int channel = 0; channel < Block; ++channel) {
                        const V w = broadcast<V>(weight[(kx * 4 + tap) * Block + channel]);
                        for (int i = 0; i < together; ++i) {
                            m[channel][tap][i] = fma(d[tap][i], w, m[channel][tap][i]);
                        }
                    }
                }
            }
            corner += row.plane_stride;
            weight += 12 * Block;
        }
        for (int channel = 0; channel < Block; ++channel) {
            for (int i = 0; i < together; ++i) {
                const auto& t = m[channel];
                sum.at[channel][0][first + i] = t[0][i] + t[1][i] + t[2][i];
                sum.at[channel][1][first + i] = t[1][i] - t[2][i] - t[3][i];
            }
        }
    }
    return sum;
}

inline V relu(V v) { return max(v, V{}); }

/// Writes one row of sums to row `y` of the output, or to rows 2y and 2y + 1 if it is enlarged.
template <int Block, int Rows>
inline void write(const ConvRow& row, const Sums<Block, Rows>& sum, int r, int y, int x, Then then) {
    if constexpr (Block == 4) {
        if (then == Then::shuffle) {
            float* out = row.output[0] + row.output_row_stride * static_cast<std::size_t>(2 * y) + 2 * x;
            for (int channel = 0; channel < 4; channel += 2, out += row.output_row_stride) {
                for (int i = 0; i < vectors; ++i) {
                    const V left = sum.at[channel][r][i], right = sum.at[channel + 1][r][i];
                    store(out + 2 * i * lanes, zip_low(left, right));
                    store(out + 2 * i * lanes + lanes, zip_high(left, right));
                }
            }
            return;
        }
    }
    for (int channel = 0; channel < Block; ++channel) {
        const V* v = sum.at[channel][r];
        float* out = row.output[channel];
        if (then == Then::relu_upsample) {
            out += row.output_row_stride * static_cast<std::size_t>(2 * y) + 2 * x;
            for (int i = 0; i < vectors; ++i) {
                for (float* p : {out, out + row.output_row_stride}) {
                    store(p + 2 * i * lanes, twice_low(relu(v[i])));
                    store(p + 2 * i * lanes + lanes, twice_high(relu(v[i])));
                }
            }
        } else {
            out += row.output_row_stride * static_cast<std::size_t>(y) + x;
            for (int i = 0; i < vectors; ++i) store(out + i * lanes, then == Then::relu ? relu(v[i]) : v[i]);
        }
    }
}

/// Writes the 2x2 maxima of two rows.
template <int Block, int Rows>
inline void write_pooled(const ConvRow& row, const Sums<Block, Rows>& upper, int r_upper,
                         const Sums<Block, Rows>& lower, int r_lower, int x) {
    for (int channel = 0; channel < Block; ++channel) {
        const V a = max(upper.at[channel][r_upper][0], lower.at[channel][r_lower][0]);
        const V b = max(upper.at[channel][r_upper][1], lower.at[channel][r_lower][1]);
        store(row.output[channel] + x / 2, relu(max(even(a, b), odd(a, b))));
    }
}

/// Goes on to the next block of output channels.
template <int Block>
inline void advance(ConvRow& row, Then then) {
    row.weight += row.inputs * 9 * Block;
    row.weight_pair += row.inputs * 12 * Block;
    row.bias += Block;
    row.output += then == Then::shuffle ? Block / 4 : Block;
}

/// The differences that Winograd's products need, of columns x - 1 to x + conv_tile of all inputs, to the scratch.
[[maybe_unused]] inline void keep_differences(const ConvRow& row, int x) {
    const float* corner = row.input + x - 1;
    float* to = row.scratch;
    const int columns = std::min(conv_tile, row.width - x) + 2;
    for (int input = 0; input < row.inputs; ++input) {
        for (int i = 0; i < columns; i += lanes) {
            const V above = load<V>(corner + i + row.rows[0]), upper = load<V>(corner + i + row.rows[1]);
            const V lower = load<V>(corner + i + row.rows[2]), below = load<V>(corner + i + row.rows[3]);
            store(to + i, above - lower);
            store(to + i + scratch_row, upper + lower);
            store(to + i + 2 * scratch_row, lower - upper);
            store(to + i + 3 * scratch_row, upper - below);
        }
        corner += row.plane_stride;
        to += conv_scratch;
    }
}

/// `convolve_pair` from the differences kept, at column x of the tile: one product after the other, so that few registers
/// are enough.
template <int Block>
inline Sums<Block, 2> convolve_kept(const ConvRow& row, int x) {
    V products[4][Block][vectors];
    BOB_KEEP_LOOP
    for (int tap = 0; tap < 4; ++tap) {
        V m[Block][vectors];
        BOB_UNROLL
        for (int channel = 0; channel < Block; ++channel) {
            BOB_UNROLL
            for (int i = 0; i < vectors; ++i) m[channel][i] = tap == 1 ? broadcast<V>(row.bias[channel]) : V{};
        }
        const float* from = row.scratch + tap * scratch_row + x;
        const float* weight = row.weight_pair + tap * Block;
        for (int input = 0; input < row.inputs; ++input) {
            BOB_KEEP_LOOP
            for (int kx = 0; kx < 3; ++kx) {
                V d[vectors];
                BOB_UNROLL
                for (int i = 0; i < vectors; ++i) d[i] = load<V>(from + kx + i * lanes);
                BOB_UNROLL
                for (int channel = 0; channel < Block; ++channel) {
                    const V w = broadcast<V>(weight[kx * 4 * Block + channel]);
                    BOB_UNROLL
                    for (int i = 0; i < vectors; ++i) m[channel][i] = fma(d[i], w, m[channel][i]);
                }
            }
            from += conv_scratch;
            weight += 12 * Block;
        }
        BOB_UNROLL
        for (int channel = 0; channel < Block; ++channel) {
            BOB_UNROLL
            for (int i = 0; i < vectors; ++i) products[tap][channel][i] = m[channel][i];
        }
    }
    Sums<Block, 2> sum;
    BOB_UNROLL
    for (int channel = 0; channel < Block; ++channel) {
        BOB_UNROLL
        for (int i = 0; i < vectors; ++i) {
            const V m0 = products[0][channel][i], m1 = products[1][channel][i];
            const V m2 = products[2][channel][i], m3 = products[3][channel][i];
            sum.at[channel][0][i] = m0 + m1 + m2;
            sum.at[channel][1][i] = m1 - m2 - m3;
        }
    }
    return sum;
}

template <int Block>
inline void write_pair(const ConvRow& row, const Sums<Block, 2>& sum, int x, Then then) {
    if (then == Then::relu_pool) {
        write_pooled(row, sum, 0, sum, 1, x);
    } else {
        write(row, sum, 0, 0, x, then);
        write(row, sum, 1, 1, x, then);
    }
}

/// Two rows, tile by tile, all output channels from the same differences.
template <int Block>
inline void conv_tiles(const ConvRow& row, Then then) {
    for (int first = 0; first < row.width; first += conv_tile) {
        keep_differences(row, first);
        ConvRow block = row;
        for (int i = 0; i < row.blocks; ++i, advance<Block>(block, then)) {
            for (int x = first; x < std::min(first + conv_tile, row.width); x += step) {
                write_pair(block, convolve_kept<Block>(block, x - first), x, then);
            }
        }
    }
}

template <int Block>
inline void conv_block(const ConvRow& row, int rows, Then then) {
    for (int x = 0; x < row.width; x += step) {
        if (rows == 1) {
            write(row, convolve<Block>(row, 0, x), 0, 0, x, then);
        } else if constexpr (in_pairs) {
            write_pair(row, convolve_pair<Block>(row, x), x, then);
        } else {
            const auto upper = convolve<Block>(row, 0, x);
            if (then != Then::relu_pool) write(row, upper, 0, 0, x, then);
            const auto lower = convolve<Block>(row, 1, x);
            if (then != Then::relu_pool) {
                write(row, lower, 0, 1, x, then);
            } else {
                write_pooled(row, upper, 0, lower, 0, x);
            }
        }
    }
}

template <int Block>
void conv(const ConvRow& row, int rows, Then then) {
    if constexpr (Block > 1 && !in_pairs) {
        if (rows == 2) return conv_tiles<Block>(row, then);
    }
    ConvRow block = row;
    for (int i = 0; i < row.blocks; ++i, advance<Block>(block, then)) conv_block<Block>(block, rows, then);
}

}  // namespace

const ConvKernels conv_kernels = {conv<5>, conv<4>, conv<1>};

}  // namespace bob::BOB_ISA
