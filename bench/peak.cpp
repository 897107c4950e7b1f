/// Prints how many GFLOP/s of fused multiply-adds so many threads do at most, from registers alone: the peak of this machine
/// while others use it as they do now. Compiled by bench/complete.py with the flags of the widest kernels.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "base/simd.h"

namespace {

using bob::BOB_ISA::F;
constexpr int sums = 10;  // more than a multiply-add's cycles times those begun in one
constexpr int steps = 20'000'000;

void multiply_and_add() {
    volatile float factor = 0.5f;
    F sum[sums];
    for (F& s : sum) s = bob::BOB_ISA::constant(factor);  // read anew, lest the compiler see that they are the same
    const F f = bob::BOB_ISA::constant(factor);
    for (int step = 0; step < steps; ++step) {
#pragma GCC unroll 10
        for (F& s : sum) s = bob::BOB_ISA::fma(s, f, f);
    }
    for (const F& s : sum) factor = s[0];
}

}  // namespace

int main(int, char** arguments) {
    const int count = std::atoi(arguments[1]);
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::thread> threads;
    for (int i = 0; i < count; ++i) threads.emplace_back(multiply_and_add);
    for (auto& thread : threads) thread.join();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("%.1f\n", 2e-9 * sums * bob::BOB_ISA::lanes * steps * count / seconds);
}
