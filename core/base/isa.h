/// Instruction sets. Files named *_kernels.cpp are compiled once for each, with BOB_ISA as the name of their namespace;
/// the best set of the machine is chosen at run time.
#pragma once

#include <string_view>

namespace bob {

enum class Isa { baseline, avx2, avx512 };

/// Number of lanes in the widest vectors of any instruction set.
constexpr int max_lanes = 16;

/// The instruction set in use: initially, the best of both this build and this machine.
[[nodiscard]] Isa isa();

/// Uses another instruction set, for tests and benchmarks; false if this machine lacks it.
bool set_isa(Isa isa);

[[nodiscard]] std::string_view name(Isa isa);

/// Picks this machine's variant of a table of kernels that every instruction set defines under the same name.
#ifdef BOB_X86
#define BOB_DECLARE_KERNELS(Type, table)                           \
    namespace baseline { extern const Type table; }                \
    namespace avx2 { extern const Type table; }                    \
    namespace avx512 { extern const Type table; }                  \
    inline const Type& best_##table() {                            \
        return isa() == Isa::avx512 ? avx512::table                \
               : isa() == Isa::avx2 ? avx2::table                  \
                                    : baseline::table;             \
    }
#else
#define BOB_DECLARE_KERNELS(Type, table)            \
    namespace baseline { extern const Type table; } \
    inline const Type& best_##table() { return baseline::table; }
#endif

}  // namespace bob
