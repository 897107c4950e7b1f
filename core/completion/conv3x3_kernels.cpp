#include "completion/conv3x3_kernels.h"

#include <algorithm>
#include <cstring>

#include "base/simd.h"

/// Winograd's F(n, 3) down the columns. It computes n rows of results from n + 2 rows of pixels with n + 2 products
/// (Lavin and Gray, "Fast Algorithms for Convolutional Neural Networks", 2016). All output channels share the
/// transformed inputs, and one product follows the other, so that few registers suffice. Unrolling the taps costs AVX2
/// up to a fifth.
///
/// Many inputs are 0, as sparse pictures and rectified layers are. An input that is 0 across the vectors computed
/// together is skipped, which changes no bit. For a picture with 5 % of its pixels that skips half of all products.
namespace bob::BOB_ISA {
namespace {

/// Maximum number of vectors computed together. The sums of a block, the pixels and a weight stay in registers, and
/// fewer vectors find more inputs that are 0. Five in AVX-512 cost one Zen 4 core a tenth more time.
constexpr int most_vectors = 2;

/// Sums of a block of output channels, in `Rows` rows.
template <int Rows, int Block, int Vectors>
struct Sums {
    F at[Rows][Block][Vectors];
};

/// The transformed inputs of one column: Winograd's matrices B and A transposed; G is in conv3x3.cpp.
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

/// Parts of a tile, computed one after the other. Each reads the inputs that are not 0 everywhere in and next to it.
struct Steps {
    int count, begin[conv_steps + 1];  // in vectors
    int inputs[conv_steps] = {};       // number of inputs used
    std::uint64_t seen[conv_steps];    // vectors that a step reads, one bit each; two columns only of the last

