#include "completion/conv3x3_kernels.h"

#include <algorithm>
#include <cstring>

#include "simd.h"

/// Winograd's F(n, 3) down the columns: n rows of results from n + 2 rows of pixels by as many products (Lavin and Gray, "Fast
/// Algorithms for Convolutional Neural Networks", 2016). The differences that are multiplied are kept for all output channels, and
/// one product follows the other, so that few registers are enough.
///
/// 17 channels to 12 of 320x240 pixels, one Zen 4 core, in ms: F(4, 3) 1.6 in AVX-512 and 1.7 in AVX2, which is 95 % of what
/// the multiply-adds alone take. Unrolling the taps costs AVX2 up to a fifth.
namespace bob::BOB_ISA {
namespace {

/// Vectors side by side, at most: the sums of a block, the pixels and a weight lie in registers.
template <int Block>
constexpr int most_vectors = Block == 1 ? 4 : lanes == 16 ? 20 / Block : 2;

/// Sums of a block of output channels, in some rows.
template <int Rows, int Block, int Vectors>
struct Sums {
    F at[Rows][Block][Vectors];
};

/// The differences that the products need, of one column. Winograd's matrices B and A transposed, and G in conv3x3.cpp.
template <int Rows>
struct Winograd;

template <>
struct Winograd<2> {
    static constexpr int products = 4;

    static void differences(const F (&d)[4], F (&to)[4]) {
        to[0] = d[0] - d[2], to[1] = d[1] + d[2], to[2] = d[2] - d[1], to[3] = d[1] - d[3];
    }
    static void results(const F (&m)[4], F bias, F (&to)[2]) {
        const F middle = m[1] + bias;
        to[0] = m[0] + middle + m[2];
        to[1] = middle - m[2] - m[3];
    }
};

template <>
struct Winograd<4> {
    static constexpr int products = 6;
    static constexpr float a = winograd_near, b = winograd_far;

