#include "base/isa.h"

#ifdef BOB_X86
#include <cpuid.h>
#endif

#include <atomic>

namespace bob {
namespace {

#ifdef BOB_X86
struct Registers {
    unsigned eax = 0, ebx = 0, ecx = 0, edx = 0;
};

Registers cpuid(unsigned leaf) {
    Registers r;
    __get_cpuid_count(leaf, 0, &r.eax, &r.ebx, &r.ecx, &r.edx);
    return r;
}

/// Whether the operating system saves these parts of the registers: bits of XCR0.
bool system_saves(unsigned parts) {
    unsigned low = 0, high = 0;
    __asm__("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return (low & parts) == parts;
}

constexpr bool has_all(unsigned value, unsigned bits) { return (value & bits) == bits; }
#endif

/// Queries the processor directly: zig's __builtin_cpu_supports always answers no.
bool machine_has([[maybe_unused]] Isa isa) {
#ifdef BOB_X86
    if (isa == Isa::baseline) return true;
    // Bits from the Intel SDM, volume 2A, CPUID; the sets are the ones that CMakeLists.txt enables.
    constexpr unsigned fma = 1U << 12, movbe = 1U << 22, popcnt = 1U << 23, osxsave = 1U << 27, avx = 1U << 28, f16c = 1U << 29;
    constexpr unsigned bmi = 1U << 3, avx2 = 1U << 5, bmi2 = 1U << 8, lzcnt = 1U << 5;
    const unsigned features = cpuid(7).ebx;
    if (!has_all(cpuid(1).ecx, fma | movbe | popcnt | osxsave | avx | f16c) || !has_all(features, bmi | avx2 | bmi2) ||
        !has_all(cpuid(0x80000001).ecx, lzcnt) || !system_saves(0x06)) {
        return false;
    }
    constexpr unsigned avx512f = 1U << 16, dq = 1U << 17, cd = 1U << 28, bw = 1U << 30, vl = 1U << 31;
    return isa == Isa::avx2 || (has_all(features, avx512f | dq | cd | bw | vl) && system_saves(0xe6));
#else
    return isa == Isa::baseline;
#endif
}

Isa best() {
    for (const Isa isa : {Isa::avx512, Isa::avx2}) {
        if (machine_has(isa)) return isa;
    }
    return Isa::baseline;
}

std::atomic<Isa> chosen{best()};

}  // namespace

Isa isa() { return chosen.load(std::memory_order_relaxed); }

bool set_isa(Isa isa) {
    if (!machine_has(isa)) return false;
    chosen = isa;
    return true;
}

std::string_view name(Isa isa) {
    switch (isa) {
        case Isa::avx512: return "avx512";
        case Isa::avx2: return "avx2";
        case Isa::baseline: break;
    }
    return "baseline";
}

}  // namespace bob