    explicit Steps(int columns) {
        const int vectors = (columns + lanes - 1) / lanes;
        count = (vectors + most_vectors - 1) / most_vectors;
        for (int i = 0; i <= count; ++i) begin[i] = vectors * i / count;
        for (int i = 0; i < count; ++i) seen[i] = (std::uint64_t{2} << begin[i + 1]) - (std::uint64_t{1} << begin[i]);
    }
};

/// Finds the inputs that are not 0 in columns x to x + columns. Calls `keep(number, i, pixels)` for each with its
/// columns from x - 1 + i on, in memory order.
template <int Rows, class Keep>
inline void find_used(const ConvRows& rows, int x, int columns, Steps& steps, Keep keep) {
    const int inputs = rows.inputs[0].channels + rows.inputs[1].channels;
    int number = 0;
    for (const ConvInput& whole : rows.inputs) {
        const ConvInput input = whole;  // a copy, which no store can alias
        const float* corner = input.row + x - 1;
        for (int channel = 0; channel < input.channels; ++channel, ++number, corner += input.plane_stride) {
            std::uint64_t used = 0, used_first = 0;  // nonzero vectors, and vectors nonzero in their first two columns
            for (int i = 0, vector = 0; i < columns + 2; i += lanes, ++vector) {
                F pixels[Rows + 2];
                M any{};
                BOB_UNROLL
                for (int k = 0; k < Rows + 2; ++k) {
                    pixels[k] = load<F>(corner + i + input.rows[k]);
                    any |= (M)pixels[k];
                    if (i % 16 == 0) __builtin_prefetch(corner + i + input.rows[k] + input.plane_stride);  // of the next channel
                }
                if (const unsigned of_lanes = bits(any != M{})) {
                    used |= std::uint64_t{1} << vector;
                    if (of_lanes & 3) used_first |= std::uint64_t{1} << vector;
                    keep(number, i, pixels);
                }
            }
            std::uint64_t zeros = 0;
            for (int step = 0; step < steps.count; ++step) {
                const std::uint64_t seen = steps.seen[step], inside = seen & seen >> 1;
                if (!((used & inside) | (used_first & seen))) continue;
                rows.used[step * inputs + steps.inputs[step]++] = number;
                zeros |= seen & ~used;
            }
            for (int i = 0; zeros; zeros >>= 1, i += lanes) {
                if (zeros & 1) keep(number, i, {});
            }
        }
    }
}

/// Stores the transformed columns x - 1 to x + columns of all nonzero inputs.
template <int Rows>
void keep_differences(const ConvRows& rows, int x, int columns, Steps& steps) {
    constexpr int products = Winograd<Rows>::products;
    const std::ptrdiff_t product = (rows.inputs[0].channels + rows.inputs[1].channels) * conv_scratch;
    find_used<Rows>(rows, x, columns, steps, [product, scratch = rows.scratch](int number, int i, const F (&pixels)[products]) {
        F differences[products];
        Winograd<Rows>::differences(pixels, differences);
        float* const to = scratch + number * conv_scratch + i;
        BOB_UNROLL
        for (int k = 0; k < products; ++k) store(to + k * product, differences[k]);
    });
}

/// Convolves some vectors of pixels from the stored transforms, at column x of the tile.
template <int Rows, int Block, int Vectors>
inline Sums<Rows, Block, Vectors> convolve(const ConvRows& rows, int x, const int* used, int count) {
    constexpr int products = Winograd<Rows>::products;
    const int inputs = rows.inputs[0].channels + rows.inputs[1].channels;
    F kept[products][Block][Vectors];
    const float* differences = rows.scratch + x;
    const float* weights = rows.weight;
    BOB_KEEP_LOOP
    for (int product = 0; product < products; ++product) {
        F m[Block][Vectors] = {};
        for (int i = 0; i < count; ++i) {
            const float* from = differences + used[i] * conv_scratch;
            const float* weight = weights + used[i] * 3 * Block;
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
        }
        differences += conv_scratch * inputs;
        weights += 3 * Block * inputs;
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

/// Convolves a single output channel directly, for some vectors from column x on: a transform would be used only once.
template <int Rows, int Vectors>
inline Sums<Rows, 1, Vectors> convolve_one(const ConvRows& rows, int x, const int* used, int count) {
    Sums<Rows, 1, Vectors> sums;
    for (auto& row : sums.at) {
        for (F& sum : row[0]) sum = constant(rows.bias[0]);
    }
    for (const int* const end = used + count; used != end; ++used) {
        const int first = rows.inputs[0].channels;
        const ConvInput& input = rows.inputs[*used >= first];
        const float* const corner = input.row + static_cast<std::size_t>(*used >= first ? *used - first : *used) * input.plane_stride + x - 1;
        F weight[3][3];
        for (int i = 0; i < 9; ++i) weight[i / 3][i % 3] = constant(rows.weight[*used * 9 + i]);
        BOB_UNROLL
        for (int k = 0; k < Rows + 2; ++k) {
            BOB_UNROLL
            for (int kx = 0; kx < 3; ++kx) {
                BOB_UNROLL
                for (int i = 0; i < Vectors; ++i) {
                    const F pixels = load<F>(corner + input.rows[k] + kx + i * lanes);
                    BOB_UNROLL
                    for (int ky = 0; ky < 3; ++ky) {
                        if (k >= ky && k - ky < Rows) sums.at[k - ky][0][i] = fma(pixels, weight[ky][kx], sums.at[k - ky][0][i]);
                    }
                }
            }
        }
    }
    return sums;
}

inline F relu(F v) { return max(v, F{}); }

/// Writes one row of sums to row `y` of the output; if enlarged, to rows 2y and 2y + 1.
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

/// Writes the maxima of 2x2 sums to row `y`.
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

/// A block of output channels for `vectors` vectors from column x on, at column `at` of the tile.
template <int Rows, int Block, int Vectors = most_vectors>
inline void conv_step(const ConvRows& rows, int vectors, int x, int at, const int* used, int count, Then then) {
    if constexpr (Vectors > 1) {
        if (vectors < Vectors) return conv_step<Rows, Block, Vectors - 1>(rows, vectors, x, at, used, count, then);
    }
    Sums<Rows, Block, Vectors> sums;
    if constexpr (Block == 1) {
        sums = convolve_one<Rows, Vectors>(rows, x, used, count);
    } else {
        sums = convolve<Rows, Block, Vectors>(rows, at, used, count);
    }
    if (then == Then::relu_pool) {
        for (int y = 0; y < rows.rows; y += 2) write_pooled(rows, sums.at[y], sums.at[y + 1], y / 2, x);
    } else {
        for (int y = 0; y < rows.rows; ++y) write(rows, sums.at[y], y, x, then);
    }
}

/// Tile by tile, computes all output channels from the same transforms.
template <int Rows, int Block>
void conv(const ConvRows& rows, Then then) {
    const int inputs = rows.inputs[0].channels + rows.inputs[1].channels;
    for (int tile = rows.begin; tile < rows.end; tile += conv_tile) {
        const int columns = std::min(conv_tile, rows.end - tile);
        Steps steps(columns);
        if constexpr (Block == 1) {
            find_used<Rows>(rows, tile, columns, steps, [](int, int, const F (&)[Rows + 2]) {});
        } else {
            keep_differences<Rows>(rows, tile, columns, steps);
        }
        for (int step = 0; step < steps.count; ++step) {
            const int begin = steps.begin[step], end = steps.begin[step + 1];
            ConvRows block = rows;
            for (int i = 0; i < rows.blocks; ++i) {
                conv_step<Rows, Block>(block, end - begin, tile + begin * lanes, begin * lanes, rows.used + step * inputs, steps.inputs[step], then);
                block.weight += (Block == 1 ? 3 : Winograd<Rows>::products) * inputs * 3 * Block;
                block.bias += Block;
                block.output += then == Then::shuffle ? Block / 4 : Block;
            }
        }
    }
}

}  // namespace

const ConvKernels conv_kernels = {conv<4, 1>, conv<4, 4>, conv<4, 5>, conv<2, 4>};

}  // namespace bob::BOB_ISA
