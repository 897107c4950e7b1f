#include "isa.h"

#include <atomic>

namespace bob {
namespace {

bool machine_has(Isa isa) {
#ifdef BOB_X86
    switch (isa) {
        case Isa::avx512:
            return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                   __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512vl");
        case Isa::avx2:
            return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                   __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
        case Isa::baseline: return true;
    }
#endif
    return isa == Isa::baseline;
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