    static void differences(const F (&d)[6], F (&to)[6]) {
        const F product = constant(a * a * b * b), sum = constant(-(a * a + b * b));
        const F even_near = fma(constant(-b * b), d[2], d[4]), odd_near = fma(constant(-b * b), d[1], d[3]);
        const F even_far = fma(constant(-a * a), d[2], d[4]), odd_far = fma(constant(-a * a), d[1], d[3]);
        to[0] = fma(product, d[0], fma(sum, d[2], d[4]));
        to[1] = fma(constant(a), odd_near, even_near);
        to[2] = fma(constant(-a), odd_near, even_near);
        to[3] = fma(constant(b), odd_far, even_far);
        to[4] = fma(constant(-b), odd_far, even_far);
        to[5] = fma(product, d[1], fma(sum, d[3], d[5]));
    }
    static void results(const F (&m)[6], F bias, F (&to)[4]) {
        const F even_near = m[1] + m[2], odd_near = m[1] - m[2], even_far = m[3] + m[4], odd_far = m[3] - m[4];
        to[0] = (m[0] + bias) + (even_near + even_far);
        to[1] = fma(constant(a), odd_near, fma(constant(b), odd_far, bias));
        to[2] = fma(constant(a * a), even_near, fma(constant(b * b), even_far, bias));
        to[3] = fma(constant(a * a * a), odd_near, fma(constant(b * b * b), odd_far, m[5] + bias));
    }
};

/// Keeps the differences of columns x - 1 to x + columns of all inputs.
template <int Rows>
void keep_differences(const ConvRows& rows, int x, int columns) {
    constexpr int products = Winograd<Rows>::products;
    const auto inputs = static_cast<std::size_t>(rows.inputs[0].channels + rows.inputs[1].channels);
    float* to = rows.scratch;
    for (const ConvInput& input : rows.inputs) {
        const float* corner = input.row + x - 1;
        for (int channel = 0; channel < input.channels; ++channel) {
            for (int i = 0; i < columns + 2; i += lanes) {
                F pixels[products], differences[products];
                BOB_UNROLL
                for (int k = 0; k < products; ++k) pixels[k] = load<F>(corner + i + input.rows[k]);
                Winograd<Rows>::differences(pixels, differences);
                BOB_UNROLL
                for (int k = 0; k < products; ++k) store(to + static_cast<std::size_t>(k * conv_scratch) * inputs + i, differences[k]);
            }
            corner += input.plane_stride;
            to += conv_scratch;
        }
    }
}

/// The convolution at some vectors of pixels, from the differences kept, at column x of the tile.
template <int Rows, int Block, int Vectors>
inline Sums<Rows, Block, Vectors> convolve(const ConvRows& rows, int x) {
    constexpr int products = Winograd<Rows>::products;
    const int inputs = rows.inputs[0].channels + rows.inputs[1].channels;
    F kept[products][Block][Vectors];
    const float* from = rows.scratch + x;
    const float* weight = rows.weight;
    BOB_KEEP_LOOP
    for (int product = 0; product < products; ++product) {
        F m[Block][Vectors] = {};
        for (int input = 0; input < inputs; ++input) {
            BOB_KEEP_LOOP
            for (int kx = 0; kx < 3; ++kx) {
                F d[Vectors];
                BOB_UNROLL
                for (int i = 0; i < Vectors; ++i) d[i] = load<F>(from + kx + i * lanes);
                BOB_UNROLL
                for (int channel = 0; channel < Block; ++channel) {
                    const F w = constant(weight[channel]);
                    BOB_UNROLL
                    for (int i = 0; i < Vectors; ++i) m[channel][i] = fma(d[i], w, m[channel][i]);
                }
                weight += Block;
            }
            from += conv_scratch;
        }
        BOB_UNROLL
        for (int channel = 0; channel < Block; ++channel) {
            BOB_UNROLL
            for (int i = 0; i < Vectors; ++i) kept[product][channel][i] = m[channel][i];
        }
    }
    Sums<Rows, Block, Vectors> sums;
    for (int channel = 0; channel < Block; ++channel) {
        const F bias = constant(rows.bias[channel]);
        BOB_UNROLL
        for (int i = 0; i < Vectors; ++i) {
            F m[products], results[Rows];
            BOB_UNROLL
            for (int k = 0; k < products; ++k) m[k] = kept[k][channel][i];
            Winograd<Rows>::results(m, bias, results);
            BOB_UNROLL
            for (int y = 0; y < Rows; ++y) sums.at[y][channel][i] = results[y];
        }
    }
    return sums;
}

inline F relu(F v) { return max(v, F{}); }

/// Writes one row of sums to row `y` of the output, or to rows 2y and 2y + 1 if it is enlarged.
template <int Block, int Vectors>
inline void write(const ConvRows& rows, const F (&sums)[Block][Vectors], int y, int x, Then then) {
    const auto row = static_cast<std::size_t>(y) * rows.output_row_stride;
    if constexpr (Block == 4) {
        if (then == Then::shuffle) {
            float* out = rows.output[0] + 2 * row + 2 * x;
            for (int channel = 0; channel < 4; channel += 2, out += rows.output_row_stride) {
                for (int i = 0; i < Vectors; ++i) {
                    const F left = sums[channel][i], right = sums[channel + 1][i];
                    store(out + 2 * i * lanes, zip_low(left, right));
                    store(out + 2 * i * lanes + lanes, zip_high(left, right));
                }
            }
            return;
        }
    }
    for (int channel = 0; channel < Block; ++channel) {
        const F* v = sums[channel];
        if (then == Then::relu_upsample) {
            float* out = rows.output[channel] + 2 * row + 2 * x;
            for (int i = 0; i < Vectors; ++i) {
                for (float* p : {out, out + rows.output_row_stride}) {
                    store(p + 2 * i * lanes, twice_low(relu(v[i])));
                    store(p + 2 * i * lanes + lanes, twice_high(relu(v[i])));
                }
            }
        } else {
            float* out = rows.output[channel] + row + x;
            for (int i = 0; i < Vectors; ++i) store(out + i * lanes, then == Then::relu ? relu(v[i]) : v[i]);
        }
    }
}

/// Writes the 2x2 maxima of two rows to row `y`.
template <int Block, int Vectors>
inline void write_pooled(const ConvRows& rows, const F (&upper)[Block][Vectors], const F (&lower)[Block][Vectors], int y, int x) {
    for (int channel = 0; channel < Block; ++channel) {
        float* out = rows.output[channel] + static_cast<std::size_t>(y) * rows.output_row_stride + x / 2;
        for (int i = 0; i < Vectors; i += 2) {
            const F a = max(upper[channel][i], lower[channel][i]);
            const F b = i + 1 < Vectors ? max(upper[channel][i + 1], lower[channel][i + 1]) : F{};
            const F pooled = relu(max(even(a, b), odd(a, b)));
            std::memcpy(out + i / 2 * lanes, &pooled, sizeof(F) / (i + 1 < Vectors ? 1 : 2));
        }
    }
}

/// A block of output channels over `vectors` vectors from column x on, which lies at column `at` of the tile.
template <int Rows, int Block, int Vectors = most_vectors<Block>>
inline void conv_step(const ConvRows& rows, int vectors, int x, int at, Then then) {
    if constexpr (Vectors > 1) {
        if (vectors < Vectors) return conv_step<Rows, Block, Vectors - 1>(rows, vectors, x, at, then);
    }
    const auto sums = convolve<Rows, Block, Vectors>(rows, at);
    if (then == Then::relu_pool) {
        for (int y = 0; y < rows.rows; y += 2) write_pooled(rows, sums.at[y], sums.at[y + 1], y / 2, x);
    } else {
        for (int y = 0; y < rows.rows; ++y) write(rows, sums.at[y], y, x, then);
    }
}

/// Tile by tile, all output channels from the same differences.
template <int Rows, int Block>
void conv(const ConvRows& rows, Then then) {
    const int inputs = rows.inputs[0].channels + rows.inputs[1].channels;
    for (int tile = 0; tile < rows.width; tile += conv_tile) {
        const int columns = std::min(conv_tile, rows.width - tile), vectors = (columns + lanes - 1) / lanes;
        const int steps = (vectors + most_vectors<Block> - 1) / most_vectors<Block>;
        keep_differences<Rows>(rows, tile, columns);
        ConvRows block = rows;
        for (int i = 0; i < rows.blocks; ++i) {
            for (int step = 0; step < steps; ++step) {
                const int begin = vectors * step / steps, end = vectors * (step + 1) / steps;
                conv_step<Rows, Block>(block, end - begin, tile + begin * lanes, begin * lanes, then);
            }
            block.weight += Winograd<Rows>::products * inputs * 3 * Block;
            block.bias += Block;
            block.output += then == Then::shuffle ? Block / 4 : Block;
        }
    }
}

}  // namespace

const ConvKernels conv_kernels = {{conv<2, 1>, conv<2, 4>, conv<2, 5>}, {conv<4, 1>, conv<4, 4>, conv<4, 5>}};

}  // namespace bob::BOB_ISA
