#include "completion/ratio_kernels.h"

#include <algorithm>

namespace bob::BOB_ISA {
namespace {

void count(const float* __restrict row, int width, float* __restrict counts) {
    for (int x = 0; x < width; ++x) counts[x] = row[x] > 0 ? 1.f : 0.f;
}

void pull(const float* __restrict above, const float* __restrict below, int width, float* __restrict sums) {
    const int pairs = width / 2;
    if (below) {
        for (int x = 0; x < pairs; ++x) sums[x] = (above[2 * x] + above[2 * x + 1]) + (below[2 * x] + below[2 * x + 1]);
    } else {
        for (int x = 0; x < pairs; ++x) sums[x] = above[2 * x] + above[2 * x + 1];
    }
    if (width % 2) sums[pairs] = above[width - 1] + (below ? below[width - 1] : 0);
}

void gather(const RowOfThree& rows, float beside, int width, float* __restrict between, float* __restrict sums) {
    const float *const above = rows.above, *const row = rows.row, *const below = rows.below;
    float* const __restrict columns = between + 1;
    if (above && below) {
        for (int x = 0; x < width; ++x) columns[x] = row[x] + beside * (above[x] + below[x]);
    } else if (const float* const other = above ? above : below) {
        for (int x = 0; x < width; ++x) columns[x] = row[x] + beside * other[x];
    } else {
        std::copy_n(row, width, columns);
    }
    between[0] = columns[width] = 0;
    for (int x = 0; x < width; ++x) sums[x] = columns[x] + beside * (columns[x - 1] + columns[x + 1]);
}

void push(const float* __restrict nearer, const float* __restrict farther, int width, int finer_width, float* __restrict between,
          float* __restrict finer) {
    for (int x = 0; x < width; ++x) between[x] = 0.75f * nearer[x] + 0.25f * farther[x];
    finer[0] = between[0];
    for (int x = 1; x < width; ++x) {
        finer[2 * x - 1] = 0.75f * between[x - 1] + 0.25f * between[x];
        finer[2 * x] = 0.75f * between[x] + 0.25f * between[x - 1];
    }
    if (finer_width % 2 == 0) finer[finer_width - 1] = between[width - 1];
}

void inverse(const float* __restrict weight, float prior, int width, float* __restrict inverse) {
    for (int x = 0; x < width; ++x) inverse[x] = 1 / (weight[x] + prior);
}

void mean(const float* __restrict sum, const float* __restrict inverse, float prior, int width, float* __restrict expected) {
    for (int x = 0; x < width; ++x) expected[x] = (sum[x] + prior * expected[x]) * inverse[x];
}

void shade(const float* __restrict wanted, const float* __restrict mean, float brighter, int width, float* __restrict ratio) {
    for (int x = 0; x < width; ++x) {
        const float most = brighter * mean[x], colored = wanted[x] < most ? wanted[x] : most;
        ratio[x] = ratio[x] * colored + (wanted[x] - colored);
    }
}

}  // namespace

const RatioKernels ratio_kernels = {count, pull, gather, push, inverse, mean, shade};

}  // namespace bob::BOB_ISA
