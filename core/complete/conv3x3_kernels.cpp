#include "complete/conv3x3_kernels.h"
#include "simd.h"

namespace bob::BOB_ISA {
namespace {

using V = Vector<lanes>;

// Accumulators must stay in registers: 5 channels x 2 rows x 2 vectors where there are 32, x 1 row where there are 16.
constexpr int rows_at_once = lanes == 16 ? 2 : 1;
constexpr int vectors = 2;
constexpr int step = vectors * lanes;  // pixels

template <int Block, int Rows>
struct Sums {
    V at[Block][Rows][vectors];
};

/// The convolution at `step` pixels from column x on, in Rows rows from `first_row` on.
template <int Block, int Rows>
inline Sums<Block, Rows> convolve(const ConvRow& row, int first_row, int x) {
    Sums<Block, Rows> sum;
    for (int channel = 0; channel < Block; ++channel) {
        for (int r = 0; r < Rows; ++r) {
            for (int i = 0; i < vectors; ++i) sum.at[channel][r][i] = broadcast<V>(row.bias[channel]);
        }
    }
    const float* corner = row.input + row.row_stride * static_cast<std::size_t>(first_row) + x - 1;
    corner -= row.row_stride;
    const float* weight = row.weight;
    for (int input = 0; input < row.inputs; ++input) {
#pragma GCC unroll 4
        for (int y = 0; y < Rows + 2; ++y) {
            // A weight serves one row of output now and the other at the next y: GCC would spill 90 registers between.
            reload(weight);
#pragma GCC unroll 3
            for (int kx = 0; kx < 3; ++kx) {
                const float* p = corner + row.row_stride * static_cast<std::size_t>(y) + kx;
                V pixels[vectors];
                for (int i = 0; i < vectors; ++i) pixels[i] = load<V>(p + i * lanes);
#pragma GCC unroll 2
                for (int r = 0; r < Rows; ++r) {
                    const int ky = y - r;
                    if (ky < 0 || ky > 2) continue;
#pragma GCC unroll 5
                    for (int channel = 0; channel < Block; ++channel) {
                        const V w = broadcast<V>(weight[(ky * 3 + kx) * Block + channel]);
                        for (int i = 0; i < vectors; ++i) {
                            sum.at[channel][r][i] = fma(pixels[i], w, sum.at[channel][r][i]);
                        }
                    }
                }
            }
        }
        corner += row.plane_stride;
        weight += 9 * Block;
    }
    return sum;
}

inline V relu(V v) { return max(v, V{}); }

/// Writes one row of sums to row `y` of the output.
template <int Block, int Rows>
inline void write(const ConvRow& row, const Sums<Block, Rows>& sum, int r, int y, int x, Then then) {
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

template <int Block>
void conv(const ConvRow& row, int rows, Then then) {
    for (int x = 0; x < row.width; x += step) {
        if (rows == 2) {
            if constexpr (rows_at_once == 2) {
                const auto sum = convolve<Block, 2>(row, 0, x);
                if (then == Then::relu_pool) {
                    write_pooled(row, sum, 0, sum, 1, x);
                } else {
                    write(row, sum, 0, 0, x, then);
                    write(row, sum, 1, 1, x, then);
                }
            } else {
                const auto upper = convolve<Block, 1>(row, 0, x);
                if (then != Then::relu_pool) write(row, upper, 0, 0, x, then);
                const auto lower = convolve<Block, 1>(row, 1, x);
                if (then != Then::relu_pool) {
                    write(row, lower, 0, 1, x, then);
                } else {
                    write_pooled(row, upper, 0, lower, 0, x);
                }
            }
        } else {
            write(row, convolve<Block, 1>(row, 0, x), 0, 0, x, then);
        }
    }
}

}  // namespace

const ConvKernels conv_kernels = {conv<5>, conv<1>};

}  // namespace bob::BOB_ISA
